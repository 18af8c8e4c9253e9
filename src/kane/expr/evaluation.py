# SPDX-License-Identifier: BSD-3-Clause
"""The reference evaluator: the graph walked with NumPy, the meaning that every emitter must reproduce; its symbols."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from kane.errors import ExpressionError, ValueMissingError, alike, cut
from kane.expr import floats
from kane.expr.floats import FLOAT, in_batches
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr, as_exprs, constant_value, postorder
from kane.expr.ops import OPS, PI, SYMBOL, Op
from kane.expr.symbols import Parameter, StateVariable, Symbol, Symbols, declared

Values = Mapping[Any, Any]

_NUMPY: dict[Op, Callable[..., Any]] = {op: op.numpy for op in OPS.values() if op.arity}


def know(op: Op) -> None:
    """One more operation, which the table of operations does not hold."""
    _NUMPY[op] = op.numpy
    floats.know(op)


class Walk:
    """Expressions whose graph is walked again and again: all of them at once, each node once.

    The nodes are listed when it is made; from the second state of plain numbers on it goes by a list of instructions in Python's
    floats. What is computed depends on neither.
    """

    def __init__(self, roots: Iterable[Any]) -> None:
        if not isinstance(roots, Iterable):
            raise ExpressionError(f"Expected an expression or several to evaluate, got {cut(repr(roots))}.")
        self.roots = tuple(as_expr(r) for r in roots)
        self.order = postorder(self.roots)
        self.leaves: dict[Expr, float | None] = {}
        """The nodes without arguments; constants with their numbers."""
        for node in self.order:
            if not node.args:
                self.leaves[node] = math.pi if node.op is PI else _number(node)
        self._walked = False

    @cached_property
    def symbols(self) -> tuple[Symbol, ...]:
        """The symbols below the roots, in the order of their first appearance."""
        return tuple(n for n in self.leaves if isinstance(n, Symbol))

    def missing(self, known: Mapping[Any, Any]) -> list[Symbol]:
        """The symbols that are not among `known`."""
        return [s for s in self.symbols if s not in known]

    def check(self, known: Mapping[Any, Any]) -> None:
        """A ValueMissingError names a symbol that is not among `known`."""
        for node in self.missing(known):
            raise ValueMissingError(
                f"Expected a value for every symbol, got none for {node} ({type(node).__name__}). Known here: "
                f"{', '.join(str(s) for s in known) or 'none'}."
            )

    @cached_property
    def _in_batches(self) -> Callable[[Mapping[Expr, float]], list[float]]:
        return in_batches(self.order, self.roots, self.leaves)

    def __call__(self, values: Mapping[Any, Any]) -> list[Any]:
        """The roots at numbers or broadcastable arrays for all symbols: floats where all are numbers.

        Division by zero and the like give infinity or NaN as IEEE 754 says, without a warning.
        """
        given: dict[Expr, Any] = {s: _plain(values[s]) for s in self.symbols}
        with np.errstate(all="ignore"):
            if any(type(v) is not float for v in given.values()):
                return self._through(given, _NUMPY, lambda v: np.float64(v) if type(v) is float else v)
            if self._walked:
                return self._in_batches(given)
            self._walked = True
            return self._through(given, FLOAT, float)

    def rows(self, leaves: Sequence[Expr], rows: Iterable[Sequence[float]]) -> list[list[float]]:
        """The roots at several rows of floats for `leaves`, which hold all symbols."""
        places = [(s, k) for k, s in enumerate(leaves) if s in self.leaves]
        with np.errstate(all="ignore"):
            return [self._in_batches({s: row[k] for s, k in places}) for row in rows]

    def _through(self, given: dict[Expr, Any], functions: dict[Op, Callable[..., Any]], number: Any) -> list[Any]:
        found = {leaf: number(given[leaf] if value is None else value) for leaf, value in self.leaves.items()}
        for node in self.order:
            if node.args:
                found[node] = functions[node.op](*[found[a] for a in node.args])
        return [found[r] for r in self.roots]


def _number(leaf: Expr) -> float | None:
    return None if leaf.op is SYMBOL else float(constant_value(leaf) or 0)


def _plain(value: Any) -> Any:
    """A number as a float, an array as it is."""
    if type(value) is float:
        return value
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ExpressionError(
            f"Expected a real number or an array of them as a value, got {type(value).__name__}: {cut(value)}."
        ) from error
    return array if array.ndim else float(array)


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A function from the values of `leaves` (numbers or broadcastable arrays) to those of the roots of a walk."""

    walk: Walk
    leaves: Sequence[Expr]

    def __call__(self, values: Sequence[Any]) -> list[Any]:
        """The values of the roots."""
        return self.walk(dict(zip(self.leaves, values, strict=True)))

    def rows(self, rows: Iterable[Sequence[float]]) -> list[list[float]]:
        """Those at several rows of floats, the same bit by bit."""
        return self.walk.rows(self.leaves, rows)


