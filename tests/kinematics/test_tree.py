# SPDX-License-Identifier: BSD-3-Clause
"""Links: mass matrices composed of their joints' twists are those of the equations."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from benchmarks.random_trees import random_tree
from benchmarks.systems import COUNTED
from kane import Vector
from kane.dynamics import carrying, derived
from kane.gallery import GALLERY, load
from kane.kinematics import Unsuited, aligned_bases, tree_of
from tests.oracles import kane_tree
from tests.oracles import tree as oracle


def links_of(system):
    """The links of a system, the ground first."""
    return tree_of(system, aligned_bases(system.frames)).links


def systems():
    for name in GALLERY:
        if any(isinstance(b, kn.Beam) for b in load(name).system().bodies):
            continue  # their parts share momenta
        yield pytest.param(lambda name=name: load(name).system(), id=name)
    for bodies in range(1, 6):
        tree = oracle.random_tree(np.random.default_rng(bodies), bodies)
        yield pytest.param(lambda tree=tree: kane_tree.derive(tree).eom.system, id=f"{bodies} bodies")
    yield pytest.param(lambda: random_tree((-1, 0, 0), 3, floating=True), id="free-flyer")


def motions(system, rates):
    """For each part ∂v/∂b of its mass centre and ∂ω/∂b by rate b, summed along the links."""
    links = links_of(system)
    found = []
    for link in links:
        for part, arm in link.parts:
            shift, turn = dict.fromkeys(rates, Vector()), dict.fromkeys(rates, Vector())
            at = link
            while at.parent is not None:
                for rate, twist in at.twists(rates).items():
                    shift[rate] = shift[rate] + twist.translation + twist.rotation.cross(arm)
                    turn[rate] = turn[rate] + twist.rotation
                arm, at = arm + at.offset, links[at.parent]
            found.append((part, shift, turn))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("make", list(systems()))
def test_twists_along_the_tree_give_the_kinetic_energy(make):
    system = make()
    eom = kn.derive(system)
    rates, rows = eom.kinematical.rates, eom.kinematical.rows
    b = dict(zip(rates, kn.speeds(f"b1:{len(rates) + 1}"), strict=True))
    twice = 0
    for part, shift, turn in motions(system, rates):
        v = sum((shift[r] * b[r] for r in rates), start=Vector())
        w = sum((turn[r] * b[r] for r in rates), start=Vector())
        twice = twice + part.mass * v.dot(v) + (w.dot(part.inertia.dot(w)) if part.frame is not None else 0)
    rng = np.random.default_rng(1)
    values = {s: rng.uniform(0.3, 1.2) for s in (*system.coordinates, *system.parameters, *b.values())}
    values[kn.time] = 0.7
    for group in system.euler_parameters:
        length = np.sqrt(sum(values[e] ** 2 for e in group.coordinates))
        values |= {e: values[e] / length for e in group.coordinates}
    speeds = {
        u: sum((c * b[r] for r, c in row.items()), start=z)
        for u, row, z in zip(eom.speeds, rows, eom.kinematical.z, strict=True)
    }

    def energy(factor):
        at = values | {x: factor * values[x] for x in b.values()}
        return float(kn.evaluate(eom.kinetic_energy, at | {u: float(kn.evaluate(e, at)) for u, e in speeds.items()}))

    wanted = (energy(1) + energy(-1)) / 2 - energy(0)  # without what motions in time add
    assert float(kn.evaluate(twice / 2, values)) == pytest.approx(wanted, rel=1e-12)


def test_links_of_absolute_angles_follow_the_points():
    """Rods whose frames all hang on the ground are a chain, as each begins at the end of the one before."""
    system = COUNTED["planar pendulum, absolute angles, 10 rods"]()
    links = links_of(system)
    assert [link.parent for link in links] == [None, *range(10)]
    assert [len(link.twists(q.dt for q in system.coordinates)) for link in links] == [0, 1, *[2] * 9]


def test_links_know_their_joints_and_massless_ones_are_left_out():
    system = random_tree((-1, 0, 0, 2), 3, floating=True)
    ground, base, *limbs = links_of(system)
    assert (ground.parts, base.parent, base.joint.kind) == ((), 0, "free")
    assert [link.joint.name for link in limbs] == ["joint1", "joint2", "joint3", "joint4"]
    assert [link.parent for link in limbs] == [1, 2, 2, 4]
    assert [len(link.parts) for link in limbs] == [1, 1, 1, 1]
    for link in limbs:  # one rate, about z of the link
        ((frame, (x, y, z)),) = link.rotation.parts
        assert frame is link.basis
        assert x is y
        assert len(link.twists([z])) == 1


def wrist(order=(0, 1, 2), twist=1.0, offset=0, at_each=True):
    """Bodies on pins whose axes meet at a point, declared in any order; `at_each` pin has a point of its own there."""
    N = kn.Frame("N")
    at, frame, bodies = kn.Point("O", fixed_in=N), N, []
    for k in range(1, 4):
        if at_each or k == 1:
            at = at.at(f"P{k}", offset * frame.y)
        seat = frame.rotate(f"A{k}", twist, frame.x)
        frame = seat.rotate(f"B{k}", kn.coordinate(f"q{k}"), seat.z)
        center = at.at(f"C{k}", 0.1 * k * frame.x + 0.2 * frame.y)
        inertia = kn.inertia(frame, 1, 2, 2.5)
        bodies.append(kn.RigidBody(f"b{k}", frame=frame, mass_center=center, mass=k, inertia=inertia))
    gravity = kn.gravity(-9.81 * N.x)
    return kn.System(N, bodies=[bodies[k] for k in order], speeds="rates", loads=[gravity])


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
@pytest.mark.parametrize("at_each", [True, False])
def test_links_whose_axes_meet_at_a_point_hang_on_each_other(order, at_each):
    ground, *links = links_of(wrist(order, at_each=at_each))
    assert ground.parent is None
    assert [link.parent for link in links] == [0, 1, 2]
    assert [part.name for link in links for part, _ in link.parts] == ["b1", "b2", "b3"]
    assert all(link.offset.is_zero for link in links)


def test_points_at_one_place_of_a_body_are_one_link():
    """What hangs on a point of its own there hangs on the body."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    A = N.rotate("A", kn.coordinate("q1"), N.z)
    B = A.rotate("B", kn.coordinate("q2"), A.x)
    P, Q = O.at("P", N.x), O.at("Q", N.x)
    seat = Q.at("S", A.y)
    bodies = [
        kn.RigidBody(n, frame=f, mass_center=c, mass=1, inertia=kn.inertia(f, 1, 1, 1))
        for n, f, c in (("a", A, P.at("a*", A.x)), ("b", B, seat.at("b*", B.y)))
    ]
    assert [link.parent for link in links_of(kn.System(N, bodies=bodies, speeds="rates"))] == [None, 0, 1]


