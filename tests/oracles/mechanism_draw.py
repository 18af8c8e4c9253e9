# SPDX-License-Identifier: BSD-3-Clause
"""Random mechanisms with 1 to 3 closures. Structure is drawn by Hypothesis and shrinks; numbers are generic, from a drawn seed.

A closure is placed where the tree stands, so that it holds. One that would take the last degree of freedom, repeat a row that
is there already, or come near either is replaced by one that holds less.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from tests.oracles.loops.records import GROUND, Mark, Pose
from tests.oracles.mechanism import CONTACTS, STEPS, Closure, Frames, Mechanism, Part, frames, to_oracle
from tests.oracles.mechanism_kane import SPEEDS, Asked
from tests.oracles.tree import Array, normalized, rotation, six_points

CONDITION = 100.0  # of all rows in the metric of mass
_JOINTS = {
    True: ("pin", "pin", "rail", "planar"),
    False: ("pin", "universal", "gimbal", "ball", "free", "cylindrical", "planar", "free", "slider"),
}
_CLOSURES = {
    True: ("on line", "on line", "distance", "on plane", "knife edge", "groove"),
    False: (
        "ball", "pin", "universal", "cylindrical", "slider", "planar", "distance", "on line", "on plane", "sphere",
        "wheel", "knife edge", "groove",
    ),
}  # fmt: skip
_WEAKER = {
    True: ("on plane", "distance", "knife edge"),
    False: ("ball", "on line", "distance", "on plane", "knife edge"),
}
Z = np.array([0.0, 0.0, 1.0])


def _tilt(rng: np.random.Generator, planar: bool) -> Array:
    axis = Z if planar else np.array(normalized(rng.normal(size=3)))
    return rotation(axis, rng.uniform(-3.0, 3.0))


def _vector(rng: np.random.Generator, planar: bool, size: float) -> Array:
    return rng.uniform(-size, size, 3) * ([1.0, 1.0, 0.0] if planar else np.ones(3))


def _part(rng: np.random.Generator, planar: bool, parent: int, joint: str) -> tuple[Part, Array]:
    mass = float(rng.uniform(0.5, 2.0))
    arms, turn = rng.uniform(0.2, 0.6, 3), rotation(normalized(rng.normal(size=3)), rng.uniform(-3.0, 3.0))
    pushed = rng.random() < 0.5
    part = Part(
        parent,
        joint,
        _vector(rng, planar, 1.0),
        _tilt(rng, planar),
        mass,
        _vector(rng, planar, 0.5),
        np.array(six_points(mass, arms, turn)),
        pushed * rng.uniform(-3.0, 3.0, 3),
        pushed * rng.uniform(-3.0, 3.0, 3),
    )
    values: list[float] = []
    for kind, _ in STEPS[joint]:
        if kind == "sphere":
            e = rng.normal(size=4)
            values += (e / np.linalg.norm(e)).tolist()
        else:
            values.append(rng.uniform(-1.2, 1.2))
    return part, np.array(values)


def _mark(pose: Pose, point: Array, axes: Array) -> Mark:
    return Mark(pose.R.T @ (point - pose.r), pose.R.T @ axes)


def _closure(rng: np.random.Generator, planar: bool, kind: str, pair: tuple[int, int], places: Frames) -> Closure:
    """A closure of this kind that holds where the bodies are."""
    near, far = (Pose(np.zeros(3), np.eye(3)) if b == GROUND else places.poses[b] for b in pair)
    point = far.at(_vector(rng, planar, 1.0))
    axes = _tilt(rng, planar)
    if planar and kind == "on plane":  # the plane stands upright
        axes = axes[:, [1, 2, 0]]
    if kind in CONTACTS:
        radius = float(rng.uniform(0.2, 0.5))
        turn = _tilt(rng, planar)
        drop = np.zeros(3)
        if kind == "sphere":
            drop = -radius * axes[:, 2]
        elif kind == "wheel":
            across = axes[:, 2] @ turn[:, 2] * turn[:, 2] - axes[:, 2]
            drop = radius * across / np.linalg.norm(across)
        floor = point + drop + axes[:, :2] @ rng.uniform(-1.0, 1.0, 2)
        return Closure(kind, pair, (_mark(near, floor, axes), _mark(far, point, turn)), radius)
    if kind == "distance":
        way = _vector(rng, planar, 1.0)
        way *= (0.5 + np.linalg.norm(way)) / np.linalg.norm(way)
        marks = _mark(near, point - way, axes), _mark(far, point, axes)
        return Closure(kind, pair, marks, float(np.linalg.norm(way)))
    shift, own = np.zeros(3), axes
    if kind in ("on line", "cylindrical", "slider") and not planar:
        shift = rng.uniform(-1.0, 1.0) * axes[:, 2]
    if kind in ("on plane", "planar"):
        shift = axes[:, :2] @ (rng.uniform(-1.0, 1.0, 2) * ([0.0, 1.0] if planar else 1.0))
    if kind == "screw":
        pitch = float(rng.uniform(0.1, 0.4))
        angle = rng.uniform(-3.0, 3.0)
        marks = _mark(near, point - pitch * angle * axes[:, 2], axes), _mark(far, point, axes @ rotation(Z, angle))
        return Closure(kind, pair, marks, pitch)
    if kind in ("pin", "cylindrical", "planar"):
        own = axes @ rotation(Z, rng.uniform(-3.0, 3.0))
    if kind == "universal":
        own = axes @ rotation(Z, rng.uniform(-3.0, 3.0)) @ rotation(np.array([1.0, 0.0, 0.0]), rng.uniform(-1.2, 1.2))
    if kind in ("ball", "on line", "on plane") and not planar:
        own = _tilt(rng, False)
    return Closure(kind, pair, (_mark(near, point - shift, axes), _mark(far, point, own)))


def well_posed(m: Mechanism) -> bool:
    """At least one degree of freedom, no redundant row, nothing nearly so."""
    loops = to_oracle(m)
    rank, redundant, condition = loops.rank
    return rank < 6 * len(m.parts) and not redundant and condition < CONDITION


@st.composite
def mechanisms(
    draw: st.DrawFn, planar: bool, loops: int, max_parts: int = 4, kinds: tuple[str, ...] | None = None
) -> Mechanism:
    """Mechanisms with so many closures, of these kinds where they leave a degree of freedom."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(min(loops + 1, max_parts), max_parts))
    made = [
        _part(rng, planar, draw(st.integers(-1, i - 1)), draw(st.sampled_from(_JOINTS[planar]))) for i in range(count)
    ]
    gravity = rng.uniform(-10.0, 10.0, 3) * ([1.0, 1.0, 0.0] if planar else 1.0)
    m = Mechanism(tuple(p for p, _ in made), (), gravity, tuple(q for _, q in made))
    places = frames(m)
    for _ in range(loops):
        far = draw(st.integers(0, count - 1))
        near = draw(st.integers(-1, count - 2))
        near += near >= far
        tried = (draw(st.sampled_from(_CLOSURES[planar] if kinds is None else kinds)), *_WEAKER[planar])
        for kind in tried:
            pair = (GROUND if kind in CONTACTS else near, far)
            trial = replace(m, closures=(*m.closures, _closure(rng, planar, kind, pair, places)))
            if well_posed(trial):
                m = trial
                break
        else:
            assume(False)
    return m


@st.composite
def questions(draw: st.DrawFn, parts: int) -> Asked:
    """What is asked of a mechanism with so many parts."""
    cuts = draw(st.lists(st.integers(0, parts - 1), max_size=2, unique=True))
    return Asked(draw(st.sampled_from(SPEEDS)), tuple(cuts), draw(st.booleans()), draw(st.integers(0, 9)))
