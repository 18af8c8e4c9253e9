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
    for name, limit in json.loads(LIMITS.read_text()).items():
        for kind in ("total", "emitted"):
            assert found[name][kind] <= limit, f"{name}: {found[name][kind]} operations ({kind}), limit {limit}"
