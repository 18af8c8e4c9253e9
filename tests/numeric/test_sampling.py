# SPDX-License-Identifier: BSD-3-Clause
"""What is drawn for a symbol follows from the seed and its declaration: from no order, no process and no other symbol."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import kane as kn
from kane.expr import rate
from kane.numeric import HIGH, LOW, draw, sample, value_of, values_of

Q = kn.coordinates("q1:6")
SYMBOLS = (*Q, *kn.speeds("u1:4"), *map(rate, Q), kn.parameter("m", unit="kg"), kn.input("F"), kn.time)
MASS = kn.parameter("mass", 2.5)

ELSEWHERE = """
import kane as kn
from kane.expr import rate
from kane.numeric import draw
Q = kn.coordinates("q1:6")
symbols = (*Q, *kn.speeds("u1:4"), *map(rate, Q), kn.parameter("m", unit="kg"), kn.input("F"), kn.time)
print(*(draw(7, s).hex() for s in reversed(symbols)))
"""


def test_the_order_of_asking_does_not_matter():
    forwards, backwards = values_of(SYMBOLS, 7), values_of(SYMBOLS[::-1], 7)
    assert forwards == backwards
    assert all(values_of([s], 7) == {s: forwards[s]} for s in SYMBOLS)
    together = sample(SYMBOLS, 7)
    assert together == [sample([s], 7)[0] for s in SYMBOLS] == list(forwards.values())


@pytest.mark.slow
@pytest.mark.parametrize("hash_seed", ["0", "1"])
def test_another_process_draws_the_same(hash_seed):
    printed = subprocess.run(
        [sys.executable, "-c", ELSEWHERE],
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    assert [float.fromhex(x) for x in printed] == [draw(7, s) for s in reversed(SYMBOLS)]


def test_seeds_and_symbols_tell_draws_apart():
    drawn = [draw(seed, s) for seed in (1, 2, 3) for s in SYMBOLS]
    assert len(set(drawn)) == len(drawn)
    assert draw(1, kn.coordinate("q1")) != draw(1, kn.coordinate("q1", unit="m")) != draw(1, kn.speed("q1"))


def test_draws_are_uniform_and_do_not_follow_each_other():
    """Means and variances of 4,000 numbers, and correlations between neighbouring symbols and seeds, within four deviations."""
    table = np.array([[draw(seed, s, 0.0, 1.0) for s in kn.coordinates("x0:200")] for seed in range(20)])
    assert 0 <= table.min() < 0.01
    assert 0.99 < table.max() < 1
    assert table.mean() == pytest.approx(0.5, abs=4 * np.sqrt(1 / 12 / table.size))
    assert table.var() == pytest.approx(1 / 12, abs=4 * np.sqrt(1 / 180 / table.size))
    for a, b in ((table[:, 1:], table[:, :-1]), (table[1:], table[:-1])):
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 4 / np.sqrt(a.size)


def test_a_value_for_every_symbol():
    """The one given, else the default, else a number drawn."""
    q, r = Q[:2]
    values = values_of([q, r, MASS], 3, {q: 5.0})
    assert values == {q: 5.0, r: draw(3, r), MASS: 2.5}
    assert LOW <= values[r] < HIGH
    assert values_of([MASS], 3, {MASS: 4.0}) == {MASS: 4.0}
    assert value_of(MASS, 3) == 2.5
    assert sample([q * MASS + kn.sin(kn.pi)], 3) == [pytest.approx(2.5 * draw(3, q))]
