# SPDX-License-Identifier: BSD-3-Clause
"""Random expressions over all operations, as programs that two routes can run: our builders, and mpmath with 50 digits.

A program keeps away from places where an operation is not smooth or not defined, and from large numbers, so that both
routes must agree to many digits.
"""

from __future__ import annotations

import os
import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath  # type: ignore[import-untyped]
from hypothesis import strategies as st

from kane import Expr, coordinates, parameter, pi, speed
from kane.expr import NODE_BUILDERS, as_expr, constant_value, postorder

DEEP = 100_000 if os.environ.get("KANE_FULL") else 20_000
"""How deep a graph must be to show recursion: Python's own limit is at 1,000 calls."""
MP = mpmath.mp.clone()
MP.dps = 50

X, Y = coordinates("x, y")
U = speed("u")
M = parameter("m")
LEAVES = (X, Y, U, M)
CONSTANTS = (
    0,
    1,
    -1,
    2,
    3,
    Fraction(1, 2),
    Fraction(-2, 3),
    0.3,
    -1.7,
    pi,
    pi / 2,
    -pi / 2,
    2 * pi,
    pi + X,
    X - pi / 2,
)

ROUTES: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    "pow": lambda a, b: MP.power(a, b),
    "sqrt": lambda a: MP.sqrt(a),
    "sin": lambda a: MP.sin(a),
    "cos": lambda a: MP.cos(a),
    "tan": lambda a: MP.tan(a),
    "asin": lambda a: MP.asin(a),
    "acos": lambda a: MP.acos(a),
    "atan": lambda a: MP.atan(a),
    "atan2": lambda a, b: MP.atan2(a, b),
    "sinh": lambda a: MP.sinh(a),
    "cosh": lambda a: MP.cosh(a),
    "tanh": lambda a: MP.tanh(a),
    "exp": lambda a: MP.exp(a),
    "log": lambda a: MP.log(a),
    "abs": lambda a: abs(a),
    "sign": lambda a: MP.sign(a),
    "min": lambda a, b: min(a, b),
    "max": lambda a, b: max(a, b),
    "less": lambda a, b: a < b,
    "where": lambda c, a, b: a if c else b,
    "floor": lambda a: MP.floor(a),
}
OPERATIONS = tuple(name for name in ROUTES if name != "less")  # `where` brings its own
SMOOTH = tuple(name for name in ROUTES if name not in ("abs", "sign", "min", "max", "less", "where", "floor"))
_SAFE: dict[str, Callable[..., bool]] = {
    "div": lambda a, b: abs(b) > 0.1,
    "pow": lambda a, b: 0.1 < a < 5 and abs(b) < 3,
    "sqrt": lambda a: a > 0.1,
    "tan": lambda a: abs(MP.cos(a)) > 0.1,
    "asin": lambda a: abs(a) < 0.9,
    "acos": lambda a: abs(a) < 0.9,
    "atan2": lambda a, b: a * a + b * b > 0.1 and (b > 0.1 or abs(a) > 0.1),
    "log": lambda a: a > 0.1,
    "abs": lambda a: abs(a) > 0.01,
    "sign": lambda a: abs(a) > 0.01,
    "floor": lambda a: abs(a - MP.nint(a)) > 0.01,
    "min": lambda a, b: abs(a - b) > 0.01,
    "max": lambda a, b: abs(a - b) > 0.01,
}
_LARGE = 100


