# SPDX-License-Identifier: BSD-3-Clause
"""Generalized speeds (Kane & Levinson 1985, sec. 2.12): u = Y q̇ + z, its inverse q̇ = W u + X, and velocities matched to speeds.

A measure number whose row in the rates is a combination of rows of Y is written in those speeds directly, without W. An angular
velocity is thus written in the speeds defined by it even where W is singular.

Euler parameters enter by their three quasi-rates w, ė = ½ Gᵀ(e) w; the reported Y has the row eᵀė = 0 for each set.

`Matching` finds, for each frame and point, a frame along which the measure numbers of its velocity are sums of rows of Y. Such a
measure number has coefficients 0, 1 and −1 in the speeds at a random configuration, so that `Sample` rules out most frames
numerically, before any symbolic work.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial, reduce
from typing import Any, NamedTuple

import numpy as np

from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sub, sum_of
from kane.expr.differentiation import Affine, affine_forms, combined
from kane.expr.evaluation import price
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr, constant_value
from kane.expr.ops import DIV, MUL, NEG, PI, SYMBOL
from kane.expr.symbols import Coordinate, Speed, Symbols, rate
from kane.expr.visit import fold, substituted
from kane.model.system import System
from kane.numeric.arrays import Array, spread
from kane.numeric.sampling import SEED, draw
from kane.numeric.scale import SIX_DIGITS
from kane.space.frame import Point
from kane.space.rotation import Basis, Triple
from kane.space.vector import Parts, Vector, angular_velocity, axes

Row = Mapping[Expr, Expr]


class ScalarForm(NamedTuple):
    """Σ coefficient · speed + rest; `exact` if it is a sum of whole rows of Y, at least one of which is not a bare rate."""

    coefficients: dict[Expr, Expr]
    rest: Expr
    exact: bool = False

    def total(self) -> Expr:
        """The sum as an expression."""
        return sum_of([self.rest, *(mul(c, u) for u, c in self.coefficients.items())])


def is_rate(row: Row) -> bool:
    """Whether a row of Y is one bare rate."""
    return len(row) == 1 and next(iter(row.values())) is ONE


@dataclass(frozen=True, slots=True, eq=False)
class Speeds:
    """The kinematical equations of a system.

    `rates` are the basic rates b: q̇ of ordinary coordinates, quasi-rates of Euler parameters. `rows` and `z` are Y_b and z in
    u = Y_b b + z, `inverse` and `x` are W_b and X_b in b = W_b u + X_b, and `pivots` the divisors of W_b. `along` gives ė of Euler
    parameters in speeds without W. `groups` numbers the blocks of rates that share no row, and `by_row` finds speeds by ± row.
    """

    system: System
    speeds: Symbols[Speed]
    rates: tuple[Expr, ...]
    rows: tuple[dict[Expr, Expr], ...]
    z: tuple[Expr, ...]
    inverse: dict[Expr, dict[Expr, Expr]]
    x: dict[Expr, Expr]
    pivots: tuple[Expr, ...]
    euler_rates: dict[Expr, Expr]
    along: dict[Expr, Expr]
    groups: dict[Expr, int]
    by_row: dict[frozenset[tuple[Expr, Expr]], dict[int, Expr]]
    nontrivial: bool
    offsets: tuple[tuple[Speed, Expr], ...] = field(init=False)
    """The speeds with a nonzero z, and z."""
    _known: dict[Expr, Affine] = field(default_factory=dict)

    def __post_init__(self) -> None:
        own = tuple((u, z) for u, z in zip(self.speeds, self.z, strict=True) if z is not ZERO)
        object.__setattr__(self, "offsets", own)

    # Matching -------------------------------------------------------------------------------------------------------

    def form(self, row: Row, rest: Expr = ZERO) -> ScalarForm:
        """Σ row·b + rest in speeds."""
        coefficients: dict[Expr, Expr] = {}
        exact = self.nontrivial and bool(row)
        used = False
        for part in self._by_group(row):
            shares = self.by_row.get(frozenset(part.items()))
            if shares is not None:
                used = used or not all(is_rate(self.rows[i]) for i in shares)
            else:
                shares = self._peeled(part)
                used, exact = used or shares is not None, exact and shares is not None
                shares = shares or self._proportional(part)
            gained: list[tuple[Expr, Expr]]
            if shares is not None:
                gained = [(self.speeds[i], c) for i, c in shares.items()]
            else:
                gained = [(u, mul(c, w)) for b, c in part.items() for u, w in self.inverse[b].items()]
            for u, c in gained:
                coefficients[u] = add(coefficients.get(u, ZERO), c)
        kept = {u: c for u, c in coefficients.items() if c is not ZERO}
        for u, z in self.offsets:
            if u in kept:
                rest = sub(rest, mul(kept[u], z))
        return ScalarForm(kept, rest, exact and used)

    def _by_group(self, row: Row) -> Iterable[dict[Expr, Expr]]:
        if len(row) < 2:
            return (dict(row),) if row else ()
        parts: dict[int, dict[Expr, Expr]] = {}
        for b, c in row.items():
            parts.setdefault(self.groups[b], {})[b] = c
        return parts.values()

    def _peeled(self, part: dict[Expr, Expr]) -> dict[int, Expr] | None:
        """The signs, by row number, with which rows of Y sum to `part`, found by subtracting equal rows; None if a rest is left."""
        left, whole = dict(part), {}
        for i, row in enumerate(self.rows):
            if not left or not row.keys() <= left.keys():
                continue
            if all(left[b] is c for b, c in row.items()):
                whole[i] = ONE
            elif all(left[b] is neg(c) for b, c in row.items()):
                whole[i] = neg(ONE)
            else:
                continue
            for b in row:
                del left[b]
        return None if left else whole

    def _proportional(self, part: dict[Expr, Expr]) -> dict[int, Expr] | None:
        """The number of a row of Y proportional to `part`, with the factor; None if there is none."""
        for i, row in enumerate(self.rows):
            if row.keys() != part.keys():
                continue
            first = next(iter(part))
            factor = div(part[first], row[first])
            if all(mul(factor, row[b]) is c for b, c in part.items()):
                return {i: factor}
        return None

    # Expressions ----------------------------------------------------------------------------------------------------

    def forms(self, exprs: Iterable[Expr]) -> list[ScalarForm]:
        """Expressions affine in rates, as forms in speeds."""
        return [self.form(c, r) for c, r in self.in_rates(exprs)]

    def in_rates(self, exprs: Iterable[Expr]) -> list[Affine]:
        """Expressions affine in rates, as affine forms in the basic rates."""
        return affine_forms([self._basic(e) for e in exprs], self.rates, self._known)

    def _basic(self, e: Expr) -> Expr:
        return substituted(e, self.euler_rates) if self.euler_rates else e

    def in_speeds(self, root: Expr, memo: dict[Expr, Affine]) -> Expr:
        """`root` with every rate expressed in speeds; subexpressions affine in rates are matched as a whole.

        `memo` may be shared between calls.
        """
        rates = set(self.rates)

        def combine(node: Expr) -> Affine:
            if node in rates:
                return {node: ONE}, ZERO
            parts = [memo[a] for a in node.args]
            return combined(node, parts) or ({}, NODE_BUILDERS[node.op.name](*[self._finished(p) for p in parts]))

        basic = self._basic(root)
        whole = self._finished(fold(basic, memo, combine))
        factors, left = _rate_free(basic, memo)
        if left is basic or len(memo[left][0]) < 2:
            return whole
        apart = reduce(lambda e, f: f(e), reversed(factors), self._finished(memo[left]))
        return min(whole, apart, key=lambda e: price([e]))

    def _finished(self, part: Affine) -> Expr:
        return self.form(*part).total() if part[0] else part[1]

    # Reports --------------------------------------------------------------------------------------------------------

    def coordinate_rates(self) -> tuple[Expr, ...]:
        """q̇ = W u + X, written out, in the order of the coordinates."""
        totals = {b: ScalarForm(self.inverse[b], self.x[b]).total() for b in self.rates}
        return tuple(
            self.along[r] if r in self.along else substituted(self._basic(r), totals)
            for r in map(rate, self.system.coordinates)
        )

    def matrices(self) -> tuple[Matrix, tuple[Expr, ...], Matrix, tuple[Expr, ...]]:
        """Y, z, W, X in the rates of the coordinates; Y has the row eᵀė = 0 for each set of Euler parameters."""
        q, sets = self.system.coordinates, self.system.euler_parameters
        shares: dict[Expr, dict[Coordinate, Expr]] = {rate(x): {x: ONE} for x in q}
        for s in sets:
            rows = zip(s.quasi, twice_g(s.coordinates), strict=True)
            shares.update((w, dict(zip(s.coordinates, row, strict=True))) for w, row in rows)
        y_rows: list[list[Expr]] = []
        for row in self.rows:
            line = dict.fromkeys(q, ZERO)
            for b, c in row.items():
                for x, g in shares[b].items():
                    line[x] = add(line[x], mul(c, g))
            y_rows.append([line[x] for x in q])
        of_set = [[x if x in set(s.coordinates) else ZERO for x in q] for s in sets]
        z = (*self.z, *(ZERO for _ in sets))
        w_rows: list[list[Expr]] = []
        x_column: list[Expr] = []
        for k, (own, _) in enumerate(affine_forms([self._basic(rate(x)) for x in q], self.rates)):
            by_speed: dict[Expr, Expr] = {}
            rest = ZERO
            for b, c in own.items():
                rest = add(rest, mul(c, self.x[b]))
                for u, w in self.inverse[b].items():
                    by_speed[u] = add(by_speed.get(u, ZERO), mul(c, w))
            w_rows.append([by_speed.get(u, ZERO) for u in self.speeds] + [e[k] for e in of_set])
            x_column.append(rest)
        return Matrix([*y_rows, *of_set]), z, Matrix(w_rows), tuple(x_column)


def _rate_free(e: Expr, forms: Mapping[Expr, Affine]) -> tuple[list[Callable[[Expr], Expr]], Expr]:
    """Splits off factors and divisors without rates: the operations that apply them, outermost first, and the remaining expression."""
    found: list[Callable[[Expr], Expr]] = []
    while True:
        if e.op is NEG:
            found.append(neg)
            (e,) = e.args
        elif e.op is DIV and not forms[e.args[1]][0]:
            found.append(partial(_over, forms[e.args[1]][1]))
            e = e.args[0]
        elif e.op is MUL and sum(not forms[a][0] for a in e.args) == 1:
            factor, e = e.args if not forms[e.args[0]][0] else e.args[::-1]
            found.append(partial(mul, forms[factor][1]))
        else:
            return found, e


def _over(divisor: Expr, e: Expr) -> Expr:
    return div(e, divisor)


def twice_g(e: tuple[Coordinate, ...]) -> list[list[Expr]]:
    """2 G with w = 2 G ė for unit Euler parameters."""
    e0, e1, e2, e3 = e
    rows = ((-e1, e0, e3, -e2), (-e2, -e3, e0, e1), (-e3, e2, -e1, e0))
    return [[2 * x for x in row] for row in rows]


@dataclass(frozen=True, eq=False)
class Sample:
    """Random values of a system's symbols, drawn at first use. Rates take n + 1 values: each basic rate at 1 alone, then all at 0.

    `values` caches values of expressions, `turns` direction cosines, `rooted` measure numbers along the inertial frame.
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
        """A sample with the same numbers for other speeds; a new one if these have other rates."""
        if speeds.rates not in {self.speeds.rates}:
            return Sample(speeds, self.seed)
        return Sample(speeds, self.seed, self.values, self.turns, self.rooted)

    def numbers(self, exprs: Iterable[Expr]) -> list[Any]:
        """The values of expressions, each of shape (rates + 1,), or a scalar if it has no rates."""
        with np.errstate(all="ignore"):
            return [fold(e, self.values, self._value) for e in exprs]

    def _value(self, node: Expr) -> Any:
        if node.args:
            return node.op.numpy(*[self.values[a] for a in node.args])
        if node.op is SYMBOL:
            e = self.speeds.euler_rates.get(node)
            return np.float64(draw(self.seed, node)) if e is None else fold(e, self.values, self._value)
        return np.float64(math.pi) if node.op is PI else np.float64(constant_value(node) or 0)

    def turn(self, frame: Basis) -> Array:
        """The direction cosines (3, 3) of a frame in the inertial frame."""
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
        """W (rates × speeds) as the pseudoinverse of Y; NaN if Y is not finite."""
        rates = self.speeds.rates
        numbers = [dict(zip(row, self.numbers(row.values()), strict=True)) for row in self.speeds.rows]
        y = np.array([[row.get(b, 0.0) for b in rates] for row in numbers], dtype=float).reshape(-1, len(rates))
        return np.asarray(np.linalg.pinv(y) if np.isfinite(y).all() else np.full(y.T.shape, np.nan))

    def at_speeds(self, e: Expr) -> float:
        """The value of an expression affine in the rates at random speeds, q̇ = W u + X."""
        known = self.speeds
        numbers = np.broadcast_to(self.numbers([e])[0], (len(known.rates) + 1,))
        u, x = self.numbers(known.speeds), self.numbers(known.x[b] for b in known.rates)
        q_dot = self.inverse @ np.array(u) + np.array(x)
        return float((numbers[:-1] - numbers[-1]) @ q_dot + numbers[-1])

    def coefficients(self, v: Vector) -> Array:
        """The coefficients (3 × speeds) of the speeds in `v`, along the axes of the inertial frame."""
        if v.parts not in self.rooted:  # the measure numbers (3 × (rates + 1)) along those axes
            width = len(self.speeds.rates) + 1
            total = np.zeros((3, width))
            for frame, triple in v.parts:
                total = total + self.turn(frame) @ spread(self.numbers(triple), (width,))
            self.rooted[v.parts] = total
        total = self.rooted[v.parts]
        return np.asarray((total[:, :-1] - total[:, -1:]) @ self.inverse)

    def whole(self, coefficients: Array, frames: Sequence[Basis]) -> list[tuple[int, bool]]:
        """For each of `frames`, how many measure numbers along it may be sums of rows of Y, and whether all nonzero ones may.

        (3, True) where the numbers are not finite.
        """
        along = np.array([self.turn(f).T for f in frames]).reshape(-1, 3, 3) @ coefficients
        finite = np.asarray(np.isfinite(along).all(axis=(1, 2)))
        with np.errstate(invalid="ignore"):
            whole = np.minimum(np.maximum(np.rint(along), -1.0), 1.0)
            near = np.abs(along - whole).max(axis=2, initial=0) < SIX_DIGITS
            present = np.abs(along).max(axis=2, initial=0) > SIX_DIGITS
        counts, full = (near & present).sum(axis=1), np.asarray(near.all(axis=1) & present.any(axis=1))
        flags = zip(counts, full, finite, strict=True)
        return [(int(count), bool(every)) if known else (3, True) for count, every, known in flags]


