# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of many motions, carried along in lanes, beside those of each motion by itself and differences."""

import numpy as np
import pytest

import kane as kn
from kane.fitting import sensitivities
from kane.gallery import load, pendulums
from tests.motion.derivatives.test_sensitivities import four_bar, oscillator

pytest.importorskip("xarray")
TIGHT = {"rtol": 1e-12, "atol": 1e-12}


def each(runs, eom, span, by, whats, given, at, samples, atol=2e-9):
    """Instances beside `sensitivities` of each."""
    for k in range(runs.sizes["instance"]):
        alone = sensitivities(eom, span, by, samples=samples, **at(k), **given)
        for name, what in whats.items():
            wanted = alone[what]
            found = runs[f"{name}_by"].values[k]
            np.testing.assert_allclose(found, wanted, rtol=0, atol=atol * max(1.0, np.abs(wanted).max()))


@pytest.mark.parametrize("lanes", [False, True])
def test_of_pendulums(lanes):
    """By parameters and starts, of states, of an energy and of a vector; in lanes and one by one."""
    eom = kn.derive(pendulums.system(2))
    by, starts = ["m2", "q1", "u2"], [0.2, 0.9]
    velocity = eom.system.bodies[-1].mass_center.velocity(eom.system.inertial)
    outputs = {"q1": eom.coordinates[0], "energy": eom.energy, "v": velocity}
    runs = kn.simulate_many(
        eom, (0, 1), q={"q1": starts, "q2": 0.1}, u=[0, 0], outputs=outputs, by=by, samples=4, lanes=lanes, **TIGHT
    )
    assert runs["v_by"].dims == ("instance", "t", "axis", "by")
    assert runs["q1_by"].dims == ("instance", "t", "by")
    assert runs["by"].values.tolist() == by
    assert runs.sizes["state"] == 4
    assert not any("d_" in str(name) for name in runs.coords)
    each(runs, eom, (0, 1), by, outputs, {"u": [0, 0]}, lambda k: {"q": [starts[k], 0.1]}, 4)


def ball(**changes):
    """A ball that an event throws back: v := −e v, in a wind that is another one behind each bounce."""
    m, g, e, c, N = (
        kn.parameter("m", 1.0),
        kn.parameter("g", 9.81),
        kn.parameter("e", 0.8),
        kn.state("c"),
        kn.Frame("N"),
    )
    y, v = kn.coordinate("y"), kn.speed("v")
    P = kn.Point("O", fixed_in=N).at("P", y * N.y)
    bounce = kn.Event("bounce", y, direction=-1, **({"then": {v: -e * v, c: c + 0.1 * g}} | changes))
    force = kn.Force(P, -m * (g + c * v / 10) * N.y)
    system = kn.System(
        N, bodies=[kn.Particle("B", P, m)], speeds={v: y.dt}, loads=[force], events=[bounce], states={c: -c}
    )
    return kn.derive(system), (y, v, c, g, e)


def test_across_events():
    """Each lane bounces at times of its own."""
    eom, (y, v, c, g, _) = ball()
    by, heights = [y, g], [0.6, 1.0]
    runs = kn.simulate_many(
        eom,
        (0, 1.9),
        q={y: heights},
        u=[0.2],
        by=by,
        samples=4,
        lanes=True,
        reduce={"v": "last"},
        method="dop853",
        settings=kn.Settings(contract=False),
        **TIGHT,
    )
    assert runs["v_by"].dims == ("instance", "by")
    for k, height in enumerate(heights):
        s = sensitivities(eom, (0, 1.9), by, q={y: height}, u=[0.2], samples=2)
        assert len(s.motion.events) >= 2
        for found, what in ((runs["v_by"], v), (runs["c_by"][:, -1], c), (runs["y_by"][:, -1], y)):
            np.testing.assert_allclose(found.values[k], s[what][-1], rtol=1e-8, atol=1e-8)


