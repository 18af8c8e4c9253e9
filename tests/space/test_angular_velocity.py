# SPDX-License-Identifier: BSD-3-Clause
"""An angular velocity given beside the angle is compared with it."""

from __future__ import annotations

import pytest

import kane as kn

N = kn.Frame("N")
q, p = kn.coordinates("q p")
A = N.rotate("A", p, N.x)
rate = kn.parameter("rate", 3.0)


def test_the_right_one_changes_nothing():
    for axis in (A.z, (A.x + 2 * A.y).normalized()):
        plain = A.rotate("B", q, axis)
        told = A.rotate("B", q, axis, angular_velocity=q.dt * axis)
        for other in (A, N):
            found, known = (f.angular_velocity(other).components(N) for f in (told, plain))
            assert all(x is y for x, y in zip(found, known, strict=True))


def test_however_it_is_written():
    tilted = A.rotate("T", 0.3, A.z)
    A.rotate("B", rate * kn.time, A.z, angular_velocity=rate * tilted.z)
    A.rotate("B", kn.sin(q), A.y, angular_velocity=q.dt * kn.cos(q) * A.y)
    A.rotate("B", 0.7, A.y, angular_velocity=0 * A.y)


@pytest.mark.parametrize(
    ("angle", "given"),
    [
        (q, -q.dt * A.z),
        (q, q.dt * A.x),
        (q, 2 * q.dt * A.z),
        (q, (q.dt + p.dt) * A.z),
        (kn.sin(q), q.dt * A.z),
        (0.7, 1e-6 * A.z),
        (q, q.dt * A.z + p.dt * A.x),  # that in N, not in A
    ],
)
def test_what_contradicts_the_orientation(angle, given):
    with pytest.raises(
        kn.SpaceError, match=r"angular velocity of B in A that its orientation gives, .*, got .* leave it out"
    ):
        A.rotate("B", angle, A.z, angular_velocity=given)


def test_a_scalar_is_refused():
    with pytest.raises(kn.SpaceError, match="angular_velocity= of B to be a Vector, got q'"):
        A.rotate("B", q, A.z, angular_velocity=q.dt)
