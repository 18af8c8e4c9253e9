# SPDX-License-Identifier: BSD-3-Clause
"""Chunks of many motions as tasks of a Dask cluster.

Equations and instances are sent to each worker once; the worker derives and compiles its own kernels. A task is a chunk on one
thread; the worker writes it to the store or sends it back. Dask repeats tasks of workers that died; since the numbers of a chunk are
always the same, a chunk that is written twice does no harm.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from kane import expect
from kane.equations.instances import package
from kane.errors import KaneError, SimulationError, cut
from kane.motion.many.chunks import Job
from kane.motion.many.stores import write


def checked(client: Any) -> Any:
    """The client, if it is a synchronous one of Dask's distributed.

    Raises
    ------
    ImportError
        without the package distributed
    SimulationError
        if it is not a Client, or is asynchronous
    """
    kind = package("distributed", "cluster").Client
    cure = "Write client=distributed.Client(cluster)."
    expect.instance(client, kind, "a Client of Dask's distributed as client=", cure, error=SimulationError)
    plain = "a client that is not asynchronous as client="
    expect.that(not client.asynchronous, plain, client, cure, error=SimulationError)
    return client


def spread(client: Any, job: Job, chunks: Sequence[range], path: Path | None, told: Callable[[int], Any]) -> list[Any]:
    """Run chunks on a cluster, to the store at `path`, or return their Datasets in order. `told` is called with the number completed.

    Raises
    ------
    SimulationError
        if the cluster is lost, or a chunk repeatedly kills its worker
    """
    found: dict[range, Any] = {}
    done = 0
    with _lost(client):
        shared = client.scatter(job, broadcast=True, hash=False)
        work = {client.submit(_run, shared, rows, path, pure=False): rows for rows in chunks}
        try:
            for future in package("distributed").as_completed(list(work)):
                rows = work.pop(future)
                found[rows] = future.result()
                future.release()
                done += len(rows)
                told(done)
        except BaseException:  # Ctrl-C, too
            client.cancel(list(work), force=True)
            raise
    return [found[rows] for rows in chunks]


def _run(job: Job, rows: range, path: Path | None) -> Any:
    """The task of a worker."""
    chunk = job.chunk(rows, threads=1)
    if path is None:
        return chunk.dataset({})
    write(path, chunk)
    return None


@contextmanager
def _lost(client: Any) -> Iterator[None]:
    try:
        yield
    except KaneError:
        raise
    except Exception as error:  # each layer of a cluster raises its own types when it is lost
        raise SimulationError(
            f"Expected the cluster {client.scheduler_info().get('address', '')} to run every chunk, got {type(error).__name__}: "
            f"{cut(str(error), 300)}. Start it again and call again: with store= only the chunks that are missing are run."
        ) from error