def compile_reference(roots: Iterable[Expr], leaves: Sequence[Expr]) -> Reference:
    """A function from the values of `leaves` (numbers or broadcastable arrays) to the values of `roots`.

    Threads may call it at the same time.
    """
    walk = Walk(roots)
    walk.check(dict.fromkeys(leaves))
    return Reference(walk, leaves)


def evaluate(exprs: Any, values: Values) -> Any:
    """Values of one expression, or of a sequence or Matrix of them, at numbers or broadcastable arrays, by symbol or name.

    Those of a sequence all have the broadcast shape. Parameters and states without a value take their default; any other symbol
    without one is a `ValueMissingError`, and so is a name, or another symbol of the name, of none of their symbols.
    """
    if isinstance(exprs, Matrix):
        return stacked(evaluate(exprs.entries, values), exprs.shape)
    if isinstance(exprs, Expr | int | float | np.generic) or (isinstance(exprs, np.ndarray) and exprs.ndim == 0):
        return evaluate([exprs], values)[0]
    walk = Walk(exprs)
    return of_one_shape(at(walk, _by_symbol(walk.symbols, values)))


def _by_symbol(symbols: Sequence[Symbol], values: Values) -> Values:
    """The values by symbol; symbols that are not among `symbols` are let pass, their values are not needed."""
    if not isinstance(values, Mapping):
        raise ValueMissingError(f"Expected values as a dict {{symbol or name: number}}, got {cut(repr(values))}.")
    own = set(symbols)
    strange = [key for key in values if key not in own]
    if not strange:
        return values
    by_name: dict[str, list[Symbol]] = {}
    for s in symbols:
        by_name.setdefault(s.name, []).append(s)
    found = {key: value for key, value in values.items() if not isinstance(key, str)}
    for key in strange:
        alone = by_name.get(key.name if isinstance(key, Symbol) else key, [])
        if isinstance(key, str) and len(alone) == 1 and alone[0] not in found:
            found[alone[0]] = values[key]
        elif isinstance(key, str) or (alone and not all(s in found for s in alone)):
            raise ValueMissingError(_not_told(key, alone, by_name))
    return found


def _not_told(key: str | Symbol, alone: Sequence[Symbol], names: Iterable[str]) -> str:
    if isinstance(key, Symbol):
        return (
            f"Expected values of the symbols in the expressions, got one for another symbol of the name {key.name!r}: {declared(key)} "
            f"in place of {declared(alone[0])}. Take the same symbol, or give the name alone."
        )
    if alone:
        return f"Expected one symbol and one value for the name {key!r}, got more. Give its values by symbol alone."
    return f"Expected values of the symbols in the expressions ({', '.join(names) or 'none'}), got one for {key!r}.{alike(key, names)}"


def at(walk: Walk, values: Values) -> list[Any]:
    """The roots of a walk at numbers or arrays, with defaults of parameters and states."""
    known = dict(values)
    for s in walk.missing(known):
        if isinstance(s, Parameter | StateVariable) and s.default is not None:
            known[s] = s.default
    walk.check(known)
    return walk(known)


def of_one_shape(numbers: Iterable[Any]) -> list[Any]:
    """Numbers and arrays as arrays of the broadcast shape."""
    results = [np.asarray(v) for v in numbers]
    shape = np.broadcast_shapes(*(v.shape for v in results))
    return [v if v.shape == shape else np.broadcast_to(v, shape).copy() for v in results]


def stacked(entries: Sequence[Any], shape: tuple[int, int]) -> Any:
    """A matrix of numbers, or of arrays as its leading axes, from its entries row by row."""
    leading = entries[0].shape if entries else ()
    flat = np.stack(entries) if entries else np.zeros((0,))
    return np.moveaxis(flat.reshape(*shape, *leading), (0, 1), (-2, -1))


def free_symbols(roots: Expr | Iterable[Expr]) -> Symbols[Symbol]:
    """The symbols below an expression, or below several, in the order of their first appearance."""
    seen: set[Expr] = set()
    found: list[Symbol] = []
    waiting = [roots] if isinstance(roots, Expr) else list(as_exprs("what holds symbols", roots))[::-1]
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            args = node.args
            if args:
                waiting += args[::-1]
            elif isinstance(node, Symbol):
                found.append(node)
    return Symbols(found)


def holds_any(roots: Iterable[Expr], among: Set[Expr]) -> bool:
    """Whether any of the expressions `among` is below `roots`."""
    seen: set[Expr] = set()
    waiting = list(roots)
    while waiting:
        node = waiting.pop()
        if node not in seen:
            if node in among:
                return True
            seen.add(node)
            waiting.extend(node.args)
    return False


def is_constant_in_time(exprs: Iterable[Expr]) -> bool:
    """Whether the expressions hold parameters and numbers only."""
    seen: set[Expr] = set()
    waiting = list(exprs)
    while waiting:
        node = waiting.pop()
        if node.op is SYMBOL and not isinstance(node, Parameter):
            return False
        if node not in seen:
            seen.add(node)
            waiting.extend(node.args)
    return True
