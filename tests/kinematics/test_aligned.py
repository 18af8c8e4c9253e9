# SPDX-License-Identifier: BSD-3-Clause
"""Aligned bases: motions written along them are those along the declared frames, and what is read keeps the latter."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.random_trees import random_tree
from kane import free_symbols
from kane.gallery import GALLERY, load
from kane.kinematics import AS_DECLARED, aligned_bases
from tests.oracles import kane_tree, newton_euler
from tests.oracles import tree as oracle
from tests.oracles.compare import error, tolerance
from tests.oracles.tree import Step, Tree, normalized, random_states, rotation, square

t = kn.time
q = kn.coordinates("q1:6")
e = kn.coordinates("e0:4")
a, b = kn.parameter("a", 0.6), kn.parameter("b", 1.1)


def by_parameters(x, y):
    """Direction cosines of R_x(x) R_z(y)."""
    (c, s), (k, m) = ((kn.cos(v), kn.sin(v)) for v in (x, y))
    return [[k, -m, 0], [c * m, c * k, -s], [s * m, s * k, c]]


def unit(rng, frame, eps=1.0, base=(0.0, 0.0, 0.0)):
    x, y, z = normalized(np.array(base) + eps * rng.normal(size=3))
    return x * frame.x + y * frame.y + z * frame.z


KINDS = {
    "pin": lambda rng, f, k: f.rotate(f"F{k}", q[k % 5] + 0.3 * k, unit(rng, f)),
    "again": lambda rng, f, k: f.rotate(f"F{k}", -2 * q[k % 5], -1 * (f.x + 2 * f.y - 2 * f.z) / 3),
    "axis": lambda rng, f, k: f.rotate(f"F{k}", q[k % 5], (f.x + 2 * f.y - 2 * f.z) / 3),
    "basis": lambda rng, f, k: f.rotate(f"F{k}", q[k % 5] * kn.sin(t), f.y),
    "nearly": lambda rng, f, k: f.rotate(f"F{k}", q[k % 5], unit(rng, f, 1e-9, (0, 0, -1))),
    "tilted": lambda rng, f, k: f.rotate_matrix(f"F{k}", rotation(normalized(rng.normal(size=3)), 2.0)),
    "turned": lambda rng, f, k: f.rotate(f"F{k}", 0.4, f.x),
    "tilted by a parameter": lambda rng, f, k: f.rotate(f"F{k}", a + 0.2 * k, (f.x + 2 * f.y - 2 * f.z) / 3),
    "tilted by parameters": lambda rng, f, k: f.rotate_matrix(f"F{k}", by_parameters(a, b - 0.3 * k)),
    "by a parameter": lambda rng, f, k: f.rotate(f"F{k}", a, f.z),
    "along parameters": lambda rng, f, k: f.rotate(f"F{k}", q[k % 5], f.y * kn.cos(b) + f.z * kn.sin(b)),
    "any": lambda rng, f, k: f.rotate_euler_parameters(f"F{k}", e),
}


def values(exprs, seed):
    draws = np.random.default_rng(seed).uniform(-1, 1, 10)
    numbers = dict(zip((*q, *e, t), draws, strict=True))
    length = np.linalg.norm(draws[5:9])
    numbers |= {x: numbers[x] / length for x in e}
    return np.array([float(x) for x in kn.evaluate(list(exprs), numbers)])


@pytest.mark.slow
@given(
    st.lists(st.tuples(st.sampled_from(sorted(KINDS)), st.integers(0, 4)), min_size=1, max_size=8), st.integers(0, 9)
)
def test_vectors_along_aligned_bases_are_the_declared_ones(steps, seed):
    rng = np.random.default_rng(seed)
    frames = [kn.Frame("N")]
    used = set()
    for k, (kind, back) in enumerate(steps):
        if kind == "any" and kind in used:  # one set of Euler parameters
            continue
        used.add(kind)
        frames.append(KINDS[kind](rng, frames[max(0, len(frames) - 1 - back)], k))
    aligned = aligned_bases(frames)
    for f in frames:
        v = 0.3 * f.x - 1.1 * f.y + q[0] * f.z
        written = aligned.vector(v)
        for g in frames:
            assert error(values(written.components(g), seed), values(v.components(g), seed)) < 1e-14
            assert values([written.dot(g.x)], seed) == pytest.approx(values([v.dot(g.x)], seed), abs=1e-14)


def test_a_symmetric_dyadic_turns_with_its_frame():
    N = kn.Frame("N")
    B = N.rotate("B", q[0], (N.x + 2 * N.y - 2 * N.z) / 3)
    C = B.rotate("C", q[1], (2 * B.x + B.y + 2 * B.z) / 3)
    aligned = aligned_bases([N, B, C])
    for entries in ((1, 2, 3), (1, 2, 3, 0.1, 0.2, -0.3), (2, 2, 5), (2, 2, 2)):
        dyadic = kn.inertia(C, *entries)
        rows = tuple(tuple(row) for row in dyadic.components(C).rows)
        basis, turned = aligned.symmetric(C, rows)
        written = kn.Dyadic.of(basis, turned)
        assert (
            error(values(sum(written.components(N).rows, ()), 1), values(sum(dyadic.components(N).rows, ()), 1)) < 1e-14
        )
    assert all(
        x is y for row, other in zip(turned, rows, strict=True) for x, y in zip(row, other, strict=True)
    )  # a sphere


@pytest.mark.parametrize("name", GALLERY)
def test_systems_that_turn_about_basis_vectors_keep_their_frames(name):
    assert aligned_bases(load(name).system().frames) is AS_DECLARED


@pytest.mark.slow
@pytest.mark.parametrize("eps", [0.0, 1e-16, 1e-15, 3e-15, 1e-14, 1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("seed", range(3))
def test_axes_that_are_nearly_parallel_lose_no_digits(eps, seed):
    rng = np.random.default_rng(seed)
    tree = oracle.random_tree(rng, 6)
    bodies = []
    for i, body in enumerate(tree.bodies):
        base = np.eye(3)[rng.integers(3)] * rng.choice([-1, 1])
        tilt = np.array(body.tilt) if i == 0 else rotation(normalized(rng.normal(size=3)), eps)
        steps = (Step("turn", normalized(base + eps * rng.normal(size=3))),)
        bodies.append(replace(body, parent=i - 1, tilt=square(tilt), steps=steps, force=None, torque=None))
    tree = Tree(tuple(bodies), tree.gravity)
    states = random_states(rng, tree, 3)
    found = kane_tree.derive(tree).accelerations(*states)
    for k, (place, rate) in enumerate(zip(*(s.T for s in states), strict=True)):
        engine = newton_euler.solve(tree, place, rate)
        condition = np.linalg.cond(engine.mass_matrix)
        assert error(found[:, k], engine.qddot) <= tolerance(1e-13, condition)


def pendulum(axis):
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    hinge = kn.pin("hinge", O, N, axis=axis(N))
    center = hinge.point.at("G", hinge.frame.x + 2 * hinge.frame.y)
    body = kn.RigidBody("body", frame=hinge.frame, mass_center=center, mass=2, inertia=kn.inertia(hinge.frame, 1, 2, 3))
    return kn.derive(kn.System(N, bodies=[body], joints=[hinge], loads=[kn.gravity(-9.81 * N.z)]))


def test_an_axis_counts_as_one_of_unit_length_up_to_what_is_checked():
    exact = pendulum(lambda N: (2 * N.x + N.y + 2 * N.z) / 3)
    rough = pendulum(lambda N: (2 * N.x + N.y + 2 * N.z) / 3 * (1 + 4e-13))
    one, other = (eom.evaluate(eom.accelerations[0], q=[0.4], u=[1.3]) for eom in (exact, rough))
    assert one == pytest.approx(other, rel=1e-11)


def test_an_axis_of_parameters_may_turn_into_a_basis_vector():
    """Its parameters are the system's, and the equations have derivatives by them."""
    eom = pendulum(lambda N: N.z * kn.cos(a) + N.x * kn.sin(a))
    (acceleration,) = eom.accelerations
    for angle in (0.0, 1e-9, 0.6):
        number = pendulum(lambda N, angle=angle: N.z * np.cos(angle) + N.x * np.sin(angle))
        wanted = number.evaluate(number.accelerations[0], q=[0.4], u=[1.3])
        value = eom.evaluate(acceleration, q=[0.4], u=[1.3], parameters={a: angle})
        assert value == pytest.approx(wanted, rel=1e-12, abs=1e-15)
    slope = eom.evaluate(kn.diff(acceleration, a), q=[0.4], u=[1.3], parameters={a: 0.0})
    ahead, behind = (eom.evaluate(acceleration, q=[0.4], u=[1.3], parameters={a: h}) for h in (1e-6, -1e-6))
    assert slope == pytest.approx((ahead - behind) / 2e-6, rel=1e-6)


