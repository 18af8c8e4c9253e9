# SPDX-License-Identifier: BSD-3-Clause
"""Gauss collocation: nodes against NumPy's, order 16 at the ends of steps and 9 within, q' = u and without."""

import numpy as np
import pytest

import kane as kn
from kane import Settings
from kane.motion import ReturnCode, Slot, along, gauss, gauss_kernel, integrals
from kane.program import CompiledKernel
from tests.motion.steppers.runs import arguments, spring


@pytest.mark.parametrize("stages", [1, 2, 5, 8])
def test_nodes_integrate_powers(stages):
    nodes = gauss(stages)
    x, w = np.polynomial.legendre.leggauss(stages)
    assert np.array(nodes.c) == pytest.approx((x + 1) / 2, abs=4e-16)
    assert np.array(nodes.b) == pytest.approx(w / 2, abs=1e-15)
    a, c = np.array(nodes.a).T, np.array(nodes.c)
    for k in range(stages):
        assert a @ c**k == pytest.approx(c ** (k + 1) / (k + 1), abs=4e-16)
    assert pytest.approx(a @ a, abs=1e-16) == np.array(nodes.a2).T
    assert np.dot(nodes.b2, np.ones(stages)) == pytest.approx(0.5, abs=2e-16)
    assert np.dot(nodes.top, c ** (stages - 1)) == pytest.approx(1, abs=1e-11)


def test_integrals_along_a_step_are_those_of_lagranges_polynomials():
    """In 50 digits one by one, and of many shares at once; at the nodes they are the method's own."""
    shares = np.array([0.0, 0.1, 0.5, 0.93, 1.0, *gauss(8).c])
    once, twice = along(shares)
    for row, double, share in zip(once, twice, shares, strict=True):
        exact = integrals(gauss(8), float(share))
        assert row == pytest.approx(exact[0], abs=1e-15)
        assert double == pytest.approx(exact[1], abs=1e-15)
    assert pytest.approx(np.array(gauss(8).a), abs=1e-15) == once[5:].T
    assert once[4] == pytest.approx(gauss(8).b, abs=1e-15)
    assert twice[4] == pytest.approx(gauss(8).b2, abs=1e-15)


def turned():
    """The spring by the speed u = 2 q', so that no rate of a coordinate is a speed."""
    N = kn.Frame("N")
    q, u = kn.coordinate("q"), kn.speed("u")
    p = kn.Point("O", fixed_in=N).at("P", q * N.x)
    return kn.derive(kn.System(N, bodies=[kn.Particle("P", p, 1)], loads=[kn.Force(p, -q * N.x)], speeds={u: 2 * q.dt}))


@pytest.fixture(scope="module")
def willing():
    """A kernel that takes every step."""
    return CompiledKernel(gauss_kernel(accepted=1e20, rounds=600), Settings())


@pytest.mark.slow
@pytest.mark.parametrize("make", [spring, turned])
def test_the_order_is_16_and_9_within(willing, make):
    """Steps of 6 and 4, about a turn, for the ends; of 2 and 1 within."""
    eom = make()

    def error(h, at):
        given, _ = arguments(eom, Settings(), "gauss16", [1.0, 0.0], at[-1], h, 1e-15, at)
        given["s"][Slot.ATOL] = 1e-15
        while willing(given | {"limit": 1}) == ReturnCode.LIMIT:
            given["s"][[Slot.STEP, Slot.FRESH]] = h, 1.0
        assert given["s"][Slot.STEPS] == round(at[-1] / h)
        return np.abs(given["rows"][:, 0] - np.cos(at)).max()

    assert np.log(error(6.0, [24.0]) / error(4.0, [24.0])) / np.log(1.5) == pytest.approx(16, abs=1)
    between = np.arange(1, 80) / 5 + 0.03
    within = [error(h, [*between, 16.0]) for h in (2.0, 1.0)]
    assert np.log2(within[0] / within[1]) > 8.5
