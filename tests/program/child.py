# SPDX-License-Identifier: BSD-3-Clause
"""Code in a process of its own, so that a crash or a deadlock is seen."""

import os
import signal
import subprocess
import sys
import textwrap


def child(code, folder="off", timeout=60, **environment):
    """What the code prints; its cache is `folder`. Warnings are errors there too."""
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", textwrap.dedent(code)],
        env={**os.environ, "KANE_CACHE": str(folder), **environment},
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
    how = signal.strsignal(-run.returncode) if run.returncode < 0 else run.returncode
    assert run.returncode == 0, f"the child ended with: {how}\n{run.stdout}\n{run.stderr}"
    return run.stdout
