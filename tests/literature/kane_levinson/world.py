# SPDX-License-Identifier: BSD-3-Clause
"""What the problems of several chapters are set in: an inertial frame and its origin, gravity, bodies, systems."""

from __future__ import annotations

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
g = 9.81


def rigid(name: str, frame: kn.Frame, center: kn.Point, mass: float, inertia: kn.Dyadic) -> kn.RigidBody:
    return kn.RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=inertia)


def derived(bodies: list[object], loads: list[object], speeds: object = "rates", **more: object) -> kn.Equations:
    return kn.derive(kn.System(N, bodies=bodies, loads=loads, speeds=speeds, **more))
