# SPDX-License-Identifier: BSD-3-Clause
"""A rigid body in space, one point of which strikes a rough floor, with a parameter for all that the impact depends on."""

from __future__ import annotations

import kane as kn

PARAMETERS = ("l_x", "l_y", "l_z", "I_x", "I_y", "I_z", "mu", "e")


def thrown_body(law: str) -> kn.System:
    """Its speeds are ω along its own axes and the velocity of its mass centre; there is no weight, and its mass is 1."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    a, b, c, x, y, z = q = kn.coordinates("a b c x y z")
    l_x, l_y, l_z, I_x, I_y, I_z, mu, e = (kn.parameter(name, 1.0 - k / 10) for k, name in enumerate(PARAMETERS))
    B = N.rotate_body("B", [a, b, c], "123")
    C = O.at("C", x * N.x + y * N.y + z * N.z)
    w = B.angular_velocity(N)
    speeds = dict(
        zip(
            kn.speeds("w_x w_y w_z v_x v_y v_z"),
            [w.dot(B.x), w.dot(B.y), w.dot(B.z), x.dt, y.dt, z.dt],
            strict=True,
        )
    )
    tip = C.fixed_in(B, "P", l_x * B.x + l_y * B.y + l_z * B.z)
    place = kn.joints.point_on_plane("floor", tip, O, normal=N.z, along=N.x)
    body = kn.RigidBody("body", frame=B, mass_center=C, mass=1.0, inertia=kn.inertia(B, I_x, I_y, I_z))
    floor = kn.contact(place, mu, restitution=e, law=law)
    return kn.System(N, bodies=[body], speeds=speeds, contacts=[floor], coordinates=list(q))
