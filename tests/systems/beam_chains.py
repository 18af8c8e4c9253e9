# SPDX-License-Identifier: BSD-3-Clause
"""A cantilever as rigid rods joined by pins with torsion springs, on a hub whose motion is prescribed."""

from typing import Any

import kane as kn


def chain(links: int, *, flap: bool = False, angle: Any = None) -> tuple[kn.System, kn.Point, kn.Frame]:
    """Unit length, mass and EI, with its tip and the hub's frame; the hub turns by Ω t about N.z, or by an angle.

    Springs of EI/h stand halfway along each of `links` pieces of length h, so that the first and the last rod are half as long:
    curvatures are those in the middle of pieces, and what is left out is of order h². A force F across the axis is at the tip.
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    Omega = kn.parameter("Omega", 0.0, "rad/s")
    A = N.rotate("A", Omega * kn.time if angle is None else angle, N.z)
    F = kn.parameter("F", 0.0, "N")
    h = 1.0 / links
    frame, point, arm = A, O, h / 2
    bodies, joints, loads = [], [], []
    for k in range(1, links + 1):
        axis = -frame.y if flap else frame.z
        joint = kn.pin(str(k), point.at(f"H{k}", arm * frame.x), frame, axis=axis)
        loads.append(kn.torsional_spring(joint.frame, frame, joint.coordinates[0], float(links), axis=axis))
        frame, point = joint.frame, joint.point
        arm = h if k < links else h / 2
        turning = arm**3 / 12
        center = point.at(f"C{k}", arm / 2 * frame.x)
        bodies.append(
            kn.RigidBody(
                f"rod {k}", frame=frame, mass_center=center, mass=arm, inertia=kn.inertia(frame, 0.0, turning, turning)
            )
        )
        joints.append(joint)
    tip = point.at("tip", arm * frame.x)
    loads.append(kn.Force(tip, F * (A.z if flap else A.y)))
    return kn.System(N, bodies=bodies, joints=joints, loads=loads), tip, A
