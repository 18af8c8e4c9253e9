# SPDX-License-Identifier: BSD-3-Clause
"""Many starts at once: those that are slow are waited for while none that is meant is closed."""

import numpy as np
import pytest

from kane.numeric.many import Sizes, close_many, close_most

SIZE = Sizes(np.ones(1), np.ones(1), np.array([False]))


def slow(x, members):
    """Starts with even numbers do as `quick` says, the others come to the double root at 5, half the way in a step."""
    even = members[:, None] % 2 == 0
    f = np.where(even, x, (x - 5) ** 2)
    return f, np.where(even, 1.0, 2 * (x - 5))[:, :, None]


def stuck(x, members):
    """Starts with even numbers lead nowhere."""
    even = members[:, None] % 2 == 0
    f, g = slow(x, members)
    return np.where(even, 1.0, f), np.where(even[:, :, None], 1e-3, g)


@pytest.mark.parametrize("way", [close_many, close_most])
def test_slow_starts_are_waited_for_while_others_lead_nowhere(way):
    found = way(stuck, np.full((8, 1), 4.0), SIZE)
    assert (found.left[1::2] <= 1e-12).all()
    assert found.x[1::2] == pytest.approx(5.0, abs=1e-5)


@pytest.mark.parametrize("way", [close_many, close_most])
def test_slow_starts_are_waited_for_while_closed_ones_are_not_meant(way):
    def accepted(x, members):
        return x[:, 0] > 4.5

    start = np.full((8, 1), 4.0)
    assert (way(slow, start, SIZE, accepted).left[1::2] <= 1e-12).all()
    assert (close_many(slow, start, SIZE).left[1::2] > 1e-9).all()  # one is enough where any will do