def test_what_is_read_keeps_the_declared_frames():
    eom = kn.derive(random_tree((-1, 0, 1), 1))
    declared = set(eom.frames)
    read = [
        v
        for table in (eom.angular_velocities, eom.velocities, eom.angular_accelerations, eom.point_accelerations)
        for v in table.values()
    ]
    read += [
        v
        for table in (eom.partial_velocities, eom.partial_angular_velocities)
        for row in table.values()
        for v in row.values()
    ]
    read += [
        v for c in map(eom.contributions, eom.speeds) for x in (*c.active, *c.inertia) for v in (x.vector, x.partial)
    ]
    read += [v for step in eom.steps for _, v in step.items if isinstance(v, kn.Vector)]
    read += [eom.linear_momentum(), eom.angular_momentum(eom.points[0]), eom.reaction("joint2").torque]
    assert {frame for v in read for frame, _ in v.parts} <= declared
    assert any(
        frame not in declared for b in eom.derived.bodies for v in b.center.partials.values() for frame, _ in v.parts
    )
    assert not re.search(r"\w\^\.", "\n".join(map(str, eom.steps[:6])))


def test_what_is_read_is_what_is_solved():
    eom = kn.derive(random_tree((-1, 0, 1, 0), 1))
    rng = np.random.default_rng(4)
    state = {"q": rng.uniform(-1, 1, 4), "u": rng.uniform(-1, 1, 4)}
    balance = [f + g for f, g in zip(eom.Fr, eom.Fr_star, strict=True)]
    assert np.abs(eom.evaluate(balance, **state)).max() < 1e-12
    shares = [x for c in eom.mass_contributions(eom.speeds[1], eom.speeds[2]) for x in (c.translation, c.rotation)]
    assert sum(eom.evaluate(shares, **state)) == pytest.approx(eom.evaluate(eom.mass_matrix[1, 2], **state), rel=1e-12)


