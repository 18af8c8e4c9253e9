# SPDX-License-Identifier: BSD-3-Clause
"""The console blocks of the page on the command line: each command runs and prints the lines shown."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.cli.command import kane

PAGE = Path(__file__).resolve().parents[2] / "docs" / "howto" / "command_line.md"


@pytest.mark.slow
def test_console_blocks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```console\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    ran = 0
    for block in blocks:
        for part in re.split(r"^\$ kane ", block, flags=re.MULTILINE)[1:]:
            command, *shown = part.splitlines()
            printed = kane(*shlex.split(command)).stdout
            pattern = "".join(".*" if piece == "…" else re.escape(piece) for piece in re.split("(…)", "\n".join(shown)))
            assert re.fullmatch(pattern, printed.rstrip("\n"), flags=re.DOTALL), (command, printed)
            ran += 1
    assert ran == 6
