# SPDX-License-Identifier: BSD-3-Clause
"""The reference evaluator against mpmath, and how it takes values."""

import threading

import numpy as np
import pytest
from hypothesis import given

from kane import Expr, coordinates, evaluate, free_symbols, parameter, pi, speed
from kane.errors import ValueMissingError
from kane.expr import BUILDERS, OPS, as_expr, compile_reference
from tests.expr.expressions import LEAVES, Program, identical, programs, random_program

x, y = coordinates("x, y")


@given(programs())
def test_values_agree_with_50_digits(program: Program) -> None:
    ours, direct = evaluate(program.nodes(), program.at), program.direct()
    for a, b in zip(ours, direct, strict=True):
        assert abs(a - float(b)) <= 1e-10 * (1 + abs(float(b)))


@given(programs())
def test_arrays_give_what_single_values_give(program: Program) -> None:
    scaled = np.array([1.0, 0.97, 1.01])
    together = evaluate(program.root, {s: v * scaled for s, v in program.at.items()})
    single = [evaluate(program.root, {s: v * k for s, v in program.at.items()}) for k in scaled]
    assert np.broadcast_to(together, 3) == pytest.approx(np.array(single), rel=1e-9, abs=1e-9, nan_ok=True)


@given(programs())
def test_arrays_are_evaluated_alike_each_time(program: Program) -> None:
    """In the first call node by node, then by a list of instructions; numbers among them, such as parameters, too."""
    nodes, scaled = program.nodes(), np.array([1.0, 0.97, 1.01])
    run = compile_reference(nodes, LEAVES)
    given = [v * scaled if k % 2 else v for k, v in enumerate(program.values)]
    first = run(given)
    run([v * scaled[::-1] for v in program.values])
    for one, other in zip(first, run(given), strict=True):
        assert type(one) is type(other)
        assert np.array_equal(one, other, equal_nan=True)


@pytest.mark.parametrize("name", [n for n, op in OPS.items() if op.arity])
def test_each_operation(name: str) -> None:
    op = OPS[name]
    assert op.numpy is not None
    args = (x.less(y), x, y) if name == "where" else (x, y)[: op.arity]
    at = {x: 0.4, y: 0.9}
    raw = (True, 0.4, 0.9) if name == "where" else (0.4, 0.9)[: op.arity]
    assert evaluate(BUILDERS[name](*args), at) == pytest.approx(op.numpy(*raw), rel=1e-15)


def test_forms_of_the_argument() -> None:
    at = {x: 2.0, y: 3.0}
    assert evaluate(x * y, at) == 6
    assert evaluate([x, y, 1, 0.5], at) == [2, 3, 1, 0.5]
    assert evaluate(4, {}) == 4
    assert evaluate(pi, {}) == np.pi
    assert isinstance(evaluate(x, at), np.ndarray)
    assert evaluate(x * y, {x: [1, 2], y: np.ones((3, 1))}).shape == (3, 2)
    assert evaluate([], {}) == []


def test_parameters_fall_back_to_their_defaults() -> None:
    m = parameter("m", 1.5)
    assert evaluate(m * x, {x: 2}) == 3
    assert evaluate(m * x, {x: 2, m: 1}) == 2


def test_a_missing_value_is_named() -> None:
    with pytest.raises(ValueMissingError, match=r"got none for y \(Coordinate\)\. Known here: x") as missing:
        evaluate(x * y, {x: 1})
    assert str(missing.value).startswith("Expected a value for every symbol")
    with pytest.raises(ValueMissingError, match="got none for k"):
        evaluate(parameter("k") * 2, {})


@pytest.mark.parametrize(
    ("expr", "value"), [(1 / x, np.inf), (x.log(), -np.inf), ((x - 1).sqrt(), np.nan), (x / x.sin(), np.nan)]
)
def test_ieee_values_without_a_warning(expr: Expr, value: float) -> None:
    assert evaluate(expr, {x: 0.0}) == pytest.approx(value, nan_ok=True)


def test_where_takes_one_branch() -> None:
    guarded = x.less(1e-9).where(0, x.log())
    assert evaluate(guarded, {x: [0.0, 1.0]}) == pytest.approx([0, 0])


def test_compiled_functions_are_reusable_by_threads() -> None:
    program = random_program(3, length=30)
    run = compile_reference([program.root], LEAVES)
    expected = [float(run([v + k / 100 for v in program.values])[0]) for k in range(50)]
    found: dict[int, list[float]] = {}

    def work(i: int) -> None:
        found[i] = [float(run([v + k / 100 for v in program.values])[0]) for k in range(50)]

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert all(np.array_equal(found[i], expected, equal_nan=True) for i in range(4))


def test_a_deep_graph() -> None:
    e: Expr = x
    for _ in range(10_000):
        e = (e + 1) / 2
    assert evaluate(e, {x: 5.0}) == pytest.approx(1)


def test_free_symbols() -> None:
    u = speed("u")
    assert set(free_symbols([x * y + u, x])) == {x, y, u}
    assert identical(free_symbols([x, y.sin(), x * y]), (x, y))
    assert free_symbols([as_expr(1), pi]) == ()
    assert identical(free_symbols(x * y), free_symbols([x * y]))
