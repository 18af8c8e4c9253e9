# SPDX-License-Identifier: BSD-3-Clause
"""Many motions with a store, as a process that is killed: `python -m tests.motion.many.runs STORE [local | FILE of a scheduler]`."""

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


def same(stored, kept):
    """What a store has is what there is in memory: names, dimensions, attributes and bits; texts are of another type."""
    import xarray

    found = stored.load()
    texts = {name for name, v in {**kept.data_vars, **kept.coords}.items() if v.dtype.kind == "U"}
    assert {name for name, v in found.variables.items() if v.dtype.kind not in "if"} == texts
    found = found.assign({name: found[name].astype(kept[name].dtype) for name in texts})
    xarray.testing.assert_identical(found, kept)
    assert list(found) == list(kept)


def environment():
    """That of a process which finds what this one finds."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (*sys.path, ROOT)))}


def started(*words, module="tests.motion.many.runs", **more):
    """A module as a process of its own."""
    command = [sys.executable, "-m", module, *map(str, words)]
    return subprocess.Popen(command, cwd=ROOT, env=environment(), start_new_session=True, text=True, **more)


def records(store, count, process=None):
    """Wait until a store has as many whole chunks, or the process that writes it has ended."""
    while len(list(store.glob("status/c/*"))) < count and (process is None or process.poll() is None):
        time.sleep(0.005)


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


def main(store, cluster=""):
    """Run them, on a cluster of this process or of a scheduler that wrote a file."""
    if not cluster:
        run(store)
        return
    import distributed

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    own = distributed.LocalCluster(**options) if cluster == "local" else None
    place = {"address": own} if own else {"scheduler_file": cluster}
    try:
        run(store, client=distributed.Client(timeout=3, **place))
    except kn.SimulationError as error:
        print(error)
        sys.stdout.flush()
        os._exit(3)  # clients that have lost their scheduler take their time to end


if __name__ == "__main__":
    main(*sys.argv[1:])