Forms = Sequence[ScalarForm]
"""The forms of three measure numbers."""
Match = tuple[Basis, Forms]
"""The frame, and the measure numbers along it."""


@dataclass(frozen=True, eq=False)
class Matching:
    """Matches of velocities to speeds, found once per frame and point of a system; speeds in `vanishing` are set to zero in them."""

    speeds: Speeds
    sample: Sample
    vanishing: frozenset[Expr] = frozenset()
    _known: dict[Basis | Point, Match | None] = field(default_factory=dict)

    def without(self, vanishing: frozenset[Expr]) -> "Matching":
        """The same matches with other vanishing speeds."""
        return replace(self, vanishing=vanishing)

    @cached_property
    def rates(self) -> Mapping[Expr, Expr]:
        """q̇ by coordinate, in speeds."""
        gone, memo = dict.fromkeys(self.vanishing, ZERO), dict[Expr, Expr]()
        rates = self.speeds.coordinate_rates()
        values = (substituted(x, gone, memo) for x in rates) if gone else rates
        return dict(zip(self.speeds.system.coordinates, values, strict=True))

    def forms(self, rates: Triple) -> Forms:
        """The forms of three scalars affine in the rates."""
        return self._remaining(self.speeds.forms(rates))

    def match(self, place: Basis | Point) -> Match | None:
        """The velocity of a point, or ω of a frame, along a frame where its measure numbers are rows of Y; None if there is none."""
        if place not in self._known:
            self._known[place] = self._translation(place) if isinstance(place, Point) else self._rotation(place)
        found = self._known[place]
        return found and (found[0], self._remaining(found[1]))

    def _remaining(self, forms: Forms) -> Forms:
        gone = self.vanishing
        if gone.isdisjoint(u for f in forms for u in f.coefficients):
            return forms
        return [f._replace(coefficients={u: x for u, x in f.coefficients.items() if u not in gone}) for f in forms]

    def _rotation(self, frame: Basis) -> Match | None:
        """ω along the frame or ancestor in which most measure numbers are sums of rows of Y; None if there are none."""
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
                if score >= count:
                    break
        return best and best[1]

    def _translation(self, point: Point) -> Match | None:
        """v along the first frame in which two measure numbers, or all nonzero ones, are sums of rows of Y; None if there is none."""
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
        """The forms of the measure numbers of `v` along `frame`, in one or two notations (`measured`), made when asked for."""
        ways = measured(v, frame)
        first = next(ways)
        yield self.speeds.forms(first)
        for second in ways:
            if any(x is not y for x, y in zip(first, second, strict=True)):
                yield self.speeds.forms(second)


def measured(v: Vector, frame: Basis) -> Iterator[Triple]:
    """The measure numbers of `v` in the two notations that a definition may have: by change of basis, and by scalar products."""
    yield v.components(frame)
    x, y, z = map(v.dot, axes(frame))
    yield x, y, z