def test_rows_of_axes_that_are_parallel_are_one_rotation_by_the_sum_of_the_angles():
    def chain(direction):
        N = kn.Frame("N")
        at, frame, joints, bodies = kn.Point("O", fixed_in=N), N, [], []
        for k in range(4):
            n = direction(frame)
            joints.append(kn.pin(f"j{k}", at, frame, axis=n if k % 2 else -n))
            frame = joints[-1].frame
            at = joints[-1].point.at(f"P{k}", frame.x + frame.y)
            bodies.append(
                kn.RigidBody(f"b{k}", frame=frame, mass_center=at, mass=1, inertia=kn.inertia(frame, 1, 1, 1))
            )
        return kn.derive(kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-9.81 * N.x)]))

    general = chain(lambda f: (f.x + 2 * f.y - 2 * f.z) / 3)
    bases = {b.rotation.motion.total.parts[0][0] for b in general.derived.bodies}
    assert len({basis.orientation.base for basis in bases}) == 1


def seated(seats):
    """Pins about z of seats; these, offsets and mass centres are parameters with such defaults."""
    N = kn.Frame("N")
    point, frame, joints, bodies = kn.Point("O", fixed_in=N), N, [], []
    for k, seat in enumerate(seats, 1):
        rows = [[kn.parameter(f"R{k}_{i}{j}", float(x)) for j, x in enumerate(row)] for i, row in enumerate(seat)]
        seat = frame.rotate_matrix(f"A{k}", rows)
        joints.append(kn.pin(f"j{k}", point, seat, axis=seat.z))
        point, frame = joints[-1].point, joints[-1].frame
        c = kn.parameters(f"cx{k} cy{k} cz{k}", 0.1)
        center = point.at(f"C{k}", c[0] * frame.x + c[1] * frame.y + c[2] * frame.z)
        inertia = kn.inertia(frame, 0.1, 0.2, 0.25, *kn.parameters(f"Ixy{k} Iyz{k} Izx{k}", 0.01))
        bodies.append(kn.RigidBody(f"b{k}", frame=frame, mass_center=center, mass=1.0, inertia=inertia))
        point = point.at(f"P{k}", kn.parameter(f"px{k}", 0.3) * frame.x + kn.parameter(f"pz{k}", 0.2) * frame.z)
    return kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-9.81 * N.y)])


