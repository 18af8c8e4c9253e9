# SPDX-License-Identifier: BSD-3-Clause
"""The listings in the documentation are what is emitted now."""

from pathlib import Path

import kane as kn
from kane.gallery import rolling_disk

LISTING = Path(__file__).resolve().parents[2] / "docs" / "_static" / "disk.c"


def test_c_of_the_disk():
    emitted = kn.derive(rolling_disk.system()).compile(name="disk").emit("c", ["rhs"])
    assert LISTING.read_text(encoding="utf-8") == emitted
