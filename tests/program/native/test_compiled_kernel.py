# SPDX-License-Identifier: BSD-3-Clause
"""What kernels are given is checked before their code sees it."""

import numpy as np
import pytest

from kane.errors import ProgramError
from kane.program import INT, CompiledKernel, Writer
from tests.program.kernel.kernels import EXACT


def test_arguments_are_what_they_are_for():
    w = Writer("sums")
    n, x, back = w.number("n"), w.array("x"), w.variable("back", INT)
    w.callee("f", "array")
    with w.count(n) as i:
        x[0] = x[0] + x[i + 1]
    kernel = CompiledKernel(w.finished(back), EXACT)
    with pytest.raises(ProgramError, match="Expected a routine as f, got None"):
        kernel({"n": 2, "x": np.ones(3)})
    with pytest.raises(ProgramError, match=r"Expected an integer as n, got 2\.0"):
        kernel({"n": 2.0, "x": np.ones(3)})
    for wrong in (np.ones(3, np.float32), np.ones(6)[::2], [1.0]):
        with pytest.raises(ProgramError, match="Expected an array of doubles without gaps, to be written to as x"):
            kernel({"n": 2, "x": wrong})


def test_arguments_are_bound_once():
    """The arrays are those that were given, the integers those of the call."""
    w = Writer("counts")
    n, x, back = w.number("n"), w.array("x"), w.variable("back", INT)
    with w.count(n):
        x[0] = x[0] + 1.0
    back.put(n)
    given = {"n": 2, "x": np.zeros(1)}
    bound = CompiledKernel(w.finished(back), EXACT).bound(given)
    assert (bound(), bound(n=3), bound(n=0)) == (2, 3, 0)
    assert given["x"] == 5.0
