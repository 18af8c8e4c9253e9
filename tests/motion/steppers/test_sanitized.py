# SPDX-License-Identifier: BSD-3-Clause
"""The integrators' C reads and writes nothing but its arrays, and does nothing that is undefined."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.motion.steppers.sanitized import NAMES
from tests.program.programs import compiler


@pytest.mark.slow
def test_sanitizers_find_nothing(tmp_path):
    names = ("libasan.so", "libubsan.so")
    found = [
        subprocess.run([compiler(), f"-print-file-name={n}"], capture_output=True, text=True, check=True) for n in names
    ]
    libraries = [f.stdout.strip() for f in found]
    if not all(Path(library).is_absolute() for library in libraries):
        pytest.skip("the compiler has no sanitizers")
    environment = {**os.environ, "LD_PRELOAD": ":".join(libraries), "ASAN_OPTIONS": "detect_leaks=0"}
    command = [sys.executable, "-m", "tests.motion.steppers.sanitized", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, timeout=900)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == list(NAMES)
