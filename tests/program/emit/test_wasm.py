# SPDX-License-Identifier: BSD-3-Clause
"""Modules of WebAssembly compute what Programs and kernels mean, bit by bit, by wasmtime."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.random_trees import random_tree
from kane.gallery import load, pendulums
from kane.program import LIMIT, CompiledKernel, emit_wasm, sine_cosine, specialized, values
from tests.examples import examples
from tests.peer import require
from tests.program.hosted import Hosted, from_wasm, in_wasm, told
from tests.program.kernel.kernels import copied
from tests.program.kernel.random_kernels import SIZE, Random
from tests.program.programs import (
    EDGES,
    assert_each_operation_right,
    bits,
    every_operation,
    grid,
    points,
    programs,
    small,
)

require("wasmtime")


@given(st.data())
@examples(0.5, 5)
def test_each_operation_is_the_one_of_the_reference(data):
    """Of NumPy; those of the library within 4 ulp, as everywhere."""
    program = data.draw(programs())
    rows = np.array(data.draw(points(program, 4)))
    run = from_wasm(program, emit_wasm(program))
    every = run("all", rows)
    assert_each_operation_right(program, every.T)
    assert bits(run("some", rows)) == bits(every[:, list(program.routine("some").results)])


def test_each_operation_at_special_numbers():
    """NaN, zeros of both signs, infinities, the smallest numbers."""
    program = every_operation()
    assert_each_operation_right(program, from_wasm(program, emit_wasm(program))("all", grid()).T)


@pytest.mark.parametrize("name", EDGES)
def test_edges(name):
    program = EDGES[name]()
    row = np.linspace(0.5, 1.5, len(program.inputs))
    expected = values(program, program.routine("f").body, row)
    found = from_wasm(program, emit_wasm(program))("f", row[None])
    assert bits(found) == bits([expected[i] for i in program.routine("f").results])


def test_sine_and_cosine_are_those_of_all_languages(rng):
    """By the steps up to the limit, of the library beyond, at multiples of π/2, alone and in pairs."""
    program = small([("sin", (1,)), ("cos", (1,)), ("sin", (2,)), ("cos", (2,))], (3, 4, 6), p=())
    alone = small([("cos", (1,))], (3,), p=())
    x = np.concatenate(
        [rng.uniform(-10, 10, 200), rng.uniform(-LIMIT, LIMIT, 200), np.arange(-40, 41) * np.pi / 2, [-0.0]]
    )
    rows = np.zeros((len(x), 3))
    rows[:, 1], rows[:, 2] = x, x[::-1]
    found = from_wasm(program, emit_wasm(program))("f", rows)
    sine, cosine = sine_cosine(x)
    assert bits(found.T) == bits([sine, cosine, cosine[::-1]])
    assert bits(from_wasm(alone, emit_wasm(alone))("f", rows)) == bits(cosine)
    far = np.zeros((3, 3))
    far[:, 1], far[:, 2] = [1e6, np.inf, np.nan], 0.7
    expected = [[np.sin(1e6), np.cos(1e6)], [np.nan, np.nan], [np.nan, np.nan]]
    found = from_wasm(program, emit_wasm(program))("f", far)
    np.testing.assert_allclose(found[:, :2], expected, rtol=1e-15)
    assert bits(found[:, 2]) == bits(sine_cosine(np.full(3, 0.7))[1])


@pytest.mark.parametrize("name", ["rolling_disk", "four_bar", "muscle_arm"])
def test_routines_of_systems_are_those_of_machine_code(name, rng):
    """All that a compiled system emits, without contraction."""
    compiled = kn.derive(load(name).system()).compile(contract=False)
    program = compiled.program
    run = from_wasm(program, compiled.emit("wasm"))
    n, p = (
        len(program.port("x").symbols),
        compiled.rhs.defaults["p"] if hasattr(compiled.rhs, "defaults") else compiled.default,
    )
    for x in rng.normal(size=(5, n)):
        row = np.concatenate([[0.0], x, p, np.zeros(len(program.port("r").symbols))])
        for routine in program.routines:
            expected = getattr(compiled, routine.name)(0.0, x, p, np.zeros(len(program.port("r").symbols)))
            assert bits(run(routine.name, row[None])) == bits(expected)


@pytest.mark.slow
@pytest.mark.parametrize("make", [lambda: pendulums.system(60, relative=True), lambda: random_tree(range(-1, 11), 3)])
def test_long_code_in_pieces(make, rng):
    """More than a function holds: values go through memory from one to the next."""
    compiled = kn.derive(make()).compile(contract=False)
    program = compiled.program
    assert max(len(r.body) for r in program.routines) > 1500
    n = len(program.port("x").symbols)
    x = rng.uniform(-1, 1, n)
    found = from_wasm(program, compiled.emit("wasm"))("rhs", np.concatenate([[0.0], x, compiled.default])[None])
    assert bits(found) == bits(compiled.rhs(0.0, x))


@pytest.mark.slow
def test_200_000_instructions_take_three_seconds(rng):
    """In functions of at most 1,500 of them."""
    count = 260_000
    reads = [(int(a), int(b)) for a, b in rng.integers(1, 50, size=(count, 2))]
    operations = rng.choice(["add", "mul", "sub"], size=count)
    steps = [
        (op, (max(1, k + 5 - a), max(1, k + 5 - b)))
        for k, (op, (a, b)) in enumerate(zip(operations, reads, strict=True))
    ]
    program = small(steps, range(count, count + 5))
    assert len(program.routine("f").body) > 200_000
    start = time.process_time()
    raw = emit_wasm(program)
    assert time.process_time() - start < 3.0
    row = np.array([0.0, 0.1, 0.2, 1.0, 2.5])
    expected = values(program, program.routine("f").body, row)
    assert bits(from_wasm(program, raw)("f", row[None])) == bits([expected[i] for i in program.routine("f").results])


# ----------------------------------------------------------------------------------------------------------- kernels


def kernels_agree(kernel, given, integers):
    """A kernel as it is and for known integers, in WebAssembly, does what NumPy does."""
    known = specialized(kernel, integers)
    arrays = {name: v for name, v in given.items() if isinstance(v, np.ndarray)}
    results = []
    for one in (kernel, known):
        own = copied({a.name: given[a.name] for a in one.arguments} | arrays)
        results.append((in_wasm(one)(own), own))
    return results


@given(st.integers(0, 2**32 - 1))
@examples(0.5, 5)
def test_random_kernels(seed):
    """Choices, loops, cells and places, nested; as they are and for known integers."""
    rng = np.random.default_rng(seed)
    made = Random(rng)
    made.block(3)
    made.y[0] = made.cell.get() + made.w.compute("float", made.whole.get())
    kernel = made.w.finished(made.back)
    given = {"n": SIZE, "x": rng.normal(size=SIZE), "y": rng.normal(size=SIZE), "c": rng.normal(size=SIZE)}
    expected = copied(given)
    back = CompiledKernel(kernel, kn.Settings(contract=False, cache=False))(expected)
    for found, own in kernels_agree(kernel, given, {"n": SIZE}):
        assert found == back
        for name in "xyc":
            assert bits(own[name]) == bits(expected[name])


def test_what_a_module_is(rng):
    """It is small, says what is where, and its functions are those of the Program."""
    program = small([("mul", (1, 3))], (5,))
    raw = emit_wasm(program, version="1.2")
    assert told(raw)["kane"] == "1.2"
    assert [name for name, *_ in told(raw)["symbols"]["p"]] == ["m", "k"]
    assert len(raw) < 1000
    assert Hosted(raw).exports["f"] is not None
    with pytest.raises(KeyError):
        Hosted(raw).exports["g"]
