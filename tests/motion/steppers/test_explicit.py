# SPDX-License-Identifier: BSD-3-Clause
"""Explicit methods: their order on closed forms, their interpolant's, and tables that are checked."""

from dataclasses import replace

import numpy as np
import pytest

import kane as kn
from kane import Settings
from kane.errors import SimulationError
from kane.gallery import pendulums
from kane.motion import DOP853, EXPLICIT, ReturnCode, Slot, compiled, tableau
from tests.motion.steppers.runs import arguments, spring


@pytest.fixture(scope="module")
def oscillator():
    return spring()


def error(eom, method, h, at):
    """Largest error of cos t at the times, with steps of h."""
    given, _ = arguments(eom, Settings(), method, [1.0, 0.0], at[-1], h, 1e3, at)
    assert compiled(method, Settings())(given) == ReturnCode.END
    assert given["s"][Slot.STEPS] == round(at[-1] / h)
    return max(np.abs(given["rows"][:, 0] - np.cos(at)).max(), np.abs(given["rows"][:, 1] + np.sin(at)).max())


@pytest.mark.parametrize("integrator", EXPLICIT, ids=lambda i: i.name)
def test_what_is_told_of_a_method_is_true_of_its_tableau(integrator):
    """Steps are of one length where there is no estimate, and inputs in Python are asked where no stage lies behind the step."""
    own = tableau(integrator.name)
    assert (own.name, integrator.fixed) == (integrator.name, not own.errors)
    assert integrator.driven == (max(own.c) <= 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", [i.name for i in EXPLICIT])
def test_the_order_is_that_of_the_method(name, oscillator):
    """Halving the step divides the error at the end by 2^order or hardly more, and that between by one power less at least."""
    method = tableau(name)
    coarse, fine = (1.0, 0.5) if method.order > 5 else (0.25, 0.125)
    ends = [error(oscillator, name, h, [8.0]) for h in (coarse, fine)]
    assert method.order - 0.4 < np.log2(ends[0] / ends[1]) < method.order + 1.3
    between = np.arange(1, 80) / 10 + 0.03
    within = [error(oscillator, name, h, [*between, 8.0]) for h in (coarse, fine)]
    assert np.log2(within[0] / within[1]) > method.order - 1


def test_a_number_that_is_mistyped_is_found():
    wrong = (*DOP853.a[:4], (*DOP853.a[4][:-1], 0.2), *DOP853.a[5:])
    with pytest.raises(SimulationError, match=r"Expected row 5 of dop853 to add up to 0\.333"):
        replace(DOP853, a=wrong)
    weights = (*DOP853.b[:5], DOP853.b[6], DOP853.b[5], *DOP853.b[7:])
    with pytest.raises(SimulationError, match=r"Expected b\^1 of dop853 to add up to 0.5"):
        replace(DOP853, b=weights)


@pytest.mark.parametrize("tolerance", [1e-12, 1e-13])
def test_order_8_is_scipys(tolerance):
    """A double pendulum, both integrators at the same tolerance: 1e-10 along two seconds."""
    eom = kn.derive(pendulums.system(2))
    start = {"q": [1.0, 2.0], "u": [0.0, 0.0], "rtol": tolerance, "atol": tolerance, "samples": 101}
    own, other = (kn.simulate(eom, (0, 2), **start, method=m) for m in ("dop853", "DOP853"))
    assert own.states == pytest.approx(other.states, abs=1e-10)
    assert own.evaluations < 1.2 * other.evaluations
