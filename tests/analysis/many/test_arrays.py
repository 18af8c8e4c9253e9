# SPDX-License-Identifier: BSD-3-Clause
"""Analyses of many states: equal to those one by one, on one branch, and marked where that ends."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import bricard, four_bar, pendulums, pure_rolling_disk
from tests.peer import require
from tests.systems import stewart

xarray = require("xarray")

LINKAGE = four_bar.system()
DRIVE = kn.input("drive", "N*m")
CRANK = next(part.frame for part in LINKAGE.bodies[0].parts() if part.frame is not None)
U1, *OTHERS = LINKAGE.speeds
WEIGHT = kn.gravity(-9.81 * LINKAGE.inertial.y)
BAR = kn.derive(
    LINKAGE.replace(
        loads=[WEIGHT, kn.Torque(CRANK, DRIVE * CRANK.z)],
        reactions=[],
        dependent_speeds=OTHERS,
        dependent_coordinates=LINKAGE.coordinates[1:],
    )
)
TWO = kn.derive(pendulums.system(2))
A, B, C, D = 0.4, 1.0, 0.8, 1.1
TURN = np.linspace(0, 2 * np.pi, 73)
OPEN = {"q2": kn.guess(0.9), "q3": kn.guess(-1.4)}


@pytest.fixture(scope="module")
def turn():
    return kn.assemble(BAR, q={"q1": TURN, **OPEN}, u={"u1": 5.0})


@pytest.fixture(scope="module")
def platform():
    return kn.derive(stewart.system())


def column(found, eom, k):
    """The kth state of a Dataset."""
    return {
        kind: {s: float(found[s.name][k]) for s in own} for kind, own in (("q", eom.coordinates), ("u", eom.speeds))
    }


def close(found, wanted, share=1e-12):
    found, wanted = np.asarray(found, dtype=float), np.asarray(wanted, dtype=float)
    assert np.abs(found - wanted).max() <= share * max(1.0, np.abs(wanted).max())


# Assembly ------------------------------------------------------------------------------------------------------------


def test_a_turn_of_a_crank_beside_freudenstein(turn):
    """K₁ cos q3′ − K₂ cos q1 + K₃ = cos(q1 − q3′) of the rocker's angle q3′ = q3 + π (Freudenstein 1955), on one branch."""
    rocker = turn["q3"].values + np.pi
    k1, k2, k3 = D / A, D / C, (A**2 - B**2 + C**2 + D**2) / (2 * A * C)
    close(k1 * np.cos(rocker) - k2 * np.cos(TURN) + k3, np.cos(TURN - rocker))
    # its solution in closed form, of which the other sign is the other branch
    u, v, w = k1 - np.cos(TURN), -np.sin(TURN), k3 - k2 * np.cos(TURN)
    both = [np.arctan2(v, u) + sign * np.arccos(-w / np.hypot(u, v)) for sign in (1, -1)]
    apart = [np.abs((branch - rocker + np.pi) % (2 * np.pi) - np.pi).max() for branch in both]
    assert min(apart) < 1e-12
    assert max(apart) > 0.5
    assert set(turn["status"].values) == {"found"}
    assert np.abs(np.diff(rocker)).max() < 0.2
    close(turn["q3"].values[0], turn["q3"].values[-1])
    assert turn["residual"].max() < 1e-14


def test_poses_are_those_of_a_loop(turn):
    before = OPEN
    for k in range(0, len(TURN), 6):
        one = kn.assemble(BAR, q={"q1": TURN[k], **before}, u={"u1": 5.0})
        close([turn[s.name].values[k] for s in BAR.state], [one.state[s] for s in BAR.state])
        before = {s.name: kn.guess(one.q[s]) for s in BAR.coordinates[1:]}


