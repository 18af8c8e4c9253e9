# SPDX-License-Identifier: BSD-3-Clause
"""Interpreter, machine code and C give the same bits where nothing is contracted."""

import numpy as np
import pytest

from kane.program import INT, Type, Writer
from tests.program.kernel.kernels import agree

SPECIAL = [0.0, -0.0, 1.0, -1.0, 0.1, -2.5, 1e-310, 5e-324, 1e200, -1e308, 3.0, 7.25, np.inf, 1e16, -3e-9, 12.0]
BINARY = ("add", "sub", "mul", "div", "min", "max")
UNARY = ("neg", "abs")


def number(w, x, y):
    """Something finite in place of NaN, whose bits are no one's business."""
    return w.select(x <= x, x, y)


@pytest.mark.slow
@pytest.mark.parametrize("width", [1, 4, 8])
def test_random_arithmetic(width, rng, tmp_path):
    """Operations on lanes, each of values before it, with comparisons and choices."""
    w = Writer(f"random{width}")
    x, out = w.array("x"), w.array("out")
    back = w.variable("back", INT)
    pool = [x.lanes(k * width, width) for k in range(8)]
    for _ in range(64 // width):
        a, b = (pool[k] for k in rng.integers(len(pool), size=2))
        kind = rng.integers(4)
        if kind == 0:
            new = w.compute(str(rng.choice(UNARY)), a)
        elif kind == 1:
            new = w.select((a < b) | ~(a <= 0.5), a, b)
        elif kind == 2:
            new = w.compute("sqrt", w.compute("abs", a))
        else:
            new = w.compute(str(rng.choice(BINARY)), a, b)
        pool.append(number(w, new, a))
    for k, value in enumerate(pool):
        if width == 1:
            out[k] = value
            continue
        out[3 * k] = number(w, w.compute("sum", value), w.compute("lane", value, lane=1))
        out[3 * k + 1] = w.compute("largest", value)
        out[3 * k + 2] = w.select(w.compute("any", value < 0.0), 1.0, w.compute("lane", value, lane=width - 1))
    back.put(len(pool))
    values = np.array([rng.choice(SPECIAL) if rng.random() < 0.5 else rng.normal() for _ in range(8 * width)])
    assert agree(w.finished(back), {"x": values, "out": np.zeros(3 * len(pool))}, tmp_path / "k.c") == len(pool)


def test_loops_choices_and_cells(tmp_path):
    """The Collatz numbers of 1 to 20 by nested loops, halves being told by a sum of twos; cells keep lanes too."""
    w = Writer("collatz")
    n, out = w.number("n"), w.array("out")
    x, half, steps, back = (w.variable(name, INT) for name in ("x", "half", "steps", "back"))
    lanes = w.variable("lanes", Type("float", 4))
    with w.count(n) as i:
        x.put(i + 1)
        steps.put(0)
        with w.repeat(lambda: x.get() > 1):
            half.put(0)
            with w.repeat(lambda: half.get() * 2 + 2 <= x.get()):
                half.put(half.get() + 1)
            with w.when(half.get() * 2 < x.get()):
                x.put(x.get() * 3 + 1)
            with w.otherwise():
                x.put(half.get())
            steps.put(steps.get() + 1)
        out[i] = w.compute("float", steps.get())
        lanes.put(lanes.get() + w.compute("splat4", out[i]) * (1.0, 0.5, 0.25, 0.0))
        back.put(back.get() + steps.get())
    out_lanes = lanes.get()
    for k in range(4):
        out[n + k] = w.compute("lane", out_lanes, lane=k)
    kernel = w.finished(back)
    assert (
        agree(kernel, {"n": 20, "out": np.zeros(24)}, tmp_path / "k.c") == 196
    )  # 0, 1, 7, 2, 5, 8, 16, 3, 19, 6, 14, …
