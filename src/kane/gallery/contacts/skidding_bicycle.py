# SPDX-License-Identifier: BSD-3-Clause
"""A bicycle that skids on braking: the Whipple bicycle, whose wheels roll, lock, skid and lift off the road; z points down.

Brakes are dry friction of a given size, an input, between a wheel and what it turns in. Upright and straight, with the mass centre h
high, b ahead of the rear contact and w − b behind the front one, light wheels that are locked decelerate it by

    rear a = μ g (w − b)/(w + μ h),    front a = μ g b/(w − μ h),    both a = μ g,

and above a = g (w − b)/h the rear wheel lifts off.
"""

import math

import kane as kn
from kane.gallery.rolling import whipple_bicycle
from kane.gallery.rolling.whipple_bicycle import SOURCES as SOURCES

TITLE = "bicycle skidding on braking"
COORDINATES = (*whipple_bicycle.COORDINATES, ("z", "m", "rear contact below the road"))
START = {
    "q": {name: 0.0 for name, *_ in COORDINATES} | {"phi": 0.02},
    "u": {f"u{i}": 0.0 for i in range(1, 10)} | {"u5": -5 / 0.3, "u6": -5 / 0.35, "u7": 5.0},
    "inputs": {"T_R": 200.0, "T_F": 0.0, "T_delta": 0.0},
}
"""It leans a little and rolls at 5 m/s; the rear brake locks the wheel."""


def system() -> kn.System:
    """The bicycle free of the road, two contacts and two brakes; it ends where it lies on its side or pitches over."""
    q = x, y, _, phi, theta, delta, _, theta_F, z = tuple(kn.coordinate(*c) for c in COORDINATES)
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
    tilt = kn.parameter("lambda", math.pi / 10, "rad", "tilt of the steering axis")
    mu_k = kn.parameter("mu_k", 0.7, "1", "coefficient of sliding friction")
    mu_s = kn.parameter("mu_s", 0.8, "1", "coefficient of static friction")
    T_R = kn.input("T_R", "N*m", "rear brake: torque up to which it holds")
    T_F = kn.input("T_F", "N*m", "front brake: torque up to which it holds")
    T_delta = kn.input("T_delta", "N*m", "steer torque between rear frame and fork")
    frames = N, Y, L, B, S, H, _, R, F = whipple_bicycle.frames(q[:8], tilt)
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x + y * N.y + z * N.z)
    bodies, (r_R, r_F) = whipple_bicycle.bodies(frames, P, tilt)
    wheels = (("rear", bodies[0], L.y, r_R, L.z), ("front", bodies[3], H.y, r_F, None))
    places = [
        kn.joints.disk_on_plane(
            f"{end} tyre", body.frame, body.mass_center, O, axis=axis, radius=r, normal=-N.z, along=Y.x, down=down
        )
        for end, body, axis, r, down in wheels
    ]
    brakes = [kn.joints.clutch("rear brake", R, B, B.y, T_R), kn.joints.clutch("front brake", F, H, H.y, T_F)]
    speeds = whipple_bicycle.definitions(frames, delta, theta_F, P)["rates"]
    return kn.System(
        N,
        bodies=bodies,
        speeds=speeds | {kn.speed("u9", "m/s"): z.dt},
        loads=[kn.gravity(g * N.z), kn.loads.torque_pair(H, B, T_delta * S.z, name="steer torque")],
        contacts=[*(kn.contact(place, mu_k, static=mu_s) for place in places), *brakes],
        events=[
            kn.Event("falls", kn.cos(phi), 0.5, direction=-1, terminal=True),
            kn.Event("pitches over", theta, -1.0, direction=-1, terminal=True),
        ],
        coordinates=q,
    )
