# SPDX-License-Identifier: BSD-3-Clause
"""The table of nodes: interning, identity, refusals, pickling, threads, memory."""

import copy
import gc
import math
import pickle
import subprocess
import sys
import threading
import weakref
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given

import kane as kn
from kane import Expr, Rational, Symbol, coordinate, coordinates, parameter, pi, speed
from kane.errors import ExpressionError
from kane.expr import (
    ADD,
    MUL,
    NODE_BUILDERS,
    OPS,
    as_expr,
    constant,
    constant_value,
    digest,
    intern_node,
    node,
    postorder,
    precedes,
)
from tests.expr.expressions import DEEP, Program, programs, random_program

x, y = coordinates("x, y")


def deep(n: int = DEEP) -> Expr:
    e: Expr = x
    for _ in range(n // 2):
        e = (e + y).sin()
    return e


def test_equal_structure_is_the_same_object() -> None:
    assert (x + y) * y.sin() is (y + x) * y.sin()
    assert x.atan2(y) is not y.atan2(x)


@given(programs())
def test_building_again_gives_the_same_nodes(program: Program) -> None:
    assert all(a is b for a, b in zip(program.nodes(), program.nodes(), strict=True))


def test_equality_hash_is_identity() -> None:
    assert {x: 1, y: 2}[y] == 2
    assert x in {x}
    assert x not in {y}


@pytest.mark.parametrize(
    ("compare", "sign", "cure"),
    [
        (lambda: x == y, "`==`", "`a is b`"),
        (lambda: x != y, "`!=`", "`a is not b`"),
        (lambda: x == 1, "`==`", "dict or set"),
        (lambda: x in [y], "`==`", "not a list"),
        (lambda: x < y, "`<`", "kn.where(kn.less(a, b), x, y)"),
        (lambda: x > 0, "`>`", "kn.where(kn.less(b, a), x, y)"),
        (lambda: x <= y, "`<=`", "kn.where(kn.less(b, a), y, x)"),
        (lambda: x >= y, "`>=`", "kn.where(kn.less(a, b), y, x)"),
        (lambda: bool(x), "`if`", "kn.where"),
        (lambda: not x.less(y), "`if` on x < y", "kn.where"),
        (lambda: max([x, y]), "`>`", "kn.where"),
    ],
)
def test_truth_values_are_refused_with_the_cure(compare, sign: str, cure: str) -> None:
    with pytest.raises(ExpressionError) as refused:
        compare()
    assert sign in str(refused.value)
    assert cure in str(refused.value)


def test_expr_cannot_be_called_or_changed() -> None:
    with pytest.raises(ExpressionError, match="operators and functions on symbols"):
        Expr()
    with pytest.raises(AttributeError, match="immutable: 'key'"):
        x.key = 1
    with pytest.raises(AttributeError, match="cannot be deleted"):
        del x.args
    with pytest.raises(AttributeError):
        x.colour = "red"


def test_float_of_an_expression() -> None:
    assert float(Rational(1, 4)) == 0.25
    with pytest.raises(ExpressionError, match=r"kn\.evaluate"):
        float(x + 1)


@pytest.mark.parametrize(
    ("value", "kept"),
    [
        (3, 3),
        (3.0, 3),
        (-0.0, 0),
        (0.5, Fraction(1, 2)),
        (Fraction(1, 3), Fraction(1, 3)),
        (Fraction(4, 2), 2),
        (0.1, 0.1),
        (1 / 3, 1 / 3),
        (2**53, 2**53),
        (2.0**60, 2.0**60),
        (10**30, 1e30),
        (Fraction(1, 2048), 1 / 2048),
        (np.float64(0.25), Fraction(1, 4)),
        (np.float32(0.5), Fraction(1, 2)),
        (np.int64(7), 7),
    ],
)
def test_constants_have_one_form(value: Any, kept: Any) -> None:
    made = constant(value)
    assert constant_value(made) == kept
    assert isinstance(constant_value(made), type(kept))
    assert made is constant(kept)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, True, np.True_, 1j, "2", None, [1]])
def test_what_is_no_finite_real_number_is_refused(value) -> None:
    with pytest.raises(ExpressionError, match="Expected a"):
        as_expr(value)


def test_rational_constants_stay_exact() -> None:
    third = Rational(1, 3)
    assert third + third + third is constant(1)
    assert constant_value(third * third) == Fraction(1, 9)
    assert constant_value(Rational(1, 10) + Rational(2, 10)) == Fraction(3, 10)


