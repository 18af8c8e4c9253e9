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
    narrowed,
    own_entries,
    verified_kernel,
)
from tests.examples import examples
from tests.program.programs import ports

EXACT = Settings(contract=False, cache=False)
SIZE = 6


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


class Random:
    """A kernel of random statements on the array y, reading also from x and the shared c."""

    def __init__(self, rng):
        self.rng, self.w = rng, Writer("random")
        self.n = self.w.number("n")
        self.x, self.y, self.c = (self.w.array(name) for name in "xyc")
        self.back, self.cell, self.whole = (
            self.w.variable("back", INT),
            self.w.variable("cell"),
            self.w.variable("whole", INT),
        )
        self.indices = [self.w.integer(0), self.w.integer(SIZE - 1)]

    def index(self):
        kind = self.rng.integers(3)
        if kind:
            return self.indices[self.rng.integers(len(self.indices))]
        return self.w.compute("int", self.w.compute("min", self.w.compute("abs", self.number()), SIZE - 1.0))

    def number(self):
        """Something between −8 and 8."""
        w, kind = self.w, self.rng.integers(5)
        if kind == 0:
            return w.constant(float(self.rng.normal()))
        if kind == 1:
            return self.cell.get()
        array = (self.x, self.y, self.c)[kind - 2]
        return array[self.indices[self.rng.integers(len(self.indices))]]

    def value(self):
        w, a, b = self.w, self.number(), self.number()
        kind = self.rng.integers(5)
        found = (a + b, a * b, w.compute("sqrt", w.compute("abs", a)), w.select(self.condition(), a, b), -a)[kind]
        return w.compute("max", w.compute("min", found, 8.0), -8.0)

    def condition(self):
        a, b = self.number(), self.number()
        return (a < b, ~(a <= b), (a < b) | (a > 0.5), (a < 1.0) & (b < 1.0))[self.rng.integers(4)]

    def block(self, depth):
        for _ in range(self.rng.integers(1, 4)):
            self.statement(depth)

    def statement(self, depth):
        w, kind = self.w, self.rng.integers(7 if depth else 4)
        if kind == 0:
            self.y[self.index()] = self.value()
        elif kind == 1:
            self.cell.put(self.value())
        elif kind == 2:
            self.whole.put(w.compute("int", self.value()))
        elif kind == 3:
            self.back.put(self.back.get() + 1)
        elif kind == 4:
            with w.when(self.condition()):
                self.block(depth - 1)
            with w.otherwise():
                self.block(depth - 1)
        elif kind == 5:
            start = [0, self.w.compute("int", self.w.compute("abs", self.number()))][self.rng.integers(2)]
            stop = [self.n, self.w.compute("int", self.number())][self.rng.integers(2)]
            with w.count(stop, start) as i:
                self.y[w.compute("int", w.compute("min", w.compute("float", i), SIZE - 1.0))] = self.value()
                self.cell.put(self.cell.get() * 0.5 + w.compute("float", i))
                self.block(depth - 1)
        else:
            times = w.variable(f"times{len(w.cells)}", INT)
            times.put(0)
            with w.repeat(lambda: self.condition() & (times.get() < 5)):
                times.put(times.get() + 1)
                self.block(depth - 1)


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
    run, hoist = own_entries(routine, width)
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
