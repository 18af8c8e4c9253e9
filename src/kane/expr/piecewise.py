# SPDX-License-Identifier: BSD-3-Clause
"""Piecewise polynomials f(x) = Σ_j a_ij (x − c_i)^j on piece i as operations of the graph, and the switching surfaces of expressions.

Each piecewise polynomial is an operation of one argument, one object for equal data, whose derivative is another one. It is one
function in expressions and in print; for emitted code it is rewritten in comparisons and choices (`lowered`). A `Table` interpolates
data.

An end of a piece, a comparison or a choice is a switch: a quantity whose zeros separate two smooth forms of an expression.
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise, product
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from kane import expect
from kane.errors import Attributes, ExpressionError, cut
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sub, where
from kane.expr.evaluation import know
from kane.expr.node import ONE, ZERO, Expr, as_expr, constant, constant_value, intern_node, postorder
from kane.expr.ops import ABS, LESS, MAX, MIN, NEG, SIGN, Op
from kane.expr.symbols import Parameter, Symbol
from kane.expr.visit import fold, rebuilt, substituted

Numbers = npt.NDArray[np.float64]
_less, _floor = NODE_BUILDERS["less"], NODE_BUILDERS["floor"]


@dataclass(frozen=True, slots=True, eq=False)
class Data:
    """Pieces separated by `ends` (m − 1), with centers c (m) and coefficients a (m × degree + 1), lowest power first.

    With `period` (x₀, P) x is replaced by x − P ⌊(x − x₀)/P⌋, else the outer pieces extend to infinity. `corners` are the ends at
    which the sides differ.
    """

    ends: Numbers
    centers: Numbers
    coefficients: Numbers
    period: tuple[float, float] | None = None
    corners: tuple[float, ...] = ()

    def digest(self) -> str:
        """A hash of the data, the same in every process."""
        found = hashlib.sha256(repr((self.period, self.corners, self.coefficients.shape)).encode())
        for array in (self.ends, self.centers, self.coefficients):
            found.update(array.astype("<f8").tobytes())
        return found.hexdigest()

    def within(self, x: Any) -> Any:
        """x reduced to the first period."""
        if self.period is None:
            return x
        start, period = self.period
        return x - period * np.floor((x - start) / period)

    def at(self, x: Any) -> Any:
        """Values at numbers or arrays."""
        with np.errstate(invalid="ignore"):
            x = self.within(np.asarray(x, dtype=float))
            piece = np.searchsorted(self.ends, x, side="right")
            d = x - self.centers[piece]
            value = self.coefficients[piece, -1]
            for column in self.coefficients.T[-2::-1]:
                value = value * d + column[piece]
        return np.where(np.isnan(x), np.nan, value)[()]

    def slope(self) -> "Data":
        """The derivative."""
        degrees = np.arange(1, self.coefficients.shape[1])
        own = self.coefficients[:, 1:] * degrees
        return replace(self, coefficients=own if own.size else np.zeros((len(self.centers), 1)))


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Piecewise(Op):
    """The operation of piecewise data; `unit` is that of its values and `of` that of its argument, "" if not given."""

    data: Data = Data(np.zeros(0), np.zeros(1), np.zeros((1, 1)))
    unit: str = ""
    of: str = ""
    order: int = 0
    sides: "tuple[Piecewise, Piecewise, Piecewise] | None" = None
    """Of one with corners: a quantity that changes its sign there, and what the operation is on either side of it."""

    def __repr__(self) -> str:
        return f"Piecewise({self.label!r})"

    def __reduce__(self) -> "tuple[Callable[..., Piecewise], tuple[Any, ...]]":
        sides = None if self.sides is None else tuple(self.sides)
        return piecewise, (self.data, self.label, self.unit, self.of, self.order, sides)


_known: dict[tuple[Any, ...], Piecewise] = {}


def piecewise(
    data: Data,
    label: str,
    unit: str = "",
    of: str = "",
    order: int = 0,
    sides: tuple[Piecewise, Piecewise, Piecewise] | None = None,
) -> Piecewise:
    """The operation of this data and label, one object for equal ones."""
    digest = data.digest()
    own = (digest, label, unit, of, order, None if sides is None else tuple(s.name for s in sides))
    op = _known.get(own)
    if op is None:
        # the name, and the number that expressions are ordered by, say all that it is
        text = hashlib.sha256(repr(own).encode()).hexdigest()
        code = 1000 + int(text[:12], 16)
        given: dict[str, Any] = {"data": data, "unit": unit, "of": of, "order": order, "sides": sides}
        op = Piecewise(f"table {text}", 1, data.at, _slope_of, 1, label=label, code=code, **given)
        op = _known.setdefault(own, op)
        NODE_BUILDERS[op.name] = _builder(op)
        know(op)
    return op


def _slope_of(node: Expr, x: Expr) -> tuple[Any]:
    op: Any = node.op
    if not op.data.coefficients[:, 1:].any():
        return (0,)
    return (NODE_BUILDERS[derivative(op).name](x),)


def derivative(op: Piecewise) -> Piecewise:
    """The operation of the derivative."""
    sides = None
    if op.sides is not None:
        turning, *others = op.sides
        sides = (turning, *map(derivative, others))
    return piecewise(op.data.slope(), f"{op.label}'", op.unit, op.of, op.order + 1, sides)  # type: ignore[arg-type]


def _builder(op: Piecewise) -> Callable[[Expr], Expr]:
    def build(a: Expr) -> Expr:
        value = constant_value(a)
        return intern_node(op, a) if value is None else constant(float(op.data.at(float(value))))

    return build


def lowered(roots: Iterable[Expr], memo: dict[Expr, Expr] | None = None) -> list[Expr]:
    """The expressions with piecewise operations rewritten in comparisons and choices; unchanged without any."""
    wanted = list(roots)
    if not any(isinstance(node.op, Piecewise) for node in postorder(wanted)):
        return wanted
    images: dict[Expr, Expr] = {} if memo is None else memo

    def image(node: Expr) -> Expr:
        args = [images[a] for a in node.args]
        return written(node.op.data, args[0]) if isinstance(node.op, Piecewise) else rebuilt(node, args)

    return [fold(root, images, image) for root in wanted]


def written(data: Data, x: Expr) -> Expr:
    """The value at x, as `Data.at` computes it."""
    if data.period is not None:
        start, period = map(constant, data.period)
        x = sub(x, mul(period, _floor(div(sub(x, start), period))))
    before = [_less(x, constant(float(end))) for end in data.ends]

    def pick(numbers: Numbers) -> Expr:
        return _picked([constant(float(v)) for v in numbers], before)

    d = sub(x, pick(data.centers))
    value = pick(data.coefficients[:, -1])
    for column in data.coefficients.T[-2::-1]:
        value = add(mul(value, d), pick(column))
    return value


def _picked(values: list[Expr], before: list[Expr]) -> Expr:
    """The value for the piece that contains x, by bisection; `before[i]` is the condition that x is before the end of piece i."""
    if len(values) == 1:
        return values[0]
    half = len(values) // 2
    return where(before[half - 1], _picked(values[:half], before), _picked(values[half:], before[half:]))


def applied(op: Piecewise, x: Any) -> Expr:
    """The expression op(x)."""
    return NODE_BUILDERS[op.name](as_expr(x))


_ROUNDED = 1e-9
"""Share of their sizes that values and slopes of two sides differ by at a corner."""
Piece = tuple[float, float, list[float]]
"""Where it ends, its center, its coefficients."""


def with_corners(data: Data, label: str, unit: str, of: str) -> Piecewise:
    """The operation of data; with corners, also those of its two sides and of the quantity that changes sign there."""
    corners = tuple(data.ends[_apart(data) | _apart(data.slope())].tolist())
    if not corners:
        return piecewise(data, label, unit, of)
    if data.period is not None and len(corners) % 2:  # signs must come round
        corners = (data.period[0], *corners)
    data = replace(data, corners=corners)
    turning = piecewise(_turning(data), f"corners of {label}")
    one, other = (piecewise(_side(data, k), f"{label}{'+-'[k]}", unit, of) for k in (0, 1))
    return piecewise(data, label, unit, of, 0, (turning, one, other))


@cache
def leaps(op: Piecewise) -> bool:
    """Whether the operation is discontinuous at an end of a piece."""
    return bool(_apart(op.data).any())


def _apart(data: Data) -> npt.NDArray[np.bool_]:
    """The ends at which the values of the adjacent pieces differ."""
    powers = np.arange(data.coefficients.shape[1])
    before, after = (
        data.coefficients[k : k + len(data.ends)]
        * (data.ends - data.centers[k : k + len(data.ends)])[:, None] ** powers
        for k in (0, 1)
    )
    sizes = np.maximum(np.abs(before).max(axis=1, initial=0), np.abs(after).max(axis=1, initial=0))
    far: npt.NDArray[np.bool_] = np.abs(before.sum(axis=1) - after.sum(axis=1)) > _ROUNDED * sizes
    return far


def _turning(data: Data) -> Data:
    """Piecewise data that changes sign at the corners."""
    corners = list(data.corners)
    if data.period is None:
        bounds = [-np.inf, *corners, np.inf]
    else:
        start, period = data.period
        bounds = [*([corners[-1] - period] if corners[0] > start else []), *corners, corners[0] + period]
    rows, centers = [], []
    for i, (a, b) in enumerate(pairwise(bounds)):
        sign = -1.0 if i % 2 else 1.0
        if np.isinf(a):
            centers.append(b)
            rows.append([0.0, -sign, 0.0])
        else:
            centers.append(a)
            rows.append([0.0, sign, 0.0 if np.isinf(b) else -sign / (b - a)])
    return Data(np.array(bounds[1:-1]), np.array(centers), np.array(rows), data.period)


def _side(data: Data, which: int) -> Data:
    """The data of the side + (0) or − (1), continued across the corners."""
    corners = list(data.corners)
    if data.period is not None:
        corners += [data.period[0] + data.period[1]] if corners[0] > data.period[0] else []
    pieces: list[Piece] = []
    ends = [*data.ends.tolist(), np.inf]
    own = list(zip(ends, data.centers.tolist(), data.coefficients.tolist(), strict=True))
    regions = [-np.inf, *[c for c in corners if np.isfinite(c)], np.inf]
    shift = 1 if data.period is not None and data.corners[0] == data.period[0] else 0
    for i, (a, b) in enumerate(pairwise(regions)):
        inside = [p for k, p in enumerate(own) if p[0] > a and (k == 0 or own[k - 1][0] < b)]
        if (i - shift) % 2 == which or not inside:
            pieces += [(min(end, b), c, row) for end, c, row in inside]
            continue
        before = next((p for p in reversed(own) if p[0] <= a), None)
        after = next((p for k, p in enumerate(own) if k and own[k - 1][0] >= b), None)
        if before is not None and after is not None:
            pieces.append(((a + b) / 2, before[1], before[2]))
        last = after or before
        if last is not None:
            pieces.append((b, last[1], last[2]))
    return Data(
        np.array([end for end, _, _ in pieces[:-1]]),
        np.array([center for _, center, _ in pieces]),
        np.array([row for _, _, row in pieces]),
        data.period,
    )


_OF_TWO = frozenset((LESS, MIN, MAX))


class SwitchedQuantity(NamedTuple):
    """A quantity, and the nodes that switch where it passes zero."""

    quantity: Expr
    nodes: tuple[Expr, ...]


def turning_on(node: Expr) -> tuple[Expr, bool] | None:
    """The quantity of a switch, and whether its sign is that of the node or the opposite; None if the node is no switch.

    A quantity and its negative count as one, so that x < 0 and 0 < x have the same quantity.
    """
    if node.op is ABS or node.op is SIGN:
        c = node.args[0]
    elif isinstance(node.op, Piecewise) and node.op.sides is not None:
        return applied(node.op.sides[0], node.args[0]), True
    elif node.op in _OF_TWO:
        c = sub(node.args[1], node.args[0])
    else:
        return None
    return (c.args[0], False) if c.op is NEG else (c, True)


def switches(roots: Iterable[Expr]) -> tuple[SwitchedQuantity, ...]:
    """The switches in `roots` by quantity, without those whose quantity is piecewise constant or depends on parameters alone."""
    order = postorder(roots)
    varies: dict[Expr, bool] = {}
    found: dict[Expr, list[Expr]] = {}
    for node in order:
        own = turning_on(node)
        if own is not None and any(varies[a] for a in node.args):
            found.setdefault(own[0], []).append(node)
        varies[node] = _varies(node, varies)
    return tuple(SwitchedQuantity(c, tuple(nodes)) for c, nodes in found.items())


def _varies(node: Expr, varies: Mapping[Expr, bool]) -> bool:
    if isinstance(node, Symbol):
        return not isinstance(node, Parameter)
    return node.op is not LESS and node.op is not SIGN and any(varies[a] for a in node.args)


_Choose = Callable[[Expr, Expr], Expr]
_ON_SIDE: dict[Op, Callable[[tuple[Expr, ...], _Choose], Expr]] = {
    ABS: lambda a, choose: choose(a[0], neg(a[0])),
    SIGN: lambda a, choose: choose(ONE, constant(-1)),
    MAX: lambda a, choose: choose(a[1], a[0]),
    MIN: lambda a, choose: choose(a[0], a[1]),
}


def on_sides(root: Expr, sides: Mapping[Expr, Symbol], memo: dict[Expr, Expr]) -> Expr:
    """`root` with every switch of a quantity in `sides` decided by the sign of the side's symbol instead."""

    def replaced(node: Expr) -> Expr:
        args = tuple(memo[a] for a in node.args)
        own = turning_on(node)
        side = sides.get(own[0]) if own is not None else None
        if own is None or side is None:
            return rebuilt(node, args)
        holds = _less(ZERO, side) if own[1] else _less(side, ZERO)
        if isinstance(node.op, Piecewise) and node.op.sides is not None:
            return where(holds, *(applied(op, args[0]) for op in node.op.sides[1:]))
        return holds if node.op is LESS else _ON_SIDE[node.op](args, lambda x, y: where(holds, x, y))

    return fold(root, memo, replaced)