def shaft(place, tilted):
    """A body that slides on a shaft, listed first, the shaft, and a body fixed further on, all along the frame of the shaft."""
    N = kn.Frame("N")
    seat = N.rotate("A", 0.4, N.x) if tilted else N
    O, (q, s), g = kn.Point("O", fixed_in=N), kn.coordinates("q s"), kn.parameter("g", 9.81)
    S = seat.rotate("S", q, seat.z)
    points = [O.at("slide", s * seat.z + 0.1 * S.x), O.at("shaft", 0.2 * S.y), O.at("far", place(seat, S))]
    bodies = [
        kn.RigidBody(p.name, frame=S, mass_center=p, mass=1.0, inertia=kn.inertia(S, 0.1, 0.2, 0.15, 0.01))
        for p in points
    ]
    return kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.z - 3 * N.x)])


def coordinate(system, name):
    """The coordinate of that name."""
    return next(x for x in system.coordinates if x.name == name)


@pytest.mark.parametrize("tilted", [False, True])
@pytest.mark.parametrize("far", ["along the axis", "in the shaft"])
def test_what_turns_alike_is_one_shaft_with_what_slides_on_it(tilted, far):
    """q is of one link alone, so that recursion takes it."""
    places = {"along the axis": lambda A, S: 0.5 * A.z + 0.1 * S.y, "in the shaft": lambda A, S: 0.3 * S.x}
    system = shaft(places[far], tilted)
    turning = [link for link in links_of(system) if link.twists([coordinate(system, "q").dt])]
    assert len(turning) == 1
    agree(system)


def agree(system):
    """Recursion gives the accelerations of the classical route."""
    own, usual = (kn.derive(system, route=route) for route in ("recursive", "classical"))
    at = {"q": [0.3, 0.4], "u": [1.1, -0.7]}
    a, b = (np.array(e.evaluate(list(e.accelerations), **at), dtype=float) for e in (own, usual))
    np.testing.assert_allclose(a, b, rtol=1e-12)


def test_what_turns_alike_aside_of_the_axis_is_no_shaft():
    """Two links share q, which is not tried unless it is asked for."""
    system = shaft(lambda A, S: 0.5 * A.x + 0.1 * S.y, False)
    turning = [link for link in links_of(system) if link.twists([coordinate(system, "q").dt])]
    assert len(turning) == 2
    with pytest.raises(Unsuited, match="several joints share"):
        carrying(derived(system))
    agree(system)


def test_a_basis_fixed_in_another_at_one_place_hangs_on_it():
    """The bicycle's steering axis, turned from its frame by a constant about the axle."""
    links = links_of(load("whipple_bicycle").system())
    assert [link.basis.name for link in links if link.parent == 1] == ["R", "B"]
