# SPDX-License-Identifier: BSD-3-Clause
"""Systems of several flexible beams: arms of links, hubs with booms, beams in space with joints and bodies on them."""

from typing import Any

import kane as kn


def flexible_arm(links: int, *, modes: int = 2, form: str = "linearized", reactions: bool = False) -> kn.System:
    """A planar arm of flexible links with a mass at the end of each, under gravity; the last joint's force by name."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    L = kn.parameter("L", 0.5, "m")
    share = kn.parameter("rhoA", 1.0, "kg/m")
    stiff = kn.parameter("EI", 10.0, "N*m^2")
    m = kn.parameter("m", 1.0, "kg")
    frame, point, cut = N, O, O
    bodies: list[Any] = []
    joints = []
    for k in range(1, links + 1):
        cut = point.at(f"cut {k}", 0)
        joint = kn.pin(str(k), cut, frame, axis=frame.z)
        shapes = kn.mode_shapes("polynomials", modes)
        link = kn.Beam(
            f"b{k}", joint.point, frame=joint.frame, axis=joint.frame.x, length=L, mass_per_length=share, EI=stiff,
            modes=shapes, form=form,
        )  # fmt: skip
        joints.append(joint)
        point, frame = link.point_at(1), link.frame_at(1)
        bodies += [link, kn.Particle(f"m{k}", point, m)]
    named = [kn.reaction("Rx", at=cut, along=N.x), kn.reaction("Ry", at=cut, along=N.y)] if reactions else []
    return kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-9.81 * N.y)], reactions=named)


def booms(count: int, *, form: str = "linearized", fixed: bool = False) -> kn.System:
    """A hub in a plane, or the ground, with booms along different axes and a mass at the tip of each."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    bodies: list[Any] = []
    joints = []
    A, P = N, O
    if not fixed:
        base = kn.planar("hub", O, N, normal=N.z)
        A, P = base.frame, base.point
        bodies.append(kn.RigidBody("hub", frame=A, mass_center=P, mass=4.0, inertia=kn.inertia(A, 1.0, 1.0, 1.0)))
        joints.append(base)
    for k in range(count):
        angle = 2 * kn.pi * k / count
        axis = kn.cos(angle) * A.x + kn.sin(angle) * A.y
        boom = kn.Beam(
            f"b{k}", P.at(f"root {k}", 0.3 * axis), frame=A, axis=axis, along=A.z.cross(axis), length=2.0,
            mass_per_length=0.3, EI=6.0, modes=2, form=form,
        )  # fmt: skip
        bodies += [boom, kn.Particle(f"tip {k}", boom.point_at(1), 0.2)]
    return kn.System(N, bodies=bodies, joints=joints, loads=[kn.gravity(-1.6 * N.y)])


def spatial(links: int = 1, form: str = "linearized") -> kn.System:
    """On a free hub beams that bend both ways, stretch and twist, with loads, a mass halfway, and a joint with a body at the tip."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    base = kn.free("hub", O, N)
    frame, point = base.frame, base.point.at("R", 0.3 * base.frame.x)
    inertia = kn.inertia(frame, 1.0, 2.0, 1.5)
    bodies: list[Any] = [kn.RigidBody("hub", frame=frame, mass_center=base.point, mass=3.0, inertia=inertia)]
    joints: list[Any] = [base]
    loads: list[Any] = [kn.gravity(-9.81 * N.z)]
    for k in range(links):
        beam = kn.Beam(
            f"b{k}", point, frame=frame, axis=frame.x, along=frame.y, length=1.2, mass_per_length=0.7, EI=(3.0, 5.0),
            modes=(2, 1), EA=200.0, stretch=1, GJ=2.0, torsion=1, polar=0.01, form=form, damping={"ratio": 0.02},
        )  # fmt: skip
        middle, E = beam.point_at(0.5), beam.frame_at(1)
        joint = kn.pin(f"j{k}", beam.point_at(1), E, axis=E.y)
        frame, point = joint.frame, joint.point
        center = point.at(f"c{k}", 0.1 * frame.x + 0.02 * frame.z)
        end = kn.RigidBody(
            f"r{k}", frame=frame, mass_center=center, mass=0.3, inertia=kn.inertia(frame, 0.01, 0.02, 0.03)
        )
        bodies += [beam, kn.Particle(f"p{k}", middle, 0.1), end]
        joints.append(joint)
        loads += [kn.Torque(E, 0.3 * N.x, name=f"T{k}"), kn.Force(middle, 0.2 * E.y, name=f"F{k}")]
    return kn.System(N, bodies=bodies, joints=joints, loads=loads)
