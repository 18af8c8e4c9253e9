# SPDX-License-Identifier: BSD-3-Clause
"""Bodies: what they hold, and what they refuse."""

from __future__ import annotations

import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q, x = kn.coordinates("q x")
A = N.rotate("A", q, N.z)
G = O.at("G", x * N.x)
m = kn.parameter("m", 2.0)
I = kn.inertia(A, 1, 2, 3)


def test_particle():
    p = kn.Particle("bob", G, 3)
    assert p.mass_center is G
    assert str(p.mass) == "3"
    assert repr(p) == "Particle('bob', at G)"


def test_rigid_body():
    b = kn.RigidBody("link", frame=A, mass_center=G, mass=m, inertia=I)
    assert (b.frame, b.mass_center, b.mass, b.inertia) == (A, G, b.mass, I)
    assert b.mass is m
    assert repr(b) == "RigidBody('link', frame A, mass centre G)"


def test_massless_parts_are_allowed():
    assert str(kn.Particle("p", G, 0).mass) == "0"


def test_frozen():
    with pytest.raises(AttributeError):
        kn.Particle("p", G, 1).mass = 2  # type: ignore[misc]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kn.Particle("p", G, -1), "mass ≥ 0 for p, got -1"),
        (lambda: kn.Particle("p", A, 1), "Expected a Point as the position of p"),
        (lambda: kn.Particle("p", G.fixed_in(A, "Q", A.x), 1), "got Q, the particle of A .* with at"),
        (lambda: kn.RigidBody("b", frame=A, mass_center=G, mass=-m * 0 - 2, inertia=I), "mass ≥ 0"),
        (lambda: kn.RigidBody("b", frame=G, mass_center=G, mass=m, inertia=I), "Frame for the body b"),
        (lambda: kn.RigidBody("b", frame=A, mass_center=G, mass=m, inertia=3), r"kn.inertia\(A, Ixx.*got int"),
        (lambda: kn.RigidBody("b", frame=A, mass_center=A, mass=m, inertia=I), "Point as the position of b"),
    ],
)
def test_errors(make, message):
    with pytest.raises(kn.ModelError, match=message):
        make()


def test_mass_must_be_a_number_or_expression():
    with pytest.raises(kn.ExpressionError, match="real number"):
        kn.Particle("p", G, "heavy")
    with pytest.raises(kn.ExpressionError, match="finite number"):
        kn.Particle("p", G, float("nan"))


def test_frame_and_mass_center_in_different_trees():
    M = kn.Frame("M")
    with pytest.raises(kn.SpaceError, match="no common root"):
        kn.RigidBody("b", frame=M, mass_center=G, mass=1, inertia=kn.inertia(M, 1, 1, 1))
