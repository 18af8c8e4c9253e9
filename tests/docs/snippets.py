# SPDX-License-Identifier: BSD-3-Clause
"""The Python blocks of a page, run from top to bottom as one script, and what each of them prints.

A block of text or of LaTeX right below a Python block is what that block prints; "…" in it stands for anything. A Python block
below the comment `<!-- fragment -->` is not run.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PAGES = (
    "README.md",
    *sorted(p.relative_to(ROOT).as_posix() for p in (ROOT / "docs").rglob("*.md") if "_build" not in p.parts),
)

MOST = 60.0
"""What the blocks of a page may take of a processor (s), however busy the machine is; the longest page takes a quarter of it."""

_BLOCK = re.compile(
    r"^(?P<fragment><!-- fragment -->\n)?```python\n(?P<code>.*?)^```\n(?:\n?```(?:text|latex)\n(?P<shown>.*?)^```$)?",
    re.DOTALL | re.MULTILINE,
)
_END = "\x1e"


class Block(NamedTuple):
    """Code, and what the page says that it prints; None where it says nothing."""

    code: str
    shown: str | None


def blocks(text: str) -> list[Block]:
    """The blocks of a page that run."""
    return [Block(m["code"], m["shown"]) for m in _BLOCK.finditer(text) if not m["fragment"]]


def printed(found: list[Block], folder: Path) -> list[str]:
    """What each block prints."""
    script = folder / "page.py"
    script.write_text(f"print({_END!r}, end='')\n".join(block.code for block in found), encoding="utf-8")
    before = os.times()
    done = subprocess.run(
        [sys.executable, "-W", "error", str(script)],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    spent = os.times()
    spent_s = spent.children_user + spent.children_system - before.children_user - before.children_system
    assert spent_s < MOST, f"the page takes {spent_s:.0f} s of a processor"
    return done.stdout.split(_END)


def agrees(shown: str, output: str) -> bool:
    """Whether the output is the one shown, white space at the ends of lines apart."""
    lines = "\n".join(line.rstrip() for line in output.rstrip().splitlines())
    pattern = "".join(".*" if piece == "…" else re.escape(piece) for piece in re.split("(…)", shown.rstrip()))
    return re.fullmatch(pattern, lines, flags=re.DOTALL) is not None
