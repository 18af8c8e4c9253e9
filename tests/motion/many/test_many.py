# SPDX-License-Identifier: BSD-3-Clause
"""Many motions at once: each is that of `kn.simulate`, by any number of threads, in lanes or not; one that fails stops no other."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kane as kn
from kane.gallery import four_bar, pendulums, slider_crank
from kane.gallery.contacts import bouncing_ball, mass_on_belt
from kane.gallery.flexible import flexible_slider_crank
from kane.motion import check_values, surely_admitted
from tests.examples import FULL
from tests.peer import require
from tests.systems import thrown_stone
from tests.systems.four_bar import BAR
from tests.systems.thrown_stone import FLOOR, MU, E

require("xarray")

TWO = kn.derive(pendulums.system(2))
x, v = kn.coordinate("x"), kn.speed("v")
m, k = kn.parameter("m", 2.0), kn.parameter("k", 3.0)
gain = kn.parameter("gain", 1.0)
F = kn.input("F")
N = kn.Frame("N")
P = kn.Point("O", fixed_in=N).at("P", x * N.x)


def block(*loads, **more):
    """A block on a line."""
    forces = [kn.Force(P, f * N.x) for f in loads]
    return kn.derive(kn.System(N, bodies=[kn.Particle("block", P, m)], speeds={v: x.dt}, loads=forces, **more))


DRIVEN = block(F - k * x)
BALL = block(-9.81 * m, events=[kn.Event("bounce", x, direction=-1, then={v: -0.9 * v})])
LANDS = block(-9.81 * m, events=[kn.Event("lands", x, direction=-1)])


EXACT = kn.Settings(contract=False)
KERNELS = {"method": "vern9"} if FULL else {"method": "tsitpap8", "settings": EXACT}
"""What starts are found for: the quick tests take kernels that those of lanes compile anyway."""


def one_by_one(eom, span, runs, given, rounding=0.0):
    """Each instance as `kn.simulate` has it, beside what `runs` have of it; starts that are solved for may differ by rounding."""
    alone = kn.derive(eom.system)
    for n, own in enumerate(given):
        if eom.system.contacts:  # also where no mode is known yet
            alone = kn.derive(eom.system)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kn.KaneWarning)
            sol = kn.simulate(alone, span, **own)
        at = np.searchsorted(sol.t, runs.t.values, side="right") - 1
        there = sol.t[at] == runs.t.values
        for j, s in enumerate(eom.state):
            own_values = np.where(there, sol.states[at, j], np.nan)
            np.testing.assert_allclose(runs[s.name].values[n], own_values, rtol=0, atol=rounding, err_msg=f"{n}, {s}")
            np.testing.assert_allclose(runs[s.name].values[n, :1], own_values[:1], rtol=0, atol=min(rounding, 1e-14))
        assert runs.status.values[n] == sol.status
        assert runs.cause.values[n] == sol.message
        assert runs.end_t.values[n] == sol.t[-1]
        np.testing.assert_allclose(runs.end_state.values[n], sol.states[-1], rtol=0, atol=rounding)
        assert runs.steps.values[n] == sol.steps


def spread(low, high, count=6):
    return np.linspace(low, high, count)


@pytest.mark.parametrize("threads", [1, 2])
def test_trees(threads):
    q, mass = np.stack([spread(-1, 1), spread(0.5, -2)], axis=-1), spread(1, 3)
    runs = kn.simulate_many(TWO, (0, 3), q=q, u=[0, 0.1], parameters={"m1": mass}, samples=21, threads=threads)
    given = [{"q": q[n], "u": [0, 0.1], "parameters": {"m1": mass[n]}, "samples": 21} for n in range(6)]
    one_by_one(TWO, (0, 3), runs, given)
    assert runs["q1"].dims == ("instance", "t")
    assert runs["q1"].attrs["units"] == TWO.unit(TWO.coordinates[0])
    assert np.array_equal(runs["m1"], mass)
    assert np.array_equal(runs["q2(0)"], q[:, 1])


@pytest.mark.parametrize(
    "options",
    [
        {"samples": [0.5, 1.25]},
        {"samples": []},
        {"samples": [3.0], "method": "dop853"},
        {"method": "radau9", "samples": 5},
        {"max_steps": 20, "samples": 5},
        {"method": "midpoint", "max_step": 1e-3, "samples": 3},
        {"method": "RK45", "samples": 3, "rtol": 1e-6},
        {"breakpoints": [0.3], "samples": 4},
    ],
    ids=str,
)
def test_options(options):
    """Motions that a tile runs in one call, and those that end otherwise or take many steps."""
    q, mass = np.stack([spread(-1, 1, 4), spread(0.5, -2, 4)], axis=-1), spread(1, 3, 4)
    runs = kn.simulate_many(TWO, (0, 3), q=q, u=[0, 0.1], parameters={"m1": mass}, **options)
    given = [{"q": q[n], "u": [0, 0.1], "parameters": {"m1": mass[n]}, **options} for n in range(4)]
    one_by_one(TWO, (0, 3), runs, given)


@pytest.mark.parametrize("system", [four_bar, slider_crank])
def test_closed_loops(system):
    eom = kn.derive(system.system())
    first, *others = eom.coordinates
    name = eom.independent_speeds[0]
    start = kn.assemble(eom, q={first: 1.2, **{c: kn.guess(0.3) for c in others}})
    angles, near = spread(1.1, 1.3, 4), {c: kn.guess(start.q[c]) for c in others}
    for parameters in ({}, {eom.parameters[0].name: spread(1.0, 1.02, 4) * eom.parameters[0].default}):
        runs = kn.simulate_many(
            eom, (0, 2), q={first: angles, **near}, u={name: 0.5}, parameters=parameters, samples=11, threads=2
        )
        given = [
            {
                "q": {first: angles[n], **near},
                "u": {name: 0.5},
                "parameters": {s: c[n] for s, c in parameters.items()},
                "samples": 11,
            }
            for n in range(4)
        ]
        one_by_one(eom, (0, 2), runs, given)


def test_events_that_act_and_that_end():
    heights = spread(0.2, 2)
    runs = kn.simulate_many(BALL, (0, 1.5), q={x: heights}, u={v: 0}, samples=16, threads=2)
    one_by_one(BALL, (0, 1.5), runs, [{"q": {x: h}, "u": {v: 0}, "samples": 16} for h in heights])
    runs = kn.simulate_many(LANDS, (0, 0.5), q={x: heights}, u={v: 0}, samples=16)
    one_by_one(LANDS, (0, 0.5), runs, [{"q": {x: h}, "u": {v: 0}, "samples": 16} for h in heights])
    assert set(runs.event.values) == {"lands", ""}
    assert np.all(np.isnan(runs["x"].values[0, -1]))


@pytest.mark.parametrize("module", [bouncing_ball, mass_on_belt])
def test_contacts(module):
    eom = kn.derive(module.system())
    q = dict.fromkeys(eom.coordinates, 0.5) | {eom.coordinates[0]: spread(0.5, 1.0, 3)}
    u = dict.fromkeys(eom.speeds, 0.1)
    runs = kn.simulate_many(eom, (0, 2), q=q, u=u, samples=11, threads=2)
    given = [{"q": {s: c if np.ndim(c) == 0 else c[n] for s, c in q.items()}, "u": u, "samples": 11} for n in range(3)]
    one_by_one(eom, (0, 2), runs, given)


@pytest.mark.grows
def test_contacts_that_close_slip_and_stick():
    """Of a stone that is thrown: what its kernel leads, what is not admitted, and forces, which are those of the modes."""
    eom, count = kn.derive(thrown_stone.SYSTEM), 48
    speeds, bounces, frictions = spread(-1, 3, count), spread(0, 0.8, count), spread(0, 0.6, count)
    bounces[[7, 30]] = 1.2, -0.1
    forces = {"N": FLOOR.normal_force, "F": FLOOR.friction_forces[0]}
    start = {"q": [0.0, 0.3]}
    options = {"u": {"u_x": speeds, "u_y": 0.0}, "parameters": {E: bounces, MU: frictions}, "samples": 16, "threads": 2}
    for _ in range(2):  # modes become known
        runs = kn.simulate_many(eom, (0, 2), **start, **options)
        more = kn.simulate_many(eom, (0, 2), **start, **options, outputs=forces)
    assert list(np.flatnonzero(runs.status.values == "failed")) == [7, 30]
    assert all("restitution from 0 to 1" in cause for cause in runs.cause.values[[7, 30]])
    valid = [n for n in range(count) if n not in (7, 30)]
    given = [
        {**start, "u": [speeds[n], 0.0], "parameters": {E: bounces[n], MU: frictions[n]}, "samples": 16} for n in valid
    ]
    few = slice(None, None, 1 if FULL else 4)
    one_by_one(eom, (0, 2), runs.isel(instance=valid[few]), given[few])
    for n, own in list(zip(valid, given, strict=True))[::5]:
        sol = kn.simulate(eom, (0, 2), **own)
        at = np.searchsorted(sol.t, runs.t.values, side="right") - 1
        for name, what in forces.items():
            np.testing.assert_allclose(more[name].values[n], sol[what][at], rtol=1e-12, atol=1e-12)


def test_inputs():
    """Numbers of each instance, and laws with parameters of the model and of their own."""
    force, stiff, gains = spread(1, 2, 4), spread(2, 4, 4), spread(0.5, 2, 4)
    begin = {"q": {x: 1.0}, "u": {v: 0.0}}
    more = {"samples": 11, "threads": 2}
    runs = kn.simulate_many(DRIVEN, (0, 2), **begin, inputs={F: force}, parameters={k: stiff}, **more)
    given = [
        {**begin, "inputs": {F: f}, "parameters": {k: c}, "samples": 11} for f, c in zip(force, stiff, strict=True)
    ]
    one_by_one(DRIVEN, (0, 2), runs, given)
    assert np.array_equal(runs["F"], force)
    for law in (-2 * x - 3 * v, -gain * v - k * x, -gain * kn.sign(x - 0.3), kn.sin(gain * kn.time)):
        runs = kn.simulate_many(DRIVEN, (0, 2), **begin, inputs={F: law}, parameters={k: stiff, gain: gains}, **more)
        given = [
            {**begin, "inputs": {F: law}, "parameters": {k: c, gain: g}, "samples": 11}
            for c, g in zip(stiff, gains, strict=True)
        ]
        one_by_one(DRIVEN, (0, 2), runs, given)


def test_functions_of_python_run_one_after_the_other():
    law, masses = (lambda t, s: -s[1]), spread(1, 2, 3)
    with pytest.warns(kn.KaneWarning, match=r"got Python functions for F: the 3 motions run one after the other"):
        runs = kn.simulate_many(
            DRIVEN, (0, 1), q={x: 1}, u={v: 0}, inputs={F: law}, parameters={m: masses}, samples=6, threads=2
        )
    given = [{"q": {x: 1}, "u": {v: 0}, "inputs": {F: law}, "parameters": {m: c}, "samples": 6} for c in masses]
    one_by_one(DRIVEN, (0, 1), runs, given)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_threads_do_not_matter(threads):
    q = np.random.default_rng(3).uniform(-2, 2, (150, 2))
    given = {"q": q, "u": [0, 0], "samples": 7, "outputs": {"energy": TWO.energy, "q1": TWO.coordinates[0]}}
    assert kn.simulate_many(TWO, (0, 2), threads=threads, **given).identical(
        kn.simulate_many(TWO, (0, 2), threads=1, **given)
    )


@pytest.mark.parametrize(("threads", "lanes"), [(1, False), (2, False), (1, True), (2, True)])
def test_one_that_fails_stops_no_other(threads, lanes):
    """A mass of zero has no start, a force that grows without bound has no end, others have both."""
    eom = block(k * x**3)
    masses, stiff, start = np.tile([2.0, 0.0, 2.0], 20), np.tile([-1.0, -1.0, 1.0], 20), np.tile([1.0, 1.0, 5.0], 20)
    runs = kn.simulate_many(
        eom, (0, 3), q={x: start}, u={v: 0}, parameters={m: masses, k: stiff}, samples=5, threads=threads, lanes=lanes
    )
    assert list(runs.status.values[:3]) == ["finished", "failed", "stopped"]
    assert np.array_equal(runs.status.values, np.tile(runs.status.values[:3], 20))
    with pytest.raises(kn.SimulationError) as told:
        kn.simulate(eom, (0, 3), q=[1], u=[0], parameters={m: 0.0, k: -1.0})
    assert runs.cause.values[1] == str(told.value)
    assert np.isnan(runs.end_t.values[1])
    assert 0 < runs.end_t.values[2] < 3
    assert np.isfinite(runs.end_state.values[2]).all()
    given = [{"q": [q], "u": [0], "parameters": {m: 2.0, k: c}, "samples": 5} for q, c in ((1, -1), (5, 1))]
    # the one that stops is run by itself
    one_by_one(eom, (0, 3), runs.isel(instance=[2] if lanes else [0, 2]), given[1:] if lanes else given)


def test_a_function_that_raises_stops_no_other():
    with pytest.warns(kn.KaneWarning, match="one after the other"):
        runs = kn.simulate_many(
            DRIVEN, (0, 1), q={x: [1.0, 20.0]}, u={v: 0}, inputs={F: lambda t, s: 1 // int(s[0] < 10)}, samples=3
        )
    assert list(runs.status.values) == ["finished", "failed"]
    assert "ZeroDivisionError" in runs.cause.values[1]


def test_what_is_warned_of_is_told_of_each():
    """A fixed step that is too long keeps no energy."""
    runs = kn.simulate_many(
        TWO, (0, 3), q={"q1": [0.1, 2.5], "q2": 0}, u=[0, 0], method="rk4", max_step=0.1, samples=5, threads=2
    )
    with pytest.warns(kn.KaneWarning) as told:
        kn.simulate(TWO, (0, 3), q=[2.5, 0], u=[0, 0], method="rk4", max_step=0.1, samples=5)
    assert runs.warning.values[1] == str(told[0].message)


def test_outputs_and_reductions():
    q = spread(0.1, 1.0, 5)
    outputs = {"energy": TWO.energy, "height": kn.cos(TWO.coordinates[0]), "F": TWO.coordinates[1]}
    given = {"q": {"q1": q, "q2": 0}, "u": [0, 0], "parameters": {"m1": spread(1, 2, 5)}, "samples": 9}
    runs = kn.simulate_many(TWO, (0, 1), **given, outputs=outputs)
    assert "q1" not in runs
    for n in range(5):
        own = {"q": [q[n], 0], "u": [0, 0], "parameters": {"m1": spread(1, 2, 5)[n]}, "samples": 9}
        sol = kn.simulate(TWO, (0, 1), **own)
        for name, what in outputs.items():
            np.testing.assert_allclose(runs[name].values[n], sol[what], rtol=1e-13, atol=1e-13)
    for name in ("last", "max", "min", "mean"):
        less = kn.simulate_many(TWO, (0, 1), **given, outputs=outputs, reduce=name)
        whole = runs["height"].isel(t=-1) if name == "last" else getattr(runs["height"], name)("t")
        np.testing.assert_allclose(less["height"], whole, rtol=1e-14)
        assert less["height"].dims == ("instance",)
    own = kn.simulate_many(TWO, (0, 1), **given, outputs=outputs, reduce={"height": np.ptp})
    np.testing.assert_allclose(own["height"], runs["height"].max("t") - runs["height"].min("t"), rtol=1e-14)
    assert own["energy"].dims == ("instance", "t")


def test_reductions_stop_where_the_motion_does():
    runs = kn.simulate_many(LANDS, (0, 2), q={x: [1.0, 2.0]}, u={v: 0}, samples=201, reduce="min")
    assert np.all(runs["x"].values >= 0)
    assert np.all(np.isfinite(runs["v"].values))


# Lanes ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("threads", [1, 2])
def test_motions_in_lanes_are_those_of_one(threads):
    """Bit for bit where nothing is contracted, with parameters that differ or not, and few samples or none at the end."""
    q, mass = np.random.default_rng(1).uniform(-2, 2, (70, 2)), spread(1, 3, 70)
    for more in ({"samples": 5}, {"samples": [0.5, 1.25]}, {"samples": 3, "method": "tsitpap8"}):
        for own in ({}, {"m1": mass}):
            runs = kn.simulate_many(
                TWO, (0, 2), q=q, u=[0, 0.1], parameters=own, settings=EXACT, threads=threads, **more
            )
            given = [
                {"method": "vern9"}
                | more
                | {"q": q[n], "u": [0, 0.1], "parameters": {s: c[n] for s, c in own.items()}, "settings": EXACT}
                for n in range(0, 70, 9)
            ]
            one_by_one(TWO, (0, 2), runs.isel(instance=slice(0, 70, 9)), given)


@pytest.mark.parametrize(("eom", "end"), [(BALL, 1.5), (LANDS, 0.5)], ids=["acts", "ends"])
def test_events_in_lanes(eom, end):
    heights = spread(0.2, 2, 20)
    given = {"u": {v: 0}, "samples": 16, "settings": EXACT, "method": "dop853"}
    runs = kn.simulate_many(eom, (0, end), q={x: heights}, lanes=True, **given)
    one_by_one(eom, (0, end), runs, [{"q": {x: h}, **given} for h in heights])


@pytest.mark.slow
def test_closed_loops_in_lanes():
    eom = kn.derive(four_bar.system())
    start = kn.assemble(eom, q={"q1": 1.2, **{c: kn.guess(0.3) for c in eom.coordinates[1:]}})
    near, angles = {c: kn.guess(start.q[c]) for c in eom.coordinates[1:]}, spread(1.1, 1.3, 20)
    name = eom.parameters[0].name
    for own in ({}, {name: spread(1.0, 1.02, 20) * eom.parameters[0].default}):
        given = {"u": {eom.independent_speeds[0]: 0.5}, "samples": 6, "settings": EXACT, "method": "dop853"}
        runs = kn.simulate_many(eom, (0, 1), q={"q1": angles, **near}, parameters=own, lanes=True, **given)
        one_by_one(
            eom,
            (0, 1),
            runs,
            [
                {"q": {"q1": a, **near}, "parameters": {s: c[n] for s, c in own.items()}, **given}
                for n, a in enumerate(angles)
            ],
            rounding=1e-11,
        )


@pytest.mark.grows
@pytest.mark.parametrize(
    ("system", "names", "share"),
    [(four_bar, "abcd", 0.35), (slider_crank, None, 0.3)],
    ids=["four-bar", "slider-crank"],
)
def test_starts_on_constraints_are_found_together(system, names, share, rng):
    """Lengths differ by a third, so that some links do not reach each other: each instance is on the branch that it is on alone."""
    eom, count = kn.derive(system.system()), 70 if FULL else 24
    own = {s.name: s.default for s in eom.parameters if names is None or s.name in names}
    parameters = {name: value * (1 + share * rng.uniform(-1, 1, count)) for name, value in own.items()}
    begin_alike(eom, 0.02, parameters=parameters, **system.START)


def begin_alike(eom, end, **given):
    """Motions in lanes begin, or fail, as each does alone, and go the same way."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        together, alone = (
            kn.simulate_many(eom, (0, end), samples=3, lanes=lanes, **given, **KERNELS) for lanes in (True, False)
        )
    assert list(together.status.values) == list(alone.status.values)
    assert list(together.cause.values) == list(alone.cause.values)
    for s in eom.state:
        ours, theirs = together[s.name].values, alone[s.name].values
        np.testing.assert_allclose(ours[:, 0], theirs[:, 0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6)
    return list(alone.cause.values)


@pytest.mark.grows
@pytest.mark.parametrize("guesses", [(-3.672, -3.868), pytest.param((0.853, 1.836), marks=pytest.mark.slow)])
def test_starts_far_from_their_guesses(guesses, rng):
    """The first four-bar does not close; from far away Newton's steps of others come to the further branch alone."""
    eom, count = kn.derive(four_bar.system()), 120 if FULL else 40
    own = {"a": 0.4, "b": 1.0, "c": 0.8, "d": 1.1}
    parameters = {name: value * rng.uniform(0.5, 1.8, count) for name, value in own.items()}
    parameters["d"][0] = 4.0
    q = {"q1": rng.uniform(-3, 3, count), "q2": kn.guess(guesses[0]), "q3": kn.guess(guesses[1])}
    begin_alike(eom, 0.001, q=q, u={"u1": 3.0}, parameters=parameters)


def test_starts_whose_nearest_branch_the_first_does_not_have():
    """A point of a coupler is moved: six branches or fewer, by lengths, of which Newton's steps from far away do not see all."""
    N, parts = kn.Frame("N"), list[kn.RigidBody]()
    O = kn.Point("O", fixed_in=N)
    own = {
        "a": [0.688, 0.811, 0.826],
        "b": [0.707, 0.761, 0.797],
        "c": [1.062, 1.025, 0.995],
        "d": [1.318, 0.978, 0.937],
        "e": [0.493, 0.588, 0.623],
    }
    q, x, lengths = kn.coordinates("q1:4"), kn.coordinate("x"), [kn.parameter(name, v[0]) for name, v in own.items()]
    place = O.at("pivot", 0)
    for name, angle, length in zip("ABC", q, lengths, strict=False):
        frame = N.rotate(name, angle, N.z)
        center, inertia = place.at(f"{name}*", length / 2 * frame.x), kn.inertia(frame, 0.01, 0.1, 0.1)
        parts.append(kn.RigidBody(name, frame=frame, mass_center=center, mass=1, inertia=inertia))
        place = place.at(f"end {name}", length * frame.x)
    point, slide = parts[1].mass_center.at("P", lengths[4] * parts[1].frame.y), O.at("S", x * N.x)
    loop = kn.coincident(place, O.at("anchor", lengths[3] * N.x), along=(N.x, N.y), name="loop")
    slider = kn.coincident(point, slide, along=(N.x,), name="slider")
    bodies = [*parts, kn.Particle("slide", slide, 1.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, holonomic=[*loop, *slider], speeds="rates"))
    guesses = dict(zip(("q1", "q2", "q3"), map(kn.guess, (-0.98, 1.586, 1.582)), strict=True))
    begin_alike(eom, 5e-4, q=guesses | {"x": [0.198, 0.241, 0.195]}, u={"u_x": 0.1}, parameters=own)


@pytest.mark.grows
@pytest.mark.parametrize("guesses", [(1.2, 0.1), pytest.param((3.0, 5.0), marks=pytest.mark.slow)])
def test_starts_between_lengths_and_angles(guesses, rng):
    """Which branch is nearer is told by lengths beside angles, in sizes that differ from slider-crank to slider-crank."""
    eom, count = kn.derive(slider_crank.system()), 120 if FULL else 40
    size = 10 ** rng.uniform(-1, 1, count)
    parameters = {name: x * size * rng.uniform(0.5, 1.5, count) for name, x in (("r", 0.08), ("l", 0.24))}
    q = {"q1": rng.uniform(-3, 3, count), "q2": kn.guess(guesses[0]), "x": kn.guess(guesses[1])}
    begin_alike(eom, 0.001, q=q, u={"u1": 3.0}, parameters=parameters)


@pytest.mark.parametrize(
    ("u", "told"),
    [
        (None, "either u= or rates="),
        ({"u1": kn.guess(3.0)}, "too few"),
        ({"u2": 1 + 2j}, "a number as the start value"),
    ],
    ids=["none", "too few", "complex"],
)
def test_speeds_that_are_no_start(u, told):
    """What is wrong with the speeds of one motion is wrong with those of many."""
    q = {"q1": np.linspace(0.8, 1.2, 66), "q2": kn.guess(0.4), "q3": kn.guess(-1.5)}
    causes = begin_alike(kn.derive(four_bar.system()), 0.01, q=q, u=u)
    assert all(told in cause for cause in causes)


def test_states_that_are_no_numbers():
    z = kn.state("z")
    eom = BAR.derive(states={z: -z})
    q = {"q1": np.linspace(0.8, 1.2, 66), "q2": kn.guess(0.4), "q3": kn.guess(-1.5)}
    causes = begin_alike(eom, 0.01, q=q, u={"u1": 1.0}, states={"z": 1 + 1j})
    assert all("a number as the start value for z" in cause for cause in causes)


@pytest.mark.slow
def test_beams_bent_beyond_their_equations():
    """Where the kinetic energy would be negative there is no motion, of many as of one."""
    eom, bent = kn.derive(flexible_slider_crank.system()), np.linspace(0, 0.12, 66)
    q = {"q_crank": 0.5, "v1_rod": bent, "v2_rod": -bent, "q_wrist": kn.guess(0.1), "x": kn.guess(0.1)}
    causes = begin_alike(eom, 1e-4, q=q, u={u.name: 0.0 for u in eom.independent_speeds})
    assert 0 < sum("kinetic energy ≥ 0" in cause for cause in causes) < 66


def test_starts_that_are_given_whole_and_in_doubt():
    """Starts that miss the constraints are named one by one; a dead point is left to what judges one motion."""
    eom = kn.derive(four_bar.system())
    start = kn.assemble(eom, **{k: four_bar.START[k] for k in ("q", "u")})
    whole = {s: np.full(66, value) for s, value in start.q.items()}
    whole[eom.coordinates[1]][3] += 0.1
    runs = kn.simulate_many(eom, (0, 0.1), q=whole, u=start.u, samples=3, lanes=True, **KERNELS)
    assert [int(k) for k in np.flatnonzero(runs.status.values == "failed")] == [3]
    assert "coordinates that miss" in str(runs.cause.values[3])
    sol = kn.simulate(eom, (0, 0.1), q=start.q, u=start.u, samples=3, **KERNELS)
    np.testing.assert_allclose(runs["q3"].values[0], sol["q3"], rtol=0, atol=1e-9)


def test_few_instances_go_without_lanes():
    """From a number of instances on there are lanes, unless told; both are as near to the motion as the tolerances say."""
    q = spread(0.1, 0.5, 64)
    given = {"u": [0, 0], "samples": 3, "settings": EXACT}
    few = kn.simulate_many(TWO, (0, 1), q={"q1": q[:63], "q2": 0}, **given)
    alone = kn.simulate_many(TWO, (0, 1), q={"q1": q, "q2": 0}, lanes=False, **given)
    many = kn.simulate_many(TWO, (0, 1), q={"q1": q, "q2": 0}, **given)
    assert np.array_equal(few["q1"], alone["q1"][:63])
    assert np.array_equal(alone["q1"][5], kn.simulate(TWO, (0, 1), q=[q[5], 0], **given).states[:, 0])
    np.testing.assert_allclose(many["q1"], alone["q1"], atol=1e-8)
    np.testing.assert_allclose(
        many["q1"], kn.simulate_many(TWO, (0, 1), q={"q1": q, "q2": 0}, **given | {"settings": None})["q1"], atol=1e-8
    )


# Instances -----------------------------------------------------------------------------------------------------------


def test_tables_of_pandas_and_xarray():
    pandas, xarray = require("pandas"), require("xarray")
    q, mass = spread(0, 1, 3), spread(1, 2, 3)
    usual = kn.simulate_many(TWO, (0, 1), q={"q1": q, "q2": 0.5}, u=[0, 0], parameters={"m1": mass}, samples=3)
    frame = pandas.DataFrame({"q1": q, "m1": mass})
    table = xarray.Dataset({"q1": ("run", q), "m1": ("run", mass)})
    for design in (frame, table, {"q1": q, "m1": list(mass)}):
        own = kn.simulate_many(TWO, (0, 1), q={"q2": 0.5}, u=[0, 0], design=design, samples=3)
        assert own.identical(usual)
    own = kn.simulate_many(TWO, (0, 1), q={"q1": frame["q1"], "q2": 0.5}, u=[0, 0], parameters=frame[["m1"]], samples=3)
    assert own.identical(usual)


@pytest.mark.parametrize("sampler", ["sobol", "latin", "halton", "uniform"])
def test_designs_between_bounds(sampler):
    given = {"design": {"m1": (1, 2), "q1": (0, 0.5)}, "sampler": sampler, "q": {"q2": 0}, "u": [0, 0], "samples": 2}
    runs = kn.simulate_many(TWO, (0, 0.1), **given, count=37)
    assert runs.sizes["instance"] == 37
    assert 1 <= runs["m1"].min() < 1.2
    assert 1.8 < runs["m1"].max() <= 2
    assert 0 <= runs["q1(0)"].min() < runs["q1(0)"].max() <= 0.5
    assert runs.identical(kn.simulate_many(TWO, (0, 0.1), **given, count=37))
    other = kn.simulate_many(TWO, (0, 0.1), **given, count=37, seed=1)
    assert not np.array_equal(other["m1"], runs["m1"])


def test_a_product_has_every_combination():
    given = {"design": {"m1": [1, 2], "q1": [0.1, 0.2, 0.3]}, "sampler": "product", "q": {"q2": 0}, "u": [0, 0]}
    runs = kn.simulate_many(TWO, (0, 0.1), **given, samples=2)
    assert list(zip(runs["m1"].values, runs["q1(0)"].values, strict=True)) == [
        (a, b) for a in (1, 2) for b in (0.1, 0.2, 0.3)
    ]


def test_numbers_alone_are_one_instance():
    assert kn.simulate_many(TWO, (0, 1), q=[0.1, 0], u=[0, 0], samples=3).sizes["instance"] == 1


def test_a_range_has_a_number_for_each():
    many, listed = (
        kn.simulate_many(TWO, (0, 1), q={"q1": own, "q2": 0.1}, u=0, samples=3) for own in (range(3), [0.0, 1.0, 2.0])
    )
    np.testing.assert_array_equal(many["end_state"], listed["end_state"])


START = {"q": [0.1, 0.2], "u": [0, 0]}


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        (
            {"q": {"q1": [1, 2, 3], "q2": 0}, "u": [0, 0], "parameters": {"m1": [1, 2]}},
            kn.SimulationError,
            r"arrays of one length.* got 3 for q1 \(q\), 2 for m1 \(parameters\)\. Give as many of each",
        ),
        (START | {"q": np.zeros((5, 3))}, kn.SimulationError, r"\(instances × 2\) of q1, q2.* got the shape \(5, 3\)"),
        (START | {"q": [[0.1, 0.2], 3]}, kn.SimulationError, r"as a dict.*Give a dict"),
        (START | {"parameters": {"m1": np.ones((2, 2))}}, kn.SimulationError, r"one axis, the instances, for m1"),
        (START | {"parameters": {"m9": [1, 2]}}, kn.errors.ValueMissingError, r"got one for 'm9'\. Did you mean"),
        (START | {"parameters": {"m1": []}}, kn.SimulationError, r"at least one instance.* for m1"),
        (START | {"parameters": {"m1": ["a", "b"]}}, kn.SimulationError, r"numbers for m1 in parameters"),
        (START | {"parameters": {"m1": "a"}}, kn.SimulationError, r"a number as the value for m1, got 'a'"),
        (START | {"parameters": {"m1": None}}, kn.SimulationError, r"a number as the value for m1, got None"),
        (
            START | {"design": {"m1": [1, np.nan, 3]}},
            kn.SimulationError,
            r"finite numbers for m1 in parameters, got nan for instance 1, 1 of 3",
        ),
        (START | {"design": {"q1": [1, 2]}}, kn.errors.ValueMissingError, r"one value for q1, got two, by q= and by"),
        (START | {"design": {"b": (1, 2)}, "sampler": "sobol", "count": 3}, kn.errors.ValueMissingError, r"got 'b'"),
        (START | {"design": {"m1": (2, 1)}, "sampler": "sobol", "count": 3}, kn.SimulationError, r"two bounds"),
        (
            START | {"design": {"m1": (np.nan, 1)}, "sampler": "latin", "count": 3},
            kn.SimulationError,
            r"two bounds \(low, high\) for m1 in a design, got \(nan, 1\)",
        ),
        (START | {"design": {"m1": (1, 2)}, "sampler": "sobol"}, kn.SimulationError, r"count=.*got None"),
        (START | {"design": {"m1": (1, 2)}, "sampler": "sobol", "count": 0}, kn.SimulationError, r"count=.*got 0"),
        (START | {"design": {"m1": (1, 2)}, "sampler": "sobl", "count": 2}, kn.SimulationError, r"Did you mean sobol"),
        (START | {"design": {"m1": (1, 2)}, "count": 2}, kn.SimulationError, r"Expected sampler= where count="),
        (START | {"design": {"m1": [1, 2]}, "sampler": "product", "count": 2}, kn.SimulationError, r"no count or seed"),
        (START | {"design": {}, "sampler": "sobol", "count": 2}, kn.SimulationError, r"at least one quantity"),
        (START | {"design": 3}, kn.SimulationError, r"a design as a dict"),
        (START | {"reduce": "median"}, kn.SimulationError, r"reduce= to be one of last, max, min, mean"),
        (START | {"reduce": {"b": "max"}}, kn.SimulationError, r"reduce= to name outputs"),
        (START | {"threads": 0}, kn.SimulationError, r"threads= as a whole number above 0"),
        (START | {"outputs": [1]}, kn.errors.ArgumentError, r"outputs as a dict"),
        (START | {"samples": 0.5}, kn.SimulationError, r"samples"),
    ],
)
def test_bad_input(given, error, told):
    with pytest.raises(error, match=told):
        kn.simulate_many(TWO, (0, 1), **given)


def test_without_xarray(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "xarray", None)
    with pytest.raises(ImportError, match=r"pip install 'kane\[table\]'"):
        kn.simulate_many(TWO, (0, 1), **START)


def test_values_that_are_surely_admitted_are_admitted() -> None:
    """A column of masses and moments at once says what each row says by itself, where it says something."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, a = kn.coordinates("x a")
    B = N.rotate("B", a, N.z)
    m, i, j = (kn.parameter(name, default) for name, default in (("m", 1.0), ("i", 1.0), ("j", 0.1)))
    body = kn.RigidBody("body", frame=B, mass_center=O.at("C", x * N.x), mass=m, inertia=kn.inertia(B, i, i, i, j))
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates"))
    rng = np.random.default_rng(1)
    p = rng.uniform(-0.5, 2, (200, 3))
    p[0, 0] = np.nan
    sure = surely_admitted(eom, p)
    right = []
    for row in p:
        try:
            check_values(eom, row, (0.0, 1.0))
            right.append(True)
        except kn.SimulationError:
            right.append(False)
    assert 20 < sure.sum() < 180
    np.testing.assert_array_equal(sure[1:], right[1:])
    assert not sure[0]
