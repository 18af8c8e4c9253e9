# SPDX-License-Identifier: BSD-3-Clause
"""Optimized code computes the same, in fewer operations, nearly as exactly, and is the same in every process."""

import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.systems import COUNTED
from kane import Handle, Settings
from kane.equations import program
from kane.expr import ADD, MUL, OPS, SUB
from kane.program import Code, Port, Routine, optimize, optimized, receipt, rewritten, rounding
from tests.examples import examples
from tests.program.child import child
from tests.program.emitted import from_c, from_numpy
from tests.program.passes.codes import (
    ARITHMETIC,
    EPS,
    NUMBERS,
    PARAMETERS,
    STATES,
    SYMBOLS,
    built,
    code,
    costs,
    exact,
    expressions,
    tree,
)  # fmt: skip

a, b, c, d = STATES
k, l, m = PARAMETERS
FUNCTIONS = (*ARITHMETIC, *ARITHMETIC, "sqrt", "sin", "abs", "min", "max")
points = st.lists(NUMBERS, min_size=len(SYMBOLS), max_size=len(SYMBOLS))


def cost(*roots, **options):
    """Operations with the state, and of parameters."""
    ((_, found),) = receipt(built(list(roots), reciprocals=True, **options)).routines
    return found.state, found.parameter


class TestRandom:
    @examples(0.5)
    @given(st.lists(expressions(FUNCTIONS), min_size=1, max_size=2), points, st.booleans())
    def test_no_routine_grows_and_values_stay_within_the_bound(self, routines, values, reciprocals):
        made = code(*routines, reciprocals=reciprocals)
        found = rewritten(made)
        assert all(new <= old for new, old in zip(costs(found), costs(made), strict=True))
        for (value, error), right in zip(rounding(found, values), exact(made, values), strict=True):
            if right is not None and error * EPS < 1e-3 * abs(value):
                assert abs(value - right) <= 1.01 * error * EPS / 2 + 1e-300

    @examples(0.5)
    @given(st.lists(expressions(FUNCTIONS), min_size=1, max_size=2))
    def test_the_bound_grows_by_no_more_than_is_said_at_the_points_looked_at(self, routines):
        made = code(*routines)
        found = optimized(made)
        growths = []
        for point in optimize.points(made):
            pairs = zip(rounding(made, point), rounding(found, point), strict=True)
            growths.append([(more + abs(new)) / ((error + abs(old)) or 1) for (old, error), (new, more) in pairs])
        growths = np.array(growths)
        assert not np.any(growths > optimize.AT_ONE)
        with np.errstate(divide="ignore"):
            known = np.isfinite(growths)
            means = np.exp(np.where(known, np.log(growths), 0).sum(0) / np.maximum(known.sum(0), 1))
        assert np.all(means <= optimize.IN_THE_MEAN * (1 + 8 * EPS))

    @pytest.mark.slow
    def test_many_trees(self, rng):
        """Sums in products in sums, most of them read once: what is taken out of one is part of another one."""
        for _ in range(120):
            made = code([tree(lambda n: int(rng.integers(n))) for _ in range(1 + int(rng.integers(2)))])
            found = rewritten(made)
            assert sum(op.cost for op in found.ops) <= sum(op.cost for op in made.ops)
            at = rng.uniform(-2, 2, len(made.inputs)).tolist()
            for (x, error), (y, more) in zip(rounding(made, at), rounding(found, at), strict=True):
                assert abs(x - y) <= (error + more) * EPS / 2

    @examples(0.3)
    @given(expressions(FUNCTIONS))
    def test_twice_is_the_same_text(self, roots):
        first, second = (optimized(code(roots)) for _ in range(2))
        assert (first.ops, first.args, first.constants) == (second.ops, second.args, second.constants)

    @examples(0.04, least=2)
    @given(expressions(ARITHMETIC), st.lists(points, min_size=3, max_size=3))
    def test_every_language_runs_the_same_program(self, tmp_path_factory, roots, rows):
        made, rows = built(roots, reciprocals=True, optimize=True), np.array(rows)
        library = from_c(made, tmp_path_factory.mktemp("c"), contract=False)
        module = from_numpy(made, tmp_path_factory.mktemp("numpy"))
        split = rows[:, 0], rows[:, 1:5], rows[:, 5:]
        right = Handle(made, "f0", Settings(contract=False), None, "ignore")(*split)
        assert np.array_equal(library("f0", rows), right, equal_nan=True)
        assert np.array_equal(module.f0(*split), right, equal_nan=True)


