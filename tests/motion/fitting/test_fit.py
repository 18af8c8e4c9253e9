# SPDX-License-Identifier: BSD-3-Clause
"""Fits of motions whose parameters are known: values within their standard errors, errors that are right, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.fitting import sensitivities
from kane.gallery import load, pendulum_on_cart
from tests.gallery.test_scales import factor
from tests.motion.derivatives.test_sensitivities import four_bar, oscillator
from tests.peer import require
from tests.systems.plate import plate


def named(fit):
    return {s.name: v for s, v in fit.values.items()}


def test_without_noise_the_values_are_exact():
    """Parameters of the equations and of an input, and a start value."""
    eom, inputs, (k, c, A, _, x, _) = oscillator()
    t = np.linspace(0, 5, 41)
    true = kn.simulate(eom, (0, 5), q=[0.4], u=[0.0], inputs=inputs, samples=t, rtol=1e-12, atol=1e-12)
    begin = {"q": {x: 0.3}, "u": [0.0], "parameters": {k: 1.7, c: 0.15, A: 0.6}}
    found = kn.fit(eom, {"t": t, "x": true["x"]}, [k, c, A, x], inputs=inputs, **begin)
    assert [*found.values] == [k, c, A, x]
    np.testing.assert_allclose([*found.values.values()], [2.0, 0.1, 0.7, 0.4], rtol=1e-8)
    assert found.sigma["x"] < 1e-9
    again = kn.simulate(eom, (0, 5), start=found.start.replace(parameters=found.parameters), inputs=inputs, samples=t)
    np.testing.assert_allclose(again["x"], true["x"], atol=1e-7)


@pytest.mark.parametrize(
    ("length", "mass", "time"),
    [
        (1e-3, 1, 1),
        *(pytest.param(*own, marks=pytest.mark.slow) for own in ((1, 1e-3, 1), (1e3, 1e3, 1e3))),
        (1e-6, 1e-9, 1e-3),
    ],
)
def test_errors_in_other_units(length, mass, time):
    """A Duffing oscillator in metres, kilograms and seconds, and in others: the same values and standard errors."""

    def fitted(L, M, T):
        N = kn.Frame("N")
        x, u = kn.coordinate("x", "m"), kn.speed("u", "m/s")
        units = {"k": M / T**2, "c": M / T, "h": M / (T * L) ** 2, "x": L, "u": L / T}
        k, c, h = (
            kn.parameter("k", 30 / units["k"]),
            kn.parameter("c", 0.7 / units["c"]),
            kn.parameter("h", 40 / units["h"]),
        )
        block = kn.Particle("block", kn.Point("O", fixed_in=N).at("P", x * N.x), 2 / M)
        pull = kn.Force(block.point, -(k * x + c * u + h * x**3) * N.x)
        eom = kn.derive(kn.System(N, bodies=[block], speeds={u: x.dt}, loads=[pull]))
        t = np.linspace(0, 3, 31)
        fine = {"rtol": 1e-11, "atol": 1e-11 * min(1.0, 1 / L)}
        true = kn.simulate(eom, (0, 3 / T), q=[0.5 / L], u=[0.1 / units["u"]], samples=t / T, **fine)
        noise = 1e-3 * np.random.default_rng(1).normal(size=31)
        guess = {"q": [0.45 / L], "u": [0], "parameters": {k: 25 / units["k"], c: 0.5 / units["c"], h: 20 / units["h"]}}
        found = kn.fit(eom, {"t": true.t, "x": true["x"] + noise / L}, [*units], atol=fine["atol"], **guess)
        return [[a[s] * units[s.name] for s in found.values] for a in (found.values, found.errors)]

    np.testing.assert_allclose(fitted(length, mass, time), fitted(1, 1, 1), rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("length", [1e9, 1e-5])
def test_segments_join_in_any_units(length):
    """A cart with a pendulum, in other units of length: gaps of angles are measured by angles, those of lengths by lengths."""
    eom, t = kn.derive(pendulum_on_cart.system()), np.linspace(0, 2, 41)
    noise = np.random.default_rng(1).normal(size=(2, 41))

    def fitted(metre):
        usual = {p.name: p.default * factor(p.unit, (metre, 1, 1)) for p in eom.parameters}
        atol = 1e-10 * min(1.0, metre)
        true = kn.simulate(
            eom, (0, 2), q=[0.1 * metre, 2], u=[0, 0], samples=t, parameters=usual, rtol=1e-11, atol=atol
        )
        data = {"t": t, "x": true["x"] + 1e-3 * metre * noise[0], "theta": true["theta"] + 2e-3 * noise[1]}
        first = usual | {"l": 0.4 * metre, "m": 1.2 * usual["m"], "c": 0.5 * usual["c"]}
        found = kn.fit(
            eom, data, ["l", "m", "c", "x", "theta"], q=[0, 1.9], u=[0, 0], parameters=first, segments=6,
            sigma={"x": 1e-3 * metre, "theta": 2e-3}, rtol=1e-10, atol=atol,
        )  # fmt: skip
        return np.array([*found.values.values()]) / [metre, 1, 1, metre, 1]

    np.testing.assert_allclose(fitted(length), fitted(1.0), rtol=1e-7)


SETS = 100


def within(true, unknown, deviations, **given):
    """(estimate − truth)/standard error of each unknown in fits to many sets of noise (sets × k)."""
    rng, rows = np.random.default_rng(1), []
    start = dict(zip(true.equations.state, true.states[0], strict=True))
    known = {s: true.parameters[s] if s in true.parameters else start[s] for s in unknown}
    t, rows_of_t = np.unique(true.t, return_index=True)
    exact = {name: true[name][rows_of_t] for name in deviations}
    for _ in range(SETS):
        data = {"t": t} | {name: x + deviations[name] * rng.normal(size=len(t)) for name, x in exact.items()}
        found = kn.fit(true.equations, data, unknown, **given)
        rows.append([(found.values[s] - value) / found.errors[s] for s, value in known.items()])
    return np.array(rows)


def agrees(z):
    """Of the sets 99 of 100 within three standard errors, by each unknown, and errors neither too large nor too small."""
    assert ((np.abs(z) < 3).sum(axis=0) >= 0.99 * SETS).all()
    assert (z.std(axis=0) > 0.8).all()
    assert (z.std(axis=0) < 1.2).all()
    assert (np.abs(z.mean(axis=0)) < 3.5 / SETS**0.5).all()


@pytest.mark.slow
def test_a_tree_within_its_errors():
    eom, inputs, (k, c, _, _, x, u) = oscillator()
    true = kn.simulate(eom, (0, 4), q=[0.4], u=[0.0], inputs=inputs, samples=25)
    first = {"q": {x: 0.4}, "u": {u: 0.0}, "parameters": {k: 1.9, c: 0.11}}
    agrees(within(true, [k, c], {"x": 0.01}, inputs=inputs, **first))


@pytest.mark.slow
def test_a_four_bar_within_its_errors():
    eom, given = four_bar()
    true = kn.simulate(eom, (0, 0.5), samples=26, **given)
    m2 = next(p for p in eom.parameters if p.name == "m2")
    first = {"q": given["q"], "u": {eom.speeds[0]: 4.98}, "parameters": {**given["parameters"], m2: 2.03}}
    sigma = {"q1": 1e-3, "q3": 2e-3}  # told: what is estimated anew takes twice the time
    agrees(within(true, [m2, eom.speeds[0]], sigma, **first, sigma=sigma))


@pytest.mark.slow
def test_stick_and_slip_within_its_errors():
    """Both coefficients of a mass on a belt from noisy places, through stick, slip and stick."""
    belt = load("mass_on_belt")
    eom = kn.derive(belt.system())
    own = {p.name: p for p in eom.parameters}
    true = kn.simulate(eom, (0, 2), **belt.START, samples=33)
    first = {own["mu_s"]: 0.41, own["mu_k"]: 0.19}
    agrees(within(true, [own["mu_s"], own["mu_k"]], {"x": 1e-3}, **belt.START, parameters=first))


def test_friction_of_stick_and_slip():
    """Both coefficients of a mass on a belt from a noisy place, through changes of mode."""
    belt = load("mass_on_belt")
    eom = kn.derive(belt.system())
    own = {p.name: p for p in eom.parameters}
    t = np.linspace(0, 5, 101)
    true = kn.simulate(eom, (0, 5), **belt.START, samples=t)
    x = eom.coordinates[0]
    rows = np.searchsorted(true.t, t)
    data = {"t": t, x.name: true[x][rows] + 1e-3 * np.random.default_rng(2).normal(size=len(t))}
    first = {own["mu_s"]: 1.05 * own["mu_s"].default, own["mu_k"]: 0.95 * own["mu_k"].default}
    found = kn.fit(eom, data, [own["mu_s"], own["mu_k"]], **belt.START, parameters=first)
    for s, value in found.values.items():
        assert abs(value - s.default) < 3 * found.errors[s]
        assert found.errors[s] < 2e-2 * s.default
    assert found.sigma[x.name] == pytest.approx(1e-3, rel=0.3)


@pytest.mark.slow
def test_a_chaotic_motion_in_segments():
    """A double pendulum over a time in which errors grow a million times: one segment stays at a false minimum, ten do not."""
    pendulum = load("double_pendulum")
    eom = kn.derive(pendulum.system())
    t = np.linspace(0, 12, 241)
    q = dict(zip(eom.coordinates, (2.0, 2.5), strict=True))
    true = kn.simulate(eom, (0, 12), q=q, u=[0, 0], samples=t, rtol=1e-12, atol=1e-12)
    rng = np.random.default_rng(3)
    data = {"t": t} | {s.name: true[s] + 1e-3 * rng.normal(size=len(t)) for s in eom.coordinates}
    length = next(p for p in eom.parameters if p.unit == "m" or p.name.lower().startswith("l"))
    value = true.parameters[length]
    found = kn.fit(eom, data, [length], q=q, u=[0, 0], parameters={length: 1.02 * value}, segments=10, sigma=1e-3)
    assert abs(found.values[length] - value) < 1e-9
    assert found.errors[length] < 1e-9
    assert found.gap < 1e-9


def test_several_sets_of_data():
    """Two motions of other starts, inputs and columns: the information of both is the sum."""
    eom, inputs, (k, c, _, _, x, u) = oscillator()
    (F,) = eom.inputs
    t = np.linspace(0, 3, 25)
    states = [kn.State(q={x: 0.4}, u={u: 0.0}, inputs=inputs), kn.State(q={x: -0.3}, u={u: 0.5}, inputs={F: 0.0})]
    rng, sigma = np.random.default_rng(4), {"x": 1e-3, "u": 2e-3}
    columns = (["x"], ["u", "x"])
    sets = []
    for state, names in zip(states, columns, strict=True):
        true = kn.simulate(eom, (0, 3), start=state, samples=t)
        sets.append({"t": t} | {name: true[name] + sigma[name] * rng.normal(size=len(t)) for name in names})
    near = [state.replace(parameters={k: 1.8, c: 0.12}) for state in states]
    both = kn.fit(eom, sets, [k, c, u], near, sigma=sigma)
    starts = [run.values[u] for run in both.runs]
    np.testing.assert_allclose(starts, [0.0, 0.5], atol=3e-3)
    assert both.covariance.shape == (4, 4)
    known = {k: 2.0, c: 0.1}
    assert all(abs(both.values[s] - value) < 3 * both.errors[s] for s, value in known.items())
    alone = [kn.fit(eom, data, [k, c, u], state, sigma=sigma) for data, state in zip(sets, near, strict=True)]
    information = sum(np.linalg.inv(one.covariance[:2, :2]) for one in alone)
    np.testing.assert_allclose(np.linalg.inv(both.covariance[:2, :2]), information, rtol=2e-2)
    joined = kn.fit(eom, sets, [k, c, u], near, sigma=sigma, segments=2)
    np.testing.assert_allclose([*joined.values.values()], [*both.values.values()], atol=1e-8)
    assert joined.gap < 1e-9


def test_gaps_and_frames():
    """A DataFrame with NaN: rows that miss a column still count for the others."""
    pandas = require("pandas")
    eom, inputs, (k, _, _, _, x, u) = oscillator()
    t = np.linspace(0, 4, 41)
    true = kn.simulate(eom, (0, 4), q=[0.4], u=[0.0], inputs=inputs, samples=t, rtol=1e-12, atol=1e-12)
    frame = pandas.DataFrame({"t": t, "place": 2 * true["x"], "u": true["u"]})
    frame.loc[3:20, "place"] = np.nan
    frame.loc[15, "u"] = np.nan
    found = kn.fit(
        eom, frame, [k], q={x: 0.4}, u={u: 0.0}, parameters={k: 1.5}, inputs=inputs, outputs={"place": 2 * x}
    )
    assert found.values[k] == pytest.approx(2.0, rel=1e-8)
    assert np.isnan(found.residuals["place"]).sum() == 18
    by_name = {
        "q": {"x": 0.4},
        "u": {"u": 0.0},
        "parameters": {"k": 1.5},
        "inputs": inputs,
        "outputs": {"place": 2 * x},
    }
    again = kn.fit(eom, frame, "k", **by_name)
    assert again.values[k] == found.values[k]


def test_unknowns_that_are_not_determined_are_named():
    """The masses of a linkage under gravity alone: their common factor moves nothing."""
    eom, given = four_bar()
    true = kn.simulate(eom, (0, 0.6), samples=31, **given)
    data = {"t": true.t, "q1": true["q1"]}
    with pytest.raises(kn.SimulationError, match=r"m1, m2, m3 undetermined"):
        kn.fit(eom, data, ["m1", "m2", "m3"], **given)
    eom, _, (_, _, A, *_) = oscillator()
    late = A * kn.where(kn.less(kn.time, 5.0), 0, 1)
    with pytest.raises(kn.SimulationError, match="got A, on which no column depends"):
        kn.fit(eom, {"t": [0, 1, 2], "x": [0.4, 0.3, 0.1]}, [A], q=[0.4], u=[0], inputs={"F": late})


@pytest.mark.parametrize(
    ("data", "error", "said"),
    [
        ({"x": [1, 2]}, kn.ValueMissingError, "times of the data"),
        ({"t": [0, 1, 1], "x": [1, 2, 3]}, kn.SimulationError, "1, then 1 in row 2"),
        ({"t": [0, 1], "x": [1, 2, 3]}, kn.SimulationError, "2 numbers"),
        ({"t": [0, 1], "x": [1, np.inf]}, kn.SimulationError, "infinite"),
        ({"t": [0, 1], "y": [1, 2]}, kn.ValueMissingError, "columns of data"),
        ({"t": [0, 1], "x": [np.nan, np.nan]}, kn.SimulationError, "at least one column"),
        ({"t": [0, 1], "x": ["a", "b"]}, kn.SimulationError, "numbers in the column"),
        (3.0, kn.SimulationError, "DataFrame"),
    ],
)
def test_data_that_are_none(data, error, said):
    eom, inputs, (k, *_) = oscillator()
    with pytest.raises(error, match=said):
        kn.fit(eom, data, [k], q=[0.4], u=[0.0], inputs=inputs)


def test_data_that_begin_later():
    """From t = 0.1 + 0.2 on, where the end is off by rounding as the beginning and the length count it."""
    eom, inputs, (k, _, _, _, x, u) = oscillator()
    t = 0.1 + 0.2 + np.linspace(0, 4.3, 44)
    true = kn.simulate(eom, (t[0], t[-1]), q=[0.4], u=[0.0], inputs=inputs, samples=t, rtol=1e-12, atol=1e-12)
    found = kn.fit(eom, {"t": t, "x": true[x]}, [k, u], q={x: 0.4}, u={u: 0.1}, parameters={k: 1.8}, inputs=inputs)
    assert found.values[k] == pytest.approx(2.0, rel=1e-7)
    for end in np.linspace(1, 3, 40):
        times = np.linspace(t[0], end, 5)
        assert len(sensitivities(eom, (t[0], end), [k], q={x: 0.4}, u={u: 0}, inputs=inputs, samples=times).t) == 5


def test_segments_need_deviations():
    eom, inputs, (k, *_) = oscillator()
    with pytest.raises(kn.SimulationError, match="sigma= with segments="):
        kn.fit(eom, {"t": range(9), "x": range(9)}, [k], q=[0.4], u=[0.0], inputs=inputs, segments=2)


def test_bounds_hold():
    eom, inputs, (k, _, _, _, x, u) = oscillator()
    t = np.linspace(0, 3, 31)
    true = kn.simulate(eom, (0, 3), q=[0.4], u=[0.0], inputs=inputs, samples=t)
    data = {"t": t, "x": true["x"]}
    found = kn.fit(eom, data, [k], q={x: 0.4}, u={u: 0}, inputs=inputs, parameters={k: 1.0}, bounds={k: (0.5, 1.5)})
    assert found.values[k] == pytest.approx(1.5, abs=1e-3)
    with pytest.raises(kn.SimulationError, match="within the bounds"):
        kn.fit(eom, data, [k], q={x: 0.4}, u={u: 0}, inputs=inputs, parameters={k: 1.0}, bounds={k: (1.5, 2.5)})
    with pytest.raises(kn.SimulationError, match="bounds of k"):
        kn.fit(eom, data, [k], q={x: 0.4}, u={u: 0}, inputs=inputs, parameters={k: 1.0}, bounds={k: (2, 1)})


def turning_plate(seed):
    """A thin plate that turns, measured with noise: on the edge of what bodies there can be."""
    eom, T = plate()
    inertias = [next(p for p in eom.parameters if p.name == name) for name in ("I1", "I2", "I3")]
    t = np.linspace(0, 2, 21)
    start = {"q": [0.1, 0.2, 0.3], "u": [1.0, 4.0, 2.0], "inputs": dict.fromkeys(T, 0.0)}
    exact = kn.simulate(eom, (0, 2), **start, samples=t)
    rng = np.random.default_rng(seed)
    data = {"t": t} | {name: exact[name] + 0.02 * rng.normal(size=len(t)) for name in ("u1", "u2", "u3")}
    first = dict(zip(inertias, (0.025, 0.03, 0.05), strict=True))
    return eom, data, inertias, {**start, "parameters": first, "sigma": 0.02, "rtol": 1e-8}


@pytest.mark.slow
def test_bodies_stay_possible_in_segments():
    """The same estimate at the edge, whether the motion is cut or not."""
    eom, data, (I1, _, I3), given = turning_plate(0)
    one, two = (kn.fit(eom, data, [I1, I3], **given, physical=True, segments=count) for count in (1, 2))
    for s, value in one.values.items():
        assert abs(two.values[s] - value) < 1e-3 * one.errors[s]


@pytest.mark.parametrize(("seed", "edge"), [(0, True), pytest.param(3, False, marks=pytest.mark.slow)])
def test_bodies_stay_possible(seed, edge):
    """Noise makes I3 > I1 + I2, which no mass has, unless it is forbidden; else little changes."""
    eom, data, (I1, I2, I3), given = turning_plate(seed)
    free, held = (kn.fit(eom, data, [I1, I3], **given, physical=physical) for physical in (False, True))
    room, room_held = (found.values[I1] + 0.03 - found.values[I3] for found in (free, held))
    assert (room < 0) is edge
    assert room_held > 0
    for s, value in free.values.items():
        assert abs(held.values[s] - value) < (0.5 if edge else 0.01) * free.errors[s]
    if edge:
        assert room_held < 1e-6 < -room
        impossible = {**given, "parameters": {I1: 0.01, I2: 0.03, I3: 0.05}}
        with pytest.raises(kn.SimulationError, match="'plate' is physically possible"):
            kn.fit(eom, data, [I1], **impossible, physical=True)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"sigma": [0.1]}, "sigma= as a number, or a dict"),
        ({"sigma": {"x": "small"}}, "σ of 'x' as a number"),
        ({"outputs": ["x"]}, "outputs as a dict of names"),
        ({"data": []}, "data, or a list of sets"),
    ],
)
def test_arguments_of_another_kind_are_named(more, told):
    N, F, m = kn.Frame("N"), kn.input("F"), kn.parameter("m", 2.0)
    x, u = kn.coordinate("x"), kn.speed("u")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("B", P, m)], speeds={u: x.dt}, loads=[kn.Force(P, F * N.x)]))
    t = np.linspace(0, 1, 11)
    given = {"data": {"t": t, "x": t**2}, "unknown": [m], "q": [0], "u": [0], "inputs": {F: 1.0}} | more
    with pytest.raises(kn.errors.KaneError, match=f"Expected {told}"):
        kn.fit(eom, **given)