def test_commutative_order_is_total_when_keys_tie() -> None:
    a, b = parameter("tie_a"), parameter("tie_b")
    object.__setattr__(b, "key", a.key)
    assert a.key == b.key
    assert precedes(a, b) is not precedes(b, a)
    assert precedes(a, b) is (digest(a) < digest(b))
    assert a + b is b + a
    assert a * b is b * a
    assert a.max(b) is b.max(a)
    assert a - b is -(b - a)


def test_rates_of_different_declarations_of_one_name_are_ordered() -> None:
    first, second = coordinate("q", description="one").dt, coordinate("q", description="other").dt
    assert first is not second
    assert first + second is second + first
    object.__setattr__(second, "key", first.key)
    assert precedes(first, second) is not precedes(second, first)


def test_constants_precede_everything() -> None:
    assert (x + 2).args[0] is constant(2)
    assert (x * 2).args[0] is constant(2)


def test_digest_depends_on_structure_only() -> None:
    assert digest(x + y * 2) == digest(2 * y + x)
    assert digest(x + y) != digest(x * y)
    assert digest(x.atan2(y)) != digest(y.atan2(x))
    assert digest(parameter("m", 1.0)) != digest(parameter("m", 2.0))
    assert digest(constant(2)) != digest(constant(3))


@given(programs())
def test_postorder_has_each_node_once_after_its_arguments(program: Program) -> None:
    order = postorder(program.nodes())
    place = {n: i for i, n in enumerate(order)}
    assert len(place) == len(order)
    assert all(place[a] < place[n] for n in order for a in n.args)


@given(programs())
def test_pickling_returns_the_same_nodes(program: Program) -> None:
    e = program.root
    assert pickle.loads(pickle.dumps(e)) is e
    rates = [(x.dt * e).sin(), speed("u").dt * e]
    assert all(a is b for a, b in zip(pickle.loads(pickle.dumps(rates)), rates, strict=True))


@pytest.mark.grows
def test_pickling_a_deep_graph() -> None:
    e = deep()
    assert pickle.loads(pickle.dumps(e)) is e


@pytest.mark.slow
def test_a_pickle_read_in_another_process_means_the_same() -> None:
    e = (parameter("m", 2.0, "kg", "mass") * x.dt**2 / 2 + pi * y.cos()).sqrt()
    code = (
        "import pickle, sys; from kane.expr.node import digest; "
        "sys.stdout.write(digest(pickle.loads(bytes.fromhex(sys.stdin.read()))).hex())"
    )
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        input=pickle.dumps(e).hex(),
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout == digest(e).hex()


def test_operations_pickle_as_themselves() -> None:
    assert all(pickle.loads(pickle.dumps(op)) is op for op in OPS.values())


def test_copies_are_the_same_object() -> None:
    e = x.sin() + y
    assert copy.copy(e) is e
    assert copy.deepcopy(e) is e
    assert copy.deepcopy({"e": [e]})["e"][0] is e


@pytest.mark.slow
def test_deallocation_of_a_graph_100000_deep() -> None:
    e = deep(100_000)
    watch = weakref.ref(e)
    del e
    node.sweep()
    assert watch() is None


def test_repeated_building_leaves_nothing_behind() -> None:
    def build() -> Expr:
        e: Expr = x
        for i in range(40):
            e = (e * y + i).cos() / (x + i + 1)
        return e

    kept = build()
    node.sweep()
    size = sum(map(len, node.tables()))
    del kept
    for _ in range(1000):
        build()
    node.sweep()
    assert sum(map(len, node.tables())) < size


@pytest.mark.slow
def test_table_stays_bounded_without_sweeping_by_hand() -> None:
    node.sweep()
    held = 4 * 50  # by e itself, when a sweep falls into the middle of it
    bound = max(20_000, 2 * (max(map(len, node.tables())) + held)) + 1
    for i in range(1000):
        e: Expr = x
        for k in range(50):
            e = (e + (1000 * i + k)).sin()
        assert max(map(len, node.tables())) <= bound


def test_sweep_keeps_what_is_held() -> None:
    e = (x + 12345) * y.sin()
    inner = set(postorder((e,)))
    node.sweep()
    assert (x + 12345) * y.sin() is e
    assert all(any(n is m for known in node.tables() for m in known.values()) for n in inner)


