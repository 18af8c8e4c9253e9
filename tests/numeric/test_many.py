# SPDX-License-Identifier: BSD-3-Clause
"""Many starts at once: those that are slow are waited for while none that is meant is closed."""

import numpy as np
import pytest

from kane.numeric import NaturalSizes, close_many, close_most, sizes

SIZE = NaturalSizes(np.ones(1), np.ones(1), np.array([False]))


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


@pytest.mark.parametrize("exponent", [-9, -6, 0, 6, 9])
def test_sizes_are_those_of_the_terms_in_any_units(exponent, rng):
    """A ring of radius 0.4 and a slide across it, in units some powers of ten apart: x changes f as much as the radius does."""
    metre = 10.0**exponent

    def function(x, members):
        f = np.stack(
            [x[:, 0] ** 2 + x[:, 1] ** 2 - (0.4 * metre) ** 2, x[:, 0] - 0.4 * metre * np.cos(x[:, 2])], axis=1
        )
        zero, one = np.zeros(len(x)), np.ones(len(x))
        rows = [[2 * x[:, 0], 2 * x[:, 1], zero], [one, zero, 0.4 * metre * np.sin(x[:, 2])]]
        return f, np.moveaxis(np.array(rows), -1, 0)

    found = sizes(function, np.vstack([np.zeros(3), rng.uniform(-np.pi, np.pi, (11, 3))]))
    assert found.turns.tolist() == [False, False, True]
    assert found.x[2] == 1
    assert (found.x[:2] / metre > 0.04).all()
    assert (found.x[:2] / metre < 10).all()
    assert 0.16 / 10 < found.f[0] / metre**2 < 100
    assert 0.1 < found.f[1] / metre < 10


def test_what_enters_one_equation_weakly_is_measured_by_the_others():
    """x of the size of 1 in one, and a millionth of that in another: its size is 1, and what is closed is so."""

    def function(x, members):
        f = np.stack([x[:, 0] - 2 + np.sin(x[:, 1]), 1e-6 * x[:, 0] + np.cos(x[:, 1]) - 0.3], axis=1)
        one = np.ones(len(x))
        rows = [[one, np.cos(x[:, 1])], [1e-6 * one, -np.sin(x[:, 1])]]
        return f, np.moveaxis(np.array(rows), -1, 0)

    drawn = np.vstack([np.zeros(2), np.random.default_rng(3).uniform(-np.pi, np.pi, (11, 2))])
    found = sizes(function, drawn)
    assert 0.1 < found.x[0] < 10
    assert (found.f < 10).all()


@pytest.mark.parametrize("way", [close_many, close_most])
def test_what_is_closed_is_closed_to_rounding(way):
    """Steps end at shares of 1e-12 and less; one more leaves what rounding does."""

    def circle(x, members):
        return (x**2).sum(axis=1, keepdims=True) - 1.0, 2 * x[:, None, :]

    start = np.random.default_rng(3).normal(size=(40, 2)) + 0.3
    found = way(circle, start, NaturalSizes(np.ones(2), np.ones(1), np.zeros(2, dtype=bool)))
    assert np.median(found.left) <= 2.3e-16
    assert found.left[found.left <= 1e-10].max() <= 4.5e-16