@pytest.mark.parametrize("count", [4, 9])
def test_long_steps_are_subdivided(turn, count):
    """A turn in four steps comes through the places that one in 72 steps has."""
    few = kn.assemble(BAR, q={"q1": np.linspace(0, 2 * np.pi, count), **OPEN}, u={"u1": 5.0})
    close(few["q3"].values, turn["q3"].values[:: 72 // (count - 1)])


def test_a_tree_takes_arrays():
    q, mass = np.linspace(-1, 1, 7), np.linspace(1, 2, 7)
    found = kn.assemble(TWO, q={"q1": q, "q2": 0.3}, u=[0.1, -q[0]], parameters={"m1": mass})
    assert np.array_equal(found["q1"], q)
    assert np.array_equal(found["u2"], np.ones(7))
    assert np.array_equal(found["m1"], mass)


def test_parameters_and_times_along_an_array():
    """A crank of another length, each from the one before, and a drive θ = t by the time."""
    a = np.linspace(0.3, 0.5, 5)
    found = kn.assemble(BAR, q={"q1": 1.2, **OPEN}, u={"u1": 1.0}, parameters={"a": a})
    for k in (0, 4):
        one = kn.assemble(BAR, q={"q1": 1.2, **OPEN}, u={"u1": 1.0}, parameters={"a": a[k]})
        close([found[s.name].values[k] for s in BAR.state], [one.state[s] for s in BAR.state])


def test_times_along_an_array():
    """A crank that turns by ω t: the place is that of its angle, its speed ω."""
    omega = kn.parameter("omega", 2.0)
    driven = kn.configuration_constraint("drive", LINKAGE.coordinates[0] - omega * kn.time)
    eom = kn.derive(LINKAGE.replace(reactions=[], holonomic=[*LINKAGE.holonomic, driven]))
    found = kn.assemble(eom, q={"q1": kn.guess(0.0), **OPEN}, u={}, t=TURN / 2)
    close(found["q1"].values, TURN)
    close(found["u1"].values, 2.0)
    assert found["t"].attrs["units"] == "s"


def test_a_spatial_loop_with_a_row_that_follows_from_others():
    with pytest.warns(kn.KaneWarning, match="redundant"):
        eom = kn.derive(bricard.system(redundant=True))
    angle = np.linspace(0, 0.6, 7)
    start = {f"q{k}": kn.guess(0.0) for k in range(2, 6)}
    found = kn.assemble(eom, q={"q1": angle, **start}, u={"u1": 1.0})
    assert set(found["status"].values) == {"found"}
    before = start
    for k in range(7):
        one = kn.assemble(eom, q={"q1": angle[k], **before}, u={"u1": 1.0})
        close([found[s.name].values[k] for s in eom.state], [one.state[s] for s in eom.state], 1e-11)
        before = {f"q{i}": kn.guess(one.state[f"q{i}"]) for i in range(2, 6)}


@pytest.mark.slow
def test_a_trajectory_of_a_stewart_platform(platform):
    """The legs' lengths are the distances of their ends."""
    s = np.linspace(0, 2 * np.pi, 37)
    path = {
        "x": 0.2 * np.cos(s),
        "y": 0.2 * np.sin(s),
        "z": 1.2 + 0.1 * np.sin(2 * s),
        "a1": 0,
        "a2": 0,
        "a3": 0.3 * np.sin(s),
    }
    legs = {f"{name}{k}": kn.guess(x) for k in stewart.LEGS for name, x in (("al", 0.0), ("be", 0.0), ("s", 1.2))}
    found = kn.assemble(platform, q=path | legs, u={f"u_{name}": 0.1 for name in stewart.PLATFORM})
    assert set(found["status"].values) == {"found"}
    base, top = -0.3, -np.pi / 3 + 0.4
    across = path["a3"] + top
    ends = np.array(
        [path["x"] + 0.5 * np.cos(across) - np.cos(base), path["y"] + 0.5 * np.sin(across) - np.sin(base), path["z"]]
    )
    close(found["s0"].values, np.linalg.norm(ends, axis=0))
    forces = kn.inverse(platform, [f"f{k}" for k in stewart.LEGS])
    given = {f"{u.name}'": 0.0 for u in platform.independent_speeds}
    all_at_once = forces(found, given=given)
    for k in (0, 17):
        one = forces(**column(found, platform, k), given=given)
        close([all_at_once[f.name].values[k] for f in one], list(one.values()), 1e-11)


def test_what_is_out_of_reach_is_marked_and_others_go_on():
    """The rocker as the driver turns back where crank and coupler are in line."""
    rocker = np.concatenate([np.linspace(-1.4, -0.2, 13), np.linspace(-0.4, -1.4, 6)])
    found = kn.assemble(BAR, q={"q1": kn.guess(0.1), "q2": kn.guess(0.9), "q3": rocker}, u={"u3": 0.2})
    tip = np.stack([D - C * np.cos(rocker), -C * np.sin(rocker)])
    reach = np.linalg.norm(tip, axis=0)
    possible = (reach <= A + B) & (reach >= B - A)
    assert 0 < possible.sum() < len(rocker)
    assert np.array_equal(found["status"].values == "found", possible)
    first = int(np.argmin(possible))
    assert np.isnan(found["q1"].values[~possible]).all()
    assert f"got the end of this branch on the way from instance {first - 1}" in found["cause"].values[first]
    later = len(rocker) - 1
    close([found[f"q{i}"].values[later] for i in (1, 2, 3)], [found[f"q{i}"].values[0] for i in (1, 2, 3)])


def test_a_first_pose_out_of_reach_is_marked():
    found = kn.assemble(BAR, q={"q1": 0.3, **OPEN}, u={"u1": 1.0}, parameters={"b": [0.05, 1.0, 1.1]})
    assert found["status"].values.tolist() == ["failed", "found", "found"]
    assert "residual" in found["cause"].values[0]


# Inverse dynamics, forces, linear equations, steady motions ------------------------------------------------------------


def test_inverse_dynamics_along_poses(turn):
    inverse = kn.inverse(BAR, [DRIVE])
    found = inverse(turn, given={"u1'": 0.0})
    one_by_one = [inverse(**column(turn, BAR, k), given={"u1'": 0.0})[DRIVE] for k in range(0, 73, 12)]
    close(found["drive"].values[::12], one_by_one)
    assert found["drive"].attrs["units"] == "N*m"
    assert abs(np.trapezoid(found["drive"], TURN)) < 1e-6  # no work is left after a turn
    mass = np.linspace(1, 2, 73)
    heavier = inverse(turn, parameters={"m2": mass}, given={"u1'": 0.0})
    close(
        heavier["drive"].values[60],
        inverse(**column(turn, BAR, 60), parameters={"m2": mass[60]}, given={"u1'": 0.0})[DRIVE],
    )


def test_forces_of_constraints_along_poses(turn):
    found = kn.constraint_forces(BAR, turn, inputs={"drive": TURN})
    for k in (0, 30, 72):
        one = kn.constraint_forces(BAR, **column(turn, BAR, k), inputs={"drive": TURN[k]})
        close(found["by_multipliers"].values[k], list(one.by_multipliers.values()))
        close(found["by_auxiliary_speeds"].values[k], list(one.by_auxiliary_speeds.values()), 1e-10)
    assert found["constraint"].values.tolist() == [c.name for c in BAR.system.constraints]


def test_speeds_that_miss_constraints_are_marked(turn):
    wrong = turn["u2"].values.copy()
    wrong[3] += 1.0
    found = kn.constraint_forces(BAR, turn.assign(u2=("instance", wrong)), inputs={"drive": 0.0})
    assert np.flatnonzero(found["status"].values == "failed").tolist() == [3]
    assert "miss" in found["cause"].values[3]
    assert np.isnan(found["by_multipliers"].values[3]).all()


def test_linear_equations_of_many(turn):
    linearizer = kn.linearizer(BAR, outputs={"rocker": BAR.coordinates[2], "pull": BAR.speeds[1].dt})
    found = linearizer(turn, inputs={"drive": 1.0}, steady=False)
    for k in range(0, 73, 24):
        one = linearizer(**column(turn, BAR, k), inputs={"drive": 1.0}, steady=False)
        assert tuple(found["state"].values) == one.states
        for name in "ABCD":
            close(found[name].values[k], getattr(one, name))
        close(found["rates"].values[k], one.rates)
        close(found["output_values"].values[k], one.values)
    assert found["C"].dims == ("instance", "output", "state")


def test_steady_motions_are_linearized_and_others_marked():
    """What hangs is in equilibrium, what is displaced is not."""
    q = {"q1": np.array([0.0, 0.0, 0.2]), "q2": 0.0}
    found = kn.linearize(TWO, q=q, u=[0, 0])
    assert found["status"].values.tolist() == ["found", "found", "failed"]
    assert "kn.trim" in found["cause"].values[2]
    close(found["A"].values[1], kn.linearize(TWO, q=[0, 0], u=[0, 0]).A)


def test_linear_equations_of_a_tree():
    q = np.linspace(-1, 1, 5)
    found = kn.linearize(TWO, q={"q1": q, "q2": 0.2}, u=[0.3, 0], steady=False)
    for k in range(5):
        one = kn.linearize(TWO, q={"q1": q[k], "q2": 0.2}, u=[0.3, 0], steady=False)
        close(found["A"].values[k], one.A)


def test_equilibria_under_a_load_that_grows():
    """The branch ends where the torque is larger than any weight can hold."""
    torque = np.linspace(0, 14, 15)
    guess = {"q1": kn.guess(-1.9), "q2": kn.guess(1.0), "q3": kn.guess(-0.6)}
    found = kn.trim(BAR, q=guess, inputs={"drive": torque})
    status = found["status"].values
    assert status[0] == "found"
    assert status[-1] == "failed"
    assert "got the end of this branch on the way from instance" in found["cause"].values[-1]
    last = int(np.argmin(status == "found")) - 1
    for k in (0, last):
        own = {f"q{i}": kn.guess(float(found[f"q{i}"][k])) for i in (1, 2, 3)}
        one = kn.trim(BAR, q=own, inputs={"drive": torque[k]})
        close([found[s.name].values[k] for s in BAR.state], [one[s] for s in BAR.state], 1e-9)


def test_torques_that_hold_a_crank_beside_virtual_work(turn):
    """T u1 = d/dt of the weights' energy; guessed from zero, however far the torque goes from there."""
    found = kn.trim(BAR, q={"q1": TURN, **OPEN}, inputs={"drive": kn.guess(0.0)})
    assert set(found["status"].values) == {"found"}
    m1, m2, m3 = 0.8, 2.0, 1.6
    rates = [np.cos(turn[f"q{i}"].values) * turn[f"u{i}"].values for i in (1, 2, 3)]
    shares = (A * (m1 / 2 + m2 + m3), B * (m2 / 2 + m3), C * m3 / 2)
    power = 9.81 * sum(x * rate for x, rate in zip(shares, rates, strict=True))
    close(found["drive"], power / turn["u1"].values, 1e-9)


def two_torques() -> kn.Equations:
    """Two rods; of two torques sought one turns both, so that with k = 1 there is none that holds them."""
    frame, k = kn.Frame("N"), kn.parameter("k", 1.0)
    base = kn.Point("O", fixed_in=frame)
    first = kn.pin("h1", base, frame, axis=frame.z)
    a = first.point.at("A", -0.5 * first.frame.y)
    second = kn.pin("h2", a, frame, axis=frame.z)
    b = second.point.at("B", -0.5 * second.frame.y)
    one, two = kn.input("T"), kn.input("S")
    torques = [kn.Torque(first.frame, (one + k * two) * frame.z), kn.Torque(second.frame, (one + two) * frame.z)]
    bodies = [kn.Particle("a", a, 1.0), kn.Particle("b", b, 1.0)]
    return kn.derive(
        kn.System(frame, bodies=bodies, joints=[first, second], loads=[kn.gravity(-9.81 * frame.y), *torques])
    )


def test_torques_that_cannot_hold_are_none_and_the_next_ones_are_found():
    eom, rng = two_torques(), np.random.default_rng(1)
    gains = np.array([2.0, 3.0, 1.0, 2.0])
    for _ in range(12):
        q = rng.uniform(0.2, 0.6, 2).tolist()
        sought = {"T": kn.guess(1.0), "S": kn.guess(1.0)}
        found = kn.trim(eom, q=q, u=0, inputs=sought, parameters={"k": gains})
        assert found["status"].values.tolist() == ["found", "found", "failed", "found"]
        first, second = (9.81 * 0.5 * np.sin(x) * m for x, m in zip(q, (2.0, 1.0), strict=True))
        np.testing.assert_allclose(found["T"] + gains * found["S"], [first, first, np.nan, first], rtol=1e-9)
        np.testing.assert_allclose(found["T"] + found["S"], [second, second, np.nan, second], rtol=1e-9)


@pytest.mark.parametrize(
    ("gains", "none"),
    [
        ([1, 0.5, 0, 1], [2]),
        ([1, 1e-8, 1, 2], []),
        ([1, 1e-6, 1, 2], []),
        ([1, 1e-100, 2], []),
        ([1, -1, 2], []),
    ],
)
def test_a_torque_through_a_gear_however_far_it_goes(gains, none):
    frame, k, torque = kn.Frame("N"), kn.parameter("k", 1.0), kn.input("T")
    hinge = kn.pin("h", kn.Point("O", fixed_in=frame), frame, axis=frame.z)
    bob = kn.Particle("a", hinge.point.at("A", -0.5 * hinge.frame.y), 1.0)
    loads = [kn.gravity(-9.81 * frame.y), kn.Torque(hinge.frame, k * torque * frame.z)]
    eom = kn.derive(kn.System(frame, bodies=[bob], joints=[hinge], loads=loads))
    found = kn.trim(eom, q=[0.5], u=0, inputs={torque: kn.guess(1.0)}, parameters={"k": np.array(gains, dtype=float)})
    failed = np.isin(np.arange(len(gains)), none)
    assert found["status"].values.tolist() == np.where(failed, "failed", "found").tolist()
    gear = np.where(failed, np.nan, np.array(gains, dtype=float))
    np.testing.assert_allclose(found["T"], 9.81 * 0.5 * np.sin(0.5) / gear, rtol=1e-12)


# Bad input -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        (
            {"q": {"q1": [1, 2, 3], **OPEN}, "u": {"u1": [1, 2]}},
            kn.SimulationError,
            r"got 3 for q1 \(q\), 2 for u1 \(u\)",
        ),
        ({"q": {"q1": [1, np.nan], **OPEN}}, kn.SimulationError, r"finite numbers for q1 in q, got nan for instance 1"),
        ({"q": {"q9": [1, 2], **OPEN}}, kn.errors.ValueMissingError, r"got one for 'q9'\. Did you mean"),
        ({"q": {"q1": [], **OPEN}}, kn.SimulationError, r"at least one instance"),
        ({"q": {"q1": np.ones((2, 2)), **OPEN}}, kn.SimulationError, r"one axis, the instances, for q1"),
        (
            {"q": {"q1": kn.guess(1.0), **OPEN}, "parameters": {"a": [0.4, 0.5]}},
            kn.SimulationError,
            r"got 1 guesses too many",
        ),
        ({"q": {"q1": [1, 2], **OPEN}, "all_branches": True}, kn.errors.ArgumentError, r"all_branches= for one state"),
    ],
)
def test_bad_input(given, error, told):
    with pytest.raises(error, match=told):
        kn.assemble(BAR, **given)