def on_either_side(
    roots: Sequence[Expr],
    at: Mapping[Expr, Expr],
    made: Callable[[Sequence[Expr], Mapping[Expr, Expr]], Sequence[Expr]],
) -> tuple[Sequence[Expr], SwitchedQuantity | None]:
    """The result of `made` for the roots at a point, and the first switch at zero there whose other side gives another result."""
    standing = [s for s in switches(roots) if substituted(s.quantity, at) is ZERO]
    sides, memo = side_symbols(s.quantity for s in standing), dict[Expr, Expr]()
    either = [on_sides(root, sides, memo) for root in roots]

    def on(signs: Sequence[int]) -> Sequence[Expr]:
        return made(either, {**at, **dict(zip(sides.values(), map(as_expr, signs), strict=True))})

    first = on([1] * len(standing))
    for (k, s), others in product(enumerate(standing), (1, -1)):
        one, other = (on([sign if j == k else others for j in range(len(standing))]) for sign in (1, -1))
        if any(a is not b for a, b in zip(one, other, strict=True)):
            return first, s
    return first, None


def side_symbols(quantities: Iterable[Expr]) -> dict[Expr, Symbol]:
    """A symbol for the side of each quantity."""
    return {c: side_symbol(k) for k, c in enumerate(quantities)}


