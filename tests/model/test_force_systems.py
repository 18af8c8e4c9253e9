# SPDX-License-Identifier: BSD-3-Clause
"""Sets of bound vectors against sums of numbers, and against the theorems of the textbook's sections 4.1 to 4.3."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
A = N.rotate("A", kn.Rational(3, 5), N.y)
F, a, b = kn.parameter("F", 2.0, "N"), kn.parameter("a", 0.4, "m"), kn.parameter("b", 0.7, "m")


def numbers(v, frame=N):
    return np.asarray(kn.evaluate(v.components(frame), {}), dtype=float)


@pytest.fixture
def many(rng):
    """Six forces at six points, two torques; the numbers, along N."""
    r, f, t = rng.normal(size=(6, 3)), rng.normal(size=(6, 3)), rng.normal(size=(2, 3))

    def vector(x, frame):
        return float(x[0]) * frame.x + float(x[1]) * frame.y + float(x[2]) * frame.z

    c, s = np.cos(0.6), np.sin(0.6)
    turn = {N: np.eye(3), A: np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])}
    frames = [N, A] * 3
    forces = [kn.Force(O.at(f"P{i}", vector(r[i], g)), vector(f[i], g)) for i, g in enumerate(frames)]
    torques = [kn.Torque(N, vector(x, N)) for x in t]
    r, f = (np.array([turn[g] @ x for x, g in zip(y, frames, strict=True)]) for y in (r, f))
    return kn.force_system([forces, torques]), r, f, t


def test_resultant_moment_and_wrench(many):
    found, r, f, t = many
    np.testing.assert_allclose(numbers(found.resultant), f.sum(0), rtol=1e-13)
    q = np.array([0.3, -0.2, 0.9])
    Q = O.at("Q", 0.3 * N.x - 0.2 * N.y + 0.9 * N.z)
    moment = np.cross(r - q, f).sum(0) + t.sum(0)
    np.testing.assert_allclose(numbers(found.moment(Q)), moment, rtol=1e-12)
    wrench = found.wrench(Q)
    axis = f.sum(0) / np.linalg.norm(f.sum(0))
    np.testing.assert_allclose(numbers(wrench.direction), axis, rtol=1e-12)
    np.testing.assert_allclose(numbers(wrench.torque), axis * (moment @ axis), rtol=1e-11)
    assert kn.evaluate(wrench.pitch, {}) == pytest.approx(moment @ axis / np.linalg.norm(f.sum(0)), rel=1e-11)
    place = numbers(wrench.position)
    assert abs(place @ axis) < 1e-13
    on_axis = Q.at("S", wrench.position)
    np.testing.assert_allclose(numbers(found.moment(on_axis)), numbers(wrench.torque), atol=1e-12)
    same = kn.ForceSystem(((on_axis, wrench.force),), (wrench.torque,))
    assert found.is_equivalent(same)
    assert found.is_equivalent(found.replacement(Q))
    assert not found.is_equivalent(kn.ForceSystem(found.forces))
    assert not found.is_couple


def test_in_symbols():
    P, Q = O.at("P", a * N.x), O.at("Q", b * N.y)
    s = kn.force_system([kn.Force(P, F * N.y), kn.Force(Q, F * N.z), kn.Torque(N, a * F * N.x)])
    assert str(s.resultant) == "F N.y + F N.z"
    assert str(s.moment(O)) == "F*(a + b) N.x + a*F N.z"
    wrench = s.wrench(O)
    assert str(wrench.pitch) == "a/2"
    assert kn.unit_of(wrench.pitch) == "m"
    assert str(wrench.position) == "a/2 N.x + (a + b)/2 N.y - (a + b)/2 N.z"
    assert "pitch a/2" in repr(wrench)
    assert repr(s) == "ForceSystem(F N.y at P, F N.z at Q, torque a*F N.x)"


def test_couples():
    q = kn.coordinate("q")
    D = N.rotate("D", q, N.z)
    P, Q = O.at("P", a * N.x), O.at("Q", b * N.y)
    for couple in (
        kn.force_system(kn.action_reaction(P, Q, F * N.z)),
        kn.force_system([(P, F * N.z), (Q, F * kn.Rational(-1) * N.z)]),
    ):
        assert couple.is_couple
        assert str(couple.torque) == "-b*F N.x - a*F N.y"
        assert str(couple.moment(P)) == str(couple.moment(Q)) == str(couple.torque)
        with pytest.raises(kn.ModelError, match="no central axis"):
            couple.wrench(O)
    hidden = kn.force_system([(P, F * D.x), (Q, -F * kn.cos(q) * N.x - F * kn.sin(q) * N.y)])
    assert hidden.is_couple
    alone = kn.force_system(kn.Torque(N, F * a * N.x))
    assert alone.is_couple
    assert str(alone.torque) == "a*F N.x"
    with pytest.raises(kn.ModelError, match=r"moment\(point\)"):
        _ = kn.force_system(kn.Force(P, F * N.x)).torque


def test_small_forces_are_no_couples():
    """Whether something is zero is told by the sizes of the terms, not by a number."""
    P = O.at("P", a * N.x)
    tiny = kn.force_system([(P, 1e-15 * N.x), (O, -0.999e-15 * N.x)])
    assert not tiny.is_couple
    scale = kn.parameter("scale", 1e12)
    assert kn.force_system([(P, scale * N.x), (O, -scale * N.x)]).is_couple
    # equal by their defaults alone
    one, other = kn.parameter("one", 1.0), kn.parameter("other", 1.0)
    assert not kn.force_system([(P, one * N.x), (O, -other * N.x)]).is_couple


def test_of_weights():
    """The weights of a set of bodies are equivalent to the whole weight at the mass centre (sec. 4.8)."""
    bodies = [kn.Particle(f"P{i}", O.at(f"P{i}", (i * a) * N.x + (i * i) * b * A.z), i + 1) for i in range(3)]
    g = kn.gravity(-9.81 * N.z)
    weights = kn.force_system(g, bodies=bodies)
    center = O.at("S", kn.mass_center(bodies, O))
    assert weights.is_equivalent(kn.force_system((center, -9.81 * 6 * N.z)))
    assert not weights.is_equivalent(kn.force_system((O, -9.81 * 6 * N.z)))
    with pytest.raises(kn.ModelError, match=r"bodies=\[…\]"):
        kn.force_system(g)


def test_equivalent_sets_move_a_body_alike(many):
    """Generalized active forces of a rigid body depend on resultant and moment alone (sec. 4.6)."""
    found, *_ = many
    q = kn.coordinates("q1:4")
    B = A.rotate_body("B", q, "xyz")
    P = O.at("B*", q[0] * N.x)
    body = kn.RigidBody("b", frame=B, mass_center=P, mass=1, inertia=kn.inertia(B, 1, 1.2, 1.4))
    loads = found.load(B, "set")
    fixed = [P.fixed_in(B, f"K{i}", i * B.x - B.y) for i in range(3)]
    on_body = kn.force_system([(p, (i + 1) * N.x - N.z) for i, p in enumerate(fixed)])
    two = []
    for s in (on_body, on_body.replacement(P)):
        eom = kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=[s.load(B)]))
        two.append(np.asarray(eom.evaluate(eom.Fr, q=[0.3, -0.4, 0.5], u=[0, 0, 0]), dtype=float))
    np.testing.assert_allclose(*two, rtol=1e-12, atol=1e-13)
    assert loads.name == "set"
    assert len(loads.torques) == 1


def test_errors():
    with pytest.raises(kn.ModelError, match=r"kn.Force\(point, vector\)"):
        kn.force_system([N.x])
    with pytest.raises(kn.ModelError, match="scalar function only"):
        kn.force_system(kn.Load.from_potential(kn.coordinate("q") ** 2))
    s = kn.force_system((O, N.x))
    with pytest.raises(kn.ModelError, match="Point about which"):
        s.moment(N)
    with pytest.raises(kn.ModelError, match=r"kn.force_system\(loads\)"):
        s.is_equivalent(3)
    with pytest.raises(TypeError):
        s + 3
    assert (s + s).resultant.parts == (2 * N.x).parts
