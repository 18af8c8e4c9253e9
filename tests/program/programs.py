# SPDX-License-Identifier: BSD-3-Clause
"""Small Programs for the emitters' tests: by hand, and at random over all operations.

In a random program every value is a result of the routine "all". What an emitter makes of it is then checked one operation
at a time, at the arguments that the emitted code itself had: an error cannot hide behind another one, nor grow.
"""

import itertools
import os
import shutil
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from kane import Expr, Symbol, coordinates, input, parameters, time
from kane.expr import OPS, postorder
from kane.program import Code, Port, Program, Routine, assembled
from tests.expr.expressions import Program as Drawn

EXACT = ("add", "sub", "mul", "div", "neg", "sqrt", "abs", "sign", "min", "max", "less", "where")
"""Operations whose result IEEE 754 or the contract of emitters fixes to the last bit."""
LIBRARY = tuple(name for name, op in OPS.items() if op.arity and name not in EXACT)
SPECIAL = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -2.5,
    0.1,
    3e-310,
    5e-324,
    -1e-200,
    1e200,
    -1.7976931348623157e308,
    1e16,
    262145.5,
)
Step = tuple[str, Sequence[int]]


def compiler(name: str = "cc") -> str:
    """A compiler's path. Where there is none the test is skipped, but fails under CI or KANE_FULL."""
    found = shutil.which(name)
    if found is None:
        (pytest.fail if os.environ.get("CI") or os.environ.get("KANE_FULL") else pytest.skip)(f"no compiler {name}")
    return found


def ports(x: Sequence[Symbol], p: Sequence[Symbol] = (), r: Sequence[Symbol] = ()) -> tuple[Port, ...]:
    """The ports of equations of motion: t, x, p, r."""
    return (
        Port("t", (time,), scalar=True, noun="time"),
        Port("x", tuple(x), noun="state", nouns="states"),
        Port("p", tuple(p), "parameter", noun="parameters"),
        Port("r", tuple(r), noun="inputs", optional=True),
    )


def small(
    steps: Sequence[Step] = (),
    results: Sequence[int] = (),
    *,
    x: Sequence[Symbol] = coordinates("q1:3"),
    p: Sequence[Symbol] = parameters("m, k", 2.5),
    r: Sequence[Symbol] = (),
    constants: Sequence[float] = (),
    name: str = "small",
    labels: Sequence[str] | None = None,
    goals: Sequence[Routine] | None = None,
) -> Program:
    """A program with the routine "f" of the values `results`, which are numbered: t, x, p, r, constants, steps."""
    named = tuple(labels) if labels is not None else tuple(f"y{k}" for k in range(len(results)))
    wanted = tuple(goals or [Routine("f", (len(results),), named, tuple(results))])
    ops, args = tuple(OPS[op] for op, _ in steps), tuple(tuple(reads) for _, reads in steps)
    return assembled(Code(name, "equations of motion", ports(x, p, r), tuple(constants), ops, args, wanted))


@st.composite
def programs(draw: st.DrawFn, operations: Sequence[str] = EXACT + LIBRARY, most: int = 40) -> Program:
    """A program with the routines "all" (every value), "some" (a few, in any order, some twice) and "none"."""
    x = coordinates("a, b, c")[: draw(st.integers(0, 3))]
    p = parameters("k, l", 0.5)[: draw(st.integers(0, 2))]
    r = (input("f"),)[: draw(st.integers(0, 1))]
    constants = draw(st.lists(st.sampled_from(SPECIAL), max_size=3))
    first = count = 1 + len(x) + len(p) + len(r) + len(constants)
    steps: list[Step] = []
    for _ in range(draw(st.integers(0, most))):
        name = draw(st.sampled_from(operations))
        near = st.integers(max(0, count - 5), count - 1)
        steps.append((name, [draw(st.one_of(near, st.integers(0, count - 1))) for _ in range(OPS[name].arity)]))
        count += 1
    some = draw(st.lists(st.integers(0, count - 1), max_size=6))
    goals = [
        Routine("all", (count,), tuple(f"v{i}" for i in range(count)), tuple(range(count))),
        Routine("some", (1, len(some)), tuple(f"w{i}" for i in some), tuple(some)),
        Routine("none", (0,), (), ()),
    ]
    made = small(steps, x=x, p=p, r=r, constants=constants, goals=goals, name="random")
    assert made.first == first
    return made


NUMBERS = st.one_of(
    st.sampled_from((*SPECIAL, float("inf"), float("-inf"), float("nan"))), st.floats(-4, 4), st.floats()
)


def points(program: Program, count: int) -> st.SearchStrategy[list[list[float]]]:
    """Values of all inputs at `count` points."""
    point = st.lists(NUMBERS, min_size=len(program.inputs), max_size=len(program.inputs))
    return st.lists(point, min_size=count, max_size=count)


