# SPDX-License-Identifier: BSD-3-Clause
"""Partial derivatives of vectors in frames, velocities in any frame, simple rotations."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q1, q2, q3, x = kn.coordinates("q1 q2 q3 x")
e = kn.coordinates("e0:4")
u = kn.speed("u")
R = kn.parameter("R", 0.7)
A = N.rotate("A", q1, N.z)
B = A.rotate("B", q2 + R * q1, A.x)
C = B.rotate("C", q3, (B.x + 2 * B.y + 2 * B.z) / 3)
E = A.rotate_euler_parameters("E", e)
VALUES: dict[kn.Expr, float] = {q1: 0.3, q2: -0.8, q3: 1.1, x: 0.6, R: 0.7, u: 1.9}
VALUES |= dict(zip(e, (0.5, 0.5, -0.5, 0.5), strict=True))
VECTOR = x * R * C.x + q2**2 * A.y - N.z + u * B.z + q1 * x * E.y


@pytest.mark.parametrize("frame", [N, A, B, C, E])
@pytest.mark.parametrize("by", [q1, q2, q3, x, R, u, e[1]])
def test_they_are_those_of_measure_numbers(frame, by):
    """∂v/∂s in A: the derivatives of the measure numbers along A (sec. 1.4)."""
    found = kn.evaluate(VECTOR.diff(by, frame).components(frame), VALUES)
    wanted = kn.evaluate([kn.diff(c, by) for c in VECTOR.components(frame)], VALUES)
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-14)


def test_they_make_up_the_total_derivative():
    """dv/dt = Σ ∂v/∂q q̇ (sec. 1.9)."""
    v = x * R * C.x + q2**2 * A.y
    rates = {q.dt: r for q, r in zip((q1, q2, q3, x), (0.4, -1.2, 0.7, 2.0), strict=True)}
    total = sum((v.diff(q, B) * q.dt for q in (q1, q2, q3, x)), start=kn.Vector())
    left, right = (kn.evaluate(w.components(B), VALUES | rates) for w in (v.dt(B), total))
    np.testing.assert_allclose(left, right, rtol=1e-12)


def test_they_stay_along_their_frames():
    assert str((R * A.x).diff(q1, N)) == "R A.y"
    assert str((u * A.x).diff(u, N)) == "A.x"
    with pytest.raises(kn.SpaceError, match=r"v\.dt\(frame\)"):
        A.x.diff(q1 * 2, N)


def test_velocities_in_other_frames():
    """Of points and particles: as derivatives, and by two points fixed in a body and one that moves on it (sec. 2.6 to 2.8)."""
    Q = O.at("Q", q2 * N.x + x * A.y)  # fixed in B, say
    P = Q.at("P", x * B.y + R * q1 * C.z)
    K = P.fixed_in(C, "K", R * C.x)
    rates = {q.dt: r for q, r in zip((q1, q2, q3, x), (0.4, -1.2, 0.7, 2.0), strict=True)}
    rates |= {q.dt.dt: r for q, r in zip((q1, q2, q3, x), (-0.3, 0.2, 1.7, -0.5), strict=True)}

    def same(a, b):
        np.testing.assert_allclose(
            *(kn.evaluate(v.components(N), VALUES | rates) for v in (a, b)), rtol=1e-11, atol=1e-12
        )

    assert str(P.velocity(B, Q)) == str(P.position(Q).dt(B))
    w, alpha, r = B.angular_velocity(N), B.angular_acceleration(N), P.position(Q)
    same(P.velocity(B, Q), P.velocity(N) - Q.velocity(N) - w.cross(r))
    a = P.acceleration(N) - Q.acceleration(N) - alpha.cross(r) - w.cross(w.cross(r)) - 2 * w.cross(P.velocity(B, Q))
    same(P.acceleration(B, Q), a)
    spin, arm = C.angular_velocity(B), R * C.x
    same(K.velocity(B, Q), P.velocity(B, Q) + spin.cross(arm))
    turned = C.angular_velocity(B).dt(B).cross(arm) + spin.cross(spin.cross(arm))
    same(K.acceleration(B, Q), P.acceleration(B, Q) + turned)
    coincident = P.fixed_in(B, "P̄", 0)  # of B: moves with P's point of B only where P is fixed in B
    assert kn.evaluate(coincident.velocity(N).components(N), VALUES | rates) is not None
    with pytest.raises(kn.SpaceError, match=r"P\.velocity\(B, Q\)"):
        P.velocity(B)
    with pytest.raises(kn.SpaceError, match="as origin"):
        P.velocity(B, N)


def test_simple_rotations():
    axis, angle = C.simple_rotation(B)
    assert str(angle) == "q3"
    w = C.angular_velocity(B)
    for v, frame in ((w - axis * angle.dt, B), (w - axis * angle.dt, C)):
        np.testing.assert_allclose(kn.evaluate(v.components(frame), VALUES | {q3.dt: 1.3}), 0, atol=1e-15)
    back, minus = B.simple_rotation(C)
    assert (str(back), str(minus)) == (str(axis), "-q3")
    D = A.rotate("D", q3, A.z)  # coaxial with A: one turn in N, and one in A
    assert [str(x) for x in D.simple_rotation(A)] == ["N.z", "q3"]
    assert str(D.simple_rotation(N)[1]) == "q1 + q3"
    fixed = A.rotate("F", kn.Rational(1, 3), A.x)
    assert str(fixed.simple_rotation(N)[1]) == "q1"
    for frame in (C, E, N):
        with pytest.raises(kn.SpaceError, match="sum of simple ones"):
            frame.simple_rotation(N)
