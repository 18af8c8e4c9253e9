# SPDX-License-Identifier: BSD-3-Clause
"""What the bicycle benchmark times is the same bicycle on both sides; no test asserts a time."""

import pytest

from benchmarks import bicycle
from benchmarks.bicycle_table import TARGETS, document, targets


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_both_sides_have_the_same_accelerations(seed):
    assert bicycle.difference(seed) < 1e-9


def run(derivation, linearization):
    def spread(seconds):
        return {"median": seconds, "min": seconds / 2, "max": seconds * 2}

    return {
        "difference": 1e-13,
        "derivation": {"kane, s": spread(derivation), "SymPy, s": spread(2.0), "ratio": 2.0 / derivation},
        "linearization": {"kane, s": spread(linearization), "kane ready, s": 1.5},
    }


def test_a_target_holds_when_it_does_in_every_run():
    good, slow = run(0.05, 0.005), run(0.2, 0.02)
    assert [t["holds"] for t in targets([good, good])] == [True] * len(TARGETS)
    assert [t["holds"] for t in targets([good, slow])] == [False] * len(TARGETS)


def test_the_page_says_what_was_measured():
    runs = [run(0.05, 0.005), run(0.2, 0.02)]
    setting = {"processor": "some processor", "versions": {"sympy": "1.14.0"}, "pairs": 15, "points": 100}
    setting["SymPy linearization"] = {"s": 90.04, "difference": 1e-12}
    page = document({**setting, "runs": runs, "targets": targets(runs)})
    assert "some processor; sympy 1.14.0." in page
    assert "| 1 | 50.0 (25.0 … 100.0) | 2000.0 (1000.0 … 4000.0) | 40 |" in page
    assert "| 2 | 20.0 (10.0 … 40.0) | 1.50 |" in page
    assert "its derivation left out: 90.0 s." in page
    assert "| numeric linearization, kane, s | ≤ 0.01 | 0.005, 0.02 | **no** |" in page
