# SPDX-License-Identifier: BSD-3-Clause
"""Chunks on a Dask cluster are those of this process, bit for bit, whichever of its processes are killed."""

from __future__ import annotations

import os
import signal
import subprocess
import threading

import numpy as np
import pytest

import kane as kn
from tests.examples import FULL
from tests.motion.many import runs
from tests.peer import require

xarray = require("xarray")
require("zarr")
distributed = require("distributed")


@pytest.fixture(scope="module")
def undisturbed():
    return runs.run()


@pytest.fixture(scope="module")
def client():
    options = {"n_workers": 2 if FULL else 1, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        yield client


@pytest.mark.slow
def test_in_memory(client, undisturbed):
    xarray.testing.assert_identical(runs.run(client=client, chunk=100), undisturbed)


@pytest.mark.grows
def test_in_a_store(client, undisturbed, tmp_path):
    """All workers write, and what is there is not run again."""
    path = tmp_path / "runs.zarr"
    runs.same(runs.run(path, client=client), undisturbed)
    for k in (3, 5):
        (path / "q1" / "c" / str(k) / "0").unlink()
    (path / "status" / "c" / "3").unlink()
    found = runs.run(path, client=client)
    lost = np.isnan(found["q1"].values).all(axis=1) & (undisturbed.status.values == "finished")
    assert np.unique(np.flatnonzero(lost) // runs.CHUNK).tolist() == [5]


def test_what_workers_raise(client):
    """A law of Python goes with the chunks, and its error stays with its instance; an error of a reduction comes back."""
    x, v, F, N = kn.coordinate("x"), kn.speed("v"), kn.input("F"), kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("b", P, 1)], speeds={v: x.dt}, loads=[kn.Force(P, F * N.x)]))

    def law(t, state):
        if state[0] < 0:
            raise ValueError("there is no force")
        return -(state[0] ** 0.5)

    given = {"q": {x: [1.0, -1.0, 2.0]}, "u": {v: 0}, "samples": 3, "inputs": {F: law}}

    def gone(values):
        raise kn.SimulationError("not these")

    with pytest.warns(kn.KaneWarning, match="Python functions"):
        found = kn.simulate_many(eom, (0, 0.1), client=client, chunk=2, **given)
    with pytest.warns(kn.KaneWarning, match="Python functions"):
        xarray.testing.assert_identical(found, kn.simulate_many(eom, (0, 0.1), **given))
    assert found.cause.values[1].startswith("Expected numbers from the function of the state for F, got ValueError")
    with pytest.raises(kn.SimulationError, match="not these"), pytest.warns(kn.KaneWarning):
        kn.simulate_many(eom, (0, 0.1), client=client, reduce=gone, **given)


@pytest.mark.parametrize("client", ["tcp://127.0.0.1:1", 3, distributed.Client])
def test_no_client(client):
    with pytest.raises(
        kn.SimulationError, match=r"Expected a Client of Dask's distributed as client=, got .*Write client="
    ):
        runs.run(client=client)


@pytest.mark.slow
def test_a_killed_worker(client, undisturbed, tmp_path):
    """Another one runs its chunks; the one that takes its place joins in."""
    path = tmp_path / "runs.zarr"
    pid = min(client.run(os.getpid).values())

    def kill():
        runs.records(path, 3)
        os.kill(pid, signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    found = runs.run(path, client=client)
    thread.join()
    client.wait_for_workers(2)
    assert pid not in client.run(os.getpid).values()
    runs.same(found, undisturbed)


@pytest.mark.slow
def test_a_killed_driver(undisturbed, tmp_path, rng):
    """The process that holds the scheduler dies at any moment, more than once."""
    path = tmp_path / "runs.zarr"
    for k in range(4):
        process = runs.started(path, "local", stderr=subprocess.DEVNULL)
        runs.records(path, 2 + 6 * k, process)
        assert runs.killed(process, path, rng.uniform(0, 0.3))
    runs.same(runs.run(path), undisturbed)


@pytest.mark.slow
def test_a_killed_scheduler(undisturbed, tmp_path):
    path, file = tmp_path / "runs.zarr", tmp_path / "scheduler.json"
    quiet = {"stderr": subprocess.DEVNULL, "stdout": subprocess.DEVNULL}
    place = ("--scheduler-file", file, "--no-dashboard")
    options = ("--nthreads", 1, "--no-nanny", "--local-directory", tmp_path)
    scheduler = runs.started(
        *place, "--port", 0, "--host", "127.0.0.1", module="distributed.cli.dask_scheduler", **quiet
    )
    workers = [runs.started(*place, *options, module="distributed.cli.dask_worker", **quiet) for _ in range(2)]
    try:
        driver = runs.started(path, file, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        runs.records(path, 3, driver)
        scheduler.kill()
        told, _ = driver.communicate(timeout=90)
    finally:
        for process in (scheduler, *workers):
            process.kill()
            process.wait()
    assert driver.returncode == 3
    assert told.startswith("Expected the cluster tcp://127.0.0.1:")
    assert "call again: with store= only the chunks that are missing are run" in told
    runs.same(runs.run(path), undisturbed)