class TestByHand:
    @pytest.mark.parametrize(
        ("roots", "before", "after"),
        [
            ([a * b + a * c], (3, 0), (2, 0)),
            ([a * b - a * c + a * d], (5, 0), (3, 0)),
            ([a * b * c - kn.time * (a * b) + a * b * d], (6, 0), (4, 0)),
            ([a * (b * c) + d * (b * a)], (5, 0), (3, 0)),
            ([a * c + a * d + b * c + b * d], (7, 0), (3, 0)),  # (a + b)(c + d)
            ([(a + b) + c, (a + d) + b, (b - c) + a], (6, 0), (4, 0)),
            ([a * b * kn.sin(c), a * kn.cos(d) * b], (6, 0), (5, 0)),
            ([(a - c) + b, (b - d) - c], (4, 0), (3, 0)),
            ([(a - b) + c, (b + d) - a], (4, 0), (3, 0)),  # the same pair with the other sign
            ([k * a * l], (2, 0), (1, 1)),
            ([k + a + l], (2, 0), (1, 1)),
            ([a / (b + c) + d / (b + c)], (5, 0), (3, 0)),  # one division, no reciprocal
            ([a / (b + c), d / (b + c)], (4, 0), (4, 0)),
            ([a * b, c + d, kn.sin(a)], (3, 0), (3, 0)),
        ],
        ids=str,
    )
    def test_operations(self, roots, before, after):
        assert cost(*roots) == before
        assert cost(*roots, optimize=True) == after

    def test_a_term_that_is_read_elsewhere_stays(self):
        assert cost(a * b + a * c, a * b, a * c, optimize=True) == cost(a * b + a * c, a * b, a * c)

    def test_what_is_known_early_is_summed_first(self):
        """Nothing waits for the sine, though it stands first."""
        made = built([(kn.sin(a) + b) + c + d], optimize=True)
        body = made.routines[0].body
        assert made.op(body[-1]) is ADD
        assert any(made.op(v).name == "sin" for v in made.arguments(body[-1]))

    def test_terms_in_an_order_that_loses_digits_stay_as_they_are(self):
        """|x| − |y| is exact and small beside its terms: z waits for it, though it is known before."""
        x, y, z = kn.parameter("x", 1e16), kn.parameter("y", 1e16 + 2), kn.parameter("z", 0.5)
        port = Port("x", (x, y, z))
        absolute, steps = OPS["abs"], ((0,), (1,), (3, 4), (5, 2))
        routine = Routine("f", (1,), ("f",), (6,))
        made = Code("far", "sums", (port,), (), (absolute, absolute, SUB, ADD), steps, (routine,))
        assert optimized(made) is made
        near = [kn.parameter(s.name, v) for s, v in zip((x, y, z), (3.0, 0.1, 0.5), strict=True)]
        made = Code("near", "sums", (Port("x", tuple(near)),), (), (absolute, absolute, SUB, ADD), steps, (routine,))
        assert optimized(made) is not made

    def test_what_is_finite_nowhere_stays_as_it_is(self):
        made = code([kn.sqrt(-1 - a * a) * b + kn.sqrt(-1 - a * a) * c])
        assert optimized(made) is made


QUICK = ("rolling disk, sliding", "rolling disk, pure rolling", "four-bar", "rattleback", "car with trailer")
LONG = [name for name in COUNTED if name not in QUICK and "free-flyer" not in name]


