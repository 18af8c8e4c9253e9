# SPDX-License-Identifier: BSD-3-Clause
"""The drawing surface of a sketch: strokes by layer, in pixels, and the labels to be placed."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from kane.numeric.arrays import Array
from kane.present.scene.records import Item, Posed
from kane.present.sketch.camera import View
from kane.present.sketch.labels import Label, Span

GROUND, BODY, LOAD, REFERENCE, MOVE, FORCE, AXES, POINT = range(8)
"""Layers, the lowest first."""
BLOCK = (22.0, 13.0)
"""Half the width and height of a block, in pixels."""
_STEP = 3.0
"""Spacing, in pixels, of the points of lines that labels avoid."""


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A line or a face in a style `look`; `order` is its layer and depth, far ones first; `head` is the length of an arrowhead."""

    points: Array
    look: str
    order: tuple[float, float]
    closed: bool = False
    head: float = 0.0
    weight: float = 1.0
    holes: tuple[Array, ...] = ()


@dataclass(slots=True, eq=False)
class Paper:
    """The projection of the scene to pixels, and the strokes and labels drawn so far."""

    view: View
    width: float
    height: float
    scale: float
    shift: Array
    strokes: list[Stroke] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    rings: list[tuple[Array, int]] = field(default_factory=list)
    solids: dict[str, Array] = field(default_factory=dict)
    links: dict[str, Array] = field(default_factory=dict)
    lifts: dict[str, Array] = field(default_factory=dict)
    sides: dict[str, float] = field(default_factory=dict)
    held: set[int] = field(default_factory=set)
    blocks: set[int] = field(default_factory=set)
    most: float = np.inf

    @property
    def small(self) -> bool:
        """Whether the width is that of a phone."""
        return self.width < 480

    @property
    def unit(self) -> float:
        """Pixels per unit of arrows and letters: 1 on a desktop screen."""
        return 0.8 if self.small else 1.0

    def at(self, places: Array) -> Array:
        """Places (… × 3) in pixels."""
        return self.view.flat(places) * (self.scale, -self.scale) + self.shift

    def pixel_direction(self, direction: Array) -> Array:
        """The projection of a unit vector along a direction."""
        size = float(np.linalg.norm(direction))
        flat = self.view.flat(direction / size if size > 0 else direction)
        return np.asarray(flat * (1.0, -1.0))

    def depth(self, places: Array) -> float:
        """The mean nearness of places to the eye."""
        return float(np.mean(np.atleast_2d(places) @ self.view.toward))

    def draw(
        self, points: Array | list[Array], look: str, layer: float, depth: float = 0.0, *, closed: bool = False,
        head: float = 0.0, weight: float = 1.0, holes: tuple[Array, ...] = (),
    ) -> None:  # fmt: skip
        """Add a line or face."""
        line = np.asarray(points, dtype=float)
        self.strokes.append(Stroke(line, look, (layer, depth), closed, head, weight, holes))

    def label(
        self, runs: tuple[Span, ...], at: Array, toward: Array, look: str, *, size: float = 15.0,
        symbols: Iterable[str] = (), needed: bool = False, clearance: float = 0.0,
    ) -> None:  # fmt: skip
        """Add a label to be placed."""
        anchor, way = (float(at[0]), float(at[1])), (float(toward[0]), float(toward[1]))
        scaled = size * (0.9 if self.small else 1.0)
        self.labels.append(Label(runs, anchor, way, scaled, look, tuple(symbols), needed, clearance))

    def ring(self, at: Array) -> int:
        """The number of arcs already drawn about a place; it increases by one."""
        for k, (p, n) in enumerate(self.rings):
            if np.hypot(*(p - at)) < 6:
                self.rings[k] = (p, n + 1)
                return n
        self.rings.append((at, 1))
        return 0

    def obstacles(self) -> tuple[Array, Array]:
        """Points of all lines, and of the borders of faces, with the cost of labels on them."""
        points, weights = [np.zeros((0, 2))], [np.zeros(0)]
        for s in self.strokes:
            line = np.concatenate([s.points, s.points[:1]]) if s.closed else s.points
            dense = spaced(line, _STEP)
            points.append(dense)
            weights.append(np.full(len(dense), s.weight))
        return np.concatenate(points), np.concatenate(weights)


def spaced(line: Array, step: float) -> Array:
    """Points along a line, spaced by about `step`."""
    pieces = [line[:1]]
    for a, b in pairwise(line):
        n = max(1, min(400, int(np.hypot(*(b - a)) / step)))
        pieces.append(a + (b - a) * (np.arange(1, n + 1) / n)[:, None])
    return np.concatenate(pieces)


def ring(at: Array, radius: float, sides: int) -> Array:
    """Points of a circle, in pixels."""
    turn = np.linspace(0, 2 * np.pi, sides + 1)[:-1]
    return np.asarray(at + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1))


def rod_ends(item: Item, posed: Posed) -> Array:
    """The ends of a rod (2 × 3); none for other items."""
    if item.kind != "rod" or item.at is None or item.frame is None:
        return np.zeros((0, 3))
    half = posed.rotations[item.frame][:, 2] * float(posed.scalars[item.sizes["length"]]) / 2
    return np.array([posed.positions[item.at] - half, posed.positions[item.at] + half])


def across(way: Array) -> Array:
    """A direction rotated by a quarter turn."""
    return np.array([-way[1], way[0]])
