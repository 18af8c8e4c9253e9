# SPDX-License-Identifier: BSD-3-Clause
"""Random states on the constraints of a system, by Newton's method and projection in plain NumPy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

import kane as kn
from kane import jacobian

Array = Any


def closed(eom: kn.Equations, q: Array, moving: Sequence[int] | None = None) -> Array | None:
    """`q` with the coordinates in `moving` (all) changed until the configuration constraints hold; None where that fails."""
    symbols, f = list(eom.coordinates), [c.expr for c in eom.system.holonomic]
    places = list(range(len(symbols))) if moving is None else list(moving)
    q = np.array(q, dtype=float)
    gradient = jacobian(f, [symbols[k] for k in places])
    for _ in range(80 if f else 0):
        values = dict(zip(symbols, q, strict=True))
        residual = np.array(kn.evaluate(f, values), dtype=float)
        if np.abs(residual).max() < 1e-14:
            break
        matrix = np.array(kn.evaluate(gradient, values), dtype=float)
        q[places] -= np.linalg.lstsq(matrix, residual, rcond=1e-10)[0]
    return q if not f or np.abs(residual).max() < 1e-12 else None


def speeds(eom: kn.Equations, q: Array, rng: np.random.Generator, inputs: Any = None) -> tuple[Array, float]:
    """Random u with A u + b = 0, and the least singular value that counts over the largest."""
    d = len(eom.dependent_speeds)
    values = dict(zip(eom.coordinates, q, strict=True)) | dict(inputs or {})
    a, b = (np.array(kn.evaluate(x, values), dtype=float) for x in (eom.A, list(eom.b)))
    sizes = np.linalg.svd(a)[1]
    u = rng.normal(size=len(eom.speeds))
    return u - np.linalg.pinv(a, rcond=1e-9) @ (a @ u + b), float(sizes[d - 1] / sizes[0])


def _turned(eom: kn.Equations, q: Array) -> Array:
    """The coordinates with Euler parameters of unit length."""
    place: dict[Any, int] = {x: k for k, x in enumerate(eom.coordinates)}
    for group in eom.system.euler_parameters:
        own = [place[e] for e in group.coordinates]
        q[own] /= np.linalg.norm(q[own])
    return q


def states(
    eom: kn.Equations,
    rng: np.random.Generator,
    count: int,
    moving: Sequence[int] | None = None,
    reach: float = 3.0,
    inputs: Any = None,
) -> Iterator[tuple[Array, Array]]:
    """`count` random states at which A has its rank."""
    found = 0
    for _ in range(60 * count):
        q = closed(eom, _turned(eom, rng.uniform(-reach, reach, len(eom.coordinates))), moving)
        if q is None:
            continue
        u, share = speeds(eom, q, rng, inputs)
        if share > 1e-3:
            yield q, u
            found += 1
        if found == count:
            return
    raise AssertionError(f"Expected {count} closed states, got {found}.")
