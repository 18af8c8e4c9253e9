# SPDX-License-Identifier: BSD-3-Clause
"""Trees in which several joints move by the same coordinates: gears, cams, parallel arms, drawn at random."""

from __future__ import annotations

import numpy as np

import kane as kn


def system(seed: int, bodies: int, coordinates: int, *, held: bool = False, chosen: str = "rates") -> kn.System:
    """Bodies that turn and slide by combinations and functions of few coordinates; `held` by an edge at a
    particle of the last, at another place in it for each configuration, with a reaction where the first begins.

    Speeds are the rates, or ω of the first bodies along their axes and rates of what is left (`chosen` "mixed").
    """
    rng = np.random.default_rng(seed)
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    q = [kn.coordinate(f"q{k}") for k in range(1, coordinates + 1)]
    ends = [(kn.Point("O", fixed_in=N), N)]
    solids = []
    for i in range(bodies):
        at, base = ends[int(rng.integers(len(ends)))]
        frame = base.rotate(f"B{i}", _amount(q, rng, i), _axis(base, rng))
        if rng.random() < 0.3:
            frame = frame.rotate(f"D{i}", _amount(q, rng, i + 1), _axis(frame, rng))
        along = _axis(base, rng) * (0.5 + _amount(q, rng, i) * float(rng.choice([0, 0, 1]) if i else 0))
        origin = at.at(f"P{i}", along)
        center = origin.at(f"C{i}", 0.2 * frame.x + 0.1 * frame.y)
        inertia = kn.inertia(frame, 0.2, 0.3, 0.4, 0.05)
        solids.append(
            kn.RigidBody(f"b{i}", frame=frame, mass_center=center, mass=kn.parameter(f"m{i}", 1.0 + i), inertia=inertia)
        )
        ends.append((origin, frame))
    load = kn.Force(solids[-1].mass_center, 3.0 * N.x - 2.0 * N.z)
    found = kn.System(N, bodies=solids, speeds="rates", loads=[kn.gravity(-g * N.z), load])
    if chosen == "mixed":
        own = kn.speeds(f"w1:{len(q) + 1}")
        factors = [kn.cos(x) / 3 + 1 for x in q]
        given = {u: f * x.dt + (0.5 * y.dt) for u, f, x, y in zip(own, factors, q, [*q[1:], kn.time], strict=True)}
        given[own[-1]] = factors[-1] * q[-1].dt
        found = found.replace(speeds=given)
    if held:
        origin, frame = ends[-1]
        particle = origin.fixed_in(frame, "K", (0.4 + 0.2 * kn.sin(q[0])) * frame.x + 0.1 * q[-1] * frame.z)
        edge = kn.no_slip(particle, along=0.6 * N.x + 0.8 * N.y, name="edge")
        cut = kn.reaction("R", at=ends[1][0], along=N.z)
        found = found.replace(nonholonomic=edge, reactions=[cut])
    return found


def _axis(frame: kn.Frame, rng: np.random.Generator) -> kn.Vector:
    axes = (frame.x, frame.y, frame.z, 0.6 * frame.x + 0.8 * frame.z)
    return axes[int(rng.integers(4))]


def _amount(q: list[kn.Coordinate], rng: np.random.Generator, i: int) -> kn.Expr:
    """A coordinate, a multiple, a sum or a function of several; each comes first somewhere."""
    a, b = q[i % len(q)], q[int(rng.integers(len(q)))]
    return (a, 2 * a, a - b / 2, a + 0.3 * kn.sin(b), a + 0.2 * a * b)[int(rng.integers(5))]
