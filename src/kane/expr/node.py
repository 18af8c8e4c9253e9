# SPDX-License-Identifier: BSD-3-Clause
"""Nodes of the expression graph: immutable, interned, compared by identity.

Equal structure is the same object, so sharing is free and common subexpressions never exist twice. The table holds
strong references (a weak table costs three times as much a node) and is swept when it has doubled: whatever only the table still
holds is dropped, parents before their arguments.

The hash of a node is its identity. Its `key` is a 64-bit structural number, the same in every process, that orders
commutative arguments; `digest` is a cryptographic structural hash, made on demand, that breaks ties and serves caches.

Arithmetic of constant nodes keeps a bound on the error of each: what rounding leaves of zero becomes zero. A float that was given is
known to a few units in its last place. Sums, products and quotients pass the errors of their terms on (Higham 2002, Accuracy and
Stability of Numerical Algorithms, sec. 3.3), and a result that is no larger than its error is zero: the scalar product of
perpendicular unit vectors is, though in floats it comes out as 1e-17. Where terms cancel in part the error is a larger share of the
result than of a float that was given; such a constant carries it, until the next sum. Integers, fractions and surds are exact, and so
are their sums and products.
"""

from __future__ import annotations

import hashlib
import math
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from fractions import Fraction
from types import GeneratorType
from typing import TYPE_CHECKING, Any, NoReturn, Protocol, TypeVar, overload

import numpy as np

from kane import show
from kane.errors import Attributes, ExpressionError, cut
from kane.expect import is_list
from kane.expr.numbers import Surd, times, value_of_numbers
from kane.expr.ops import CONST, COS, OPS, PI, SIN, SYMBOL, UFUNCS, Op

Number = int | float | Fraction
T = TypeVar("T", covariant=True)
Leaf = TypeVar("Leaf", bound="Expr")


class Scalable(Protocol[T]):
    """What a scalar can multiply: a vector, a dyadic."""

    def __rmul__(self, factor: Any, /) -> T: ...


def _undecided(sign: str, cure: str) -> Callable[..., NoReturn]:
    """The method of a comparison, which refuses: an expression has no truth value."""

    def refuse(self: Expr, *other: object) -> NoReturn:
        raise ExpressionError(
            f"Expected a comparison that has a truth value, got an expression: `{sign}` on {cut(self, 80)} cannot be "
            f"decided while deriving. {cure}"
        )

    return refuse


_FROM_SYMPY = "Translate SymPy's with kn.from_sympy(expression, {SymPy's symbol: kane's})"
_CONDITION = "For a condition inside the equations write kn.where(kn.less({}), {})."


class Blank:
    """A node while it is made, which can be written; then it becomes an expression, in half the time that slots of one take."""

    __slots__ = ("__weakref__", "args", "key", "op")

    op: Op
    args: tuple[Expr, ...]
    key: int


