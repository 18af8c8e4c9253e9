# SPDX-License-Identifier: BSD-3-Clause
"""Chains pinned at both ends, in a plane or in space: closed loops of any number of links."""

from __future__ import annotations

import numpy as np

import kane as kn


def ring(n: int, spatial: bool = False, reactions: int = 0) -> kn.System:
    """Links on pins about parallel axes, or about x and z in turn, whose end is held at a point; forces in some pins as reactions."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    O = kn.Point("O", fixed_in=N)
    at, frame, bodies, cuts = O, N, [], []
    for i in range(1, n + 1):
        before = frame
        frame = frame.rotate(f"B{i}", kn.coordinate(f"q{i}"), frame.x if spatial and i % 2 else frame.z)
        length = kn.parameter(f"l{i}", 1.0 / n)
        if i <= reactions:
            at = at.at(f"A{i}", 0)
            cuts.append(kn.reaction(f"R{i}", at=at, along=before.x))
        center = at.at(f"C{i}", length / 2 * frame.y)
        inertia = kn.inertia(frame, 0.1, 0.02, 0.11)
        bodies.append(
            kn.RigidBody(f"b{i}", frame=frame, mass_center=center, mass=kn.parameter(f"m{i}", 1.0), inertia=inertia)
        )
        at = at.at(f"P{i}", length * frame.y)
    end = O.at("E", kn.parameter("a", 0.4) * N.x + kn.parameter("b", 0.3) * N.y)
    held = kn.coincident(at, end, along=(N.x, N.y, N.z) if spatial else (N.x, N.y))
    return kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)], holonomic=held, reactions=cuts)


def state(n: int, seed: int = 1) -> tuple[list[float], list[float]]:
    """Angles and speeds to begin with."""
    rng = np.random.default_rng(seed)
    return list(rng.uniform(-1, 1, n)), list(rng.normal(size=n))
