# SPDX-License-Identifier: BSD-3-Clause
"""The example of the README runs, and draws its picture."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "examples" / "sliding_disk.py"


@pytest.mark.slow
def test_sliding_disk(tmp_path: Path) -> None:
    target = tmp_path / "disk.png"
    done = subprocess.run(
        [sys.executable, "-W", "error", str(SCRIPT), str(target)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "onset of rolling" in done.stdout
    assert 10_000 < target.stat().st_size < 150_000
