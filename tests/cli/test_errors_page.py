# SPDX-License-Identifier: BSD-3-Clause
"""The console blocks of the page on errors: each command, run beside a file with that slip, prints the lines shown."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from kane.cli import app
from tests.cli import bad

HERE = Path(__file__).resolve()
PAGE = HERE.parents[2] / "docs" / "howto" / "errors.md"
BLOCKS = re.findall(r"^```console\n\$ kane (.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def test_there_are_examples():
    assert len(BLOCKS) == 8


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.splitlines()[0])
def test_console_block(block, tmp_path, monkeypatch):
    command, *shown = block.splitlines()
    monkeypatch.chdir(tmp_path)
    bad.written(Path(command.split()[-1]).stem, tmp_path)
    ran = CliRunner().invoke(app, shlex.split(command))
    printed = (ran.stderr or ran.stdout).rstrip("\n")
    assert ran.exit_code == (0 if "Warnings" in shown else 1)
    pattern = "".join(".*" if piece == "…" else re.escape(piece) for piece in re.split("(…)", "\n".join(shown)))
    assert re.fullmatch(pattern, printed, flags=re.DOTALL), printed
