# SPDX-License-Identifier: BSD-3-Clause
"""Explicit methods: their order on closed forms, their interpolant's, and the same bits in every language."""

from dataclasses import replace

import numpy as np
import pytest

import kane as kn
from kane.errors import SimulationError
from kane.gallery import pendulums
from kane.motion.steppers.dop853 import DOP853
from kane.motion.steppers.explicit import explicit_kernel
from kane.motion.steppers.outline import At, Back
from kane.motion.steppers.table import compiled
from kane.program.native.entry import entry
from kane.program.native.machine import Settings
from tests.motion.steppers.runs import arguments, spring
from tests.program.kernel.kernels import EXACT, agree

TABLEAUS = [DOP853]


@pytest.fixture(scope="module")
def oscillator():
    return spring()


def error(eom, method, h, at):
    """Largest error of cos t at the times, with steps of h."""
    given, routine = arguments(eom, Settings(), method, [1.0, 0.0], at[-1], h, 1e3, at)
    assert compiled(method, Settings())({**given, "rhs": entry(routine)}) == Back.END
    assert given["s"][At.STEPS] == round(at[-1] / h)
    return np.abs(given["rows"][:, 0] - np.cos(at)).max()


@pytest.mark.parametrize("tableau", TABLEAUS, ids=lambda t: t.name)
def test_the_order_is_that_of_the_method(tableau, oscillator):
    """Halving the step divides the error at the end by 2^order, and that between by one power less at least."""
    coarse, fine = 1.0, 0.5
    ends = [error(oscillator, tableau.name, h, [8.0]) for h in (coarse, fine)]
    assert np.log2(ends[0] / ends[1]) == pytest.approx(tableau.order, abs=0.6)
    between = np.arange(1, 80) / 10 + 0.03
    within = [error(oscillator, tableau.name, h, [*between, 8.0]) for h in (coarse, fine)]
    assert np.log2(within[0] / within[1]) > tableau.order - 1


@pytest.mark.parametrize("tableau", TABLEAUS, ids=lambda t: t.name)
def test_every_language_gives_the_same_bits(tableau, tmp_path):
    """A double pendulum for six steps and what is taken again, sampled, through the interpreter, machine code and C."""
    eom = kn.derive(pendulums.system(2))
    start, times = [1.0, 2.0, 0.5, 0.0], np.linspace(0.1, 9, 120)
    given, routine = arguments(eom, EXACT, tableau.name, start, 9.0, 0.3, 1e-9, times)

    def rate(t, x, p, r, h, out):
        out[:5] = routine(float(t), x[:4], p, None)

    code = entry(routine)
    # the interpreter takes a function, machine code an entry, C an address: each is the same code
    languages = {"interpret": rate, "llvm": code, "c": code.library.address(code.symbol)}
    assert agree(explicit_kernel(tableau), given | {"limit": 6, "rhs": languages}, tmp_path / "k.c") == Back.LIMIT


def test_a_number_that_is_mistyped_is_found():
    wrong = (*DOP853.a[:4], (*DOP853.a[4][:-1], 0.2), *DOP853.a[5:])
    with pytest.raises(SimulationError, match=r"Expected row 5 of dop853 to add up to 0\.333"):
        replace(DOP853, a=wrong)
    weights = (*DOP853.b[:5], DOP853.b[6], DOP853.b[5], *DOP853.b[7:])
    with pytest.raises(SimulationError, match=r"Expected b\^1 of dop853 to add up to 0.5"):
        replace(DOP853, b=weights)
