# SPDX-License-Identifier: BSD-3-Clause
"""Random states of a model: configurations and speeds that satisfy its constraints, and the rates that follow from them.

Two descriptions of a motion are compared only there, because they may differ where constraints are violated.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.errors import ModelError
from kane.expr.differentiation import gradient
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate, Input, Parameter, Rate, Speed, Symbol, rate
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEED
from kane.numeric.scale import CLOSED_FULLY, EQUAL, ROUNDED_SUM

COUNT = 4
_TRIES, _STEPS = 60, 60
Rows = Sequence[Sequence[Expr]]
Kinematical = tuple[Rows, Rows, Sequence[Expr]]
"""k_q, k_u and f of k_q q̇ + k_u u + f = 0."""
Sets = Sequence[tuple[Coordinate, ...]]


def numbers(exprs: Sequence[Expr], values: Mapping[Expr, Any]) -> Array:
    """Values of expressions: (n), or (n × states) for arrays of values."""
    with np.errstate(all="ignore"):
        found = evaluate(exprs, {s: values[s] for s in free_symbols(exprs) if s in values}) if exprs else []
    shape = np.shape(next(iter(values.values()), 0.0))
    return np.array([np.broadcast_to(x, shape) for x in found], dtype=float).reshape(len(exprs), *shape)


class States:
    """`COUNT` states: an array of values for each symbol and rate; additional coordinates are entered with their rates."""

    def __init__(
        self, q: Sequence[Coordinate], u: Sequence[Speed], kinematical: Kinematical,
        holonomic: Sequence[Expr], motion: Sequence[Expr], sets: Sets, others: Callable[[], Iterable[Symbol]],
    ) -> None:  # fmt: skip
        self._rng = np.random.default_rng(SEED)
        self._q, self._u, self._kinematical = tuple(q), tuple(u), kinematical
        closing = [*holonomic, *(_length(s) for s in sets)]
        slopes = [gradient(f, list(q)) for f in closing]
        rows = [gradient(f, list(u)) for f in motion]
        columns: list[dict[Expr, float]] = []
        for _ in range(_TRIES):
            values = self._drawn(others(), sets)
            if self._closed(values, closing, slopes) and self._moved(values, motion, rows):
                columns.append(values)
            if len(columns) == COUNT:
                break
        if len(columns) < COUNT:
            raise ModelError(
                f"Expected configurations at which the {len(holonomic)} configuration constraints hold, got none in {_TRIES} tries "
                "from random values. Give values= of parameters with which the mechanism closes."
            )
        self.values: dict[Expr, Any] = {s: np.array([c[s] for c in columns]) for s in columns[0]}

    def _drawn(self, others: Iterable[Symbol], sets: Sets) -> dict[Expr, float]:
        values: dict[Expr, float] = {}
        for s in others:
            if isinstance(s, Parameter):
                sign = -1.0 if s.description in ("negative", "nonpositive") else 1.0
                values[s] = float(s.default) if s.default is not None else sign * self._rng.uniform(0.4, 1.6)
            elif isinstance(s, Input):
                chain: Any = s
                for _ in range(4):
                    values[chain] = self._rng.uniform(-1, 1)
                    chain = rate(chain)
            else:
                values[s] = self._rng.uniform(0.2, 1.2)
        values.update((s, self._rng.uniform(0.2, 1.4)) for s in (*self._q, *self._u))
        for group in sets:
            e = np.array([values[s] for s in group])
            values.update(zip(group, e / np.linalg.norm(e), strict=True))
        return values

    def _closed(self, values: dict[Expr, float], f: Sequence[Expr], slopes: Sequence[Sequence[Expr]]) -> bool:
        """Projects onto f(q) = 0 by Newton's method with minimum-norm steps; whether it converged."""
        if not f:
            return True
        for _ in range(_STEPS):
            left = numbers(f, values)
            a = numbers([x for row in slopes for x in row], values).reshape(len(f), -1)
            if not (np.isfinite(left).all() and np.isfinite(a).all()):
                return False
            if np.abs(left).max() < CLOSED_FULLY * 10:
                return True
            step = np.linalg.lstsq(a, -left, rcond=1e-10)[0]
            step *= min(1.0, 0.5 / max(np.abs(step).max(), 1e-300))
            values.update((s, values[s] + d) for s, d in zip(self._q, step, strict=True))
        return False

    def _moved(self, values: dict[Expr, float], motion: Sequence[Expr], rows: Sequence[Sequence[Expr]]) -> bool:
        """Sets the nearest speeds that satisfy the motion constraints, and the rates."""
        if motion:
            a = numbers([x for row in rows for x in row], values).reshape(len(motion), -1)
            left = numbers(motion, values)
            if not (np.isfinite(left).all() and np.isfinite(a).all()):
                return False
            step = np.linalg.lstsq(a, -left, rcond=1e-10)[0]
            values.update((s, values[s] + d) for s, d in zip(self._u, step, strict=True))
            if np.abs(numbers(motion, values)).max() > ROUNDED_SUM * 100:
                return False
        k_q, k_u, f = self._kinematical
        n = len(self._q)
        a = numbers([x for row in k_q for x in row], values).reshape(n, n)
        b = numbers([x for row in k_u for x in row], values).reshape(n, -1)
        right = b @ np.array([values[s] for s in self._u]) + numbers(f, values)
        if not (np.isfinite(a).all() and np.isfinite(right).all()) or np.linalg.cond(a) > 1e8:
            return False
        values.update(zip(map(rate, self._q), -np.linalg.solve(a, right), strict=True))
        return True

    def of(self, exprs: Iterable[Any]) -> Array:
        """Values (n × states)."""
        listed = list(exprs)
        return numbers(listed, self._with_new(listed))

    def _with_new(self, exprs: Sequence[Any]) -> dict[Expr, Any]:
        """The values, with random ones for parameters and inputs that are new."""
        for s in free_symbols([e for e in exprs if isinstance(e, Expr)]):
            if s in self.values:
                continue
            base: Any = s
            while isinstance(base, Rate):
                base = base.place
            if isinstance(base, Parameter | Input):
                drawn = [self._drawn([base], ()) for _ in range(COUNT)]
                self.values |= {
                    x: np.array([d[x] for d in drawn])
                    for x in drawn[0]
                    if isinstance(x, Parameter | Input | Rate) and x not in self.values
                }
        return self.values

    def vanish(self, exprs: Iterable[Any], beside: Iterable[Any] = ()) -> bool:
        """Whether expressions are zero at all states, relative to the largest value of `beside`."""
        mine = self.of(list(exprs))
        size = max(1e-3, np.abs(self.of(list(beside))).max(initial=0))
        return bool(np.isfinite(mine).all() and np.abs(mine).max(initial=0) <= EQUAL * size)

    def enter(self, q: Symbol, moving: Expr) -> None:
        """Adds a coordinate with a given rate."""
        self.values[q] = self._rng.uniform(0.2, 1.2, COUNT)
        self.values[rate(q)] = self.of([moving])[0]

    def enter_turning(self, group: Sequence[Coordinate]) -> None:
        """Adds Euler parameters."""
        e = self._rng.uniform(0.2, 1.2, (4, COUNT))
        self.values.update(zip(group, e / np.linalg.norm(e, axis=0), strict=True))

    def turning(self, group: Sequence[Coordinate]) -> Array:
        """w = 2 (e0 ė − ė0 e − e × ė), 3 × states."""
        e = np.array([self.values[s] for s in group])
        d = np.array([self.values[rate(s)] for s in group])
        w: Array = 2 * (e[0] * d[1:] - d[0] * e[1:] - np.cross(e[1:], d[1:], axis=0))
        return w


def _length(group: Sequence[Coordinate]) -> Expr:
    """e·e − 1."""
    return sum((e * e for e in group), ZERO) - 1
