# SPDX-License-Identifier: BSD-3-Clause
"""`python -m tests.golden` makes every system anew and compares it with the committed file; `--write` writes that file.

`python -m tests.golden --to FILE` writes what is made here, and `python -m tests.golden FILE OTHER` compares two such files.
"""

import argparse
import sys
from pathlib import Path

from tests.golden import compare, records

COMMITTED = Path(__file__).with_name("golden.json.gz")


def main() -> int:
    """1 where the files differ."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "files", type=Path, nargs="*", help="one or two files instead of what is made here and the committed one"
    )
    parser.add_argument("--to", type=Path, help="write what is made here to this file")
    parser.add_argument("--write", action="store_true", help=f"write what is made here to {COMMITTED.name}")
    parser.add_argument("--random", type=int, default=records.RANDOM, help="how many random systems")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument(
        "--counts-fall", action="store_true", help="fewer operations, and other text with them, are no difference"
    )
    asked = parser.parse_args()
    if len(asked.files) > 2:
        parser.error(f"Expected at most two files, got {len(asked.files)}")
    made = [compare.read(file) for file in asked.files]
    if len(made) < 2:
        made = [*(made or [records.made(asked.random, asked.jobs)])]
    if target := asked.to or (COMMITTED if asked.write else None):
        compare.write(target, made[0])
        return 0
    one, other = made if len(made) == 2 else (compare.read(COMMITTED), made[0])
    if len(asked.files) == 0:
        one = {name: one[name] for name in one if name in other or not name.startswith("random")}
    lines = compare.differences(one, other, falling=asked.counts_fall)
    print("\n".join(lines) or f"{len(other)} systems agree.")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
