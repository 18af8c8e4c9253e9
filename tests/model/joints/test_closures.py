# SPDX-License-Identifier: BSD-3-Clause
"""Loops closed by joints: the constraints against the tree joints they stand for."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.model.joints.kinds import KINDS, rigid
from tests.model.joints.rates import power_and_rate, rank
from tests.oracles.compare import error

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
CLOSED = [kind for kind in KINDS if kind != "free"]


def two_bodies(kind):
    """Two bodies, the second free from the first, with a closure of that kind between marks on them."""
    one = kn.free("one", O, N, child="A")
    two = kn.free("two", one.point.at("P", 0.3 * one.frame.x - 0.2 * one.frame.z), one.frame, child="B")
    at = one.point.at("at", 0.4 * one.frame.x + 0.1 * one.frame.y)
    point = two.point.at("point", 0.2 * two.frame.y - 0.3 * two.frame.z)
    bodies = [rigid(j.name, j.frame, j.point, 1, kn.inertia(j.frame, 1, 2, 2.5)) for j in (one, two)]
    closure = KINDS[kind].close("G", at, one.frame, point, two.frame)
    return kn.System(N, bodies=bodies, joints=[one, two], holonomic=closure)


@pytest.mark.slow
@pytest.mark.parametrize("kind", CLOSED)
@pytest.mark.parametrize("seed", [1, 2])
def test_the_rate_of_a_closure_is_the_power_of_its_forces(kind, seed):
    """ḟ = Σ F·v + Σ T·ω at any state, far from closed ones too, and the second derivatives agree."""
    power, rate, drift, second = power_and_rate(two_bodies(kind), seed)
    assert np.abs(rate).max() > 0.01
    np.testing.assert_allclose(power, rate, atol=1e-12)
    np.testing.assert_allclose(drift, second, atol=1e-11)


@pytest.mark.parametrize("kind", CLOSED)
def test_as_many_independent_constraints_as_the_joint_takes_freedoms(kind):
    system = two_bodies(kind)
    assert len(system.constraints) == KINDS[kind].closed == rank(system, 3)
    assert len(KINDS[kind].make("J", O, N).free) == 6 - KINDS[kind].closed
    assert all(c.name.startswith("G ") for c in system.constraints)


@pytest.mark.parametrize("kind", CLOSED)
@pytest.mark.parametrize("turns", [0, 3])
def test_a_tree_joint_satisfies_its_closure_wherever_it_is(kind, turns):
    joint = KINDS[kind].make("J", O, N)
    q = np.random.default_rng(4).uniform(-3, 3, len(joint.coordinates)) + turns * 2 * np.pi
    for c in KINDS[kind].close("G", joint.at, joint.parent, joint.point, joint.frame):
        value = kn.evaluate(c.expr, dict(zip(joint.coordinates, q, strict=True)))
        assert abs(float(value)) < 1e-12, c


def quaternion(turn):
    """Euler parameters of a rotation matrix, the scalar one first."""
    e0 = np.sqrt(1 + np.trace(turn)) / 2
    return [e0, *(np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / (4 * e0))]


def carried(kind, closed):
    """A crank on the ground and a body on it: by the joint itself, or free and closed by its constraints."""
    crank = kn.pin("crank", O, N, axis=N.z, child="A")
    at = crank.point.at("at", 0.5 * crank.frame.x)
    base = kn.free("J", at, crank.frame, child="B") if closed else KINDS[kind].make("J", at, crank.frame, child="B")
    center = base.point.at("b*", 0.2 * base.frame.x - 0.1 * base.frame.y + 0.15 * base.frame.z)
    bodies = [
        rigid("a", crank.frame, crank.point.at("a*", 0.25 * crank.frame.x), 2, kn.inertia(crank.frame, 1, 1, 1)),
        rigid("b", base.frame, center, 1.5, kn.inertia(base.frame, 0.1, 0.2, 0.25, 0.01, 0.02, -0.03)),
    ]
    closure = KINDS[kind].close("G", at, crank.frame, base.point, base.frame) if closed else ()
    loads = [kn.gravity(-9.81 * N.y + 2 * N.z), kn.Torque(crank.frame, 5 * N.z), kn.Force(center, 3 * N.x)]
    system = kn.System(N, bodies=bodies, joints=[crank, base], loads=loads, holonomic=closure)
    return kn.derive(system), crank, base, center


QUICK = ("pin", "slider")


@pytest.mark.parametrize("kind", [k if k in QUICK else pytest.param(k, marks=pytest.mark.slow) for k in CLOSED])
def test_closed_by_constraints_or_by_coordinates_it_is_the_same_motion_and_the_same_reaction(kind):
    tree, crank, joint, center = carried(kind, closed=False)
    loop, _, free, same = carried(kind, closed=True)
    rng = np.random.default_rng(6)
    q = {s: rng.uniform(-0.8, 0.8) for s in tree.coordinates}
    u = {s: rng.uniform(-1, 1) for s in tree.speeds}
    state = {"q": q, "u": u}
    turn = np.array(kn.evaluate(joint.parent.dcm(joint.frame), q), dtype=float)
    place = tree.evaluate(joint.point.position(joint.at).components(joint.parent), **state)
    spin = tree.evaluate(joint.angular_velocity.components(joint.frame), **state)
    slide = tree.evaluate(joint.velocity.components(joint.frame), **state)
    q_loop = dict(zip(free.coordinates, [*quaternion(turn), *place], strict=True))
    u_loop = dict(zip(free.speeds, [*spin, *slide], strict=True))
    (angle,), (rate,) = crank.coordinates, crank.speeds
    moved = {"q": q_loop | {angle: q[angle]}, "u": u_loop | {rate: u[rate]}}
    residual = loop.evaluate([c.expr for c in loop.system.constraints], **moved)
    assert np.abs(np.array(residual, dtype=float)).max() < 1e-12
    a, b = tree.point_accelerations[center].components(N), loop.point_accelerations[same].components(N)
    assert error(loop.evaluate(b, **moved), tree.evaluate(a, **state)) < 1e-10
    one, two = tree.reaction("J"), loop.reaction("G")
    for v, w in ((one.force, two.force), (one.torque, two.torque)):
        assert error(loop.evaluate(w.components(N), **moved), tree.evaluate(v.components(N), **state)) < 1e-9
    nothing = loop.reaction("J")  # the free joint itself transmits nothing
    rest = loop.evaluate([*nothing.force.components(N), *nothing.torque.components(N)], **moved)
    assert np.abs(np.array(rest, dtype=float)).max() < 1e-9
    ground = tree.reaction("crank"), loop.reaction("crank")  # and beyond it the constraints' forces are felt
    for v, w in ((ground[0].force, ground[1].force), (ground[0].torque, ground[1].torque)):
        assert error(loop.evaluate(w.components(N), **moved), tree.evaluate(v.components(N), **state)) < 1e-9
