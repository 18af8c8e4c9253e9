# SPDX-License-Identifier: BSD-3-Clause
"""Crossings of the imaginary axis in spectra that are known: each is met once."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.analysis import changes
from kane.gallery import pure_rolling_disk


def met(spectrum, places=(0.0, 1.0)):
    """(value, root, whether it grows) along y = places."""
    path = [np.array([y]) for y in places]

    def at(y):
        return np.asarray(spectrum(float(y[0])), dtype=complex)

    found = changes(path, [at(y) for y in path], lambda a, b: (a + b) / 2, at)
    return [(float(c.y[0]), c.root, c.grows) for c in found]


def pair(middle, square):
    root = np.sqrt(complex(square))
    return [middle + root, middle - root]


@pytest.mark.parametrize("zeros", [0, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_conservative_pair_passes_through_zero(zeros, sign):
    """λ² = ±(0.3 − y): ±σ, which grows, and ±iω, which does not; once, beside eigenvalues that stay zero."""
    ((y, root, grows),) = met(lambda y: [*pair(0, sign * (0.3 - y)), *[0.0] * zeros])
    assert (y, root, grows) == (pytest.approx(0.3, abs=1e-12), 0, sign < 0)


@pytest.mark.parametrize("places", [(0.0, 1.0), (1.0, 0.0), (0.0, 0.2, 0.9), (0.2, 0.6)])
def test_a_damped_pair_is_met_once(places):
    """λ = (y − 0.4) ± i."""
    ((y, root, grows),) = met(lambda y: pair(y - 0.4, -1), places)
    assert (y, root, grows) == (pytest.approx(0.4, abs=1e-9), pytest.approx(1j), places[-1] > places[0])


def test_two_real_ones_that_merge_in_between_are_not_met_twice():
    """λ = (0.6 − y) ± √(0.2 − y): real and growing at first, a pair from y = 0.2, which ceases to grow at 0.6."""
    ((y, root, grows),) = met(lambda y: pair(0.6 - y, 0.2 - y))
    assert (y, grows) == (pytest.approx(0.6, abs=1e-9), False)
    assert root == pytest.approx(1j * np.sqrt(0.4), abs=1e-8)


def test_two_real_ones_that_cross_are_met_both():
    found = met(lambda y: [y - 0.3, y - 0.7, -1.0])
    assert [(y, root) for y, root, _ in found] == [(pytest.approx(0.3), 0), (pytest.approx(0.7), 0)]


@pytest.mark.slow
def test_a_rolling_disk_comes_to_stand():
    """Upright and rolling on, it falls below u3² = g/(3 R), and swings above."""
    eom = kn.derive(pure_rolling_disk.system())
    upright = dict.fromkeys((c.name for c in eom.coordinates), 0.0)
    branch = kn.continuation(eom, "u3", [1, 2, 6], q=upright, u={"u1": 0, "u2": 0})
    (crossing,) = branch.crossings
    assert crossing.value == pytest.approx(np.sqrt(9.81 / 3 / 0.3), rel=1e-9)
    assert (crossing.between, crossing.grows, crossing.eigenvalue) == ((1, 2), False, 0)


@pytest.mark.parametrize("rounding", [1e-18, -1e-18])
def test_a_mode_that_stays_on_the_axis_is_not_the_one_that_crosses_it(rounding):
    """Both ways to order the modes across have the same distance but for rounding."""
    found = met(lambda y: [0.3 - y + rounding, 0.0])
    assert [(v, root) for v, root, _ in found] == [(pytest.approx(0.3, abs=1e-12), 0)]