class Expr(Blank, Attributes):
    """A scalar expression. Build it from symbols with operators and the functions of `kane`."""

    __slots__ = ()

    def __init__(self) -> None:
        raise ExpressionError("An Expr is made by operators and functions on symbols, not by calling Expr().")

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"An expression is immutable: {name!r} cannot be set.")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"An expression is immutable: {name!r} cannot be deleted.")

    __hash__ = object.__hash__

    __eq__ = _undecided("==", "Use `a is b` for the same expression, or a dict or set for membership (not a list).")
    __ne__ = _undecided("!=", "Use `a is not b`, or a dict or set for membership (not a list).")
    __lt__ = _undecided("<", _CONDITION.format("a, b", "x, y"))
    __gt__ = _undecided(">", _CONDITION.format("b, a", "x, y"))
    __le__ = _undecided("<=", _CONDITION.format("b, a", "y, x"))
    __ge__ = _undecided(">=", _CONDITION.format("a, b", "y, x"))
    __bool__ = _undecided("if", _CONDITION.format("a, b", "x, y"))

    def __float__(self) -> float:
        value = constant_value(self)
        if value is None:
            raise ExpressionError(
                f"Expected a number, got the expression {cut(self, 80)}. In equations use functions of "
                "expressions, kn.sin for math.sin; for numbers give its symbols values with kn.evaluate(...)."
            )
        return float(value)

    def _sympy_(self) -> NoReturn:
        """What SymPy asks for where this stands beside an expression of its own."""
        raise ExpressionError(
            f"Expected operands of one kind, got {cut(self, 80)} of kane beside one of SymPy's. {_FROM_SYMPY}, or make SymPy's of "
            "this one with kn.to_sympy."
        )

    def __copy__(self) -> Expr:
        return self

    def __deepcopy__(self, memo: object) -> Expr:
        return self

    def __reduce__(self) -> tuple[Callable[..., Expr], tuple[Any, ...]]:
        return _from_rows, (_to_rows(self),)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        name = UFUNCS.get(ufunc)
        if method != "__call__" or name is None or options:
            return NotImplemented
        build = BUILDERS[name]
        if not any(isinstance(x, np.ndarray) for x in inputs):
            return build(*inputs)
        boxed = [np.array(x, dtype=object) if isinstance(x, Expr) else x for x in inputs]
        return np.frompyfunc(build, len(boxed), 1)(*boxed)

    def __str__(self) -> str:
        return show.text(self)

    def __repr__(self) -> str:
        return str(self)

    _repr_latex_ = show.latex

    # Arithmetic and functions are attached by expr.operators.
    if TYPE_CHECKING:

        def __add__(self, other: Expr | Number) -> Expr: ...

        __radd__ = __sub__ = __rsub__ = __rmul__ = __truediv__ = __rtruediv__ = __pow__ = __rpow__ = __add__
        atan2 = min = max = less = __add__

        @overload
        def __mul__(self, other: Expr | Number) -> Expr: ...
        @overload
        def __mul__(self, other: Scalable[T]) -> T: ...
        def __mul__(self, other: Any) -> Any: ...
        def __neg__(self) -> Expr: ...

        __pos__ = __abs__ = sqrt = exp = log = abs = sign = __neg__
        sin = cos = tan = asin = acos = atan = sinh = cosh = tanh = __neg__

        where: Callable[[Expr | Number, Expr | Number], Expr]

        @property
        def dt(self) -> Expr:
            """Total time derivative; of a coordinate or speed, its rate leaf."""


class Constant(Expr):
    """A number: exact (int or Fraction) where it is rational with a short denominator, else a float.

    `error` is the bound on that of a float in which terms have cancelled, 0 where it is as of one that was given (`constants`).
    """

    __slots__ = ("error", "value")
    value: Number
    error: float


BUILDERS: dict[str, Callable[..., Expr]] = {}
"""Builder of each operation by name; filled by expr.operators."""

_table: dict[tuple[Any, ...], Expr] = {}
"""Constants, symbols and what is made by operations that are no row of the table of operations."""
_lock = threading.RLock()
_limit = 20_000
_sweeping = False
"""Whether nodes are being dropped: they are entered under the lock then. No thread is switched between a look at this and the entry,
as an interpreter does that after calls and jumps alone."""

_set_op = Blank.__dict__["op"].__set__
_set_args = Blank.__dict__["args"].__set__
_set_key = Blank.__dict__["key"].__set__
_set_value = Constant.__dict__["value"].__set__
_set_error = Constant.__dict__["error"].__set__
_new = object.__new__


def intern_node(op: Op, *args: Expr) -> Expr:
    """The one node of `op` on `args`; no rewriting here."""
    known: dict[tuple[Any, ...], Expr] | None = op.nodes
    name: tuple[Any, ...] = args
    if known is None:
        known, name = _table, (op, *args)
    node = known.get(name)
    if node is not None:
        return node
    made: Any = Blank()
    made.op, made.args, made.key = op, args, hash((op.code, *[a.key for a in args]))
    made.__class__ = Expr
    return enter(name, made, known)


def intern_pair(op: Op, a: Expr, b: Expr, of_a: int, of_b: int) -> Expr:
    """`intern_node` of a row's operation on two, with their keys: nine of ten nodes are such. Flat, as most time is spent here."""
    args = (a, b)
    known: dict[tuple[Any, ...], Expr] = op.nodes
    node = known.get(args)
    if node is not None:
        return node
    made: Any = Blank()
    made.op, made.args, made.key = op, args, hash((op.code, of_a, of_b))
    made.__class__ = Expr
    if _sweeping:
        return enter(args, made, known)
    first = known.setdefault(args, made)
    if len(known) > _limit:
        sweep()
    return first


def intern_single(op: Op, a: Expr) -> Expr:
    """`intern_node` of a row's operation on one."""
    args = (a,)
    known: dict[tuple[Any, ...], Expr] = op.nodes
    node = known.get(args)
    if node is not None:
        return node
    made: Any = Blank()
    made.op, made.args, made.key = op, args, hash((op.code, a.key))
    made.__class__ = Expr
    if _sweeping:
        return enter(args, made, known)
    first = known.setdefault(args, made)
    if len(known) > _limit:
        sweep()
    return first


