# SPDX-License-Identifier: BSD-3-Clause
"""Files of records, and what differs between two."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np

Record = dict[str, Any]
COUNTS = ("state", "parameter")
TEXTS = ("c", "numpy")
TOLERANCES = {"accelerations": 1e-12, "end": 1e-9}
"""Of the largest number of a record, or of 1: rounding differs between machines, and with what is regrouped."""


def write(path: Path, records: dict[str, Record]) -> None:
    """Write records, compressed where the name says so; equal records make equal bytes."""
    text = json.dumps(records, indent=0, ensure_ascii=False) + "\n"
    path.write_bytes(gzip.compress(text.encode(), mtime=0) if path.suffix == ".gz" else text.encode())


def read(path: Path) -> dict[str, Record]:
    """The records of a file."""
    data = path.read_bytes()
    found: dict[str, Record] = json.loads(gzip.decompress(data) if path.suffix == ".gz" else data)
    return found


def differences(one: dict[str, Record], other: dict[str, Record], falling: bool = False) -> list[str]:
    """A line for each system of which the records differ; `falling`: fewer operations in `other`, and its text, are no difference."""
    lines = []
    for name in sorted({*one, *other}):
        a, b = one.get(name, {}), other.get(name, {})
        passed = {*COUNTS, *TEXTS} if falling and _fewer(a, b) else set()
        keys = [key for key in sorted({*a, *b} - passed) if not _equal(key, a.get(key), b.get(key))]
        lines += [f"{name}: {'; '.join(f'{key} {a.get(key)} and {b.get(key)}' for key in keys)}"] if keys else []
    return lines


def _fewer(a: Record, b: Record) -> bool:
    """No more operations of the state and in sum."""
    if not all(key in r for key in COUNTS for r in (a, b)):
        return False
    return bool(b["state"] <= a["state"] and b["state"] + b["parameter"] <= a["state"] + a["parameter"])


def _equal(key: str, a: Any, b: Any) -> bool:
    tolerance = TOLERANCES.get(key)
    if tolerance is None or a is None or b is None or len(a) != len(b):
        return bool(a == b)
    x, y = np.array(a), np.array(b)
    return bool(np.all(np.abs(x - y) <= tolerance * np.max(np.abs(x), initial=1.0)))