class TestGallery:
    @pytest.mark.parametrize("name", [*QUICK, *(pytest.param(n, marks=pytest.mark.slow) for n in LONG)])
    def test_no_more_operations_and_the_same_numbers(self, name, rng):
        eom = kn.derive(COUNTED[name]())
        plain, short = (program(eom.solved, ("rhs",), optimize=o) for o in (False, True))
        assert receipt(short)["rhs"].total <= receipt(plain)["rhs"].total
        fixed = [s.default for s in plain.port("p").symbols]
        for _ in range(5):
            at = [*rng.uniform(0.3, 1.2, len(plain.inputs) - len(fixed)), *fixed]
            for (x, error), (y, more) in zip(rounding(plain, at), rounding(short, at), strict=True):
                assert abs(x - y) <= (error + more) * EPS / 2
                assert more + abs(y) <= optimize.AT_ONE * (error + abs(x))

    def test_the_option_of_compile(self):
        eom = kn.derive(COUNTED["rolling disk, sliding"]())
        counts = [eom.compile(**o).operations["rhs"].total for o in ({}, {"optimize": False}, {"contract": False})]
        assert counts[0] < counts[1]
        assert counts[2] == kn.count_operations(eom.right_hand_side).total  # roundings apart, as expressions


HASHED = """
import kane as kn
from kane.equations import program
from kane.gallery import rolling_disk
p = program(kn.derive(rolling_disk.system()).solved)
print([op.name for op in p.ops], p.args, p.hoisted, [r.body for r in p.routines])
"""


@pytest.mark.slow
def test_the_same_program_under_any_hash_seed():
    assert len({child(HASHED, PYTHONHASHSEED=seed) for seed in ("0", "1", "77")}) == 1


# Time -------------------------------------------------------------------------------------------------------------------------


def _mixed(n):
    """Sums of products of few factors: many factors and pairs come again."""
    draw = np.random.default_rng(n)
    steps = []
    for i in range(n):
        near = draw.integers(max(0, i - 60), i + 8, 2)
        steps.append(((MUL, ADD, MUL, SUB)[i % 4], tuple(map(int, near))))
    return steps


def _long_sums(n):
    """Two sums of the same n/3 products, in opposite orders."""
    products = [(MUL, (1 + i % 4, 5 + i % 3)) for i in range(n // 3)]
    steps = products[:]
    for order in (range(len(products)), reversed(range(len(products)))):
        terms = [8 + i for i in order]
        total = terms[0]
        for term in terms[1:]:
            steps.append((ADD, (total, term)))
            total = 7 + len(steps)
    return steps


def _nested(n):
    """((x a + b) a + b) a … and the powers of a, summed."""
    steps, total = [], 1
    for i in range(n // 2):
        steps += [(MUL, (total, 2 + i % 3)), (ADD, (8 + len(steps), 1 + i % 4))]
        total = 7 + len(steps)
    return steps


def _lines(make, n):
    """Lines of the passes that run for n operations."""
    steps = make(n)
    unread = tuple(sorted({8 + i for i in range(len(steps))}.difference(*(r for _, r in steps))))
    goal = Routine("f", (len(unread),), ("",) * len(unread), unread)
    made = Code("long", "sums", built([a]).ports, (), tuple(op for op, _ in steps), tuple(r for _, r in steps), (goal,))
    count = 0

    def inside(frame, event, argument):
        nonlocal count
        count += event == "line"
        return inside

    def entered(frame, event, argument):
        return inside if {"passes", "rewrite"} & set(Path(frame.f_code.co_filename).parts) else None

    before = sys.gettrace()
    sys.settrace(entered)
    try:
        optimized(made)
    finally:
        sys.settrace(before)
    return count


@pytest.mark.slow
@pytest.mark.parametrize("make", [_mixed, _long_sums, _nested])
def test_the_work_grows_with_the_length(make):
    few, many = (_lines(make, n) for n in (200, 2000))
    assert np.log(many / few) / np.log(10) < 1.15
