# SPDX-License-Identifier: BSD-3-Clause
"""The article's formulas themselves, by a second route: positions, differentiated, and Newton-Euler.

The library is not used here. Derivatives along a motion are complex-step derivatives, exact to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.literature import yoo_2004 as yoo
from tests.literature.yoo_2004 import Array, Samples

STEP = 1e-40


def rotation(axis: int, angle: Array) -> Array:
    """Matrix (n, 3, 3) of an elementary rotation: v in the old basis = matrix @ v in the new one."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((len(angle), 3, 3), dtype=angle.dtype)
    matrix[:, axis, axis] = 1.0
    matrix[:, i, i] = matrix[:, j, j] = c
    matrix[:, i, j], matrix[:, j, i] = -s, s
    return matrix


def basis_B(q: Array) -> Array:
    """Columns b1, b2, b3 on a: yaw q1 about a_z, then pi/2 - q2 about the yawed x axis."""
    return rotation(2, q[:, 0]) @ rotation(0, np.pi / 2 - q[:, 1])


def basis_C(q: Array) -> Array:
    """Columns c1, c2, c3 on a: the basis B, then the spin q3 about b3."""
    return basis_B(q) @ rotation(2, q[:, 2])


def position_P(q: Array) -> Array:
    """Trace of the contact on the plane."""
    return np.stack([q[:, 3], q[:, 4], 0.0 * q[:, 4]], axis=1)


def apply(matrix: Array, v: Array) -> Array:
    """Matrix times vector, row by row."""
    product: Array = np.einsum("nij,nj->ni", matrix, v)
    return product


def along(f: Callable[[Array], Array], x: Array, xd: Array) -> Array:
    """Derivative of f(x) along xd."""
    return np.imag(f(x + 1j * STEP * xd)) / STEP


def spin(basis: Callable[[Array], Array], s: Samples) -> Array:
    """Angular velocity on a, from the derivative of the basis: skew(omega) = C' C^T."""
    skew = along(basis, s.q, s.qd) @ basis(s.q).transpose(0, 2, 1)
    return np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)


@pytest.fixture(scope="module")
def s() -> Samples:
    """States whose rates belong to their speeds."""
    free = yoo.samples()
    return replace(free, qd=yoo.eq_14_inverse(free))


def derivative(formula: Callable[[Samples], Array], s: Samples) -> Array:
    """Derivative on a, seen in A, of a vector formula on b in q and u."""
    return along(
        lambda x: yoo.on_a(moved := replace(s, q=x[:, :5], u=x[:, 5:]), formula(moved)),
        np.concatenate([s.q, s.u], axis=1),
        np.concatenate([s.qd, s.ud], axis=1),
    )


def same(got: Array, expected: Array) -> None:
    """Vectors agree to 1e-12 of their length."""
    scale = np.linalg.norm(expected, axis=-1, keepdims=True)
    assert np.all(np.abs(got - expected) <= 1e-12 * scale)


def test_basis(s: Samples) -> None:
    """The components of a_x, a_y, a_z on b1, b2, b3 are those of the rotations."""
    v = s.q[:, :3]
    same(yoo.on_a(s, v), apply(basis_B(s.q), v))
    same(yoo.on_b(s, yoo.on_a(s, v)), v)


def test_speeds(s: Samples) -> None:
    """(14), corrected, undoes its inverse."""
    same(yoo.eq_14(s), s.u)


def test_angular_velocities(s: Samples) -> None:
    """(11), (13), (15), (16) are the angular velocities of C and of B."""
    C, B = spin(basis_C, s), spin(basis_B, s)
    for formula in (yoo.eq_11_first_line, yoo.eq_11, yoo.eq_15):
        same(yoo.on_a(s, formula(s)), C)
    for formula in (yoo.eq_13, yoo.eq_16):
        same(yoo.on_a(s, formula(s)), B)


def test_velocities(s: Samples) -> None:
    """(12) and (17) to (20) are the derivatives of positions; C^ is a particle, fixed in C."""
    same(yoo.eq_12_a(s), along(position_P, s.q, s.qd))
    r_Cs = along(lambda q: position_P(q) + s.R[:, None] * basis_B(q)[:, :, 1], s.q, s.qd)
    same(yoo.on_a(s, yoo.eq_17(s)), r_Cs)
    same(yoo.on_a(s, yoo.eq_18(s)), r_Cs)
    in_C = apply(rotation(2, s.q[:, 2]).transpose(0, 2, 1), yoo.r_Cs_Ch(s))
    v_Ch = r_Cs + along(lambda q: apply(basis_C(q), in_C), s.q, s.qd)
    same(yoo.on_a(s, yoo.eq_19(s)), v_Ch)
    same(yoo.on_a(s, yoo.eq_20(s)), v_Ch)


def test_accelerations(s: Samples) -> None:
    """(21) to (23) are the derivatives of (18), (15), (16); a^C^ is that of a particle fixed in C."""
    same(yoo.on_a(s, yoo.eq_21(s)), derivative(yoo.eq_18, s))
    same(yoo.on_a(s, yoo.eq_22(s)), derivative(yoo.eq_15, s))
    same(yoo.on_a(s, yoo.eq_23(s)), derivative(yoo.eq_16, s))
    in_C = apply(rotation(2, s.q[:, 2]).transpose(0, 2, 1), yoo.r_Cs_Ch(s))

    def v_Ch(moved: Samples) -> Array:
        arm = apply(rotation(2, moved.q[:, 2]), in_C)
        return yoo.eq_18(moved) + np.cross(yoo.eq_15(moved), arm)

    same(yoo.on_a(s, yoo.a_Ch(s)), derivative(v_Ch, s))


def test_newton_euler(s: Samples) -> None:
    """(28) and (32), solved, fulfil Newton's and Euler's laws for C* in an inertial basis.

    Tolerance 100 eps cond of the linear system, 1e-12 at least.
    """
    s, condition = yoo.solve(s)
    tolerance = np.maximum(1e-12, 100 * np.finfo(float).eps * condition)[:, None]

    contact = yoo.on_a(s, yoo.eq_29(s)) + yoo.vector(0.0 * s.m, 0.0, s.normal)
    force = contact + yoo.on_a(s, yoo.weight(s))
    mass_times_acceleration = s.m[:, None] * derivative(yoo.eq_18, s)
    scale = np.linalg.norm(contact, axis=1, keepdims=True)
    assert np.all(np.abs(force - mass_times_acceleration) <= tolerance * scale)

    def momentum(moved: Samples) -> Array:
        # in the inertial basis, from the inertia matrix of the disk in its own basis
        C = basis_C(moved.q)
        central = yoo.inertia(s)[:, :, None] * np.eye(3)
        w = yoo.on_a(moved, moved.u[:, :3])
        return yoo.on_b(moved, apply(C @ central @ C.transpose(0, 2, 1), w))

    arm = yoo.on_a(s, yoo.r_Cs_Ch(s))
    moment = np.cross(arm, contact)
    assert np.all(np.abs(moment - derivative(momentum, s)) <= tolerance * s.R[:, None] * scale)