def leaf(kind: type[Leaf], op: Op, key: int) -> Leaf:
    """A new node without arguments, not yet in the table."""
    node = _new(kind)
    _set_op(node, op)
    _set_args(node, ())
    _set_key(node, key)
    return node


def enter(name: tuple[Any, ...], node: Expr, known: dict[tuple[Any, ...], Expr] = _table) -> Expr:
    """Put a finished node into a table, unless another thread was first; then theirs is the one."""
    with _lock:
        first = known.setdefault(name, node)
        if len(known) > _limit:
            sweep()
    return first


def tables() -> list[dict[tuple[Any, ...], Expr]]:
    """Where nodes are known by name: by arguments for each row of the table of operations, and the others."""
    return [*(op.nodes for op in OPS.values()), _table]


def sweep() -> int:
    """Drop nodes that nothing but the tables hold; returns how many went."""
    global _limit, _sweeping
    dropped = 0
    with _lock:
        within, _sweeping = _sweeping, True
        _limit = sys.maxsize  # a finalizer that builds expressions must not start another sweep in this one
        for known in tables():
            names = _alone(known)
            while names:
                dropped += _dropped(known, names.pop())
        _limit = max(20_000, 2 * max(map(len, tables())))
        _sweeping = within
    return dropped


def _alone(known: dict[tuple[Any, ...], Expr]) -> list[tuple[Any, ...]]:
    """Names of the nodes of a table that nothing else seemed to hold when they were counted: the rest is not looked at one by one."""
    # each is held by the table, the list and the call: by one more than what a list alone holds
    held = map(sys.getrefcount, list(known.values()))
    least = next(map(sys.getrefcount, [object()])) + 1
    return [name for name, count in zip(list(known), held, strict=False) if count <= least]


def _dropped(known: dict[tuple[Any, ...], Expr], name: tuple[Any, ...]) -> int:
    """Drop a node of a table if nothing else holds it, and what was held by it alone; returns how many went."""
    dropped, waiting = 0, [(known, name)]
    while waiting:
        known, name = waiting.pop()
        if name not in known or sys.getrefcount(known[name]) > 2:
            continue
        taken = [known.pop(name)]  # in a list: references from local variables are counted differently by version
        if sys.getrefcount(taken[0]) > 2:  # a reader took it between the look and the removal: it lives on
            known[name] = taken[0]
            continue
        dropped += 1
        waiting += [(nodes, a.args) for a in taken[0].args if a.args and (nodes := a.op.nodes) is not None]
        del taken, name
    return dropped


def constant(value: Number | np.number[Any], error: float = 0.0) -> Expr:
    """The constant node of a real, finite number; `error` is kept with a float."""
    exact = _exact(value)
    name = _number_name(exact)
    if error:
        error = error if type(exact) is float else 0.0
        name = (*name, error) if error else name
    node = _table.get(name)
    if node is not None:
        return node
    fresh = leaf(Constant, CONST, hash((CONST.code, _number_key(exact))))
    _set_value(fresh, exact)
    _set_error(fresh, error)
    return enter(name, fresh)


def _number_name(value: Number) -> tuple[Any, ...]:
    """What a number is called in the table: by whole numbers, as the hash of a fraction takes longer than all else here."""
    if type(value) is Fraction:
        return CONST, CONST, *value.as_integer_ratio()
    return (CONST, value) if type(value) is not Surd else (CONST, value.ratio, value.radicand)


def _number_key(value: Number) -> tuple[int, ...]:
    return (*value.ratio.as_integer_ratio(), value.radicand) if isinstance(value, Surd) else value.as_integer_ratio()


_SHORT = 1024
_WIDE = 2**53


