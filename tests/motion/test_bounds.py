# SPDX-License-Identifier: BSD-3-Clause
"""Every passage of a quantity is found and none invented, however many lie between two places."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kane.numeric import SHARES, passages
from tests.examples import FULL, examples


def found(f, start=0.0, end=1.0):
    times = start + (end - start) * np.array(SHARES)
    return passages(f, times, f(times))


def crossings(f, start=0.0, end=1.0, count=20_001):
    """Sign changes on a fine grid."""
    t = np.linspace(start, end, count)
    v = f(t)
    return [(a, b) for a, b, x, y in zip(t[:-1], t[1:], v[:-1], v[1:], strict=True) if x * y < 0]


@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("middle", [0.37, 0.5, 0.93])
def test_two_passages_close_together(width, middle):
    """A parabola that dips below zero for so short a time, anywhere."""
    brackets = found(lambda t: (t - middle) ** 2 - (width / 2) ** 2)
    assert len(brackets) == 2
    for (a, b, x, y), root in zip(brackets, (middle - width / 2, middle + width / 2), strict=True):
        assert a <= root <= b
        assert x * y <= 0


@pytest.mark.grows
@pytest.mark.parametrize("bent", [0.0, 0.3, 2.0, -0.8])
def test_a_corner_that_dips_anywhere(bent):
    """A distance that is nearly nothing for a moment, straight beside it or not, at each of many places."""
    width = 1e-7
    for t_0 in map(float, np.linspace(0.001, 0.999, 400 if FULL else 80)):

        def distance(t, t_0=t_0):
            return np.abs((t - t_0) * (1 + bent * (t - t_0))) - width

        inside = [root for root in (t_0 - width, t_0 + width) if 0 < root < 1]
        met = [bracket for bracket in found(distance) if abs(bracket[0] - t_0) < 0.2 and abs(bracket[1] - t_0) < 0.2]
        assert len(met) == len(inside), t_0
        for (a, b, _, _), root in zip(met, inside, strict=True):
            assert a - 1e-12 <= root <= b + 1e-12


def test_what_does_not_pass_is_not_met():
    assert found(lambda t: (t - 0.4) ** 2 + 1e-9) == []
    assert found(lambda t: 1 + 0 * t) == []
    assert found(lambda t: t) == []
    assert found(lambda t: np.abs(t - 0.99) + 1e-6) == []
    assert found(lambda t: np.where(t > 0.5, np.nan, 1.0)) == []


@given(st.integers(0, 2**32 - 1))
@examples(0.4)
def test_sums_of_sines(seed):
    """Up to thirty turns in the interval, with an offset; what only grazes zero within 1e-6 is not asked for."""
    rng = np.random.default_rng(seed)
    size, pace, phase = rng.normal(size=4), rng.uniform(0, 60 * np.pi, 4), rng.uniform(0, 7, 4)
    offset = rng.normal() * 2

    def f(t):
        return (size * np.sin(np.multiply.outer(t, pace) + phase)).sum(axis=-1) + offset

    expected = crossings(f)
    brackets = found(f)
    assert len(brackets) == len(expected)
    for (a, b, _, _), (s, t) in zip(brackets, expected, strict=True):
        assert a <= t
        assert s <= b


@pytest.mark.parametrize("turns", range(1, 65))
def test_no_number_of_turns_hides(turns):
    """Whole turns between the ends, which even spacing would take for rest."""
    assert len(found(lambda t: np.sin(2 * np.pi * turns * t + 0.3) + 0.1)) == 2 * turns
