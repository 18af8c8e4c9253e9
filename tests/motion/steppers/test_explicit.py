# SPDX-License-Identifier: BSD-3-Clause
"""Explicit methods: their order on closed forms, their interpolant's, and tables that are checked."""

import math
from dataclasses import replace

import numpy as np
import pytest

import kane as kn
from kane import Settings
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


def off(method):
    """The sums in a tableau that are wrong: of rows, weights and estimates, of b in c^p, of the slope of dense output."""
    rows = [(f"row {s}", row, c) for s, (row, c) in enumerate(zip(method.a, method.c[1:], strict=True), 1)]
    rows += [(f"row {s}", row, c) for s, (c, row) in enumerate(method.later, len(method.b) + 1)]
    rows += [("b", method.b, 1.0)] + [("an error", row, 0.0) for row in method.errors]
    # at θ = 1 the slope of the interpolant is k_S, at θ = 0 it is k_0
    rows += [("the slope at the start", [math.fsum(x) for x in zip(*method.dense[:2], strict=True)], 1.0)]
    powers = range(method.order)
    rows += [(f"b^{p}", [w * x**p for w, x in zip(method.b, method.c, strict=True)], 1 / (p + 1)) for p in powers]
    return [what for what, row, to in rows if abs(math.fsum(row) - to) > 1e-13 * max(1.0, *map(abs, row))]


@pytest.mark.parametrize("name", [i.name for i in EXPLICIT])
def test_no_number_is_mistyped(name):
    method = tableau(name)
    assert not off(method)
    assert method.dense[0][: len(method.b)] == method.b  # dense output ends at y'


def test_a_number_that_is_mistyped_is_found():
    wrong = (*DOP853.a[:4], (*DOP853.a[4][:-1], 0.2), *DOP853.a[5:])
    assert off(replace(DOP853, a=wrong)) == ["row 5"]
    weights = (*DOP853.b[:5], DOP853.b[6], DOP853.b[5], *DOP853.b[7:])
    assert "b^1" in off(replace(DOP853, b=weights))


@pytest.mark.parametrize("tolerance", [1e-12, 1e-13])
def test_order_8_is_scipys(tolerance):
    """A double pendulum, both integrators at the same tolerance: 1e-10 along two seconds."""
    eom = kn.derive(pendulums.system(2))
    start = {"q": [1.0, 2.0], "u": [0.0, 0.0], "rtol": tolerance, "atol": tolerance, "samples": 101}
    own, other = (kn.simulate(eom, (0, 2), **start, method=m) for m in ("dop853", "DOP853"))
    assert own.states == pytest.approx(other.states, abs=1e-10)
    assert own.evaluations < 1.2 * other.evaluations
