# SPDX-License-Identifier: BSD-3-Clause
"""A Stewart platform: a body on six legs, each a universal joint and a slide, which end in points of the platform."""

from __future__ import annotations

from math import cos, pi, sin

import kane as kn

LEGS = range(6)
PLATFORM = ("x", "y", "z", "a1", "a2", "a3")


def system() -> kn.System:
    """Coordinates of the platform, then two angles and a length of each leg; forces along the legs as inputs."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, z, *angles = kn.coordinates(" ".join(PLATFORM))
    P = N
    for a, axis in zip(angles, "xyz", strict=True):
        P = P.rotate(f"P{axis}", a, getattr(P, axis))
    C = O.at("C", x * N.x + y * N.y + z * N.z)
    bodies = [kn.RigidBody("platform", frame=P, mass_center=C, mass=10, inertia=kn.inertia(P, 0.6, 0.7, 1.2))]
    closing: list[kn.Constraint] = []
    coordinates, loads = [x, y, z, *angles], [kn.gravity(-9.81 * N.z)]
    for k in LEGS:
        base, top = k // 2 * 2 * pi / 3 + (-0.3, 0.3)[k % 2], (k + 1) // 2 * 2 * pi / 3 - pi / 3 + (0.4, -0.4)[k % 2]
        al, be, s = kn.coordinates(f"al{k} be{k} s{k}")
        F = N.rotate(f"F{k}", al, N.x)
        L = F.rotate(f"L{k}", be, F.y)
        end = O.at(f"B{k}", cos(base) * N.x + sin(base) * N.y).at(f"T{k}", s * L.z)
        place = C.at(f"A{k}", 0.5 * cos(top) * P.x + 0.5 * sin(top) * P.y)
        bodies.append(kn.Particle(f"leg {k}", end, 1))
        loads.append(kn.Force(end, kn.input(f"f{k}") * L.z))
        closing += kn.coincident(end, place, along=(N.x, N.y, N.z), name=f"leg {k}")
        coordinates += [al, be, s]
    return kn.System(N, bodies=bodies, speeds="rates", loads=loads, holonomic=closing, coordinates=coordinates)
