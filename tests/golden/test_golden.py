# SPDX-License-Identifier: BSD-3-Clause
"""The comparison sees what differs; records of one system do not."""

from pathlib import Path

import pytest

from tests.golden.compare import Record, differences, read, write
from tests.golden.records import record_of


@pytest.fixture(scope="module")
def pendulum() -> Record:
    return record_of("gallery: pendulum")


def test_records_are_repeatable_and_tell_systems_apart(pendulum: Record) -> None:
    one, again, other = pendulum, record_of("gallery: pendulum"), record_of("gallery: double_pendulum")
    assert differences({"a": one}, {"a": again}) == []
    (line,) = differences({"a": one, "b": one}, {"a": one, "b": other})
    assert line.startswith("b: accelerations ")
    assert differences({"a": one}, {}) != []


@pytest.mark.parametrize("key", ["state", "parameter", "c", "numpy", "status"])
def test_every_entry_is_compared(pendulum: Record, key: str) -> None:
    assert differences({"a": pendulum}, {"a": pendulum | {key: 0}}) == [f"a: {key} {pendulum[key]} and 0"]


@pytest.mark.parametrize(("key", "least"), [("accelerations", 1e-12), ("end", 1e-9)])
def test_numbers_are_compared_beside_the_largest(key: str, least: float) -> None:
    one = {key: [3.0, 0.0]}
    assert differences({"a": one}, {"a": {key: [3.0, 2 * least]}}) == []
    assert differences({"a": one}, {"a": {key: [3.0, 4 * least]}}) != []
    assert differences({"a": one}, {"a": {key: [3.0]}}) != []
    assert differences({"a": one}, {"a": {key: [3.0, float("nan")]}}) != []


def test_fewer_operations_are_no_difference_where_that_is_asked() -> None:
    one = {"state": 9, "parameter": 2, "c": "x"}
    fewer, more, moved = (
        one | {"state": 8, "c": "y"},
        one | {"state": 10, "c": "y"},
        one | {"state": 8, "parameter": 4, "c": "y"},
    )
    assert differences({"a": one}, {"a": fewer}, falling=True) == []
    assert all(differences({"a": one}, {"a": other}, falling=True) for other in (more, moved))
    assert differences({"a": one}, {"a": fewer}) != []


def test_files_keep_records(tmp_path: Path) -> None:
    records = {"a": {"state": 1, "end": [0.1, -1e-300], "said": "ẋ"}}
    for name in ("a.json", "a.json.gz"):
        write(tmp_path / name, records)
        assert read(tmp_path / name) == records
