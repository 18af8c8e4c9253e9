# SPDX-License-Identifier: BSD-3-Clause
"""The bicycle that skids: each mode beside Newton and Euler in redundant coordinates, and upright braking beside closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import skidding_bicycle
from tests.literature.test_whipple import INERTIA, bodies_and_joints
from tests.oracles.loops.equations import loads
from tests.oracles.loops.joints import Joint, Rows, moving
from tests.oracles.loops.records import Pose, Twist, mark
from tests.oracles.loops.rows import stack

g, v, mu_k, mu_s = 9.81, 5.0, 0.7, 0.8
r_R, r_F, J_R, J_F, w = 0.3, 0.35, 0.12, 0.28, 1.02
M = 94.0
b, h = (85 * 0.3 + 4 * 0.9 + 3 * w) / M, (2 * r_R + 85 * 0.9 + 4 * 0.7 + 3 * r_F) / M
START = skidding_bicycle.START
SYSTEM = skidding_bicycle.system()
EOM = kn.derive(SYSTEM)
TIGHT = {"rtol": 1e-11, "atol": 1e-12}
NAMES = [c.name for c in SYSTEM.contacts]
MODES = (
    ("stick", "stick", "straight", "straight"),
    ("slip", "stick", "stick", "straight"),
    ("slip", "slip", "stick", "stick"),
    ("slip", "stick", "straight", "straight"),
    ("stick", "slip", "straight", "stick"),
    ("separated", "stick", "straight", "straight"),
    ("separated", "slip", "straight", "stick"),
    ("separated", "separated", "stick", "stick"),
)
TORQUES = {"T_R": 40.0, "T_F": 25.0, "T_delta": 3.0}


def brake(ends: Any) -> Rows:
    """What the wheel turns against the body that carries it, about the wheel's axle."""
    carrier, wheel = ends
    return moving(wheel.point().x, [], (wheel.omega() - carrier.omega()).along(wheel.axis(3)))


