# SPDX-License-Identifier: BSD-3-Clause
"""A load's potential is held against its forces at random states."""

from __future__ import annotations

import warnings
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y, z, a, b = kn.coordinates("x y z a b")
k, c = kn.parameter("k", 20.0), kn.parameter("c", 0.4)
A = N.rotate("A", a, N.x)
B = A.rotate("B", b, A.z)
P = O.at("P", x * N.x + y * A.y + z * B.z)
Q = P.at("Q", 0.3 * B.x - 0.2 * B.y)
BODY = kn.RigidBody("body", frame=B, mass_center=P, mass=1.3, inertia=kn.solid_sphere(B, 1.3, 0.2))
LEVEL = P.position(O).dot(N.y)
RIGHT = {
    "spring": kn.linear_spring(Q, O, k, 0.3),
    "spring without length": kn.linear_spring(Q, O, k),
    "torsional": kn.torsional_spring(B, A, b, k, A.z, rest=0.2),
    "gravity of its own": kn.Load("weight", ((P, -5 * N.z),), potential=5 * P.position(O).dot(N.z)),
    "one-sided": kn.Load("stop", ((P, k * kn.max(-LEVEL, 0) * N.y),), potential=k * kn.max(-LEVEL, 0) ** 2 / 2),
    "in time": kn.Load("growing", ((P, -kn.time * x * N.x),), potential=None),
    "any constant": kn.Load("nothing", potential=kn.Rational(3)),
}  # fmt: skip


def said(load: kn.Load, **more: object) -> list[str]:
    arguments = {"bodies": [BODY], "speeds": "rates", "loads": [load]} | more
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        kn.derive(kn.System(N, **arguments))
    return [str(w.message) for w in caught]


@pytest.mark.parametrize("name", RIGHT)
def test_what_agrees_passes(name):
    assert said(RIGHT[name]) == []


WRONG = {
    "no force": kn.Load("V", potential=k * x**2),
    "another factor": kn.Load("V", ((P, -4 * x * N.x),), potential=4 * x**2),
    "another sign": replace(RIGHT["spring"], name="V", potential=-RIGHT["spring"].potential),
    "a damper in it": kn.Load("V", ((P, -k * P.position(O) - c * P.velocity(N)),), potential=k * P.position(O).dot(P.position(O)) / 2),
    "another place": kn.Load("V", ((Q, -5 * N.z),), potential=5 * P.position(O).dot(N.z)),
    "one-sided": kn.Load("V", ((P, k * kn.max(-x, 0) * N.x),), potential=k * kn.max(-x, 0) ** 2),
    "no torque": replace(RIGHT["torsional"], name="V", torques=()),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_differs_is_named(name):
    (message,) = said(WRONG[name])
    assert message.startswith("Expected the potential of 'V' to be that of its forces")
    assert said(replace(WRONG[name], potential=None)) == []


def test_on_constraints_only_what_moves_counts():
    rod = kn.distance(P, O, 1)
    weight, square = ((P, -5 * N.z),), P.position(O).dot(P.position(O))
    height = 5 * P.position(O).dot(N.z)
    held = {"holonomic": rod, "speeds": "rates"}
    assert said(kn.Load("V", weight, potential=height + 7 * (square - 1)), **held) == []
    assert len(said(kn.Load("V", weight, potential=height + 7 * x), **held)) == 1


def test_with_euler_parameters():
    e = kn.coordinates("e0:4")
    C = N.rotate_euler_parameters("C", e)
    body = kn.RigidBody("body", frame=C, mass_center=O, mass=1, inertia=kn.solid_sphere(C, 1, 1))
    R = O.at("R", C.x)
    spring = kn.linear_spring(R, O.at("S", 2 * N.y), k, 0.5)
    assert said(spring, bodies=[body]) == []
    assert len(said(replace(spring, potential=2 * spring.potential), bodies=[body])) == 1


@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from([x, y, x * y, kn.sin(a) * x, x * x * b]), st.floats(0.1, 3)), min_size=1, max_size=4),
    st.floats(1e-6, 1e6),
    st.sampled_from([0.0, 1e-3, -2.0]),
)  # fmt: skip
def test_random_potentials_in_any_unit(terms, unit, slip):
    """Forces made of V by hand along x (its derivative along x alone): right for it, wrong by any other part of V."""
    V = sum((unit * w * e for e, w in terms), start=kn.Rational(0))
    push = -kn.diff(V, x)
    point = O.at("X", x * N.x)
    body = kn.Particle("X", point, 1)
    fixed = kn.substitute(V, {y: 0.7, z: -0.4, a: 0.3, b: 0.2})
    slope = kn.substitute(push, {y: 0.7, z: -0.4, a: 0.3, b: 0.2})
    load = kn.Load("V", ((point, slope * N.x),), potential=fixed + slip * unit * kn.sin(x))
    assert len(said(load, bodies=[body])) == (slip != 0)
