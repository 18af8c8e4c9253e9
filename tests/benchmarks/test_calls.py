# SPDX-License-Identifier: BSD-3-Clause
"""What the benchmark of calls times is the same motion on every side; no test asserts a time."""

import pytest

from benchmarks.calls_table import BY_NAME, OVER, PARTS, ROWS, SINGLE, TARGETS, document, targets
from benchmarks.rhs_cases import pendulum
from tests.peer import require


@pytest.mark.slow
@pytest.mark.parametrize("rods", [2, 10])
def test_all_sides_give_the_same_numbers(rods):
    require("casadi")
    from benchmarks import calls

    calls.check(pendulum(rods))


def run(single, names, rows):
    def spread(us):
        return {"median": us, "min": us / 2, "max": us * 2}

    over = {SINGLE: {"kane": spread(single), f"kane, {BY_NAME}": spread(names)}, ROWS: {"kane": spread(rows)}}
    return {"pendulum, 2 rods": {"us": {part: {"kane": spread(single)} for part in PARTS}, OVER: over}}


def test_a_target_holds_when_it_does_in_every_run():
    good, slow = run(1.0, 2.0, 8.0), run(1.3, 3.5, 12.0)
    assert [t["holds"] for t in targets([good, good])] == [True] * len(TARGETS)
    assert [t["holds"] for t in targets([good, slow])] == [False] * len(TARGETS)


def test_the_page_says_what_was_measured():
    runs = [run(1.0, 2.0, 8.0), run(1.1, 2.0, 8.0)]
    page = document(
        {
            "processor": "a processor",
            "versions": {"casadi": "3.8"},
            "rounds": 15,
            "runs": runs,
            "targets": targets(runs),
        }
    )
    assert "a processor; casadi 3.8. Median" in page
    assert "| kane | 1 | 1.00 (0.50 … 2.00) |" in page
    assert "|  | 2 | 1.10 (0.55 … 2.20) |" in page
    assert "a batch of 8 rows over its evaluations, µs | ≤ 10 | 8, 8 | yes |" in page