def test_a_value_twice(turn):
    with pytest.raises(kn.errors.ValueMissingError, match=r"one value for q1, got two, by the Dataset and by keyword"):
        kn.linearize(BAR, turn, q={"q1": 1.0})
    with pytest.raises(kn.SimulationError, match=r"73 values of each array beside the Dataset, got 2"):
        kn.linearize(BAR, turn, parameters={"a": [0.4, 0.5]})


def test_what_was_marked_stays_so():
    """A state that is none keeps its cause in what is asked of it."""
    found = kn.assemble(BAR, q={"q1": 0.3, **OPEN}, u={"u1": 1.0}, parameters={"b": [0.05, 1.0, 1.1]})
    forces = kn.inverse(BAR, [DRIVE])(found, given={"u1'": 0.0})
    assert forces["cause"].values.tolist() == found["cause"].values.tolist()
    assert np.isfinite(forces["drive"].values).tolist() == [False, True, True]


# What is given as one number, and what is left out -------------------------------------------------------------------


@pytest.fixture(scope="module")
def bead():
    """A bead on a circle, driven by a force less a further state that it drives."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x y")
    P, a = O.at("P", x * N.x + y * N.y), kn.state("a", 0.2)
    loads = [kn.gravity(-9.81 * N.y), kn.Force(P, (kn.input("F") - a) * N.x)]
    system = kn.System(
        N,
        bodies=[kn.Particle("p", P, 1.0)],
        speeds="rates",
        holonomic=[kn.distance(P, O, 1.0)],
        loads=loads,
        states={a: x - a},
    )
    return kn.derive(system)


PLACES = np.linspace(-0.5, 0.4, 4)


@pytest.mark.parametrize("force", [3, np.int64(3), np.float32(3), np.array(3.0)])
@pytest.mark.parametrize("lag", [0.3, PLACES])
def test_numbers_of_all_kinds_and_further_states_reach_every_linearization(bead, force, lag):
    """As at each state by itself: a NumPy integer was left out with what was solved for, further states came twice."""
    speeds = {bead.independent_speeds[0]: 0.0}
    found = kn.linearize(
        bead, q={"x": PLACES, "y": kn.guess(-1)}, u=speeds, states={"a": lag}, inputs={"F": force}, steady=False
    )
    for k, x in enumerate(PLACES):
        own = np.broadcast_to(lag, 4)[k]
        q, inputs = {"x": x, "y": kn.guess(-1)}, {"F": 3.0}
        one = kn.linearize(bead, q=q, u=speeds, states={"a": own}, inputs=inputs, steady=False)
        close(found.rates[k], one.rates)
        close(found.A[k], one.A)


def test_states_are_left_out_at_all_states():
    """Of two particles, one on a spring of several stiffnesses and one that is free, the free one's place is cyclic."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, z = kn.coordinates("x z")
    P, k = O.at("P", x * N.x), kn.parameter("k", 1.0)
    bodies = [kn.Particle("p", P, 1.0), kn.Particle("free", O.at("Q", z * N.y), 1.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.Force(P, -k * x * N.x)]))
    for gone in ("cyclic", "z", z, [z]):
        found = kn.linearize(eom, q=0, u=0, leave_out=gone, parameters={k: [1.0, 2.0, 3.0]})
        assert list(found.state.values) == ["x", *(u.name for u in eom.speeds)]
        close(found.A[:, 1, 0], [-1.0, -2.0, -3.0])


