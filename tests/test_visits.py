# SPDX-License-Identifier: BSD-3-Clause
"""Few files stand between a declaration and its motion."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "requirements" / "visits.py"


@pytest.mark.slow
def test_a_pendulum_a_four_bar_and_an_event_visit_no_more_files_than_stated():
    found = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    assert {line.split()[0] for line in found.stdout.splitlines()[:3]} == {"pendulum", "four_bar", "event"}
