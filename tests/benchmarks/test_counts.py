# SPDX-License-Identifier: BSD-3-Clause
"""Operation counts are committed: a change of any of them must be meant."""

import json

import pytest

from benchmarks.counts import COUNTS, LIMITS, counts


@pytest.fixture(scope="module")
def found():
    return counts()


def test_counts_are_those_committed(found):
    committed = json.loads(COUNTS.read_text())
    assert found == committed, "operation counts changed; if that is meant: python -m benchmarks.counts --write"


def test_counts_keep_their_limits(found):
    for key, limit in json.loads(LIMITS.read_text()).items():
        name, _, kind = key.partition(": ")
        for own in (kind,) if kind else ("total", "emitted"):
            assert found[name][own] <= limit, f"{name}: {found[name][own]} operations ({own}), limit {limit}"


def test_the_page_of_benchmarks_shows_them(found):
    lines = (
        (LIMITS.parent.parent / "docs" / "benchmarks" / "index.md")
        .read_text()
        .split("| system | state |")[1]
        .split("\n\n")[0]
        .splitlines()[2:]
    )
    shown = [[int(x.replace(",", "")) for x in line.split("|")[2:6]] for line in lines]
    own = [[c[k] for k in ("state", "parameter", "total", "emitted")] for c in found.values()]
    assert len(shown) > 5
    assert [row for row in shown if row not in own] == []


def test_derivatives_of_an_arm_take_at_most_four_right_hand_sides(found):
    """All of d(q', u')/d(q, u), of an arm whose axes meet and of one with general axes."""
    for name in ("7R arm with wrist, full inertias", "7R arm, general axes"):
        assert found[name]["jacobian"] <= 4 * found[name]["total"]
