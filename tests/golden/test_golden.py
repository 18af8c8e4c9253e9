# SPDX-License-Identifier: BSD-3-Clause
"""The comparison sees what differs; records of one system do not."""

import pytest

from kane.gallery import load
from tests.golden.__main__ import differences, record


def test_records_are_repeatable_and_tell_systems_apart() -> None:
    one, again, other = (record(load(name).system()) for name in ("pendulum", "pendulum", "double_pendulum"))
    assert differences({"a": one}, {"a": again}) == []
    (line,) = differences({"a": one, "b": one}, {"a": one, "b": other})
    assert line.startswith("b: c ")
    assert differences({"a": one}, {}) != []


@pytest.mark.parametrize("key", ["state", "parameter", "c", "numpy"])
def test_every_entry_is_compared(key: str) -> None:
    one = record(load("pendulum").system())
    assert differences({"a": one}, {"a": one | {key: 0}}) == [f"a: {key} {one[key]} and 0"]
