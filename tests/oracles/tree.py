# SPDX-License-Identifier: BSD-3-Clause
"""A neutral description of a multibody tree, and random ones.

Every frame is given by its rotation matrix R with ``v_parent = R v_child``. A joint starts at ``offset`` in
the parent's frame, turned by ``tilt``; its steps follow one another, each in the frame the ones before it
left. The body's origin and frame are where the last step ends. Coordinates are numbered body by body, step by
step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triple = tuple[float, float, float]
Square = tuple[Triple, Triple, Triple]


@dataclass(frozen=True, slots=True)
class Step:
    """One degree of freedom: slide along, or turn about, a unit axis fixed in the current frame."""

    kind: Literal["slide", "turn"]
    axis: Triple


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid body and the joint that carries it; -1 as parent is the inertial frame.

    ``center`` and ``load_point`` (from the body's origin) and ``inertia`` (about the mass centre) are in
    the body's frame, ``force`` (at ``load_point``) and ``torque`` in the inertial frame.
    """

    parent: int
    offset: Triple
    tilt: Square
    steps: tuple[Step, ...]
    mass: float
    center: Triple
    inertia: Square
    load_point: Triple = (0.0, 0.0, 0.0)
    force: Triple | None = None
    torque: Triple | None = None


@dataclass(frozen=True, slots=True)
class Tree:
    """Bodies, parents before children, and the acceleration of gravity."""

    bodies: tuple[Body, ...]
    gravity: Triple

    @property
    def size(self) -> int:
        """Number of degrees of freedom."""
        return sum(len(body.steps) for body in self.bodies)


def skew(v: Array | Triple) -> Array:
    """Matrix of the cross product: ``skew(v) @ w = v x w``."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def rotation(axis: Array | Triple, angle: float) -> Array:
    """Rodrigues' formula for a turn about a unit axis."""
    k = skew(axis)
    return np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k


def triple(v: Array) -> Triple:
    return (float(v[0]), float(v[1]), float(v[2]))


def square(m: Array) -> Square:
    return (triple(m[0]), triple(m[1]), triple(m[2]))


def normalized(v: Array) -> Triple:
    return triple(v / np.linalg.norm(v))


def six_points(mass: float, arms: Array, turn: Array) -> Square:
    """Inertia of six equal particles, a pair at +-arm on each of three turned orthogonal axes."""
    points = np.concatenate([turn.T * arms[:, None], -turn.T * arms[:, None]])
    return square(mass / 6.0 * (np.sum(points**2) * np.eye(3) - points.T @ points))


def independence(steps: tuple[Step, ...], q: Array) -> float:
    """Smallest singular value of the joint's free directions; 0 where two steps do the same."""
    turn, point = np.eye(3), np.zeros(3)
    twists = []
    for step, value in zip(steps, q, strict=True):
        axis = turn @ step.axis
        if step.kind == "slide":
            twists.append(np.concatenate([np.zeros(3), axis]))
            point = point + value * axis
        else:
            twists.append(np.concatenate([axis, np.cross(point, axis)]))
            turn = turn @ rotation(step.axis, value)
    return float(np.linalg.svd(np.array(twists), compute_uv=False)[-1])


def random_tree(rng: np.random.Generator, bodies: int) -> Tree:
    """A tree of generic numbers, all of order one."""

    def direction() -> Triple:
        return normalized(rng.normal(size=3))

    def vector(size: float) -> Triple:
        return triple(rng.uniform(-size, size, 3))

    def body(index: int) -> Body:
        mass = float(rng.uniform(0.5, 2.0))
        steps = (Step("turn" if rng.random() < 0.6 else "slide", direction()) for _ in range(rng.integers(1, 4)))
        return Body(
            parent=int(rng.integers(-1, index)),
            offset=vector(1.0),
            tilt=square(rotation(direction(), rng.uniform(-3.0, 3.0))),
            steps=tuple(steps),
            mass=mass,
            center=vector(0.5),
            inertia=six_points(mass, rng.uniform(0.2, 0.6, 3), rotation(direction(), rng.uniform(-3.0, 3.0))),
            load_point=vector(0.5),
            force=vector(3.0) if rng.random() < 0.5 else None,
            torque=vector(3.0) if rng.random() < 0.5 else None,
        )

    return Tree(tuple(body(i) for i in range(bodies)), vector(10.0))


def random_states(rng: np.random.Generator, tree: Tree, count: int) -> tuple[Array, Array]:
    """Coordinates and rates, each of shape (degrees of freedom, count)."""
    return rng.uniform(-1.5, 1.5, (tree.size, count)), rng.uniform(-2.0, 2.0, (tree.size, count))


def _tenths(low: int, high: int) -> st.SearchStrategy[float]:
    return st.integers(low, high).map(lambda i: i / 10.0)


def _vectors(high: int) -> st.SearchStrategy[Triple]:
    return st.tuples(*[_tenths(-high, high)] * 3)


_directions = st.tuples(*[st.integers(-4, 4)] * 3).filter(any).map(lambda v: normalized(np.array(v, dtype=float)))
_turns = st.builds(rotation, _directions, _tenths(-30, 30))
_steps = st.builds(Step, st.sampled_from(("turn", "slide")), _directions)


@st.composite
def _bodies_in_motion(draw: st.DrawFn, index: int, count: int) -> tuple[Body, Array, Array]:
    mass = draw(_tenths(5, 20))
    arms = np.array(draw(st.tuples(*[_tenths(2, 6)] * 3)))
    body = Body(
        parent=draw(st.integers(-1, index - 1)),
        offset=draw(_vectors(10)),
        tilt=square(draw(_turns)),
        steps=tuple(draw(st.lists(_steps, min_size=1, max_size=3))),
        mass=mass,
        center=draw(_vectors(5)),
        inertia=six_points(mass, arms, draw(_turns)),
        load_point=draw(_vectors(5)),
        force=draw(st.none() | _vectors(30)),
        torque=draw(st.none() | _vectors(30)),
    )
    many = len(body.steps) * count
    numbers = st.lists(_tenths(-15, 15), min_size=many, max_size=many)
    q, qdot = (np.array(draw(numbers)).reshape(-1, count) for _ in range(2))
    return body, q, qdot


def _well_posed(motion: tuple[Body, Array, Array]) -> bool:
    body, q, _ = motion
    return min(independence(body.steps, column) for column in q.T) > 0.05


@st.composite
def trees_in_motion(draw: st.DrawFn, max_bodies: int = 6, count: int = 3) -> tuple[Tree, Array, Array]:
    """A tree of round numbers with coordinates and rates, each of shape (degrees of freedom, count).

    Zeros, basis axes and parallel axes come up, as do general ones, but no joint whose steps are redundant.
    """
    bodies = draw(st.integers(1, max_bodies))
    parts = [draw(_bodies_in_motion(i, count).filter(_well_posed)) for i in range(bodies)]
    tree = Tree(tuple(body for body, _, _ in parts), draw(_vectors(100)))
    return tree, np.concatenate([q for _, q, _ in parts]), np.concatenate([qdot for _, _, qdot in parts])


def trees(max_bodies: int = 6) -> st.SearchStrategy[Tree]:
    """The trees of `trees_in_motion` alone."""
    return trees_in_motion(max_bodies, 1).map(lambda motion: motion[0])
