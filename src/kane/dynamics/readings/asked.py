# SPDX-License-Identifier: BSD-3-Clause
"""What may be asked of equations and motions: expressions, names, vectors, dyadics, matrices, and lists of these."""

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from numbers import Number
from typing import Any

import numpy as np

from kane.dynamics.derivation import Derived
from kane.errors import ExpressionError, cut
from kane.expr.evaluation import stacked
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Symbol, rate, time
from kane.numeric.named import symbol_named
from kane.space.vector import Dyadic, Vector

Exprs = tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """The expressions that something asked for is made of, its shape, None where the parts of a list differ, and these parts."""

    roots: Exprs
    shape: tuple[int, ...] | None
    parts: tuple["Asked", ...] | None = None

    def filled(self, numbers: Sequence[Any]) -> Any:
        """Numbers of the roots as what was asked for: a vector as its last axis, a matrix as its last two, a list as a list."""
        if self.parts is not None:
            rest = iter(numbers)
            return [part.filled([next(rest) for _ in part.roots]) for part in self.parts]
        if not self.shape:
            return numbers[0]
        return np.stack(numbers, axis=-1) if len(self.shape) == 1 else stacked(numbers, (self.shape[0], self.shape[1]))


def asked(derived: Derived, what: Any) -> Asked:
    """What the user asks for; measure numbers of vectors and dyadics are along the inertial frame.

    Raises
    ------
    ExpressionError
        if it is none of these
    ValueMissingError
        if a name is none of the system's
    """
    frame = derived.system.inertial
    if isinstance(what, str):
        return Asked((_named(derived, what),), ())
    if isinstance(what, Vector):
        return Asked(tuple(what.components(frame)), (3,))
    if isinstance(what, Dyadic):
        what = what.components(frame)
    if isinstance(what, Matrix):
        return Asked(tuple(what.entries), what.shape)
    if isinstance(what, Expr | Number | np.generic) or (isinstance(what, np.ndarray) and what.ndim == 0):
        return Asked((as_expr(what),), ())
    if not isinstance(what, Iterable) or isinstance(what, Set | Mapping | bytes):
        raise ExpressionError(
            f"Expected an expression, vector, name, dyadic or matrix, or a list of these, got {type(what).__name__}: "
            f"{cut(repr(what))}."
        )
    parts = tuple(asked(derived, x) for x in what)
    shapes = {part.shape for part in parts}
    (inner,) = shapes if len(shapes) == 1 else (None,)
    shape = (len(parts), *inner) if inner is not None else None if parts else (0,)
    return Asked(tuple(root for part in parts for root in part.roots), shape, parts)


def _named(derived: Derived, name: str) -> Symbol:
    """The symbol of that name: the system's own, or a rate of one, or the time."""
    system = derived.system
    moving: tuple[Any, ...] = derived.state
    own: tuple[Symbol, ...] = (*moving, *derived.reactions, *system.parameters, *system.inputs)
    rates = {r.name: r for r in map(rate, moving)} | {time.name: time}
    return symbol_named(own, name) if name in {s.name for s in own} or name not in rates else rates[name]
