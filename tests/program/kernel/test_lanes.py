# SPDX-License-Identifier: BSD-3-Clause
"""A kernel in lanes does in each lane, bit by bit, what it does alone."""

import ctypes

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane import Settings
from kane.errors import ProgramError
from kane.program import (
    INT,
    CompiledKernel,
    CompiledRoutine,
    Task,
    Type,
    Writer,
    build_program,
    hoisted,
    masked_entries,
    narrowed,
    verified_kernel,
)
from tests.examples import examples
from tests.program.kernel.random_kernels import SIZE, Random
from tests.program.programs import ports

EXACT = Settings(contract=False, cache=False)


def both(kernel, width, shared, **arrays):
    """Arrays (size × width) are the same after the kernel has run in lanes as after it has run on each column; shared ones (size)."""
    one, many = CompiledKernel(kernel, EXACT), CompiledKernel(kernel, EXACT, width=width, shared=shared)
    after = {name: array.copy() for name, array in arrays.items()}
    back, backs = many(after | {"n": SIZE}), []
    for k in range(width):
        own = {name: (a if name in shared else a[:, k]).copy() for name, a in arrays.items()}
        backs.append(one(own | {"n": SIZE}))
        for name in arrays.keys() - set(shared):
            assert np.array_equal(after[name][:, k], own[name], equal_nan=True), (name, k)
    assert back == max(backs)


@given(st.integers(0, 2**32 - 1), st.sampled_from([4, 8]))
@examples(0.2, 5)
def test_random_kernels(seed, width):
    """Choices, loops and places that differ from lane to lane, nested."""
    rng = np.random.default_rng(seed)
    made = Random(rng)
    made.block(3)
    made.y[0] = made.cell.get() + made.w.compute("float", made.whole.get())
    kernel = made.w.finished(made.back)
    x, y = rng.normal(size=(2, SIZE, width))
    both(kernel, width, ("c",), x=x, y=y, c=rng.normal(size=SIZE))


def test_lanes_write_no_shared_array():
    w = Writer("wrong")
    w.number("n")
    c, back = w.array("c"), w.variable("back", INT)
    c[0] = 1.0
    with pytest.raises(ProgramError, match="c, which all lanes share"):
        CompiledKernel(w.finished(back), EXACT, width=8, shared=("c",))


@pytest.mark.parametrize("width", [4, 8])
def test_routines_with_parameters_of_their_own(width, rng):
    """Each lane has its parameters, which are hoisted for it; of lanes that do not run nothing is written."""
    (a, b, c), (k, l) = kn.coordinates("a b c"), kn.parameters("k l", 1.5)
    roots = [kn.sin(a * k) / (l + k * k), kn.exp(b) * kn.sqrt(l), c**k + kn.input("F")]
    task = Task("all", roots, (len(roots),), ["y0", "y1", "y2"])
    given_ports = ports((a, b, c), (k, l), tuple(s for s in kn.expr.free_symbols(roots) if s.name == "F"))
    routine = CompiledRoutine(build_program("own", given_ports, [task]), "all", EXACT)
    x, p, r, t = (
        rng.uniform(0.5, 2, (3, width)),
        rng.uniform(0.5, 2, (2, width)),
        rng.normal(size=(1, width)),
        np.zeros(width),
    )
    h = np.repeat(hoisted(routine, 0.0, x[:, 0], p[:, 0], r[:, 0]), width)
    run, hoist = masked_entries(routine, width)
    out, running = np.full((3, width), np.nan), rng.random(width) < 0.5
    bits = sum(1 << j for j in range(width) if running[j])
    ctypes.CFUNCTYPE(None, ctypes.c_int64, *[ctypes.c_void_p] * 2)(hoist.address)(-1, p.ctypes.data, h.ctypes.data)
    call = ctypes.CFUNCTYPE(None, ctypes.c_int64, *[ctypes.c_void_p] * 6)(run.address)
    call(bits, *(array.ctypes.data for array in (t, x, p, r, h, out)))
    for j in range(width):
        expected = routine(0.0, x[:, j], p[:, j], r[:, j]) if running[j] else np.full(3, np.nan)
        assert np.array_equal(out[:, j], expected, equal_nan=True)


def test_values_of_several_numbers_become_several(rng):
    """Sums, largest ones, comparisons and cells of eight numbers: the same bits, alone and in lanes."""
    w = Writer("wide")
    w.number("n")
    x, y = w.array("x"), w.array("y")
    back, cell = w.variable("back", INT), w.variable("cell", Type("float", 8))
    a, b = x.lanes(0, 8), x.lanes(8, 8)
    with w.when(w.compute("any", a < b)):
        cell.put(w.compute("max", a * b, w.compute("splat8", x[3])) - w.lanes(*range(8)))
    y.store(0, w.select(a < b, cell.get(), -a))
    y[8], y[9], y[10] = (w.compute(op, cell.get()) for op in ("sum", "largest", "sum"))
    y[11] = w.compute("lane", cell.get(), lane=5)
    kernel = w.finished(back)
    narrow = verified_kernel(narrowed(kernel))
    values, after = rng.normal(size=(16, 8)), np.zeros((12, 8))
    CompiledKernel(narrow, EXACT, width=8)({"n": 0, "x": values, "y": after})
    for k in range(8):
        for one in (kernel, narrow):
            own = np.zeros(12)
            CompiledKernel(one, EXACT)({"n": 0, "x": values[:, k].copy(), "y": own})
            assert np.array_equal(own, after[:, k])
