# SPDX-License-Identifier: BSD-3-Clause
"""Frames along which velocities are made of the speeds as they were defined: the search by speeds alone, for all motions by them.

A measure number can only be a sum of whole rows of Y if its coefficients in the speeds are 0, 1 and −1 at a configuration drawn at
random: numbers rule out, before any symbolic work, where matching cannot succeed.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from kane.expr.node import ZERO, Expr, constant_value
from kane.expr.ops import CONST, PI, SYMBOL
from kane.expr.visit import fold, substituted
from kane.kinematics.speeds import ScalarForm, Speeds
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEED, draw
from kane.numeric.scale import SIX_DIGITS
from kane.space.point import Point
from kane.space.rotation import Basis, Triple
from kane.space.vector import Parts, Vector, angular_velocity, axes
from kane.tree.triples import is_zero


@dataclass(frozen=True, eq=False)
class Sample:
    """Random values of a system's symbols, made when first needed; rates run through their unit vectors and zero.

    `values` are those of every expression that was met, `turns` direction cosines, `rooted` measure numbers along the root's axes.
    """

    speeds: Speeds
    seed: int = SEED
    values: dict[Expr, Any] = field(default_factory=dict)
    turns: dict[Basis, Array] = field(default_factory=dict)
    rooted: dict[Parts, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.values.update({s: np.float64(v) for s, v in self.values.items() if isinstance(v, float | int)})
        self.values.update(
            zip(self.speeds.rates, np.eye(len(self.speeds.rates), len(self.speeds.rates) + 1), strict=True)
        )
        for group in self.speeds.system.euler_parameters:
            e = np.array([draw(self.seed, s, -1.0, 1.0) for s in group.coordinates])
            self.values.update(zip(group.coordinates, e / np.linalg.norm(e), strict=True))

    def by(self, speeds: Speeds) -> "Sample":
        """The same numbers for other speeds of the same rates."""
        if speeds.rates not in {self.speeds.rates}:
            return Sample(speeds, self.seed)
        return Sample(speeds, self.seed, self.values, self.turns, self.rooted)

    def numbers(self, exprs: Iterable[Expr]) -> list[Any]:
        """Values of expressions, each with one entry a basic rate and one for all rates at rest, or a scalar."""
        with np.errstate(all="ignore"):
            return [fold(e, self.values, self._value) for e in exprs]

    def _value(self, node: Expr) -> Any:
        if node.op is SYMBOL:
            e = self.speeds.euler_rates.get(node)
            return np.float64(draw(self.seed, node)) if e is None else fold(e, self.values, self._value)
        if node.op is CONST:
            return np.float64(constant_value(node) or 0)
        if node.op is PI:
            return np.float64(math.pi)
        return node.op.numpy(*[self.values[a] for a in node.args])

    def turn(self, frame: Basis) -> Array:
        """Direction cosines of the frame in the root."""
        if frame not in self.turns:
            o = frame.orientation
            if o is None:
                self.turns[frame] = np.eye(3)
            else:
                columns = [self.numbers(axis.components(o.base)) for axis in axes(frame)]
                self.turns[frame] = self.turn(o.base) @ np.array(columns, dtype=float).T
        return self.turns[frame]

    @cached_property
    def inverse(self) -> Array:
        """W: the rates (rates × speeds) of one speed at a time."""
        rates = self.speeds.rates
        numbers = [dict(zip(row, self.numbers(row.values()), strict=True)) for row in self.speeds.rows]
        y = np.array([[row.get(b, 0.0) for b in rates] for row in numbers], dtype=float).reshape(-1, len(rates))
        return np.asarray(np.linalg.pinv(y) if np.isfinite(y).all() else np.full(y.T.shape, np.nan))

    def at_speeds(self, e: Expr) -> float:
        """The value of an expression affine in the rates, these by speeds drawn at random: q̇ = W u + X."""
        known = self.speeds
        numbers = np.broadcast_to(self.numbers([e])[0], (len(known.rates) + 1,))
        u, x = self.numbers(known.speeds), self.numbers(known.x[b] for b in known.rates)
        q_dot = self.inverse @ np.array(u) + np.array(x)
        return float((numbers[:-1] - numbers[-1]) @ q_dot + numbers[-1])

    def coefficients(self, v: Vector) -> Array:
        """What multiplies each speed in the three measure numbers of `v` along the root's axes."""
        total = self.in_root(v)
        return np.asarray((total[:, :-1] - total[:, -1:]) @ self.inverse)

    def in_root(self, v: Vector) -> Array:
        """The three measure numbers of `v` along the root's axes, for each basic rate and for all at rest."""
        if v.parts not in self.rooted:
            width = len(self.speeds.rates) + 1
            total = np.zeros((3, width))
            for frame, triple in v.parts:
                parts = [np.broadcast_to(x, (width,)) for x in self.numbers(triple)]
                total = total + self.turn(frame) @ np.array(parts)
            self.rooted[v.parts] = total
        return self.rooted[v.parts]

    def whole(self, coefficients: Array, frames: Sequence[Basis]) -> list[tuple[int, bool]]:
        """How many measure numbers along each of `frames` may be sums of whole rows, and whether all that are not absent may.

        Where the numbers are not finite nothing is ruled out.
        """
        along = np.array([self.turn(f).T for f in frames]).reshape(-1, 3, 3) @ coefficients
        finite = np.asarray(np.isfinite(along).all(axis=(1, 2)))
        with np.errstate(invalid="ignore"):
            near = np.abs(along - np.clip(np.round(along), -1, 1)).max(axis=2, initial=0) < SIX_DIGITS
            present = np.abs(along).max(axis=2, initial=0) > SIX_DIGITS
        counts, full = (near & present).sum(axis=1), np.asarray(near.all(axis=1) & present.any(axis=1))
        told = zip(counts, full, finite, strict=True)
        return [(int(count), bool(every)) if known else (3, True) for count, every, known in told]