def seats(rng, count, eps):
    """Rotations by eps about general axes, but for some half turns about x."""
    half = np.diag([1.0, -1.0, -1.0])
    return [
        rotation(normalized(rng.normal(size=3)), eps) @ (half if rng.random() < 0.3 else np.eye(3))
        for _ in range(count)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("eps", [0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1e-3, 1.0])
def test_seats_by_parameters_may_come_to_be_parallel(eps, rng):
    """Equations whose axes are apart at the defaults of the parameters, at others, are those derived at these."""
    apart, near = seats(rng, 5, 1.2), seats(rng, 5, eps)
    own, usual = kn.derive(seated(apart)), kn.derive(seated(near))
    values = {p: p.default for p in usual.parameters}
    at = {"q": rng.uniform(-2, 2, 5), "u": rng.uniform(-2, 2, 5)}
    wanted = np.array(usual.evaluate(list(usual.accelerations), **at), dtype=float)
    named = {p: next(x for s, x in values.items() if s.name == p.name) for p in own.parameters}
    found = np.array(own.evaluate(list(own.accelerations), parameters=named, **at), dtype=float)
    condition = np.linalg.cond(np.array(usual.evaluate(usual.mass_matrix, **at), dtype=float))
    assert error(found, wanted) <= tolerance(1e-13, condition)


def test_what_is_parallel_at_the_defaults_has_derivatives_by_parameters(rng):
    """γ of parallel axes has none: there direction cosines stand as they are given."""
    eom = kn.derive(seated(seats(rng, 3, 0.0)))
    p = next(p for p in eom.parameters if p.name == "R2_02")
    slopes = kn.evaluate(
        [kn.diff(x, p) for x in eom.accelerations],
        dict(zip((*eom.coordinates, *eom.speeds), rng.normal(size=6), strict=True))
        | {p: p.default for p in eom.parameters},
    )
    assert np.isfinite(np.array(slopes, dtype=float)).all()


@pytest.mark.slow
@pytest.mark.parametrize("parents", [range(-1, 6), (-1, -1, 1, 0, 2, 2, 4, 1)])
@pytest.mark.parametrize("floating", [False, True])
def test_seats_by_parameters_take_the_operations_of_seats_by_numbers(parents, floating):
    """But for angles that are added to those of the joints."""
    numbers, general = (kn.derive(random_tree(parents, 3, floating=floating, general=g)) for g in (False, True))
    assert general.operations.state <= numbers.operations.state + 4 * len(parents)
    n, rng = len(numbers.coordinates), np.random.default_rng(2)
    place, rate = rng.uniform(-1, 1, n), rng.uniform(-1, 1, len(numbers.speeds))
    if floating:
        place[:4] /= np.linalg.norm(place[:4])
    one, other = (
        np.array(eom.evaluate(list(eom.accelerations), q=place, u=rate), dtype=float) for eom in (numbers, general)
    )
    np.testing.assert_allclose(other, one, rtol=1e-11, atol=1e-12 * np.abs(one).max())


def test_seats_by_parameters_are_a_matter_of_each_joint():
    """An angle holds the parameters of its own seat and of one that sits on it, however long the chain."""
    system = random_tree(range(-1, 11), 3, general=True)
    for place in aligned_bases(system.frames).places.values():
        turn = place.basis.orientation
        parameters = [s for s in free_symbols([turn.angle]) if s not in system.coordinates] if turn else []
        assert len({p.name.split("_")[0] for p in parameters}) <= 2


def test_seats_by_parameters_have_derivatives_by_them():
    """A pin on a seat R_x(a) R_z(b) on another such: differences of two nearby values."""
    N = kn.Frame("N")
    point, frame, joints, bodies = kn.Point("O", fixed_in=N), N, [], []
    for k in (1, 2):
        seat = frame.rotate_matrix(f"A{k}", by_parameters(k * a, b))
        joints.append(kn.pin(f"j{k}", point, seat, axis=(seat.x + 2 * seat.y - 2 * seat.z) / 3))
        point, frame = joints[-1].point, joints[-1].frame
        center = point.at(f"C{k}", 0.2 * frame.x + 0.1 * frame.z)
        inertia = kn.inertia(frame, 0.1, 0.2, 0.25, 0.01)
        bodies.append(kn.RigidBody(f"b{k}", frame=frame, mass_center=center, mass=1.0, inertia=inertia))
        point = point.at(f"P{k}", 0.3 * frame.x)
    eom = kn.derive(kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-9.81 * N.y)]))
    at = {"q": [0.4, -0.7], "u": [1.1, 0.3]}
    accelerations = list(eom.accelerations)
    for p in (a, b):
        slopes = np.array(eom.evaluate([kn.diff(x, p) for x in accelerations], **at), dtype=float)
        ahead, behind = (
            np.array(eom.evaluate(accelerations, parameters={p: p.default + h}, **at), dtype=float)
            for h in (1e-6, -1e-6)
        )
        np.testing.assert_allclose(slopes, (ahead - behind) / 2e-6, rtol=1e-6)