@dataclass(frozen=True)
class Program:
    """Steps (operation, places of the arguments) after constants and leaves; `values` are those of the leaves."""

    values: tuple[float, ...]
    steps: tuple[tuple[str, tuple[int, ...]], ...]

    def nodes(self) -> list[Expr]:
        """All expressions of the program, by our builders."""
        made = [*map(as_expr, CONSTANTS), *LEAVES]
        for name, places in self.steps:
            args = [made[i] for i in places]
            if name == "where":
                args = [NODE_BUILDERS["less"](args[0], args[1]), args[2], args[3]]
            made.append(NODE_BUILDERS[name](*args))
        return made

    @property
    def root(self) -> Expr:
        return self.nodes()[-1]

    def direct(self, values: Iterable[Any] | None = None) -> list[Any]:
        """All values by mpmath, operation by operation, without the graph."""
        given = [MP.mpf(v) for v in (self.values if values is None else values)]
        made = [*_constants(given), *given]
        for name, places in self.steps:
            made.append(_step(name, [made[i] for i in places]))
        return made

    @property
    def at(self) -> dict[Expr, float]:
        return dict(zip(LEAVES, self.values, strict=True))


def _constants(given: list[Any]) -> list[Any]:
    return [
        value_of(c, given)
        if isinstance(c, Expr)
        else MP.mpf(c.numerator) / c.denominator
        if isinstance(c, Fraction)
        else MP.mpf(c)
        for c in CONSTANTS
    ]


def _step(name: str, args: list[Any]) -> Any:
    return ROUTES["where"](args[0] < args[1], args[2], args[3]) if name == "where" else ROUTES[name](*args)


def values_of(roots: list[Expr], given: Iterable[Any]) -> list[Any]:
    """Values of graph nodes by mpmath."""
    known: dict[Expr, Any] = dict(zip(LEAVES, [MP.mpf(v) for v in given], strict=True))
    for node in postorder(roots):
        if node in known:
            continue
        number = constant_value(node)
        if number is not None:
            known[node] = (
                MP.mpf(number.numerator) / number.denominator if isinstance(number, Fraction) else MP.mpf(number)
            )
        elif node is pi:
            known[node] = +MP.pi
        else:
            known[node] = ROUTES[node.op.name](*[known[a] for a in node.args])
    return [known[r] for r in roots]


def identical(a: Iterable[object], b: Iterable[object]) -> bool:
    """The same objects in the same order: expressions refuse `==`."""
    return [id(i) for i in a] == [id(i) for i in b]


def value_of(root: Expr, given: Iterable[Any]) -> Any:
    return values_of([root], given)[0]


def draw_program(
    integer: Callable[[int, int], int],
    operations: tuple[str, ...] = OPERATIONS,
    length: int = 14,
) -> Program:
    """A program from a source of integers `integer(least, most)`; what would be unsafe becomes a sum or a sine."""
    values = tuple(sign * (0.2 + integer(0, 1000) / 700) for sign in (1, -1, 1, 1))
    known = Program(values, ()).direct()
    steps: list[tuple[str, tuple[int, ...]]] = []
    for _ in range(integer(1, length)):
        name = operations[integer(0, len(operations) - 1)]
        arity = 4 if name == "where" else ROUTES[name].__code__.co_argcount
        places = tuple(_place(integer, len(known)) for _ in range(arity))
        args = [known[i] for i in places]
        safe = _SAFE.get(name, lambda *a: True)(*args) if name != "where" else abs(args[0] - args[1]) > 0.01
        value = _step(name, args) if safe else None
        if value is None or abs(value) > _LARGE:
            name, places = "sin", places[-1:]
            value = _step(name, [known[places[0]]])
        steps.append((name, places))
        known.append(value)
    return Program(values, tuple(steps))


def _place(integer: Callable[[int, int], int], known: int) -> int:
    """Mostly a recent result, for depth; else a leaf, now and then a constant."""
    kind = integer(0, 7)
    if kind < 5:
        return known - 1 - integer(0, 5)
    return len(CONSTANTS) + integer(0, len(LEAVES) - 1) if kind < 7 else integer(0, len(CONSTANTS) - 1)


@st.composite
def programs(draw: st.DrawFn, operations: tuple[str, ...] = OPERATIONS, length: int = 14) -> Program:
    """Hypothesis strategy."""
    return draw_program(lambda a, b: draw(st.integers(a, b)), operations, length)


def random_program(seed: int, length: int = 14) -> Program:
    """The same random program for the same seed."""
    return draw_program(random.Random(seed).randint, length=length)
