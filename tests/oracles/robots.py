# SPDX-License-Identifier: BSD-3-Clause
"""Robots in URDF by kane and by Pinocchio at random states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

import kane as kn
from tests.oracles import pinocchio_urdf
from tests.oracles.compare import error, tolerance

Array = Any


def turn(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def coordinates(s: pinocchio_urdf.State) -> list[float]:
    """As `kn.pin`, `kn.planar` and `kn.free` have them."""
    if len(s.rate) < 6:
        return list(s.value)
    rotation, place = s.value
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return [w, x, y, z, *place]


def speeds(s: pinocchio_urdf.State) -> list[float]:
    """Of the same joints: rates, those of a planar joint along the parent's axes, of a free one turns first."""
    if len(s.rate) == 3:
        return [*turn(s.value[2]) @ s.rate[:2], s.rate[2]]
    return [*s.rate[3:], *s.rate[:3]] if len(s.rate) == 6 else list(s.rate)


def accelerations(s: pinocchio_urdf.State, a: Array) -> Array:
    """Derivatives of such speeds as Pinocchio has them."""
    if len(a) == 6:
        return np.concatenate([a[3:], a[:3]])
    if len(a) == 3:
        x, y, w = s.rate
        return np.array([*(turn(s.value[2]).T @ a[:2] - w * np.array([-y, x])), a[2]])
    return a


def compare(
    text: str, model: Any, eom: kn.Equations, rng: np.random.Generator, states: int = 3, free: bool = False
) -> float:
    """The largest error of accelerations and, of trees, of M, over the tolerance of 1e-9 or 100 ε cond."""
    engine, tied = pinocchio_urdf.model_of(text, free), pinocchio_urdf.mimics(text)
    worst, number = 0.0, {s: k for k, s in enumerate(eom.speeds)}
    for _ in range(states):
        state = pinocchio_urdf.random_state(engine, rng, tied)
        names = {n: model.extras["joints"]["base" if n == "root_joint" else n] for n in state}
        effort = {n: rng.uniform(-1, 1) for n in state if f"tau_{names[n]}" in model.symbols}
        q: dict[str, Any] = {}
        u: dict[str, Any] = {}
        order = []
        for n, s in state.items():
            joint = model.system[names[n]]
            q |= zip((x.name for x in joint.coordinates), coordinates(s), strict=True)
            u |= zip((x.name for x in joint.speeds), speeds(s), strict=True)
            order.append([number[x] for x in joint.speeds])
        inputs = {f"tau_{names[n]}": t for n, t in effort.items()}
        found = np.array(eom.evaluate(list(eom.accelerations), q=q, u=u, inputs=inputs), dtype=np.float64)
        answer = pinocchio_urdf.solve(engine, state, effort, text)
        ours = np.concatenate([accelerations(s, found[k]) for s, k in zip(state.values(), order, strict=True)])
        theirs = np.concatenate([answer.acceleration[n] for n in state])
        worst = max(worst, error(ours, theirs) / tolerance(1e-9, answer.condition))
        if not tied and all(len(s.rate) == 1 for s in state.values()):
            flat = [k for (k,) in order]
            M = np.array(eom.evaluate(eom.mass_matrix, q=q, u=u, inputs=inputs), dtype=np.float64)[np.ix_(flat, flat)]
            worst = max(worst, error(M, answer.mass_matrix) / 1e-9)
    return worst