@pytest.mark.parametrize("modes", MODES, ids="-".join)
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2))])
def test_accelerations_of_each_mode(modes: tuple[str, ...], seed: int) -> None:
    """M a = f + Bᵀ λ, J a = −J̇ v, where of a wheel that slips B is n − μ v/|v|, of one that rolls or a brake that holds J."""
    rng = np.random.default_rng([33, seed])
    eom = kn.derive(SYSTEM.in_modes(dict(zip(NAMES, modes, strict=True))))
    q: dict[str, Any] = {s.name: x for s, x in zip(eom.coordinates, rng.uniform(-0.4, 0.4, 9), strict=True)}
    q |= {n: kn.guess(0.0) for n, m in zip(("z", "theta"), modes[:2], strict=True) if m != "separated"}
    free = dict(zip([s.name for s in eom.independent_speeds], rng.uniform(-3, 3, 9), strict=False))
    at = kn.assemble(eom, q=q, u=free)
    state: dict[str, Any] = {"q": at.q, "u": at.u}
    N = SYSTEM.inertial

    def vector(x: kn.Vector) -> Any:
        return np.array(eom.evaluate(x.components(N), **state), dtype=float)

    poses, twists = [], []
    for body in SYSTEM.rigid_bodies:
        own: Any = body.inertia.frames()[0] if body.name == "fork" else body.frame
        turned = np.column_stack([vector(a) for a in (own.x, own.y, own.z)])
        poses.append(Pose(vector(body.mass_center.position(body.mass_center.root())), turned))
        twists.append(Twist(vector(eom.velocities[body.mass_center]), vector(eom.angular_velocities[body.frame])))
    assert set(INERTIA) == {body.name for body in SYSTEM.rigid_bodies}
    bodies, joints = bodies_and_joints()
    y, center = np.array([0.0, 1.0, 0.0]), np.zeros(3)
    joints += [Joint(pair, (mark(center, y), mark(center, y)), brake) for pair in ((1, 0), (2, 3))]
    rows = stack(joints, poses, twists, 0.0)
    nu = np.concatenate([[*t.v, *t.w] for t in twists])
    first = np.cumsum([0, *(len(p.J) for p in rows.parts)])
    held, pushed = list(range(first[3])), [*rows.A[: first[3]]]
    assert np.abs(rows.A[held] @ nu).max() < 1e-11
    torques = np.zeros((4, 3))
    numbers: dict[str, float] = {}
    for k in (0, 1):
        normal, *level = range(first[3 + k], first[4 + k])
        if modes[k] == "separated":
            continue
        held.append(normal)
        pushed.append(rows.A[normal])
        if modes[k] == "slip":
            slip = rows.A[level] @ nu
            pushed[-1] = rows.A[normal] - mu_k * slip / np.linalg.norm(slip) @ rows.A[level]
        else:
            held += level
            pushed += [*rows.A[level]]
    for k, (wheel, carrier, size) in enumerate(((0, 1, "T_R"), (3, 2, "T_F"))):
        row = first[5 + k]
        if modes[2 + k] == "stick":
            held.append(row)
            pushed.append(rows.A[row])
            continue
        sense = float(np.sign(rows.A[row] @ nu))
        numbers["d_rear_brake" if size == "T_R" else "d_front_brake"] = sense
        torque = -sense * TORQUES[size] * poses[wheel].R[:, 1]
        torques[wheel] += torque
        torques[carrier] -= torque
    steering = vector(next(f for f in eom.frames if f.name == "S").z) * TORQUES["T_delta"]
    torques[2] += steering
    torques[1] -= steering
    J, n = rows.A[held], len(nu)
    mass = np.zeros((n, n))
    for i, (solid, pose) in enumerate(zip(bodies, poses, strict=True)):
        mass[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = solid.mass * np.eye(3)
        mass[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = pose.R @ solid.inertia @ pose.R.T
    force = loads(bodies, poses, twists, None, torques, np.array([0.0, 0.0, g]))
    left = np.block([[mass, -np.array(pushed).T], [J, np.zeros((len(J), len(J)))]])
    found = np.linalg.solve(left, np.concatenate([force, -rows.bias[held]]))
    for i, body in enumerate(SYSTEM.rigid_bodies):
        for expected, x in (
            (found[6 * i : 6 * i + 3], eom.point_accelerations[body.mass_center]),
            (found[6 * i + 3 : 6 * i + 6], eom.angular_accelerations[body.frame]),
        ):
            given = np.array(eom.evaluate(x.components(N), **state, inputs=TORQUES, parameters=numbers), dtype=float)
            np.testing.assert_allclose(given, expected, rtol=1e-9, atol=1e-9 * np.abs(found[:n]).max())


def braked(end: float, **inputs: Any) -> kn.Solution:
    """Upright and straight at 5 m/s."""
    q = START["q"] | {"phi": 0.0}
    return kn.simulate(EOM, (0, end), q=q, u=START["u"], inputs=START["inputs"] | inputs, **TIGHT)


def when(sol: kn.Solution, name: str) -> float:
    return next(t for e, t in sol.events if e.name == name)


@pytest.mark.slow
def test_the_rear_wheel_locks_and_skids_to_rest() -> None:
    """While it spins down, T − μ N r = J α; then a = μ g (w − b)/(w + μ h) but for the front wheel's inertia."""
    T = 200.0
    sol = braked(1.9)
    mass, arm = M + J_F / r_F**2, M * h + J_F / r_F
    N_1 = (M * g * (w - b) - T) / (w - mu_k * r_R + mu_k * arm / mass)
    N_2 = M * g * (w - b) / (w + mu_k * arm / mass)
    a_1, a_2 = mu_k * N_1 / mass, mu_k * N_2 / mass
    locks = v / r_R * J_R / (T - mu_k * N_1 * r_R)
    left = v - a_1 * locks
    assert when(sol, "rear brake sticks") == pytest.approx(locks, rel=1e-9)
    assert when(sol, "rear tyre sticks") == pytest.approx(locks + left / a_2, rel=1e-9)
    assert sol["x"][-1] == pytest.approx(v * locks - a_1 * locks**2 / 2 + left**2 / (2 * a_2), rel=1e-9)
    assert np.abs(sol["y"]).max() < 1e-12
    friction = mu_k * N_1 * (v * locks / 2 - a_1 * locks**2 / 2) + mu_k * N_2 * left**2 / (2 * a_2)
    brake_work = T * v / r_R * locks / 2
    assert sol.energy[0] - sol.energy[-1] == pytest.approx(friction + brake_work, rel=1e-9)


@pytest.mark.slow
def test_the_rear_wheel_lifts_off_where_the_front_one_brakes() -> None:
    """At a = g (w − b)/h but for the inertia of the front wheel, whose spin falls, too."""
    rate, much = 600.0, {"mu_k": 1.0, "mu_s": 1.2}
    q = START["q"] | {"phi": 0.0}
    inputs = START["inputs"] | {"T_R": 0.0, "T_F": rate * kn.time}
    sol = kn.simulate(EOM, (0, 0.5), q=q, u=START["u"], inputs=inputs, parameters=much, **TIGHT)
    assert sol.status == "finished"  # z, which is the gap, is no more than rounding where it opens
    assert sol["z"][-1] < -1e-3  # it stays up
    # before, its friction J a/r² is more than μ N: it slips, and keeps its spin
    a = M * g * (w - b) / (M * h + J_F / r_F)
    lifts = (M * a * r_F + J_F * a / r_F) / rate
    assert when(sol, "rear tyre opens") == pytest.approx(lifts, rel=1e-9)


@pytest.mark.slow
def test_a_leaning_bicycle_skids_until_it_falls() -> None:
    sol = kn.simulate(EOM, (0, 3), **START, **TIGHT)
    assert sol.event is not None
    assert sol.event.name == "falls"
    told = [tuple(modes[n] for n in NAMES) for _, modes in sol.mode_history]
    assert told[:2] == [("slip", "stick", "slip", "slip"), ("slip", "stick", "stick", "slip")]
    assert sol.energy_check.drift < 1e-8
    for c in SYSTEM.contacts[:2]:
        assert sol[c.normal_force].min() > 0


@pytest.mark.slow
def test_at_rest_with_both_brakes_forces_are_undetermined_and_one_brake_left_out_cures() -> None:
    """Four rows along the road and about the axles, three of them independent: tyres may pull against each other."""
    still = {"q": START["q"] | {"phi": 0.0}, "u": dict.fromkeys(START["u"], 0.0)}
    inputs = START["inputs"] | {"T_F": 300.0}
    with pytest.raises(kn.SimulationError, match="'front brake', 'rear tyre', 'front tyre', 'rear brake'"):
        kn.simulate(EOM, (0, 1), inputs=inputs, **still)
    one = kn.derive(SYSTEM.replace(contacts=SYSTEM.contacts[:3]))
    del inputs["T_F"]
    sol = kn.simulate(one, (0, 0.1), inputs=inputs, **still)
    assert sol.status == "finished"
    assert np.abs(sol["x"]).max() == 0
