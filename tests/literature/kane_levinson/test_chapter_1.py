# SPDX-License-Identifier: BSD-3-Clause
"""Kane & Levinson 1985, chapter 1: differentiation of vectors in reference frames.

Each problem is of the kind of its section; what is expected is in closed form, or computed in NumPy without `kane`, derivatives by
complex steps.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
Q1, Q2 = kn.coordinates("q1 q2")
S = kn.parameter("s", 0.8, "m")
A = N.rotate("A", Q1, N.y)
B = A.rotate("B", Q2, A.x)
HERE = {Q1: 0.7, Q2: -0.4, S: 0.8}
STEP = 1e-30


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    r = np.zeros((3, 3), dtype=complex)
    r[i, i] = 1
    r[j, j] = r[k, k] = c
    r[k, j], r[j, k] = s, -s
    return r


def numbers(v, frame, values=HERE):
    return np.asarray(kn.evaluate(v.components(frame), values), dtype=float)


def complex_step(f, x):
    return f(x + 1j * STEP).imag / STEP


# 1.2 to 1.4 Several reference frames, scalar functions, first derivatives ----------------------------------------------------


def test_a_diagonal_of_a_door_that_turns():
    """A vector fixed in a door with a flap: its derivatives by the two angles, in the house, the door, and the flap."""
    v = 2 * S * B.x - S * B.y + 3 * S * B.z
    local = 0.8 * np.array([2, -1, 3])
    house = [
        complex_step(lambda q: turn(1, q) @ turn(0, -0.4) @ local, 0.7),
        complex_step(lambda q: turn(1, 0.7) @ turn(0, q) @ local, -0.4),
    ]
    for q, wanted in zip((Q1, Q2), house, strict=True):
        np.testing.assert_allclose(numbers(v.diff(q, N), N), wanted, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(numbers(v.diff(Q2, A), A), complex_step(lambda q: turn(0, q) @ local, -0.4), atol=1e-15)
    assert v.diff(Q1, A).is_zero
    assert v.diff(Q2, B).is_zero


@pytest.mark.parametrize("q", [Q1, Q2])
def test_partial_derivatives_are_measure_numbers_differentiated(q):
    """The definition: ∂v/∂q in A is Σ ∂v_i/∂q a_i, with v_i along A (sec. 1.4)."""
    v = Q1**2 * B.z + S * kn.sin(Q1 * Q2) * A.x + Q2 * N.z
    for frame in (N, A, B):
        wanted = [kn.evaluate(kn.diff(x, q), HERE) for x in v.components(frame)]
        np.testing.assert_allclose(numbers(v.diff(q, frame), frame), wanted, rtol=1e-13, atol=1e-15)


# 1.5, 1.7 Representations, sums and products ----------------------------------------------------------------------------------


def test_products():
    """∂(s v), ∂(v·w), ∂(v × w) by the rule of products, the last two in any frame alike (sec. 1.7)."""
    s, v, w = kn.cos(Q1) * Q2, Q1 * B.x + S * N.y, S * A.z - Q2**2 * B.y
    for frame in (N, A, B):
        dv, dw = v.diff(Q1, frame), w.diff(Q1, frame)
        np.testing.assert_allclose(
            numbers((v * s).diff(Q1, frame), N), numbers(dv * s + v * kn.diff(s, Q1), N), rtol=1e-13, atol=1e-15
        )
        product = kn.evaluate(dv.dot(w) + v.dot(dw), HERE)
        assert kn.evaluate(kn.diff(v.dot(w), Q1), HERE) == pytest.approx(float(product), rel=1e-12)
        left = numbers(v.cross(w).diff(Q1, frame), N)
        np.testing.assert_allclose(left, numbers(dv.cross(w) + v.cross(dw), N), rtol=1e-12, atol=1e-14)


def test_a_unit_vector_changes_across_itself():
    """u·∂u/∂q = 0 for a unit vector, in any frame."""
    e = (S * B.x + Q1 * N.y + A.z).normalized()
    for frame in (N, A, B):
        assert kn.evaluate(e.dot(e.diff(Q1, frame)), HERE) == pytest.approx(0, abs=1e-15)


# 1.8 Second derivatives -------------------------------------------------------------------------------------------------------


def test_the_order_of_frames_matters():
    """In one frame mixed derivatives agree; in two, ∂/∂q1 in N of ∂/∂q2 in B is not ∂/∂q2 in B of ∂/∂q1 in N."""
    v = S * A.z + Q2 * S * B.y
    one, other = (v.diff(a, N).diff(b, N) for a, b in ((Q1, Q2), (Q2, Q1)))
    np.testing.assert_allclose(numbers(one, N), numbers(other, N), rtol=1e-13, atol=1e-15)
    first, second = v.diff(Q1, N).diff(Q2, B), v.diff(Q2, B).diff(Q1, N)
    assert np.abs(numbers(first, N) - numbers(second, N)).max() > 0.1

    def local(q1, q2):  # v along B
        return turn(0, q2).T @ np.array([0, 0, 0.8]) + np.array([0, 0.8 * q2, 0])

    def step(q1, q2):  # ∂v/∂q2 in B, along N
        return turn(1, q1) @ turn(0, q2) @ complex_step(lambda x: local(q1, x), q2)

    np.testing.assert_allclose(numbers(second, N), complex_step(lambda x: step(x, -0.4), 0.7), rtol=1e-13, atol=1e-15)


# 1.9 Total and partial derivatives --------------------------------------------------------------------------------------------


def test_total_derivative_with_explicit_time():
    """dv/dt = Σ ∂v/∂q q̇ + ∂v/∂t, for a vector and for |v|²."""
    t = kn.time
    v = Q1 * t * B.x + kn.sin(3 * t) * A.z
    values = HERE | {t: 0.9, Q1.dt: 1.3, Q2.dt: -0.6}
    total = v.diff(Q1, N) * Q1.dt + v.diff(Q2, N) * Q2.dt + v.diff(t, N)
    np.testing.assert_allclose(numbers(v.dt(N), N, values), numbers(total, N, values), rtol=1e-13)

    def along(x):  # x: complex time around 0.9, the angles moving with it
        q1, q2 = 0.7 + 1.3 * (x - 0.9), -0.4 - 0.6 * (x - 0.9)
        b, a = turn(1, q1) @ turn(0, q2), turn(1, q1)
        return b @ np.array([q1 * x, 0, 0]) + a @ np.array([0, 0, np.sin(3 * x)])

    np.testing.assert_allclose(numbers(v.dt(N), N, values), complex_step(along, 0.9), rtol=1e-13, atol=1e-14)
