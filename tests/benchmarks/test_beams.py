# SPDX-License-Identifier: BSD-3-Clause
"""What the benchmark of beams times is the manoeuvre of the literature on both sides; no test asserts a time."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks import beams, beams_table
from tests.literature import test_spin_up as spin_up


def test_the_manoeuvre_is_that_of_the_literature() -> None:
    """0.5744 m, with the tolerances that are timed; one mode is within 1 %."""
    assert beams.manoeuvre(3)() == pytest.approx(-spin_up.PEAK, rel=1e-3)
    assert beams.fewest_modes(-spin_up.PEAK) == 1


def run(ratio: float) -> dict[str, Any]:
    spread = {"median": 0.01, "min": 0.005, "max": 0.02}
    return {
        "reference": 0.5739,
        "modes": 1,
        "setting": "2 elements, 800 steps",
        "errors": {"fewest": 0.0068, "all": -0.0001, "Exudyn": 0.0011},
        "operations": 134,
        "fewest": spread,
        "all": spread,
        "Exudyn": {"median": 0.01 * ratio, "min": 0.1, "max": 1.0},
        "derivation": spread,
        "ratios": {"fewest": ratio, "all": ratio},
    }


def test_a_target_holds_when_it_does_in_every_run() -> None:
    assert [t["holds"] for t in beams_table.targets([run(30), run(40)])] == [True, True, True]
    assert [t["holds"] for t in beams_table.targets([run(30), run(10)])] == [False, False, True]


def test_the_page_says_what_was_measured() -> None:
    runs = [run(30), run(10)]
    record = {
        "processor": "some processor",
        "versions": {"exudyn": "1.13.6"},
        "rounds": 15,
        "finest": "6 elements",
        "runs": runs,
        "targets": beams_table.targets(runs),
    }
    page = beams_table.document(record)
    assert "some processor; exudyn 1.13.6. Median" in page
    assert "| 1 | kane, modes: 1 | 0.68% | 10.0 (5.0 … 20.0) | 30 |" in page
    assert "| 2 | 2 elements, 800 steps | 0.11% | 100.0 (100.0 … 1000.0) |  |" in page
    assert "| times of Exudyn's coarsest mesh, by five modes | ≥ 20 | 30, 10 | **no** |" in page
