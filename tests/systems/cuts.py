# SPDX-License-Identifier: BSD-3-Clause
"""Reactions of random trees of joints: forces and torques between each seat and its body, and friction that depends on them."""

from __future__ import annotations

from typing import Any

import numpy as np

import kane as kn

HELD = {"pin": ("x", "y"), "slider": ("x", "y"), "ball": ("x", "y", "z"), "weld": ("x", "y", "z")}


def tree(seed: int, bodies: int, friction: bool = False) -> kn.System:
    """Bodies on pins, sliders, balls and welds, each on one before, with a cut at some of the joints."""
    rng = np.random.default_rng(seed)
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    ends = [(kn.Point("O", fixed_in=N), N)]
    solids, joints, cuts = [], [], []
    loads: list[Any] = [kn.gravity(-g * N.y)]
    for i in range(1, bodies + 1):
        at, seat = ends[rng.integers(len(ends))]
        kind = str(rng.choice(list(HELD) if i < bodies else ["pin"]))
        at = at.at(f"A{i}", seat.x * kn.parameter(f"l{i}", 0.8) + seat.y * 0.1)
        near = at
        at = at.at(f"B{i}", 0)
        axis = {} if kind in ("ball", "weld") else {"axis": seat.z}
        joint = getattr(kn, kind)(f"j{i}", at, seat, **axis)
        place = joint.point if kind == "slider" and rng.random() < 0.5 else at
        center = joint.point.at(f"C{i}", joint.frame.x * 0.3 + joint.frame.z * 0.1)
        inertia = kn.inertia(joint.frame, 1.0, 1.5, 1.2, 0.1)
        solids.append(
            kn.RigidBody(
                f"b{i}", frame=joint.frame, mass_center=center, mass=kn.parameter(f"m{i}", 1.0), inertia=inertia
            )
        )
        joints.append(joint)
        ends.append((joint.point, joint.frame))
        if rng.random() < 0.5:
            n = kn.reaction(f"N{i}", at=place, along=getattr(seat, str(rng.choice(HELD[kind]))))
            cuts.append(n)
            mu = kn.parameter(f"mu{i}", 0.1)
            if friction and kind == "pin":
                (w,) = joint.speeds
                torque = -mu * n * w * seat.z
                loads += [kn.Torque(joint.frame, torque), kn.Torque(seat, -torque)]
            if friction and kind == "slider":
                (v,) = joint.speeds
                loads += [kn.Force(joint.point, -mu * n * v * seat.z), kn.Force(near, mu * n * v * seat.z)]
        if rng.random() < 0.4 and kind in ("pin", "weld"):
            cuts.append(kn.reaction(f"T{i}", frame=joint.frame, along=(seat.x, seat.y)[rng.integers(2)]))
        if rng.random() < 0.3:
            loads.append(kn.Force(center, N.x * float(rng.normal())))
        if rng.random() < 0.3:
            loads.append(kn.Force(at, N.y * float(rng.normal())))
    return kn.System(N, bodies=solids, joints=joints, loads=loads, reactions=cuts)


def held(n: int, friction: bool = False) -> kn.System:
    """An arm of pins about crossed axes with the three forces on each as reactions, rubbing in its bearings by one of them or not."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    at, frame, solids, cuts = kn.Point("O", fixed_in=N), N, [], []
    loads: list[Any] = [kn.gravity(-g * N.y)]
    speeds = {}
    for i in range(1, n + 1):
        q, u = kn.coordinate(f"q{i}"), kn.speed(f"u{i}")
        axis, before = (frame.z if i % 2 else frame.y), frame
        frame = frame.rotate(f"B{i}", q, axis)
        at = at.at(f"A{i}", 0)
        forces = [kn.reaction(f"R{k}{i}", at=at, along=getattr(before, k)) for k in "xyz"]
        cuts += forces
        if friction:
            torque = -kn.parameter(f"mu{i}", 0.02) * forces[0] * u * axis
            loads += [kn.Torque(frame, torque), kn.Torque(before, -torque)]
        speeds[u] = q.dt
        center = at.at(f"C{i}", frame.x * kn.parameter(f"c{i}", 0.5))
        inertia = kn.inertia(frame, 0.1, 1.0, 1.1)
        solids.append(
            kn.RigidBody(f"b{i}", frame=frame, mass_center=center, mass=kn.parameter(f"m{i}", 1.0), inertia=inertia)
        )
        at = at.at(f"P{i}", frame.x * kn.parameter(f"l{i}", 1.0))
    return kn.System(N, bodies=solids, speeds=speeds, loads=loads, reactions=cuts)