Forms = tuple[ScalarForm, ScalarForm, ScalarForm]
Match = tuple[Basis, Forms]
"""The frame, and the measure numbers along it."""

_NO_FORM = ScalarForm({}, ZERO)


@dataclass(frozen=True, eq=False)
class Matching:
    """What is found for the frames and points of a system, once by its speeds; those that are `vanishing` are left out of it."""

    speeds: Speeds
    sample: Sample
    vanishing: frozenset[Expr] = frozenset()
    _known: dict[Basis | Point, Match | None] = field(default_factory=dict)

    def without(self, vanishing: frozenset[Expr]) -> "Matching":
        """The same, where these speeds vanish."""
        return replace(self, vanishing=vanishing)

    @cached_property
    def rates(self) -> Mapping[Expr, Expr]:
        """q̇ by coordinate, in speeds."""
        gone, memo = dict.fromkeys(self.vanishing, ZERO), dict[Expr, Expr]()
        rates = self.speeds.coordinate_rates()
        held = (substituted(x, gone, memo) for x in rates) if gone else rates
        return dict(zip(self.speeds.system.coordinates, held, strict=True))

    def forms(self, rates: Triple) -> Forms:
        """Three scalars affine in the rates, in speeds."""
        return self._held(self._forms(rates))

    def match(self, place: Basis | Point) -> Match | None:
        """The velocity of a point, or the angular velocity of a frame, along a frame in which it is made of rows of Y."""
        if place not in self._known:
            self._known[place] = self._translation(place) if isinstance(place, Point) else self._rotation(place)
        found = self._known[place]
        return found and (found[0], self._held(found[1]))

    def _held(self, forms: Forms) -> Forms:
        gone = self.vanishing
        if gone.isdisjoint(u for f in forms for u in f.coefficients):
            return forms
        a, b, c = (f._replace(coefficients={u: x for u, x in f.coefficients.items() if u not in gone}) for f in forms)
        return (a, b, c)

    def _forms(self, rates: Triple) -> Forms:
        if is_zero(rates):
            return (_NO_FORM, _NO_FORM, _NO_FORM)
        a, b, c = self.speeds.forms(rates)
        return (a, b, c)

    def _rotation(self, frame: Basis) -> Match | None:
        """ω along the frame, of this one and its bases, in which most measure numbers are rows of Y; None without any."""
        omega = angular_velocity(frame, self.speeds.system.inertial)
        best: tuple[int, Match] | None = None
        counts = self.sample.whole(self.sample.coefficients(omega), frame.lineage)
        for target, (count, _) in zip(frame.lineage, counts, strict=True):
            if count <= (best[0] if best is not None else 0):
                continue
            for forms in self._along(omega, target):
                score = sum(f.exact for f in forms)
                if score and (best is None or score > best[0]):
                    best = (score, (target, forms))
        return best and best[1]

    def _translation(self, point: Point) -> Match | None:
        """v along the first frame in which two measure numbers, or all that it has, are sums of rows of Y."""
        velocity = point.velocity(self.speeds.system.inertial)
        targets = dict.fromkeys(g for f, _ in velocity.parts for g in f.lineage)
        targets.update(dict.fromkeys(f for f in self.speeds.system.frames if f not in targets))
        whole = self.sample.whole(self.sample.coefficients(velocity), tuple(targets))
        for target in [g for g, (count, every) in zip(targets, whole, strict=True) if count >= 2 or every]:
            for forms in self._along(velocity, target):
                exact = sum(f.exact for f in forms)
                present = sum(bool(f.coefficients) for f in forms)
                if exact and (exact >= 2 or exact == present):
                    return target, forms
        return None

    def _along(self, v: Vector, frame: Basis) -> Iterator[Forms]:
        """The measure numbers of `v` along `frame`, in two ways where they differ."""
        found = list(measured(v, frame))
        return map(self._forms, found[: 1 + any(x is not y for x, y in zip(*found, strict=True))])


def measured(v: Vector, frame: Basis) -> Iterator[Triple]:
    """The measure numbers in the two ways in which a speed's definition may have come to them."""
    yield v.components(frame)
    x, y, z = map(v.dot, axes(frame))
    yield x, y, z