def every_operation() -> Program:
    """Each operation once, of the first states."""
    steps = [(name, range(1, 1 + op.arity)) for name, op in OPS.items() if op.arity]
    results = range(4 + len(steps))
    goal = Routine("all", (len(results),), ("",) * len(results), tuple(results))
    return small(steps, x=coordinates("a, b, c"), p=(), goals=[goal], name="every")


def grid() -> np.ndarray:
    """Points for `every_operation`: each pair of special numbers."""
    numbers = [*SPECIAL, np.inf, -np.inf, np.nan]
    return np.array([[0.0, a, b, 3.0] for a, b in itertools.product(numbers, numbers)])


def exact_results(example: Drawn) -> list[Expr]:
    """The expressions of a drawn example in which every operation is exact."""
    exact = {"const", "pi", "symbol", *EXACT}
    return [root for root in dict.fromkeys(example.nodes()) if exact.issuperset(n.op.name for n in postorder([root]))]


def by_port(program: Program, values: Any) -> dict[str, Any]:
    """Values on the last axis, port by port."""
    ends = np.cumsum([len(port.symbols) for port in program.ports])[:-1]
    names = [port.name for port in program.ports]
    return dict(zip(names, np.split(np.asarray(values, dtype=float), ends, axis=-1), strict=True))


def bits(values: Any) -> list[int]:
    """Doubles as integers; one number for all NaNs, whose bits nobody promises."""
    array = np.array(values, dtype=float, copy=True).reshape(-1)
    array[np.isnan(array)] = np.nan
    return list(array.view(np.int64))


def assert_each_operation_right(program: Program, values: Any, ulps: float = 4) -> None:
    """`values[i, …]`, what emitted code has for each value i, against NumPy's operation at the code's own arguments."""
    for i in range(program.first, len(values)):
        op = program.op(i)
        arguments = [np.ascontiguousarray(values[a]) for a in program.arguments(i)]
        with np.errstate(all="ignore"):
            expected = np.asarray(op.numpy(*arguments), dtype=float)
        what = f"{op.name}{arguments} = {values[i]}, NumPy has {expected}"
        if op.name == "pow":  # NumPy takes √ where one exponent ½ serves a whole array, else pow: they differ at −∞
            expected = np.where((arguments[0] == -np.inf) & (arguments[1] == 0.5), values[i], expected)
        if op.name in EXACT:
            assert bits(values[i]) == bits(expected), what
        else:
            assert np.all(_distance(values[i], expected) <= ulps), what


def _distance(a: Any, b: Any) -> Any:
    """The distance in units of the last place; 0 where both are NaN or both the same infinity."""
    with np.errstate(all="ignore"):
        same = (a == b) | (np.isnan(a) & np.isnan(b))
        return np.where(same, 0.0, np.abs(a - b) / np.spacing(np.maximum(np.abs(a), np.abs(b))))


EDGES: dict[str, Callable[[], Program]] = {
    "nothing at all": lambda: small(x=(), p=()),
    "an input, a constant and the time": lambda: small((), (1, 5, 0, 5), constants=(-1.5,)),
    "a hoisted value": lambda: small([("mul", (3, 4))], (5,)),
    "a hoisted value and no other use of parameters": lambda: small([("mul", (3, 4)), ("add", (5, 1))], (6,)),
    "no parameters": lambda: small([("sin", (1,))], (3,), p=()),
    "no state": lambda: small([("neg", (0,))], (3,), x=()),
    "one value four times": lambda: small([("cos", (1,))], (5, 5, 5, 5)),
    "constants alone": lambda: small(
        [("div", (5, 6)), ("neg", (5,)), ("sub", (6, 5))], (7, 8, 9), constants=(-1.0, 0.0)
    ),
    "a number": lambda: small(goals=[Routine("f", (), ("y",), (1,))]),
    "numbers that are hard to print": lambda: small(
        [("add", (1, k)) for k in range(5, 5 + len(SPECIAL))], range(5, 5 + 2 * len(SPECIAL)), constants=SPECIAL
    ),
}
"""Programs in which something is missing or unusual."""

_HOSTILE = (
    "double class I NAN EOF y0 j1 sin linux x p0 out h z1 h0 w and lambda np None q1' θ₁ ω C* 2x _a a__b a-b a+b x2 x0 hoist "
    'small_f DEFAULTS shape f kane_sincos KANE_PART uint64_t memcpy a"b a\\b */x ??/ // #'
)
HOSTILE_NAMES = tuple(_HOSTILE.split())
"""Names of inputs that identifiers in C or Python cannot have, or that mean something else there."""
NASTY = st.text(st.sampled_from(list("*/\\?\"'%{}#=()<>!-&nx0 \n\r\t\0\x7f\x85\u2028\u202eé∂🤸")), max_size=30)
"""Text that tries to leave its literal or comment."""
