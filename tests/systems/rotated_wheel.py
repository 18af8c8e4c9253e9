# SPDX-License-Identifier: BSD-3-Clause
"""An upright wheel that rolls without slip, its constraints along the heading: A_D of the centre's speeds is a rotation matrix."""

from __future__ import annotations

import kane as kn


def rotated_wheel() -> kn.System:
    """Centre at (x, y), speeds the rates; forward speed is r times the spin's rate, none sideways."""
    x, y, yaw, spin = kn.coordinates("x y yaw spin")
    r, m = kn.parameter("r", 0.3, "m"), kn.parameter("m", 2.0, "kg")
    N = kn.Frame("N")
    A = N.rotate("A", yaw, N.z)
    B = A.rotate("B", spin, A.y)
    O = kn.Point("O", fixed_in=N)
    C = O.at("C", x * N.x + y * N.y)
    v = C.velocity(N)
    return kn.System(
        N,
        bodies=[kn.RigidBody("wheel", frame=B, mass_center=C, mass=m, inertia=kn.inertia(A, 0.05, 0.09, 0.05))],
        loads=[kn.Torque(A, 0.3 * A.z, name="steer"), kn.Force(C, 0.7 * N.x - 0.4 * N.y, name="push")],
        nonholonomic=[v.dot(A.x) - r * spin.dt, v.dot(A.y)],
        speeds="rates",
    )
