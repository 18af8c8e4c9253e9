# SPDX-License-Identifier: BSD-3-Clause
"""`python -m tests.golden FILE` writes what is made of each system; `python -m tests.golden FILE OTHER` compares two such files.

Of each system: its operations by tier, and a digest of what is emitted for it, C and NumPy.
"""

import argparse
import hashlib
import json
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import kane as kn
from benchmarks.systems import COUNTED
from kane.gallery import GALLERY, load
from tests.systems.draft_kinds import drafted
from tests.systems.drafts import built

RANDOM = 100
"""Random systems, of the kinds that slips of the pen are tried on."""

Record = dict[str, int | str]


def systems() -> Iterator[tuple[str, Callable[[], kn.System]]]:
    """Name and maker of every system."""
    for name in GALLERY:
        yield f"gallery: {name}", load(name).system
    yield from COUNTED.items()
    for seed in range(RANDOM):
        yield f"random {seed}", partial(_random, seed)


def _random(seed: int) -> kn.System:
    return built(drafted(seed))


def record(system: kn.System) -> Record:
    """What is made of a system."""
    eom = kn.derive(system)
    compiled = eom.compile()
    found: Record = {"state": eom.operations.state, "parameter": eom.operations.parameter}
    for target in ("c", "numpy"):
        found[target] = hashlib.sha256(compiled.emit(target).encode()).hexdigest()[:16]
    return found


def written() -> dict[str, Record]:
    """The records of all systems, by name."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kn.KaneWarning)
        return {name: record(make()) for name, make in systems()}


def differences(one: dict[str, Record], other: dict[str, Record]) -> list[str]:
    """A line for each system of which the records differ."""
    lines = []
    for name in sorted({*one, *other}):
        a, b = one.get(name, {}), other.get(name, {})
        parts = [f"{key} {a.get(key)} and {b.get(key)}" for key in sorted({*a, *b}) if a.get(key) != b.get(key)]
        lines += [f"{name}: {'; '.join(parts)}"] if parts else []
    return lines


def main() -> int:
    """1 where the files differ."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("other", type=Path, nargs="?")
    asked = parser.parse_args()
    if asked.other is None:
        asked.file.write_text(json.dumps(written(), indent=1) + "\n")
        return 0
    lines = differences(*(json.loads(path.read_text()) for path in (asked.file, asked.other)))
    print("\n".join(lines) or f"{asked.file} and {asked.other} agree.")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