@pytest.mark.slow
def test_threads_share_one_table_while_it_is_swept() -> None:
    """A race would show as two nodes of one structure."""
    rounds, workers = 40, 4
    held: list[list[Expr]] = [[] for _ in range(workers)]
    stop = threading.Event()
    errors: list[BaseException] = []
    start = threading.Barrier(workers)

    def work(mine: list[Expr]) -> None:
        try:
            start.wait()
            for seed in range(rounds):
                mine.extend(random_program(seed, length=30).nodes())
        except BaseException as error:
            errors.append(error)

    def sweeper() -> None:
        while not stop.is_set():
            node.sweep()

    interval = sys.getswitchinterval()
    threads = [threading.Thread(target=work, args=(mine,)) for mine in held]
    cleaner = threading.Thread(target=sweeper)
    sys.setswitchinterval(1e-6)
    try:
        cleaner.start()
        for t in threads:
            t.start()
        for t in threads:
            t.join()
    finally:
        stop.set()
        cleaner.join()
        sys.setswitchinterval(interval)
    assert not errors
    assert len({len(mine) for mine in held}) == 1
    assert all(a is b for mine in held[1:] for a, b in zip(held[0], mine, strict=True))
    names: dict[tuple[object, ...], Expr] = {}
    for n in postorder([e for mine in held for e in mine]):
        if n.args:
            assert names.setdefault((n.op, *n.args), n) is n


@pytest.mark.slow
def test_garbage_collection_keeps_identity() -> None:
    e = (x + y).sin()
    gc.collect()
    assert (y + x).sin() is e


def test_intern_node_does_not_rewrite() -> None:
    twice = intern_node(ADD, x, x)
    assert twice.op is ADD
    assert NODE_BUILDERS["add"](x, x).op is MUL


@pytest.mark.parametrize("length", [1, 3])
def test_numpy_arrays_combine_entry_by_entry(length: int) -> None:
    row: Any = np.linspace(1, 2, length)
    for array in (x * row, row * x):
        assert array.dtype == object
        assert all(e is x * v for e, v in zip(array, row, strict=True))
    assert ((x + y) - row)[0] is x + y - 1
    assert (row / x)[-1] is row[-1] / x
    assert (2**x) is np.float64(2) ** x
    objects: Any = np.array([x, y], dtype=object)
    numpy: Any = np
    assert np.sin(objects)[1] is y.sin()
    assert (objects @ objects) is x * x + y * y
    assert numpy.arctan2(objects, x)[1] is y.atan2(x)
    assert numpy.multiply(np.array(2.0), x) is 2 * x


@pytest.mark.parametrize("name", [n for n, op in OPS.items() if op.ufunc is not None])
def test_each_ufunc_builds_its_operation(name: str) -> None:
    op = OPS[name]
    assert op.ufunc is not None
    args = (x, y)[: op.arity]
    assert op.ufunc(*args) is NODE_BUILDERS[name](*args)


def test_ufuncs_without_an_operation_are_refused() -> None:
    numpy: Any = np
    with pytest.raises(TypeError):
        numpy.floor(x)
    with pytest.raises(TypeError):
        numpy.add.reduce(x)
    with pytest.raises(TypeError):
        numpy.add(x, y, where=np.array(False))


def test_a_symbol_is_an_expression() -> None:
    assert isinstance(x, Symbol)
    assert isinstance(x, Expr)
    assert x.args == ()


@pytest.mark.parametrize(
    "number",
    [10**400, -(10**400), Fraction(10**400, 3), Fraction(1, 10**400), -Fraction(1, 10**330)],
    ids=lambda n: f"{n!s:.8}",
)
def test_numbers_beyond_floats_are_refused(number) -> None:
    x = kn.coordinate("x")
    for use in (
        lambda: x + number,
        lambda: number * x,
        lambda: x**number,
        lambda: kn.parameter("m", number),
        lambda: kn.Matrix([[number]]),
    ):
        with pytest.raises(kn.ExpressionError, match="within the range of floating-point numbers"):
            use()


def test_values_beyond_floats_are_refused() -> None:
    x = kn.coordinate("x")
    for value in (10**400, 1j, "one", [1, "a"]):
        with pytest.raises(kn.ExpressionError, match="Expected a real number or an array of them as a value"):
            kn.evaluate(2 * x, {x: value})
    with pytest.raises(kn.ExpressionError, match="a denominator other than 0"):
        kn.Rational(1, 0)
