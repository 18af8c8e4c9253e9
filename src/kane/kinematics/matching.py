# SPDX-License-Identifier: BSD-3-Clause
"""Frames along which velocities are made of the speeds as they were defined: the search by speeds alone, for all motions by them."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

from kane.expr.node import ZERO, Expr
from kane.expr.visit import substituted
from kane.kinematics.sample import Sample
from kane.kinematics.speeds import ScalarForm, Speeds
from kane.space.point import Point
from kane.space.rotation import Basis, Triple
from kane.space.vector import Vector, angular_velocity, axes

Forms = tuple[ScalarForm, ScalarForm, ScalarForm]
Match = tuple[Basis, Forms]
"""The frame, and the measure numbers along it."""
Place = TypeVar("Place", Basis, Point)

_NO_FORM = ScalarForm({}, ZERO)


@dataclass(frozen=True, eq=False)
class Matching:
    """What is found for the frames and points of a system, once by its speeds; those that are `vanishing` are left out of it."""

    speeds: Speeds
    sample: Sample
    vanishing: frozenset[Expr] = frozenset()
    _rotations: dict[Basis, Match | None] = field(default_factory=dict)
    _translations: dict[Point, Match | None] = field(default_factory=dict)

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

    def rotation(self, frame: Basis) -> Match | None:
        """ω along the frame, of this one and its bases, in which most measure numbers are rows of Y; None without any."""
        return self._present(_once(self._rotations, frame, self._rotation))

    def translation(self, point: Point) -> Match | None:
        """v along the first frame in which two measure numbers, or all that it has, are sums of rows of Y."""
        return self._present(_once(self._translations, point, self._translation))

    def _present(self, found: Match | None) -> Match | None:
        return found and (found[0], self._held(found[1]))

    def _held(self, forms: Forms) -> Forms:
        gone = self.vanishing
        if gone.isdisjoint(u for f in forms for u in f.coefficients):
            return forms
        a, b, c = (f._replace(coefficients={u: x for u, x in f.coefficients.items() if u not in gone}) for f in forms)
        return (a, b, c)

    def _forms(self, rates: Triple) -> Forms:
        if all(x is ZERO for x in rates):
            return (_NO_FORM, _NO_FORM, _NO_FORM)
        a, b, c = self.speeds.forms(rates)
        return (a, b, c)

    def _rotation(self, frame: Basis) -> Match | None:
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
        """The measure numbers of `v` along `frame` in the two ways in which a speed's definition may have come to them."""
        components = v.components(frame)
        yield self._forms(components)
        x, y, z = axes(frame)
        products = (v.dot(x), v.dot(y), v.dot(z))
        if any(x is not y for x, y in zip(components, products, strict=True)):
            yield self._forms(products)


def _once(known: dict[Place, Match | None], place: Place, find: Callable[[Place], Match | None]) -> Match | None:
    if place not in known:
        known[place] = find(place)
    return known[place]
