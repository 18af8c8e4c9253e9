# SPDX-License-Identifier: BSD-3-Clause
"""Kernels of random statements: arithmetic, cells, arrays, choices and loops, nested."""

from kane.program import INT, Writer

SIZE = 6


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
