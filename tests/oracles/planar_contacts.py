# SPDX-License-Identifier: BSD-3-Clause
"""Plane bodies with contacts in redundant coordinates: Newton's and Euler's equations in plain NumPy, written without `kane`.

Each body has (x, y, θ) of its mass centre in axes along and across the floor; a pin, the gaps that are closed and the slips that are
none are rows J of constraints with multipliers λ, and a contact that slips pushes along n − μ d t:

    [M  −Bᵀ] [a]   [f]
    [J   0 ] [λ] = [−J̇ v],     B = J but for contacts that slip, where B_n = J_n − μ d J_t

Where the floor moves, its velocity is taken from the rates of gaps and slips, and its acceleration from theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

Array = Any
G = 9.81


@dataclass(frozen=True)
class Plate:
    """A body; `pin` is where it is pinned to the first body: there, and on itself, from the mass centres. None: it is free."""

    mass: float
    inertia: float
    pin: tuple[tuple[float, float], tuple[float, float]] | None = None


@dataclass(frozen=True)
class Touch:
    """A corner of a body at `place` on the floor; a sphere about it, with a radius; a stop of the coordinate `stops` at `place[0]`."""

    body: int
    place: tuple[float, float]
    radius: float = 0.0
    stops: str = ""  # "x": x ≤ place[0], "a": the second body's angle relative to the first ≤ place[0]
    kinetic: float = 0.0
    static: float = 0.0
    restitution: float = 0.0


@dataclass(frozen=True)
class Support:
    """A floor that is at a sin(w t) along itself, and likewise across, (a, w) of both; its surface runs with a velocity besides."""

    along: tuple[float, float]
    across: tuple[float, float]
    belt: float = 0.0


@dataclass(frozen=True)
class Plane:
    """Bodies and contacts on an incline, which gravity sees at an angle of `slope`."""

    slope: float
    plates: tuple[Plate, ...]
    touches: tuple[Touch, ...]
    support: Support | None = None

    @property
    def width(self) -> int:
        return sum(3 if p.pin is None else 1 for p in self.plates)


def turned(angle: float, v: Sequence[float]) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]])


def across(v: Array) -> Array:
    return np.array([-v[1], v[0]])


def poses(plane: Plane, q: Array) -> tuple[Array, Array]:
    """(x, y, θ) of all bodies, and their derivative by q: x, y, θ of free bodies, the angle relative to the first of a pinned one."""
    z, dz = np.zeros(3 * len(plane.plates)), np.zeros((3 * len(plane.plates), plane.width))
    k = 0
    for i, plate in enumerate(plane.plates):
        own = slice(3 * i, 3 * i + 3)
        if plate.pin is None:
            z[own], dz[own, k : k + 3] = q[k : k + 3], np.eye(3)
            k += 3
            continue
        z[3 * i + 2] = z[2] + q[k]
        dz[3 * i + 2] = dz[2]
        dz[3 * i + 2, k] = 1.0
        there, here = turned(z[2], plate.pin[0]), turned(z[3 * i + 2], plate.pin[1])
        z[3 * i : 3 * i + 2] = z[:2] + there - here
        dz[3 * i : 3 * i + 2] = dz[:2] + np.outer(across(there), dz[2]) - np.outer(across(here), dz[3 * i + 2])
        k += 1
    return z, dz


def floor(plane: Plane, t: float) -> Array:
    """Place, velocity and acceleration of the floor (3), each across and along it: 3 × 2."""
    if plane.support is None:
        return np.zeros((3, 2))
    found = [
        (a * np.sin(w * t), a * w * np.cos(w * t), -a * w * w * np.sin(w * t))
        for a, w in (plane.support.across, plane.support.along)
    ]
    return np.array(found).T


class Row(NamedTuple):
    """The gap, the rows of its rate and of the slip (2 × 3n), what these have besides J v, and what their rates have besides J a."""

    gap: float
    j: Array
    rest: Array
    drift: Array


def rows(plane: Plane, touch: Touch, z: Array, v: Array, t: float = 0.0) -> Row:
    j, rest, drift, i = np.zeros((2, len(z))), np.zeros(2), np.zeros(2), touch.body
    if touch.stops == "x":
        j[0, 0] = -1
        return Row(touch.place[0] - z[0], j, rest, drift)
    if touch.stops == "a":
        j[0, [2, 5]] = 1, -1
        return Row(touch.place[0] - (z[5] - z[2]), j, rest, drift)
    arm = turned(z[3 * i + 2], touch.place)
    swing = across(arm)
    moves = floor(plane, t)
    j[0, 3 * i : 3 * i + 3] = 0, 1, swing[1]
    j[1, 3 * i : 3 * i + 3] = 1, 0, swing[0] + touch.radius
    rest[:] = -moves[1]
    rest[1] -= plane.support.belt if plane.support else 0.0
    drift[:] = -arm[::-1] * v[3 * i + 2] ** 2 - moves[2]
    return Row(z[3 * i + 1] + arm[1] - touch.radius - moves[0, 0], j, rest, drift)


class Rigid(NamedTuple):
    """M (diagonal), f, and the rows of the pins with J̇ v."""

    mass: Array
    force: Array
    pins: Array
    drift: Array


def rigid(plane: Plane, z: Array, v: Array) -> Rigid:
    mass = np.concatenate([[p.mass, p.mass, p.inertia] for p in plane.plates])
    gravity = G * np.array([-np.sin(plane.slope), -np.cos(plane.slope), 0])
    pins, drift = np.zeros((0, len(z))), list[float]()
    for i, plate in enumerate(plane.plates):
        if plate.pin is None:
            continue
        there, here = turned(z[2], plate.pin[0]), turned(z[3 * i + 2], plate.pin[1])
        for axis in range(2):
            j = np.zeros(len(z))
            j[axis], j[2], j[3 * i + axis], j[3 * i + 2] = 1, across(there)[axis], -1, -across(here)[axis]
            pins = np.vstack([pins, j])
            drift.append(-there[axis] * v[2] ** 2 + here[axis] * v[3 * i + 2] ** 2)
    return Rigid(mass, np.tile(gravity, len(plane.plates)) * mass, pins, np.array(drift))


def reduced(plane: Plane, q: Array, u: Array, t: float = 0.0) -> tuple[Array, Array, Array, Array]:
    """W, b, the sizes of the terms of b, and the velocities of all rows of contacts (2k), the pins eliminated."""
    z, dz = poses(plane, q)
    v = dz @ u
    body, every = rigid(plane, z, v), [rows(plane, touch, z, v, t) for touch in plane.touches]
    j, drift = np.concatenate([r.j for r in every]), np.concatenate([r.drift for r in every])
    free, spread, p = body.force / body.mass, j.T / body.mass[:, None], body.pins
    if len(p):
        back = p.T / body.mass[:, None] @ np.linalg.inv(p / body.mass @ p.T)
        free, spread = free - back @ (p @ free + body.drift), spread - back @ (p @ spread)
    b, terms = j @ free + drift, np.abs(j) @ np.abs(body.force / body.mass) + np.abs(drift)
    return j @ spread, b, np.maximum(terms, np.abs(b)), j @ v + np.concatenate([r.rest for r in every])


def solved(
    plane: Plane, q: Array, u: Array, modes: Sequence[str], along: Sequence[float], t: float = 0.0
) -> tuple[Array, Array, Array]:
    """u̇, N and F of all contacts; of contacts that stick by the same row F is the least that sums up to theirs."""
    z, dz = poses(plane, q)
    v = dz @ u
    mass, force, pins, pin_drift = rigid(plane, z, v)
    held, pushed, rest, owner = list(pins), list(pins), list(pin_drift), [(-1, 0)] * len(pins)
    for k, (touch, mode, d) in enumerate(zip(plane.touches, modes, along, strict=True)):
        if mode == "separated":
            continue
        _, j, _, drift = rows(plane, touch, z, v, t)
        held.append(j[0])
        pushed.append(j[0] - touch.kinetic * d * j[1] if mode == "straight" else j[0])
        rest.append(drift[0])
        owner.append((k, 0))
        if mode in ("stick", "held") and not touch.stops:
            held.append(j[1])
            pushed.append(j[1])
            rest.append(drift[1])
            owner.append((k, 1))
    n, m = len(z), len(held)
    left = np.zeros((n + m, n + m))
    left[:n, :n] = np.diag(mass)
    if m:
        left[n:, :n], left[:n, n:] = held, -np.array(pushed).T
    right = np.concatenate([force, -np.array(rest)])
    found = np.linalg.lstsq(left, right, rcond=1e-11)[0]
    assert np.abs(left @ found - right).max(initial=0) < 1e-9 * (1 + np.abs(found).max())
    forces = np.zeros((len(plane.touches), 2))
    for (k, axis), value in zip(owner, found[n:], strict=True):
        if k >= 0:
            forces[k, axis] = value
            if axis == 0 and modes[k] == "straight":
                forces[k, 1] = -plane.touches[k].kinetic * along[k] * value
    own = [
        x
        for i, p in enumerate(plane.plates)
        for x in (found[3 * i : 3 * i + 3] if p.pin is None else [found[3 * i + 2] - found[2]])
    ]
    return np.array(own), forces[:, 0], forces[:, 1]