def test_an_event_that_another_one_sets_off(tmp_path):
    """What counts bounces changes by them alone: each motion is differentiated by itself, and no third bounce comes here."""
    eom, (y, v, c, _, e) = ball()
    events = [
        kn.Event("bounce", y, direction=-1, then={v: -e * v, c: c + 1}),
        kn.Event("third", c - 2.5, direction=1, then={v: 0 * v}),
    ]
    counted = kn.derive(eom.system.replace(events=events, states={c: 0 * y}, loads=()))
    by, heights, given = [y, e], [0.6, 1.0], {"u": [-3.0], "states": [0.0]}
    runs = kn.simulate_many(counted, (0, 1.2), q={y: heights}, by=by, samples=3, **given)
    for k, height in enumerate(heights):
        s = sensitivities(counted, (0, 1.2), by, q=[height], samples=runs.t.values, **given)
        assert len(s.motion.events) == 1
        np.testing.assert_array_equal(runs["y_by"].values[k, -1], s[y][-1])
    with pytest.raises(
        kn.SimulationError, match=r"store= supports, got events whose quantity only other events change\. Leave"
    ):
        kn.simulate_many(counted, (0, 1.2), q={y: heights}, by=by, samples=3, store=tmp_path / "runs.zarr", **given)


def test_across_impacts_of_contacts():
    """What cannot be carried along is found of each motion by itself."""
    eom = kn.derive(load("bouncing_ball").system())
    m, g, e = eom.parameters
    (y,) = eom.coordinates
    given = {"u": [0.0], "parameters": {m: 1.0, g: 9.81, e: 0.8}}
    heights = [0.6, 1.0]
    runs = kn.simulate_many(eom, (0, 1.2), q={y: heights}, by=[y, e], samples=4, **given)
    assert runs["y_by"].dims == ("instance", "t", "by")
    for k, height in enumerate(heights):
        s = sensitivities(eom, (0, 1.2), [y, e], q={y: height}, samples=runs.t.values, **given)
        rows = np.searchsorted(s.t, runs.t.values, side="right") - 1
        np.testing.assert_array_equal(runs["y_by"].values[k], s[y][rows])
    stopped = kn.simulate_many(eom, (0, 1.2), q={y: heights}, by=[y, e], samples=4, max_steps=4, **given, **TIGHT)
    assert set(stopped.status.values.tolist()) == {"stopped"}
    np.testing.assert_array_equal(np.isnan(stopped["y_by"]).all("by"), np.isnan(stopped["y"]))  # as they were told
    with pytest.raises(
        kn.SimulationError, match="got none of 2 of 2, of instance 0: Expected max_step=, the fixed step length"
    ):
        kn.simulate_many(eom, (0, 1.2), q={y: heights}, by=[y, e], method="rk4", **given)


@pytest.mark.parametrize("lanes", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_of_a_four_bar(lanes):
    """What the closure makes dependent follows."""
    eom, given = four_bar()
    by = ["u1"]
    masses = [0.8, 1.3]
    m2 = next(p for p in eom.parameters if p.name == "m2")
    parameters = {**given["parameters"], m2: masses}
    runs = kn.simulate_many(
        eom, (0, 0.8), q=given["q"], u=given["u"], parameters=parameters, by=by, samples=3, lanes=lanes, **TIGHT
    )
    assert set(runs.status.values.tolist()) == {"finished"}
    q3 = next(q for q in eom.coordinates if q.name == "q3")
    own = {"q": given["q"], "u": given["u"]}
    each(
        runs, eom, (0, 0.8), by, {"q3": q3}, own, lambda k: {"parameters": {**given["parameters"], m2: masses[k]}}, 3,
        atol=1e-8,
    )  # fmt: skip


def test_by_gains_of_inputs():
    eom, inputs, (k, _, A, w, x, _) = oscillator()
    starts = [0.1, 0.4]
    runs = kn.simulate_many(eom, (0, 2), q={x: starts}, u=[0.0], inputs=inputs, by=[A, w, k], samples=3, **TIGHT)
    each(runs, eom, (0, 2), [A, w, k], {"x": x}, {"u": [0.0], "inputs": inputs}, lambda i: {"q": [starts[i]]}, 3)


def test_what_is_not_carried_along():
    eom, inputs, (_, _, _, _, x, _) = oscillator()
    given = {"q": {x: [0.1, 0.4]}, "u": [0.0], "inputs": inputs, "samples": 3}
    with pytest.raises(kn.SimulationError, match="'last', 'mean' or none"):
        kn.simulate_many(eom, (0, 1), by=["k"], reduce="max", **given)
    parameter_set, (y, _, _, g, _) = ball(then={"g": 1.62})
    with pytest.raises(kn.SimulationError, match="parameters to numbers"):
        kn.simulate_many(parameter_set, (0, 1), by=[g], q={y: [0.5, 1.0]}, u=[0.0], samples=3)
    with pytest.raises(kn.ValueMissingError, match="Expected one of"):
        kn.simulate_many(eom, (0, 1), by=["K"], **given)