def test_values_beside_a_dataset_have_its_length(bead):
    states = kn.assemble(bead, q={"x": PLACES, "y": kn.guess(-1)})
    with pytest.raises(kn.SimulationError, match=r"4 values of each array beside the Dataset, got \(3,\) for F"):
        kn.inverse(bead, [u.dt for u in bead.speeds])(states, given={"F": np.zeros(3)})
    one, all_four = (kn.inverse(bead, [u.dt for u in bead.speeds])(states, given={"F": x}) for x in (np.ones(1), 1.0))
    assert one.equals(all_four)


def test_ragged_lists_are_named(bead):
    with pytest.raises(kn.SimulationError, match=r"numbers for x in q, got \[\[1, 2\], \[3\]\]"):
        kn.assemble(bead, q={"x": [[1, 2], [3]], "y": kn.guess(-1)})


def test_names_of_what_a_dataset_tells_are_taken():
    """A coordinate named status was overwritten by the texts."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x status")
    P = O.at("P", x * N.x + y * N.y)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", holonomic=[kn.distance(P, O, 1.0)]))
    with pytest.raises(kn.SimulationError, match=r"names other than instance, status, cause, residual, .*got 'status'"):
        kn.assemble(eom, q={x: PLACES, y: kn.guess(-1)})


def test_guesses_that_no_constraint_moves_are_kept():
    """A disk rolls without slip: constraints of its speeds alone, so that guessed coordinates are values."""
    eom = kn.derive(pure_rolling_disk.system())
    lean, (u1, u2, u3, *rest) = eom.coordinates[1], eom.speeds
    q = {c: kn.guess(0.1 * k) for k, c in enumerate(eom.coordinates)}
    u = {u1: 0.3, u2: 0.2, u3: -4.0} | {s: kn.guess(0.0) for s in rest}
    leans = np.array([0.2, 0.3, 0.4])
    many = kn.assemble(eom, q=q | {lean: leans}, u=u)
    for k, value in enumerate(leans):
        one = kn.assemble(eom, q=q | {lean: float(value)}, u=u)
        for s, x in (*one.q.items(), *one.u.items()):
            assert many[s.name].values[k] == pytest.approx(x, abs=1e-12)
