# SPDX-License-Identifier: BSD-3-Clause
"""Evaluation of expressions: the reference evaluator with NumPy, whose results every emitter must reproduce; operation counts.

From the second state of plain numbers on, `Walk` uses Python floats, many times as fast as NumPy scalars. Independent nodes of one
operation form a batch, and a product read by one sum or difference alone is computed within it; each operation still rounds
separately, so that the numbers are those of NumPy bit by bit, infinity and NaN included.

Operations of an evaluation are counted by tier and by operation.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from kane.errors import Attributes, ExpressionError, ValueMissingError, alike, cut
from kane.expect import is_list, reals
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr, as_exprs, constant_value, nodes, postorder
from kane.expr.ops import ADD, DIV, GONE, LESS, MUL, NEG, OPS, PI, REGULAR, SQRT, SUB, SYMBOL, WHERE, Op
from kane.expr.symbols import Parameter, StateVariable, Symbol, Symbols, declared

Rows = list[tuple[int, ...]]
Batch = Callable[[list[float], Rows], None]


def _rounded(function: Callable[..., Any]) -> Callable[..., float]:
    return lambda *args: float(function(*args))


def _quotient(x: float, y: float) -> float:
    """x / y by IEEE 754, with infinity and NaN for division by zero."""
    if y:
        return x / y
    return math.copysign(math.inf, x) * math.copysign(1.0, y) if x < 0 or x > 0 else math.nan


FLOAT: dict[Op, Callable[..., float]] = {
    **{op: _rounded(op.numpy) for op in OPS.values() if op.arity},
    **{op: op.numpy for op in (ADD, SUB, MUL, NEG)},
    DIV: _quotient,
    SQRT: lambda x: math.nan if x < 0 else math.sqrt(x),
    LESS: lambda x, y: 1.0 if x < y else 0.0,
    WHERE: lambda condition, x, y: x if condition else y,
    REGULAR: lambda x, size: x if abs(x) > GONE * size else math.nan,
    OPS["abs"]: abs,
}
"""Each operation on floats; those that a processor's library may round in another way are NumPy's own."""


def _add(w: list[float], rows: Rows) -> None:
    for a, b in rows:
        w.append(w[a] + w[b])


def _sub(w: list[float], rows: Rows) -> None:
    for a, b in rows:
        w.append(w[a] - w[b])


def _mul(w: list[float], rows: Rows) -> None:
    for a, b in rows:
        w.append(w[a] * w[b])


def _add_product(w: list[float], rows: Rows) -> None:
    for a, b, c in rows:
        w.append(w[a] + w[b] * w[c])


def _sub_product(w: list[float], rows: Rows) -> None:
    for a, b, c in rows:
        w.append(w[a] - w[b] * w[c])


def _product_sub(w: list[float], rows: Rows) -> None:
    for a, b, c in rows:
        w.append(w[a] * w[b] - w[c])


def _add_products(w: list[float], rows: Rows) -> None:
    for a, b, c, d in rows:
        w.append(w[a] * w[b] + w[c] * w[d])


def _sub_products(w: list[float], rows: Rows) -> None:
    for a, b, c, d in rows:
        w.append(w[a] * w[b] - w[c] * w[d])


def _each(function: Callable[..., float]) -> Batch:
    def batch(w: list[float], rows: Rows) -> None:
        for row in rows:
            w.append(function(*[w[i] for i in row]))

    return batch


_BATCHES: dict[tuple[Op, bool, bool], Batch] = {
    **{(op, False, False): _each(function) for op, function in FLOAT.items()},
    (ADD, False, False): _add,
    (SUB, False, False): _sub,
    (MUL, False, False): _mul,
    (ADD, False, True): _add_product,
    (SUB, False, True): _sub_product,
    (SUB, True, False): _product_sub,
    (ADD, True, True): _add_products,
    (SUB, True, True): _sub_products,
}
"""By operation, and whether its two arguments are products computed within."""


def in_batches(
    order: Sequence[Expr], roots: Sequence[Expr], leaves: Mapping[Expr, float | None]
) -> Callable[[Mapping[Expr, float]], list[float]]:
    """A function that maps numbers for the symbols in `leaves` to the values of `roots`.

    Parameters
    ----------
    order : every node below the roots, in topological order
    leaves : the nodes without arguments, with the numbers of constants and None of symbols
    """
    kinds, arguments = _kinds(order, roots)
    place = {leaf: i for i, leaf in enumerate(leaves)}
    program: list[tuple[Batch, Rows]] = []
    for kind, batch in _batched(kinds, arguments):
        place.update(zip(batch, range(len(place), len(place) + len(batch)), strict=True))
        program.append((_BATCHES[kind], [tuple([place[a] for a in arguments[n]]) for n in batch]))
    start = [0.0 if value is None else value for value in leaves.values()]
    given = [(place[leaf], leaf) for leaf, value in leaves.items() if value is None]
    outputs = [place[r] for r in roots]

    def run(values: Mapping[Expr, float]) -> list[float]:
        w = start.copy()
        for i, leaf in given:
            w[i] = values[leaf]
        for batch, rows in program:
            batch(w, rows)
        return [w[i] for i in outputs]

    return run


Kind = tuple[Op, bool, bool]


def _kinds(order: Sequence[Expr], roots: Sequence[Expr]) -> tuple[dict[Expr, Kind], dict[Expr, tuple[Expr, ...]]]:
    """The operation and the arguments of each node, without products that are fused into their only reader."""
    users = Counter(a for node in order for a in node.args)
    users.update(roots)
    within = {
        a for node in order if node.op is ADD or node.op is SUB for a in node.args if a.op is MUL and users[a] == 1
    }
    kinds: dict[Expr, Kind] = {}
    arguments: dict[Expr, tuple[Expr, ...]] = {}
    for node in order:
        args, op = node.args, node.op
        if not args or node in within:
            continue
        first, last = args[0] in within, args[-1] in within
        if not (first or last):
            kinds[node], arguments[node] = (op, False, False), args
            continue
        if op is ADD and first and not last:  # a sum is the same either way round
            args, first, last = (args[1], args[0]), False, True
        kinds[node] = op, first, last
        arguments[node] = (*(args[0].args if first else args[:1]), *(args[1].args if last else args[1:]))
    return kinds, arguments


def _batched(kinds: Mapping[Expr, Kind], arguments: Mapping[Expr, tuple[Expr, ...]]) -> list[tuple[Kind, list[Expr]]]:
    """Batches of nodes with one operation, in an order of computation.

    The operations take turns; a node is in the first batch of its operation at which its arguments are known, if only by that batch.
    """
    turns = {kind: k for k, kind in enumerate(dict.fromkeys(kinds.values()))}
    turn: dict[Expr, int] = {}
    batches: dict[int, list[Expr]] = {}
    for node, kind in kinds.items():
        known = max([turn.get(a, 0) for a in arguments[node]])
        mine = turn[node] = known + (turns[kind] - known) % len(turns)
        batches.setdefault(mine, []).append(node)
    return [(kinds[batches[k][0]], batches[k]) for k in sorted(batches)]


Values = Mapping[Any, Any]

_NUMPY: dict[Op, Callable[..., Any]] = {op: op.numpy for op in OPS.values() if op.arity}


def know(op: Op) -> None:
    """Registers an operation that is not in the table `OPS`."""
    _NUMPY[op], FLOAT[op] = op.numpy, _rounded(op.numpy)
    _BATCHES[op, False, False] = _each(FLOAT[op])


class Walk:
    """The repeated evaluation of several expressions together, each node once per state.

    The nodes are listed once; from the second state on a list of instructions is used, in Python floats where all are plain numbers,
    with the same results.
    """

    def __init__(self, roots: Iterable[Any]) -> None:
        if not is_list(roots):
            raise ExpressionError(f"Expected an expression or several to evaluate, got {cut(repr(roots))}.")
        self.roots = tuple(as_expr(r) for r in roots)
        self.order = postorder(self.roots)
        self.leaves: dict[Expr, float | None] = {}
        """The nodes without arguments; constants with their numbers."""
        for node in self.order:
            if not node.args:
                self.leaves[node] = math.pi if node.op is PI else _number(node)
        self._walked = self._walked_in_arrays = False

    @cached_property
    def symbols(self) -> tuple[Symbol, ...]:
        """The symbols below the roots, in the order of their first appearance."""
        return tuple(n for n in self.leaves if isinstance(n, Symbol))

    def missing(self, known: Mapping[Any, Any]) -> list[Symbol]:
        """The symbols that are not in `known`."""
        return [s for s in self.symbols if s not in known]

    def check(self, known: Mapping[Any, Any]) -> None:
        """Raises a ValueMissingError if a symbol is not in `known`."""
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
                if self._walked_in_arrays:
                    return self._in_steps(given)
                self._walked_in_arrays = True
                return self._through(given, _NUMPY, _of_numpy)
            if self._walked:
                return self._in_batches(given)
            self._walked = True
            return self._through(given, FLOAT, float)

    def rows(self, leaves: Sequence[Expr], rows: Iterable[Sequence[float]]) -> list[list[float]]:
        """The roots at several rows of floats for `leaves`, which must include all symbols."""
        places = [(s, k) for k, s in enumerate(leaves) if s in self.leaves]
        with np.errstate(all="ignore"):
            return [self._in_batches({s: row[k] for s, k in places}) for row in rows]

    @cached_property
    def _steps(self) -> tuple[list[tuple[Callable[..., Any], tuple[int, ...]]], list[int]]:
        """The operations, each with the places of its arguments among the leaves and earlier results; the places of the roots."""
        place = {leaf: i for i, leaf in enumerate(self.leaves)}
        steps: list[tuple[Callable[..., Any], tuple[int, ...]]] = []
        for node in self.order:
            if node.args:
                steps.append((_NUMPY[node.op], tuple([place[a] for a in node.args])))
                place[node] = len(place)
        return steps, [place[r] for r in self.roots]

    def _in_steps(self, given: dict[Expr, Any]) -> list[Any]:
        w = [_of_numpy(given[leaf] if value is None else value) for leaf, value in self.leaves.items()]
        steps, roots = self._steps
        for function, at in steps:
            w.append(function(w[at[0]], w[at[1]]) if len(at) == 2 else function(*[w[i] for i in at]))
        return [w[i] for i in roots]

    def _through(self, given: dict[Expr, Any], functions: dict[Op, Callable[..., Any]], number: Any) -> list[Any]:
        found = {leaf: number(given[leaf] if value is None else value) for leaf, value in self.leaves.items()}
        for node in self.order:
            if node.args:
                found[node] = functions[node.op](*[found[a] for a in node.args])
        return [found[r] for r in self.roots]


def _of_numpy(value: Any) -> Any:
    return np.float64(value) if type(value) is float else value


def _number(leaf: Expr) -> float | None:
    return None if leaf.op is SYMBOL else float(constant_value(leaf) or 0)


def _plain(value: Any) -> Any:
    """A number as a float, an array as it is."""
    if type(value) is float:
        return value
    try:
        array = reals(value)
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
        """The values of the roots at several rows of floats, bit by bit those of single calls."""
        return self.walk.rows(self.leaves, rows)


def compile_reference(roots: Iterable[Expr], leaves: Sequence[Expr]) -> Reference:
    """A function from the values of `leaves` (numbers or broadcastable arrays) to the values of `roots`.

    Threads may call it at the same time.
    """
    walk = Walk(roots)
    walk.check(dict.fromkeys(leaves))
    return Reference(walk, leaves)


def evaluate(exprs: Any, values: Values) -> Any:
    """Values of an expression, or of a sequence or Matrix of expressions, for given values of their symbols.

    `values` maps symbols or names to numbers, or to arrays that broadcast; all results then have the broadcast shape. Parameters and
    states left out take their defaults. A ValueMissingError names any other symbol without a value, and a name that is unknown.
    """
    if isinstance(exprs, Matrix):
        return stacked(evaluate(exprs.entries, values), exprs.shape)
    if isinstance(exprs, Expr | int | float | np.generic) or (isinstance(exprs, np.ndarray) and exprs.ndim == 0):
        return evaluate([exprs], values)[0]
    walk = Walk(exprs)
    return of_one_shape(at(walk, _by_symbol(walk.symbols, values)))


def _by_symbol(symbols: Sequence[Symbol], values: Values) -> Values:
    """The values by symbol; values of symbols that do not occur in the expressions are ignored."""
    if not isinstance(values, Mapping):
        raise ValueMissingError(f"Expected values as a dict {{symbol or name: number}}, got {cut(repr(values))}.")
    own = set(symbols)
    strange = [key for key in values if key not in own]
    if not strange:
        return values
    by_name: dict[str, list[Symbol]] = {}
    for s in symbols:
        by_name.setdefault(s.name, []).append(s)
    result = {key: value for key, value in values.items() if not isinstance(key, str)}
    for key in strange:
        alone = by_name.get(key.name if isinstance(key, Symbol) else key, [])
        if isinstance(key, str) and len(alone) == 1 and alone[0] not in result:
            result[alone[0]] = values[key]
        elif isinstance(key, str) or (alone and not all(s in result for s in alone)):
            raise ValueMissingError(_missing_message(key, alone, by_name))
    return result


def _missing_message(key: str | Symbol, alone: Sequence[Symbol], names: Iterable[str]) -> str:
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
    """The symbols that occur in one or several expressions, in the order of their first appearance."""
    seen: set[Expr] = set()
    found: list[Symbol] = []
    waiting = [roots] if isinstance(roots, Expr) else list(as_exprs("the argument", roots))[::-1]
    while waiting:
        node = waiting.pop()
        while node not in seen:  # down along first arguments
            seen.add(node)
            args = node.args
            if not args:
                if isinstance(node, Symbol):
                    found.append(node)
                break
            if len(args) > 1:
                waiting += args[:0:-1]
            node = args[0]
    return Symbols(found)


def is_constant_in_time(exprs: Iterable[Expr]) -> bool:
    """Whether the expressions contain parameters and numbers only."""
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


@dataclass(frozen=True, slots=True)
class Operations(Attributes):
    """Number of operations of one evaluation: + − × ÷ √ and each transcendental function count 1; sign changes, |x|, comparisons 0.

    `parameter` counts operations on parameters alone, which can be done once, `state` all others, `by_operation` each kind.
    Operations on constants alone are carried out beforehand and not counted.
    """

    parameter: int
    state: int
    by_operation: tuple[tuple[str, int], ...]

    @property
    def total(self) -> int:
        """The sum of `parameter` and `state`."""
        return self.parameter + self.state

    def __str__(self) -> str:
        kinds = ", ".join(f"{n} {k}" for k, n in self.by_operation)
        told = f"{self.total} operations: {self.state} with the state, {self.parameter} of parameters"
        return f"{told} ({kinds})" if kinds else told


_CONSTANT, _PARAMETER, _STATE = range(3)


def count_operations(roots: Iterable[Expr] | Expr) -> Operations:
    """Number of operations of one evaluation of all `roots` together; a shared subexpression counts once."""
    wanted = [roots] if isinstance(roots, Expr) else as_exprs("the argument", roots)
    tier: dict[Expr, int] = {}
    totals = [0, 0, 0]
    kinds: Counter[str] = Counter()
    for node in postorder(wanted):
        if isinstance(node, Symbol):
            tier[node] = _PARAMETER if isinstance(node, Parameter) else _STATE
            continue
        tier[node] = max((tier[a] for a in node.args), default=_CONSTANT)
        if tier[node] and node.op.cost:
            totals[tier[node]] += node.op.cost
            kinds[node.op.name] += node.op.cost
    return Operations(totals[_PARAMETER], totals[_STATE], tuple(sorted(kinds.items())))


def price(roots: Iterable[Expr]) -> int:
    """What `count_operations` gives in total, sooner; to compare ways by. Operations on constants alone, which are rare, count."""
    return _cost(nodes(roots))


class Prices:
    """The `price` of expressions beside others that are there in any case, which are walked once."""

    def __init__(self, known: Iterable[Expr]) -> None:
        self._known = nodes(known)
        self._own = _cost(self._known)

    def __call__(self, roots: Iterable[Expr]) -> int:
        """Of the known ones and `roots` together."""
        return self._own + _cost(nodes(roots, self._known))


class Together(tuple[Expr, ...]):
    """Expressions that are computed together, with what is asked of them by one rewriting after the other."""

    @classmethod
    def of(cls, roots: Sequence[Expr]) -> "Together":
        """These expressions, as they come where they are known together."""
        return roots if isinstance(roots, cls) else cls(roots)

    order = cached_property(postorder)
    price = cached_property(lambda self: _cost(nodes(self)))

    def or_shorter(self, others: Sequence[Expr]) -> "Together":
        """The `others` where they take fewer operations, else these."""
        found = Together.of(others)
        return found if found.price < self.price else self


def exceeds(roots: Iterable[Expr], most: int) -> bool:
    """Whether the `price` of `roots` is more than `most`: no further nodes are looked at than tells that."""
    seen, total = set(roots), 0
    found = list(seen)
    for node in found:  # which grows meanwhile
        total += node.op.cost
        if total > most:
            return True
        for a in node.args:
            if a not in seen:
                seen.add(a)
                found.append(a)
    return False


def _cost(of: Iterable[Expr]) -> int:
    return sum([node.op.cost for node in of])
