# SPDX-License-Identifier: BSD-3-Clause
"""Random programs give the same numbers from every emitter.

Without contraction, programs of + − × ÷ √ agree bit by bit: reference evaluator, NumPy module, C, machine code. With contraction the
difference is at most 8 ε times a running error bound (Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed., sec. 3.3).
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import Handle, Settings
from kane.expr import OPS, compile_reference, intern_node
from kane.program import Task, build_program
from tests.examples import examples
from tests.program.emitted import from_c, from_numpy
from tests.program.programs import ports

EPS = np.finfo(float).eps
STATES, PARAMETERS = kn.coordinates("a b c d"), kn.parameters("k l m", 1.0)
PORTS = ports(STATES, PARAMETERS)
SYMBOLS = (kn.time, *STATES, *PARAMETERS)
EXACT = ("add", "sub", "mul", "div", "sqrt")
ROWS = 6

plain = st.floats(-4, 4).map(lambda v: round(v, 3))
awkward = st.sampled_from([0.0, -0.0, 1.0, 5e-324, 1e-310, 1e-160, 1e160, -1.7e308, 1 + EPS])
numbers = st.one_of(plain, plain, plain, awkward)


@st.composite
def programs(draw, operations=EXACT, length=40):
    """Expressions that share subexpressions: interned as drawn, so that no rewriting rule thins them out."""
    pool = [*SYMBOLS, *(kn.parameter("z") * 0 + c for c in (2, -3, 0.1))]
    for _ in range(draw(st.integers(1, length))):
        op = OPS[draw(st.sampled_from(operations))]
        pool.append(intern_node(op, *(pool[draw(st.integers(0, len(pool) - 1))] for _ in range(op.arity))))
    count = draw(st.integers(1, 4))
    return [pool[-1], *(pool[draw(st.integers(0, len(pool) - 1))] for _ in range(count))]


def built(routines, reciprocals=False):
    wanted = [
        Task(f"f{k}", roots, (len(roots),), [f"y{i}" for i in range(len(roots))]) for k, roots in enumerate(routines)
    ]
    return build_program("random", PORTS, wanted, reciprocals)


def rows_of(values):
    return np.array(values, dtype=float).reshape(ROWS, len(SYMBOLS))


def reference(roots, rows):
    run = compile_reference(roots, list(SYMBOLS))
    return np.array([[float(v) for v in run(list(row))] for row in rows])


def machine(program, name, rows, contract, one_by_one):
    handle = Handle(program, name, Settings(contract=contract), None, "ignore")  # from the cache the second time
    split = rows[:, 0], rows[:, 1:5], rows[:, 5:]
    if one_by_one:
        return np.array([handle(t, x.copy(), p.copy()) for t, x, p in zip(*split, strict=True)])
    return handle(*split)


@pytest.mark.slow
@examples(0.4)
@given(st.lists(programs(), min_size=2, max_size=2), st.lists(numbers, min_size=ROWS * 8, max_size=ROWS * 8))
def test_programs_of_exact_operations_agree_bit_by_bit(tmp_path_factory, routines, values):
    rows = rows_of(values)
    program = built(routines)
    module = from_numpy(program, tmp_path_factory.mktemp("numpy"))
    library = from_c(program, tmp_path_factory.mktemp("c"), contract=False)
    for k, roots in enumerate(routines):
        expected = reference(roots, rows)
        found = {
            "machine code": machine(program, f"f{k}", rows, False, False),
            "machine code, row by row": machine(program, f"f{k}", rows, False, True),
            "NumPy": getattr(module, f"f{k}")(rows[:, 0], rows[:, 1:5], rows[:, 5:]),
            "C": library(f"f{k}", rows),
        }
        for name, values_ in found.items():
            assert np.array_equal(values_, expected, equal_nan=True), name
            signs = [np.signbit(v) & ~np.isnan(expected) for v in (values_, expected)]
            assert np.array_equal(*signs), name


# With contraction -----------------------------------------------------------------------------------------------------------


def bounded(node, args):
    """(value, bound on its error in units of ε/2, NaN where nothing can be said) from those of the arguments."""
    name = node.op.name
    v, e = [float(a[0]) for a in args], [a[1] for a in args]
    with np.errstate(all="ignore"):
        z = float(node.op.numpy(*map(np.float64, v)))
        if any(map(np.isnan, e)):
            return z, np.nan
        certain = not any(e)
        size = [abs(x) for x in v]
        if not np.isfinite(z) or not all(map(np.isfinite, v)):
            # infinities and NaN are the same everywhere only where they do not hang on a rounding
            overflow = all(map(np.isfinite, v)) and not (name == "div" and v[1] == 0) and not np.isnan(z)
            return z, (0.0 if certain and not overflow else np.nan)
        if name in ("add", "sub"):
            own = e[0] + e[1] + abs(z)
        elif name == "mul":
            own = size[0] * e[1] + size[1] * e[0] + abs(z) + 2**-1000
        elif name == "div":
            if (
                size[1] <= 16 * EPS * e[1] or not 2**-1020 < size[1] < 2**1020
            ):  # where its reciprocal is a normal number
                return z, np.nan
            own = 2 * (e[0] + abs(z) * e[1]) / size[1] + 3 * abs(z) + 2**-1000  # a reciprocal rounds once more
        elif name == "sqrt":
            if e[0] and size[0] <= 16 * EPS * e[0]:
                return z, np.nan
            own = (e[0] / z if z else 0.0) + abs(z)
        else:
            at = STATES[0]
            (slope,) = node.op.derivative(intern_node(node.op, at), at)
            slope = kn.evaluate(slope, {at: v[0]})
            own = 2 * abs(float(slope)) * e[0] + 4 * abs(z)
        return z, own if np.isfinite(own) and np.isfinite(abs(z) + EPS * own) else np.nan


def running_bound(roots, row):
    from kane.expr import constant_value, postorder

    known = {s: (v, 0.0) for s, v in zip(SYMBOLS, row, strict=True)}
    for node in postorder(roots):
        if node not in known:
            value = constant_value(node)
            known[node] = (
                (float(value), 1.0 * abs(float(value)))
                if value is not None
                else bounded(node, [known[a] for a in node.args])
            )
    return [known[r] for r in roots]


def held(roots, values, rows, name):
    for row, found in zip(rows, values, strict=True):
        for (expected, bound), value in zip(running_bound(roots, row), found, strict=True):
            if np.isnan(bound):
                continue
            if not np.isfinite(expected):
                assert np.array_equal(value, expected, equal_nan=True), name
            else:
                assert abs(value - expected) <= 8 * EPS * bound / 2 + 1e-320, (name, value, expected, bound)


@pytest.mark.slow
@examples(0.4)
@given(st.lists(programs(), min_size=2, max_size=2), st.lists(numbers, min_size=ROWS * 8, max_size=ROWS * 8))
def test_contraction_stays_within_the_running_error_bound(tmp_path_factory, routines, values):
    rows = rows_of(values)
    program = built(routines, reciprocals=True)
    library = from_c(program, tmp_path_factory.mktemp("c"), contract=True)
    for k, roots in enumerate(routines):
        held(roots, machine(program, f"f{k}", rows, True, False), rows, "machine code")
        held(roots, library(f"f{k}", rows), rows, "C")


ALL = (*EXACT, "sin", "cos", "tan", "atan", "exp", "tanh", "abs", "neg")


@pytest.mark.slow
@given(programs((*EXACT[:3], *ALL), 25), st.lists(plain, min_size=ROWS * 8, max_size=ROWS * 8))
def test_functions_stay_within_the_running_error_bound(roots, values):
    rows = rows_of(values)
    for contract in (False, True):
        held(roots, machine(built([roots]), "f0", rows, contract, False), rows, f"contract={contract}")


PIECEWISE = ("min", "max", "less", "where", "sign", "abs", "neg", "add", "mul", "div")


@given(programs(PIECEWISE), st.lists(numbers, min_size=ROWS * 8, max_size=ROWS * 8))
def test_piecewise_operations_agree(roots, values):
    rows = rows_of(values)
    expected = reference(roots, rows)
    found = machine(built([roots]), "f0", rows, False, False)
    assert np.array_equal(found, expected, equal_nan=True)


def test_the_bound_is_not_idle():
    """A result that is off by more than the bound allows is found."""
    a, b = STATES[:2]
    roots = [a * b + a]
    row = np.array([0.0, 1.1, 1.3, 1, 1, 1, 1, 1])
    good = reference(roots, [row])
    held(roots, good, [row], "good")
    with pytest.raises(AssertionError):
        held(roots, good * (1 + 64 * EPS), [row], "bad")
