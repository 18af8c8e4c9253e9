# SPDX-License-Identifier: BSD-3-Clause
"""The table of operations: adding an operation is adding a row.

A row gives the name, the arity, the NumPy function, the partial derivatives and the cost. `derivative(node, *args)`
returns one partial derivative an argument, built with the arguments' own operators, so that this file needs no builder.

`c` is the C expression of the arguments {0}, {1}, …; `llvm` the lines of LLVM's text for the value {r}, with {f} for flags
of floating-point contraction.

The cost is what one evaluation counts as: 1 for + − × ÷ √ and each transcendental, 0 for leaves and a change of sign.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

Derivative = Callable[..., tuple[Any, ...]]


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Op:
    """One operation of the expression graph; compared by identity."""

    name: str
    arity: int
    numpy: Callable[..., Any] | None = None
    derivative: Derivative | None = None
    cost: int = 1
    ufunc: np.ufunc | None = None
    infix: str = ""
    commutative: bool = False
    c: str = ""
    llvm: str = ""
    code: int = 0

    def __repr__(self) -> str:
        return f"Op({self.name!r})"

    def __reduce__(self) -> tuple[Callable[[str], Op], tuple[str]]:
        return _named, (self.name,)


def _named(name: str) -> Op:
    return OPS[name]


def _less(x: Any, y: Any) -> Any:
    return np.where(x < y, 1.0, 0.0)[()]  # a number: truth values would add up as "or"


def _where(condition: Any, x: Any, y: Any) -> Any:
    value = np.where(condition, x, y)
    return value if value.ndim else value[()]


def _power_partials(node: Any, x: Any, p: Any) -> tuple[Any, Any]:
    return p * x ** (p - 1), 0 if p.op is CONST else node * x.log()


def _max_partials(_node: Any, x: Any, y: Any) -> tuple[Any, Any]:
    at_x = y.less(x)
    return at_x.where(1, 0), at_x.where(0, 1)


def _min_partials(_node: Any, x: Any, y: Any) -> tuple[Any, Any]:
    at_x = x.less(y)
    return at_x.where(1, 0), at_x.where(0, 1)


_BINARY = "{{r}} = {} {{f}}double {{0}}, {{1}}"
_LIBRARY = "{{r}} = call double @{}(double {{0}})"
_LIBRARY_2 = "{{r}} = call double @{}(double {{0}}, double {{1}})"


def _ordered(compare: str) -> str:
    """The argument that compares so with the other; a NaN is passed on, as NumPy does."""
    return (
        f"{{r}}.a = fcmp {compare} double {{0}}, {{1}}\n{{r}}.b = fcmp uno double {{0}}, {{0}}\n"
        "{r}.c = or i1 {r}.a, {r}.b\n{r} = select i1 {r}.c, double {0}, double {1}"
    )


_SIGN = (
    "{r}.a = fcmp ogt double {0}, 0.0\n{r}.b = select i1 {r}.a, double 1.0, double {0}\n"
    "{r}.c = fcmp olt double {0}, 0.0\n{r}.d = select i1 {r}.c, double -1.0, double {r}.b\n"
    "{r} = fadd double {r}.d, 0.0"
)
_LESS = "{r}.c = fcmp olt double {0}, {1}\n{r} = uitofp i1 {r}.c to double"
_WHERE = "{r}.c = fcmp une double {0}, 0.0\n{r} = select i1 {r}.c, double {1}, double {2}"


def _function(name: str, numpy: np.ufunc, derivative: Derivative) -> Op:
    """A function of one argument that the C library has under the same name."""
    return Op(name, 1, numpy, derivative, ufunc=numpy, c=f"{name}({{0}})", llvm=_LIBRARY.format(name))


_ROWS = (
    Op("const", 0, cost=0),
    Op("pi", 0, cost=0),
    Op("symbol", 0, cost=0),
    Op(
        "add",
        2,
        operator.add,
        lambda n, x, y: (1, 1),
        ufunc=np.add,
        infix="+",
        commutative=True,
        c="{0} + {1}",
        llvm=_BINARY.format("fadd"),
    ),
    Op(
        "sub",
        2,
        operator.sub,
        lambda n, x, y: (1, -1),
        ufunc=np.subtract,
        infix="-",
        c="{0} - {1}",
        llvm=_BINARY.format("fsub"),
    ),
    Op(
        "mul",
        2,
        operator.mul,
        lambda n, x, y: (y, x),
        ufunc=np.multiply,
        infix="*",
        commutative=True,
        c="{0} * {1}",
        llvm=_BINARY.format("fmul"),
    ),
    Op(
        "div",
        2,
        operator.truediv,
        lambda n, x, y: (1 / y, -n / y),
        ufunc=np.divide,
        infix="/",
        c="{0} / {1}",
        llvm=_BINARY.format("fdiv"),
    ),
    Op(
        "neg", 1, operator.neg, lambda n, x: (-1,), cost=0, ufunc=np.negative, c="-{0}", llvm="{r} = fneg {f}double {0}"
    ),
    Op(
        "pow",
        2,
        np.power,
        _power_partials,
        ufunc=np.power,
        infix="**",
        c="pow({0}, {1})",
        llvm=_LIBRARY_2.format("pow"),
    ),
    Op(
        "sqrt",
        1,
        np.sqrt,
        lambda n, x: (1 / (2 * n),),
        ufunc=np.sqrt,
        c="sqrt({0})",
        llvm=_LIBRARY.format("llvm.sqrt.f64"),
    ),
    _function("sin", np.sin, lambda n, x: (x.cos(),)),
    _function("cos", np.cos, lambda n, x: (-x.sin(),)),
    _function("tan", np.tan, lambda n, x: (1 + n * n,)),
    _function("asin", np.arcsin, lambda n, x: (1 / (1 - x * x).sqrt(),)),
    _function("acos", np.arccos, lambda n, x: (-1 / (1 - x * x).sqrt(),)),
    _function("atan", np.arctan, lambda n, x: (1 / (1 + x * x),)),
    Op(
        "atan2",
        2,
        np.arctan2,
        lambda n, y, x: (x / (x * x + y * y), -y / (x * x + y * y)),
        ufunc=np.arctan2,
        c="atan2({0}, {1})",
        llvm=_LIBRARY_2.format("atan2"),
    ),
    _function("sinh", np.sinh, lambda n, x: (x.cosh(),)),
    _function("cosh", np.cosh, lambda n, x: (x.sinh(),)),
    _function("tanh", np.tanh, lambda n, x: (1 - n * n,)),
    _function("exp", np.exp, lambda n, x: (n,)),
    _function("log", np.log, lambda n, x: (1 / x,)),
    Op(
        "abs",
        1,
        np.abs,
        lambda n, x: (x.sign(),),
        ufunc=np.absolute,
        c="fabs({0})",
        llvm=_LIBRARY.format("llvm.fabs.f64"),
    ),
    Op(
        "sign",
        1,
        np.sign,
        lambda n, x: (0,),
        ufunc=np.sign,
        c="{0} != {0} ? {0} : ({0} > 0.0) - ({0} < 0.0)",
        llvm=_SIGN,
    ),
    Op(
        "min",
        2,
        np.minimum,
        _min_partials,
        ufunc=np.minimum,
        commutative=True,
        c="{0} < {1} || {0} != {0} ? {0} : {1}",
        llvm=_ordered("olt"),
    ),
    Op(
        "max",
        2,
        np.maximum,
        _max_partials,
        ufunc=np.maximum,
        commutative=True,
        c="{0} > {1} || {0} != {0} ? {0} : {1}",
        llvm=_ordered("ogt"),
    ),
    Op("less", 2, _less, lambda n, x, y: (0, 0), infix="<", c="{0} < {1}", llvm=_LESS),
    Op(
        "where",
        3,
        _where,
        lambda n, c, x, y: (0, c.where(1, 0), c.where(0, 1)),
        c="{0} != 0.0 ? {1} : {2}",
        llvm=_WHERE,
    ),
)

OPS: dict[str, Op] = {}
for _code, _row in enumerate(_ROWS):
    object.__setattr__(_row, "code", _code)
    OPS[_row.name] = _row

UFUNCS: dict[np.ufunc, str] = {row.ufunc: row.name for row in _ROWS if row.ufunc is not None}

CONST, PI, SYMBOL = OPS["const"], OPS["pi"], OPS["symbol"]
ADD, SUB, MUL, DIV, NEG, POW, SQRT = (OPS[k] for k in ("add", "sub", "mul", "div", "neg", "pow", "sqrt"))
SIN, COS, TAN = OPS["sin"], OPS["cos"], OPS["tan"]
LESS, WHERE = OPS["less"], OPS["where"]
