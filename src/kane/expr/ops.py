# SPDX-License-Identifier: BSD-3-Clause
"""The table of operations: adding an operation is adding a row.

A row gives the name, the arity, the NumPy function, the partial derivatives and the cost. `derivative(node, *args)`
returns one partial derivative an argument, built with the arguments' own operators, so that this file needs no builder.

The cost is what one evaluation counts as: 1 for + − × ÷ √ and each transcendental; 0 for leaves, changes of sign, absolute values,
comparisons and choices.

What never changes is its own copy.
"""

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from kane.errors import Attributes

Derivative = Callable[..., tuple[Any, ...]]

GONE = 2.0**-43
"""Share of the size of its terms, 1.1e-13, at which a divisor is what rounding left of zero.

A power of two changes exponents only."""


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Op:
    """One operation of the expression graph; compared by identity."""

    name: str
    arity: int
    numpy: Callable[..., Any]
    derivative: Derivative | None = None
    cost: int = 1
    ufunc: np.ufunc | None = None
    commutative: bool = False
    code: int = 0
    label: str = ""
    nodes: Any = None
    """The nodes of a row's operation, a dict by their arguments; None for operations that come and go."""

    def __repr__(self) -> str:
        return f"Op({self.name!r})"

    def __reduce__(self) -> "tuple[Callable[[str], Op], tuple[str]]":
        return _named, (self.name,)


def _named(name: str) -> Op:
    return OPS[name]


def _less(x: Any, y: Any) -> Any:
    return np.where(x < y, 1.0, 0.0)[()]  # a number: truth values would add up as "or"


def _where(condition: Any, x: Any, y: Any) -> Any:
    value = np.where(condition, x, y)
    return value if value.ndim else value[()]


def _regular(x: Any, size: Any) -> Any:
    return _where(np.absolute(x) > GONE * size, x, np.nan)


def _power_partials(node: Any, x: Any, p: Any) -> tuple[Any, Any]:
    return p * x ** (p - 1), 0 if p.op is CONST else node * x.log()


def _choice_partials(at_x: Any) -> tuple[Any, Any]:
    return at_x.where(1, 0), at_x.where(0, 1)


_ROWS = (
    Op("const", 0, lambda: None, cost=0),
    Op("pi", 0, lambda: None, cost=0),
    Op("symbol", 0, lambda: None, cost=0),
    Op("add", 2, operator.add, lambda n, x, y: (1, 1), ufunc=np.add, commutative=True),
    Op("sub", 2, operator.sub, lambda n, x, y: (1, -1), ufunc=np.subtract),
    Op("mul", 2, operator.mul, lambda n, x, y: (y, x), ufunc=np.multiply, commutative=True),
    Op("div", 2, operator.truediv, lambda n, x, y: (1 / y, -n / y), ufunc=np.divide),
    Op("neg", 1, operator.neg, lambda n, x: (-1,), cost=0, ufunc=np.negative),
    Op("pow", 2, np.power, _power_partials, ufunc=np.power),
    Op("sqrt", 1, np.sqrt, lambda n, x: (1 / (2 * n),), ufunc=np.sqrt),
    Op("sin", 1, np.sin, lambda n, x: (x.cos(),), ufunc=np.sin),
    Op("cos", 1, np.cos, lambda n, x: (-x.sin(),), ufunc=np.cos),
    Op("tan", 1, np.tan, lambda n, x: (1 + n * n,), ufunc=np.tan),
    Op("asin", 1, np.arcsin, lambda n, x: (1 / (1 - x * x).sqrt(),), ufunc=np.arcsin),
    Op("acos", 1, np.arccos, lambda n, x: (-1 / (1 - x * x).sqrt(),), ufunc=np.arccos),
    Op("atan", 1, np.arctan, lambda n, x: (1 / (1 + x * x),), ufunc=np.arctan),
    Op("atan2", 2, np.arctan2, lambda n, y, x: (x / (x * x + y * y), -y / (x * x + y * y)), ufunc=np.arctan2),
    Op("sinh", 1, np.sinh, lambda n, x: (x.cosh(),), ufunc=np.sinh),
    Op("cosh", 1, np.cosh, lambda n, x: (x.sinh(),), ufunc=np.cosh),
    Op("tanh", 1, np.tanh, lambda n, x: (1 - n * n,), ufunc=np.tanh),
    Op("exp", 1, np.exp, lambda n, x: (n,), ufunc=np.exp),
    Op("log", 1, np.log, lambda n, x: (1 / x,), ufunc=np.log),
    Op("abs", 1, np.absolute, lambda n, x: (x.sign(),), 0, np.absolute),
    Op("sign", 1, np.sign, lambda n, x: (0,), 0, np.sign),
    Op("min", 2, np.minimum, lambda n, x, y: _choice_partials(x.less(y)), 0, np.minimum, commutative=True),
    Op("max", 2, np.maximum, lambda n, x, y: _choice_partials(y.less(x)), 0, np.maximum, commutative=True),
    Op("less", 2, _less, lambda n, x, y: (0, 0), cost=0),
    Op("where", 3, _where, lambda n, c, x, y: (0, *_choice_partials(c)), cost=0),
    Op("regular", 2, _regular, lambda n, x, size: (1, 0), cost=0),
    Op("floor", 1, np.floor, lambda n, x: (0,), cost=0),
)

OPS: dict[str, Op] = {}
UFUNCS: dict[np.ufunc, str] = {}
"""Operations by NumPy's function of them."""
for _code, _row in enumerate(_ROWS):
    object.__setattr__(_row, "code", _code)
    object.__setattr__(_row, "nodes", {})
    OPS[_row.name] = _row
    if _row.ufunc is not None:
        UFUNCS[_row.ufunc] = _row.name


CONST, PI, SYMBOL = OPS["const"], OPS["pi"], OPS["symbol"]
ADD, SUB, MUL, DIV, NEG, POW, SQRT = map(OPS.__getitem__, ("add", "sub", "mul", "div", "neg", "pow", "sqrt"))
SIN, COS, TAN = OPS["sin"], OPS["cos"], OPS["tan"]
LESS, WHERE, REGULAR = OPS["less"], OPS["where"], OPS["regular"]
ABS, SIGN, MIN, MAX = OPS["abs"], OPS["sign"], OPS["min"], OPS["max"]


_STRIDE = 32


class Immutable(Attributes):
    """A copy, a deep one too, is the thing itself: frames, points and records are known by identity."""

    __slots__ = ()

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self


def landmarks(child: Any) -> Sequence[Any]:
    """Some ancestors from the root on, a bounded number of births apart: pickled first, long lines of them need no recursion."""
    line, at = [], child.parent
    while at is not None:
        line.append(at)
        at = at.parent
    return line[::-1][_STRIDE - 1 :: _STRIDE]
