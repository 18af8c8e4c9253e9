# SPDX-License-Identifier: BSD-3-Clause
"""Every passage of a quantity is found and none invented, however many lie between two places."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kane.numeric import SHARES, passages
from tests.examples import examples


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


def test_what_does_not_pass_is_not_met():
    assert found(lambda t: (t - 0.4) ** 2 + 1e-9) == []
    assert found(lambda t: 1 + 0 * t) == []
    assert found(lambda t: t) == []
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