def _exact(value: Any) -> Number:
    """Canonical number: int, Fraction with a short denominator, or float; each value has one form."""
    kind = type(value)
    if kind is int and -_WIDE <= value <= _WIDE:
        return value  # type: ignore[no-any-return]
    if kind is Fraction:
        above, below = value.as_integer_ratio()
        if below <= _SHORT and -_WIDE <= above <= _WIDE:
            return above if below == 1 else value  # type: ignore[no-any-return]
    if type(value) is Surd:
        return (
            value if max(abs(value.ratio.numerator), value.ratio.denominator, value.radicand) <= _WIDE else float(value)
        )
    if kind is not float and isinstance(value, (bool, np.bool_)):
        raise ExpressionError(f"Expected a number, got the truth value {value!r}.")
    if kind is not float and isinstance(value, (int, np.integer)):
        whole = int(value)
        return whole if -_WIDE <= whole <= _WIDE else _rounded(whole)
    if kind is not float and isinstance(value, Fraction):
        if max(abs(value.numerator), value.denominator) > _WIDE or (
            value.denominator > _SHORT and float(value) == value
        ):
            return _rounded(value)
        return value.numerator if value.denominator == 1 else value
    if isinstance(value, (float, np.floating)):
        real = float(value)
        if real != real or real in (float("inf"), float("-inf")):
            raise ExpressionError(
                f"Expected a finite number in an expression, got {real}. Nothing can be computed with it: leave the term out, or give "
                "a large number."
            )
        above, below = real.as_integer_ratio()
        if below <= _SHORT and abs(above) <= _WIDE:
            return above if below == 1 else Fraction(above, below)
        return real
    cure = ""
    if isinstance(value, tuple) and any(isinstance(x, Expr) for x in value):
        cure = " The plurals give tuples: unpack it, as in q1, q2 = kn.coordinates('q1 q2'), or declare one with kn.coordinate(…)."
    elif type(value).__module__.startswith("sympy."):
        cure = f" {_FROM_SYMPY}."
    raise ExpressionError(
        f"Expected a real number or an expression, got {type(value).__name__}: {cut(repr(value), 80)}.{cure}"
    )


def _rounded(value: int | Fraction) -> float:
    """The nearest float; a number beyond their range is refused."""
    try:
        real = float(value)
    except OverflowError:
        real = float("inf")
    if real == 0 or real == float("inf"):
        raise ExpressionError(
            f"Expected a number within the range of floating-point numbers (5e-324 to 1.8e308), got one too "
            f"{'large' if real else 'small'} for it. Take another unit."
        )
    return real


def as_expr(value: Any) -> Expr:
    """`value` as an expression; numbers become constants, everything else is refused."""
    if isinstance(value, Expr):
        return value
    inside: Any = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    return inside if isinstance(inside, Expr) else constant(inside)


_LISTS = frozenset((tuple, list, GeneratorType))
"""What is seen to be a list at once; the classes of other lists take longer to tell."""


def as_exprs(what: str, values: Any) -> tuple[Expr, ...]:
    """Several of them; an ExpressionError for what is no list, a text among that."""
    if type(values) not in _LISTS and (isinstance(values, Mapping) or not is_list(values)):
        raise ExpressionError(f"Expected {what} as a list of expressions, got {cut(repr(values))}.")
    return tuple([x if isinstance(x, Expr) else as_expr(x) for x in values])


def constant_value(node: Expr) -> Number | None:
    """The number of a constant node, else None."""
    return node.value if isinstance(node, Constant) else None


pi = intern_node(PI)
ZERO, ONE, TWO = constant(0), constant(1), constant(2)
Exprs = tuple[Expr, ...]


EPS = 2.0**-52
GIVEN = 4 * EPS
"""Error of a float that was given, over its size: components of a vector that was divided by its length have about one EPS."""
_KEPT = 9 * EPS
"""Error over size from which on a constant carries it; below, it counts as given: products and quotients of floats that were given,
whose errors are 2 GIVEN, are ordinary floats.

Each step of a sum may forget as much, so that it is no larger: of 32 EPS a sum of three terms and their difference from what they
were forgot more than rounding had left there.
"""
_ORDINARY = 32 * EPS
"""Error over size up to which nothing need have cancelled in a constant: that of a product of a few factors that were given.

Weights of constants are multiplied along a chain: were a product's 2, that of fifteen links were 2¹⁵.
"""


def number_of(a: Expr) -> Number:
    """The number of a constant node."""
    return a.value  # type: ignore[attr-defined, no-any-return]


def error_of(a: Expr) -> float:
    """The bound on the error of a constant node."""
    value = number_of(a)
    return _carried(a) or GIVEN * abs(value) if isinstance(value, float) else 0.0


def _carried(a: Expr) -> float:
    return a.error  # type: ignore[attr-defined, no-any-return]


def _certain(value: float, error: float) -> Expr:
    """The constant of a value that was computed with at most that error; ZERO where nothing of it is certain."""
    size = abs(value)
    if size <= error < math.inf:
        return ZERO
    return constant(value, error) if error > _KEPT * size else constant(value)


def total(a: Expr, b: Expr, sign: int = 1) -> Expr:
    """a + sign·b of two constants."""
    value = number_of(a) + sign * number_of(b)
    return _certain(value, error_of(a) + error_of(b)) if type(value) is float else constant(value)


def product(a: Expr, b: Expr) -> Expr:
    """a b of two constants."""
    x, y = number_of(a), number_of(b)
    value = times(x, y)
    return (
        _certain(value, abs(float(x)) * error_of(b) + abs(float(y)) * error_of(a))
        if type(value) is float
        else constant(value)
    )


