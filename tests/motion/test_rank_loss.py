# SPDX-License-Identifier: BSD-3-Clause
"""Steps across states at which constraints lose rank: each passage is seen, however long the steps are, and told once."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.dynamics import Partition
from kane.gallery import four_bar, n_four_bar
from kane.motion import crosses, looked_at

PAIR = Partition((0, 1), (0, 1), ())


def turning(turns, away, both=False, start=0.0, end=1.0):
    """Whether a step of so many turns meets rows (1, 0, 0), (cos φ, sin φ, 0) that are parallel twice a turn, but for `away`."""

    def along(t):
        angle = 2 * np.pi * turns * np.asarray(t)
        zero, one = np.zeros_like(angle), np.ones_like(angle)
        if both:  # two rows that vanish at once: their determinant keeps its sign
            rows = [[np.sin(angle), zero, away * one], [zero, np.sin(angle), zero], [zero, zero, one]]
            partition = Partition((0, 1, 2), (0, 1, 2), ())
        else:
            rows, partition = [[one, zero, zero], [np.cos(angle), np.sin(angle), away * one]], PAIR
        return looked_at(np.asarray(t), np.moveaxis(np.array(rows), -1, 0), partition, np.ones((len(rows), 3)))

    return crosses(along, start, end)


@pytest.mark.parametrize("turns", [0.6, 1.0, 7.0, 40.0])
@pytest.mark.parametrize("both", [False, True])
def test_a_step_of_any_length_sees_what_it_passes(turns, both):
    assert turning(turns, 0.0, both, start=0.01 / turns)


@pytest.mark.parametrize(
    ("turns", "start", "end"), [(0.4, 0.1, 1.0), (0.5, 0.0, 1.0), (0.5, 0.0, 0.7), (1.0, 0.5, 0.9)]
)
@pytest.mark.parametrize("both", [False, True])
def test_where_a_step_begins_or_ends_is_not_between(turns, start, end, both):
    assert not turning(turns, 0.0, both, start, end)


def test_one_passage_more_than_where_it_begins():
    assert turning(0.6, 0.0, start=0.0)
    assert turning(5.0, 0.0, start=0.0)


def test_dependent_speeds_that_do_not_follow_in_passing_are_seen_where_rank_is_kept():
    assert turning(0.6, 0.3, start=0.01)


def told(sol):
    return [t for e, t in sol.events if e.name == "rank of the constraints drops"]


def test_a_kite_that_turns_steadily():
    """Without gravity the crank keeps its speed, so that steps grow: 1 of 3 passages was told."""
    eom, pace = kn.derive(four_bar.system()), 6.0
    sizes = {"a": 0.5, "b": 0.5, "c": 1.0, "d": 1.0, "g": 0.0}
    start = {"q": {"q1": 1.2, "q2": kn.guess(-0.8), "q3": kn.guess(1.0)}, "u": {"u1": pace}}
    passages = (np.arange(1, 4) * np.pi - 1.2) / pace
    sol = kn.simulate(eom, (0, 1.6), parameters=sizes, method="RK45", samples=2, **start)
    np.testing.assert_allclose(told(sol), passages, atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("method", "gravity"), [("DOP853", 9.81), ("RK45", 0.0)])
def test_two_windows_lose_two_rows_at_once(method, gravity):
    """Their determinant does not change its sign: no passage was told."""
    eom = kn.derive(n_four_bar.system())
    sol = kn.simulate(eom, (0, 5), parameters={"g": gravity}, method=method, samples=2001, **n_four_bar.START)
    flat = np.cos(sol["q0"])
    k = np.flatnonzero(flat[:-1] * flat[1:] < 0)
    assert len(k) >= 2
    np.testing.assert_allclose(told(sol), (sol.t[k] + sol.t[k + 1]) / 2, atol=2e-3)