def side_symbol(k: int) -> Symbol:
    """The symbol of the kth side."""
    return Parameter.declare(f"side{k}", 1.0, description="of a switch")


def on(quantities: Iterable[Expr], sides: Iterable[int]) -> Callable[[Expr], Expr]:
    """A function that replaces switches by their forms on the given sides (signs) of quantities."""
    symbols, memo, turned = side_symbols(quantities), dict[Expr, Expr](), dict[Expr, Expr]()
    numbers: dict[Expr, Expr] = dict(zip(symbols.values(), map(constant, sides), strict=True))
    return lambda root: substituted(on_sides(root, symbols, turned), numbers, memo)


Kind = Literal["linear", "cubic", "periodic", "steps"]
_LEAST = {"linear": 2, "cubic": 3, "periodic": 4, "steps": 1}
"""How many points each kind needs."""


@dataclass(frozen=True, slots=True, eq=False)
class Table(Attributes):
    """A function through points, from `kn.table`: called with an expression it gives an expression, with numbers its values."""

    op: Piecewise
    points: tuple[Numbers, Numbers]
    kind: str

    def __call__(self, x: Any) -> Any:
        """The value at x."""
        return applied(self.op, x) if isinstance(x, Expr) else self.op.data.at(x)

    def derivative(self, order: int = 1) -> "Table":
        """The nth derivative, a table too."""
        op = self.op
        for _ in range(order):
            op = derivative(op)
        return Table(op, self.points, self.kind)

    def __repr__(self) -> str:
        x = self.points[0]
        return f"Table({self.op.label}: {len(x)} points, {x[0]:g} … {x[-1]:g}, {self.kind})"