def quotient(a: Expr, b: Expr) -> Expr:
    """a / b of two constants, b not 0."""
    below = number_of(b)
    value = float(number_of(a) / below)
    return _certain(value, (error_of(a) + abs(value) * error_of(b)) / abs(float(below)))


def turned(a: Expr, quarters: int) -> Expr:
    """sin(a + quarters π/2) of a constant a, quarters 0 or 1."""
    sine, cosine = (value_of_numbers(op, float(number_of(a))) for op in (SIN, COS))
    value, slope = (cosine, sine) if quarters else (sine, cosine)
    return _certain(value, abs(slope) * error_of(a))


def opposite(a: Expr) -> Expr:
    """−a of a constant."""
    return constant(-number_of(a), _carried(a))


def weight(a: Expr) -> float:
    """The size beside which a constant counts as zero: its own, or that of what cancelled in it."""
    size, carried = abs(float(number_of(a))), _carried(a)
    return carried / GIVEN if carried > _ORDINARY * size else size


def precedes(a: Expr, b: Expr) -> bool:
    """Structural order of commutative arguments: constants first, then by key, ties by digest."""
    if a.op is CONST or b.op is CONST:
        return a.op is CONST
    if a.key != b.key:
        return a.key < b.key
    return a is not b and digest(a) < digest(b)


def digest(root: Expr) -> bytes:
    """SHA-256 of the structure, the same in every process."""
    digests: dict[Expr, bytes] = {}
    for node in postorder((root,)):
        text = hashlib.sha256(node.op.name.encode())
        if node.op is CONST:
            text.update(repr(_number_key(node.value)).encode())  # type: ignore[attr-defined]
            text.update(repr(node.error).encode() if node.error else b"")  # type: ignore[attr-defined]
        elif node.op is SYMBOL:
            text.update(repr((type(node).__name__, node.key, node.declaration())).encode())  # type: ignore[attr-defined]
            if isinstance(node.place, Expr):  # type: ignore[attr-defined]
                text.update(digest(node.place))  # type: ignore[attr-defined]
        for a in node.args:
            text.update(digests[a])
        digests[node] = text.digest()
    return digests[root]


def postorder(roots: Iterable[Expr], known: set[Expr] | None = None) -> list[Expr]:
    """Every node below `roots` once, arguments before their users, without recursion; none that is `known`, as it then is."""
    seen = set[Expr]() if known is None else known
    order: list[Expr] = []
    for node in roots:
        if node in seen:
            continue
        waiting: list[tuple[Expr, Iterator[Expr]]] = []
        left = iter(node.args)
        while True:
            for a in left:
                if a not in seen:
                    below = a.args
                    if below:
                        waiting.append((node, left))
                        node, left = a, iter(below)
                        break
                    seen.add(a)
                    order.append(a)
            else:  # all below the node has been seen
                seen.add(node)
                order.append(node)
                if not waiting:
                    break
                node, left = waiting.pop()
    return order


def nodes(roots: Iterable[Expr], known: Set[Expr] = frozenset()) -> set[Expr]:
    """Every node below `roots`, sooner than in order; without those that are `known`, with all below them."""
    seen = set(roots) - known
    found = list(seen)
    for node in found:  # which grows meanwhile
        for a in node.args:
            if a not in seen and (not known or a not in known):
                seen.add(a)
                found.append(a)
    return seen


def _to_rows(root: Expr) -> list[tuple[Any, ...]]:
    """Flat topological table for pickling: depth costs nothing."""
    place: dict[Expr, int] = {}
    rows: list[tuple[Any, ...]] = []
    for node in postorder((root,)):
        place[node] = len(rows)
        if node.op is CONST:
            rows.append(("const", node.value, node.error))  # type: ignore[attr-defined]
        elif node.op is SYMBOL:
            rows.append(("symbol", type(node), node.declaration()))  # type: ignore[attr-defined]
        else:
            rows.append((node.op.name if node.op.name in OPS else node.op, *(place[a] for a in node.args)))
    return rows


def _from_rows(rows: list[tuple[Any, ...]]) -> Expr:
    nodes: list[Expr] = []
    for name, *rest in rows:
        if name == "const":
            nodes.append(constant(*rest))
        elif name == "symbol":
            nodes.append(rest[0].declare(*rest[1]))
        else:
            nodes.append(intern_node(OPS[name] if isinstance(name, str) else name, *(nodes[i] for i in rest)))
    return nodes[-1]
