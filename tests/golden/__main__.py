# SPDX-License-Identifier: BSD-3-Clause
"""`python -m tests.golden` makes every system anew and compares it with the committed file; `--write` writes that file.

`--write FILE` writes another one, and `python -m tests.golden FILE OTHER` compares two such files.
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
    parser.add_argument(
        "--write", type=Path, nargs="?", const=COMMITTED, help=f"write it to a file, by default {COMMITTED.name}"
    )
    parser.add_argument("--random", type=int, default=records.RANDOM, help="how many random systems")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument(
        "--counts-fall", action="store_true", help="fewer operations, and other text with them, are no difference"
    )
    asked = parser.parse_args()
    if len(asked.files) > 2:
        parser.error(f"Expected at most two files, got {len(asked.files)}")
    other = compare.read(asked.files[-1]) if asked.files else records.made(asked.random, asked.jobs)
    if asked.write:
        compare.write(asked.write, other)
        return 0
    one = compare.read(asked.files[0] if len(asked.files) == 2 else COMMITTED)
    if not asked.files:
        one = {name: one[name] for name in one if name in other or not name.startswith("random")}
    lines = compare.differences(one, other, falling=asked.counts_fall)
    print("\n".join(lines) or f"{len(other)} systems agree.")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
