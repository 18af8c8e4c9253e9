# SPDX-License-Identifier: BSD-3-Clause
"""A disk that rolls, with speeds of its contact along the spinning disk's axes, not at right angles."""

import kane as kn


def disk(dependent: tuple[int, ...] = (3, 4)) -> kn.System:
    """The disk; its dependent speeds by place, none to have them chosen."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    yaw, lean, spin, x, y = kn.coordinates("yaw lean spin x y")
    u = kn.speeds("u1:6")
    m, R, g = kn.parameter("m", 1.2), kn.parameter("R", 0.3), kn.parameter("g", 9.81)
    Y = N.rotate("Y", yaw, N.z)
    B = Y.rotate("B", kn.pi / 2 - lean, Y.x)
    C = B.rotate("C", spin, B.z)
    P = O.at("P", x * N.x + y * N.y)
    center = P.at("C*", R * B.y)
    body = kn.RigidBody("disk", frame=C, mass_center=center, mass=m, inertia=kn.thin_disk(C, m, R, axis=C.z))
    w, v = C.angular_velocity(N), x.dt * N.x + y.dt * N.y
    along = v.dot(C.x) + v.dot(C.z), v.dot(C.z) - 0.3 * v.dot(C.y)
    speeds = dict(zip(u, (w.dot(B.x), w.dot(B.y), w.dot(B.z), *along), strict=True))
    contact = kn.rolling(center.fixed_in(C, "C^", -R * B.y), normal=N.z)
    return kn.System(
        N,
        bodies=[body],
        speeds=speeds,
        loads=[kn.gravity(-g * N.z)],
        nonholonomic=contact,
        dependent_speeds=[u[k] for k in dependent],
    )