def table(
    x: Sequence[float], y: Sequence[float], kind: Kind = "linear", *, name: str = "table", unit: str = "", of: str = ""
) -> Table:
    """A function of one variable through the points (x, y): `pressure = kn.table(x, y, "periodic")`, then `pressure(q1)`.

    Called with an expression it gives an expression. Its derivatives are exact, and it is part of compiled and emitted code.

    Parameters
    ----------
    x, y : arguments in increasing order, and the values at them
    kind : "linear": straight lines between points; where one of the corners is linearized about, `kn.linearize` needs `side=`.
        "cubic": a twice continuously differentiable spline. "periodic": such a spline with the period x[-1] − x[0], y[-1] = y[0].
        "steps": the value of the last point that is ≤ x. Outside the points a table keeps the value at its end, unless periodic
    name : its name in printed expressions, an identifier
    unit, of : units of the values and of the argument; if they are given, they are checked

    Raises
    ------
    ExpressionError
        if there are too few points, points are not finite or not in increasing order, or y[-1] ≠ y[0] in a periodic table
    """
    places, values = _points(x, y, kind)
    told: dict[str, Any] = {"name": name, "unit": unit, "of": of}
    for what, text in told.items():
        if not isinstance(text, str) or (what == "name" and not text.isidentifier()):
            raise ExpressionError(f"Expected {what} of a table as a text such as 'p', got {cut(repr(text))}.")
    return Table(with_corners(_KINDS[kind](places, values), name, unit, of), (places, values), kind)


