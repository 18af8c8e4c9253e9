# SPDX-License-Identifier: BSD-3-Clause
"""A thin plate that turns about its centre."""

from __future__ import annotations

import kane as kn


def plate():
    """A thin plate on a ball joint at its centre, with torques: its moments of inertia are at the edge of what bodies have."""
    N, q, u = kn.Frame("N"), kn.coordinates("q1:4"), kn.speeds("u1:4")
    T = [kn.input(f"T{i}") for i in "123"]
    O = kn.Point("O", fixed_in=N)
    A = N.rotate("A", q[0], N.x)
    B = A.rotate("B", q[1], A.y)
    C = B.rotate("C", q[2], B.z)
    moments = [kn.parameter(name, value) for name, value in (("I1", 0.02), ("I2", 0.03), ("I3", 0.05))]
    P = O
    body = kn.RigidBody("plate", frame=C, mass_center=P, mass=kn.parameter("m", 2.0), inertia=kn.inertia(C, *moments))
    loads = [kn.gravity(-9.81 * N.z), *(kn.Torque(C, t * e) for t, e in zip(T, (C.x, C.y, C.z), strict=True))]
    return kn.derive(kn.System(N, bodies=[body], speeds=dict(zip(u, (x.dt for x in q), strict=True)), loads=loads)), T
