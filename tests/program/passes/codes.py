# SPDX-License-Identifier: BSD-3-Clause
"""Code for the tests of passes, at random and by hand, and its exact values."""

import mpmath  # type: ignore[import-untyped]
import numpy as np
from hypothesis import strategies as st

import kane as kn
from kane.expr import OPS, intern_node
from kane.program import Code, Task, assembled, build_program, receipt
from tests.program.programs import ports

STATES, PARAMETERS = kn.coordinates("a b c d"), kn.parameters("k l m", 1.5)
PORTS = ports(STATES, PARAMETERS)
SYMBOLS = (kn.time, *STATES, *PARAMETERS)
ARITHMETIC = ("add", "add", "sub", "mul", "mul", "neg", "div")
NUMBERS = st.floats(-4, 4).map(lambda v: round(v, 3))
MP = mpmath.mp.clone()
MP.dps = 100
EPS = np.finfo(float).eps


@st.composite
def expressions(draw, operations=ARITHMETIC, length=40):
    """Expressions that share subexpressions, interned as drawn; few symbols, so that terms and factors come again."""
    pool = [*SYMBOLS, *(kn.parameter("z") * 0 + c for c in (1, 2, -3))]
    for _ in range(draw(st.integers(1, length))):
        op = OPS[draw(st.sampled_from(operations))]
        pool.append(intern_node(op, *(pool[draw(st.integers(0, len(pool) - 1))] for _ in range(op.arity))))
    return [pool[-1 - draw(st.integers(0, min(12, len(pool) - 8)))] for _ in range(draw(st.integers(1, 5)))]


def tree(integer, depth=3):
    """A sum of products of few symbols and of such sums: many factors come again, also after others were taken out.

    `integer(n)` gives a number below n.
    """

    def chained(name, parts):
        total = parts[0]
        for part in parts[1:]:
            op = OPS["sub" if name == "add" and integer(2) else name]
            total = intern_node(op, *((total, part) if integer(2) else (part, total)))
        return total

    def factor(deep):
        return tree(integer, deep - 1) if deep and integer(2) else SYMBOLS[1 + integer(5)]

    return chained(
        "add", [chained("mul", [factor(depth) for _ in range(1 + integer(3))]) for _ in range(2 + integer(2))]
    )


def built(*routines, **options):
    """The Program of a routine a list of expressions."""
    tasks = [
        Task(f"f{k}", roots, (len(roots),), [f"y{i}" for i in range(len(roots))]) for k, roots in enumerate(routines)
    ]
    return build_program("random", PORTS, tasks, **options)


def code(*routines, **options):
    """The same before it is sorted into tiers."""
    p = built(*routines, **options)
    return Code(p.name, p.subject, p.ports, p.constants, p.ops, p.args, p.routines, notes=p.notes)


def costs(made):
    """Operations of each routine."""
    return [operations.total for _, operations in receipt(assembled(made)).routines]


def exact(made, values):
    """All results with 100 digits, None where there is none."""
    v = [MP.mpf(x) for x in (*values, *made.constants)]
    rules = {
        "add": lambda x, y: x + y, "sub": lambda x, y: x - y, "mul": lambda x, y: x * y, "neg": lambda x: -x,
        "div": lambda x, y: x / y if y else None, "sin": MP.sin, "cos": MP.cos, "exp": MP.exp, "tanh": MP.tanh, "abs": abs,
        "sqrt": lambda x: MP.sqrt(x) if x >= 0 else None, "atan": MP.atan, "min": min, "max": max,
    }  # fmt: skip
    for op, reads in zip(made.ops, made.args, strict=True):
        args = [v[i] for i in reads]
        v.append(None if None in args else rules[op.name](*args))
    return [v[i] for routine in made.routines for i in routine.results]