def table_of(op: Piecewise) -> Table | None:
    """The table of which an operation is the derivative of its order; none where it is no table's, as one side of a corner."""
    known = [x for x in _known.values() if not x.order and x.label + op.order * "'" == op.label]
    for base in known if op.order else [op]:
        data = base.data
        x, y = (data.ends, data.coefficients[1:, 0]) if data.period is None else (data.centers, data.coefficients[:, 0])
        for kind in _KINDS:
            try:
                made = table(x.tolist(), y.tolist(), kind, name=base.label, unit=base.unit, of=base.of)
            except ExpressionError:
                continue
            if made.op is base and made.derivative(op.order).op is op:
                return made
    return None


def _points(x: Any, y: Any, kind: Any) -> tuple[Numbers, Numbers]:
    expect.one_of(kind, _LEAST, "the kind of a table as", error=ExpressionError)
    try:
        places, values = np.array(expect.reals(x)), np.array(expect.reals(y))
    except (TypeError, ValueError, OverflowError) as error:
        raise ExpressionError(
            f"Expected numbers as the points of a table, got {cut(repr(x))} and {cut(repr(y))}."
        ) from error
    right = places.ndim == 1 and places.shape == values.shape and len(places) >= _LEAST[kind]
    expected = f"at least {_LEAST[kind]} points (x, y) for a table of kind {kind!r}"
    came, cure = f"shapes {places.shape} and {values.shape}", "Give more, or take another kind."
    expect.that(right, expected, came=came, cure=cure, error=ExpressionError)
    finite, cure = np.isfinite(places).all() and np.isfinite(values).all(), "Leave those points out."
    expect.that(finite, "finite points of a table", came="NaN or infinity", cure=cure, error=ExpressionError)
    if (np.diff(places) <= 0).any():
        k = int(np.argmax(np.diff(places) <= 0))
        raise ExpressionError(
            f"Expected increasing points x of a table, got {places[k + 1]:g} after {places[k]:g}. Sort the points; where the value "
            "jumps, take kind='steps', or join the two values over a short interval."
        )
    expected = f"a periodic table to end at the value that it begins with, {values[0]:g}"
    closed, cure = kind != "periodic" or values[0] == values[-1], "Close it by a last point one period after the first."
    expect.that(closed, expected, came=f"{values[-1]:g}", cure=cure, error=ExpressionError)
    return places, values


def _linear(x: Numbers, y: Numbers) -> Data:
    rows = np.column_stack([y[:-1], np.diff(y) / np.diff(x)])
    return _held(x, y, x[:-1], rows)


def _cubic(x: Numbers, y: Numbers) -> Data:
    from scipy.interpolate import CubicSpline

    return _held(x, y, x[:-1], CubicSpline(x, y).c[::-1].T)


def _held(x: Numbers, y: Numbers, centers: Numbers, rows: Numbers) -> Data:
    """Pieces between the points, and what is kept before and beyond them."""
    ends = np.zeros((2, rows.shape[1]))
    ends[:, 0] = y[[0, -1]]
    return Data(x, np.concatenate([x[:1], centers, x[-1:]]), np.vstack([ends[:1], rows, ends[1:]]))


def _periodic(x: Numbers, y: Numbers) -> Data:
    """The period begins in the middle of the first piece, so that every point is between two."""
    from scipy.interpolate import CubicSpline

    rows = CubicSpline(x, y, bc_type="periodic").c[::-1].T
    period = float(x[-1] - x[0])
    start = float((x[0] + x[1]) / 2)
    return Data(x[1:], x, np.vstack([rows, rows[:1]]), (start, period))


def _steps(x: Numbers, y: Numbers) -> Data:
    return Data(x, np.concatenate([x[:1], x]), np.concatenate([y[:1], y])[:, None])


_KINDS: dict[Kind, Callable[[Numbers, Numbers], Data]] = {
    "linear": _linear,
    "cubic": _cubic,
    "periodic": _periodic,
    "steps": _steps,
}
