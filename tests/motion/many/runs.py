# SPDX-License-Identifier: BSD-3-Clause
"""Many motions with a store, as a process that is killed: `python -m tests.motion.many.runs STORE [ADDRESS]`."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import kane as kn
from kane.gallery import pendulums

COUNT, CHUNK = 2000, 64
ROOT = Path(__file__).parents[3]
EOM = kn.derive(pendulums.system(2))


def run(store=None, **more):
    """Double pendulums, some with parameters of which there is no motion, and with a vector and a reduction among the outputs."""
    q1, q2 = np.linspace(0.1, 2.5, COUNT), np.linspace(-1, 1, COUNT)
    m1 = np.where(np.arange(COUNT) % 97 == 5, -1.0, 1.5)
    outputs = {"q1": "q1", "energy": EOM.energy, "force": EOM.speeds[0] * EOM.system.inertial.x}
    given = {"q": {"q1": q1, "q2": q2}, "u": [0, 0], "parameters": {"m1": m1}, "outputs": outputs, "samples": 20}
    given |= {"reduce": {"energy": "max"}, "threads": 2, "store": store}
    return kn.simulate_many(EOM, (0, 20), **given | ({} if store is None else {"chunk": CHUNK}) | more)


def started(*words):
    """This module as a process of its own."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (*sys.path, ROOT)))}
    command = [sys.executable, "-m", "tests.motion.many.runs", *map(str, words)]
    return subprocess.Popen(command, cwd=ROOT, env=environment, start_new_session=True)


def killed(process, store, seconds):
    """Kill a process `seconds` after its store is there; whether it was still running."""
    while not store.exists() and process.poll() is None:
        time.sleep(0.002)
    time.sleep(seconds)
    running = process.poll() is None
    if running:
        os.kill(process.pid, signal.SIGKILL)
    process.wait()
    return running


if __name__ == "__main__":
    run(sys.argv[1])
