# SPDX-License-Identifier: BSD-3-Clause
"""Generalized speeds: u = Y q̇ + z, its inverse q̇ = W u + X, and the recovery of speeds by matching.

A measure number whose row in the rates is a combination of rows of Y becomes those speeds by matching, before W is used: so
an angular velocity is written in its own speeds even where W is singular.

Euler parameters enter by their three quasi-rates w, ė = ½ Gᵀ(e) w; the reported Y has the row eᵀė = 0 for each set.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial, reduce
from typing import NamedTuple

from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sub
from kane.expr.differentiation import Affine, affine_forms, combined
from kane.expr.forms.count import price
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.ops import DIV, MUL, NEG
from kane.expr.symbols import Coordinate, Speed, Symbols, rate
from kane.expr.visit import fold, substituted
from kane.model.system import System

Row = Mapping[Expr, Expr]


class ScalarForm(NamedTuple):
    """Σ coefficient · speed + rest; `exact` where every coefficient came from a matched row of Y that is not a bare rate."""

    coefficients: dict[Expr, Expr]
    rest: Expr
    exact: bool = False

    def total(self) -> Expr:
        """The value."""
        value = self.rest
        for u, c in self.coefficients.items():
            value = add(value, mul(c, u))
        return value


def is_rate(row: Row) -> bool:
    """Whether a row of Y is one bare rate."""
    return len(row) == 1 and next(iter(row.values())) is ONE


@dataclass(frozen=True, slots=True, eq=False)
class Speeds:
    """The kinematical equations of a system.

    `rates` are the basic rates b: q̇ of ordinary coordinates, quasi-rates of Euler parameters. `rows` and `z` give
    u = Y_b b + z, `inverse` and `x` give b = W_b u + X_b, `pivots` are what W_b divides by. `along` gives rates of Euler parameters by
    speeds outright.
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
    """The speeds that have a z, with it."""
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
        """The part as a sum of whole rows of Y, each with its sign, by peeling off rows that agree with it on their support."""
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
        """The part as one row of Y times a factor."""
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
        """Affine expressions of rates in speeds."""
        return [self.form(c, r) for c, r in self.in_rates(exprs)]

    def in_rates(self, exprs: Iterable[Expr]) -> list[Affine]:
        """Affine expressions of rates in the basic ones."""
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
    """The factors free of rates that multiply or divide what is left of an expression, outermost first, and this."""
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
