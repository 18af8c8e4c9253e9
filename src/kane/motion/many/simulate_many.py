# SPDX-License-Identifier: BSD-3-Clause
"""`simulate_many`: the motions of many instances, on threads and in vector lanes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from kane import expect
from kane.equations.equations import Equations, check_equations
from kane.equations.instances import Instances, instances, package
from kane.errors import SimulationError, warn
from kane.expr.node import Expr
from kane.expr.piecewise import Table
from kane.motion.derivatives.parametric_motion import unknowns
from kane.motion.inputs.expressions import Sampled
from kane.motion.inputs.functions import Signal
from kane.motion.integrators import AdaptiveStep, FixedStep
from kane.motion.many import designs
from kane.motion.many.chunks import Job
from kane.motion.many.cluster import checked, spread
from kane.motion.many.results import RecordedQuantity, check_names, quantities
from kane.motion.many.stores import Store, write
from kane.motion.many.stores import begun as opened
from kane.motion.many.tiles import Ensemble, cores, cut_into, tiles_of
from kane.motion.many.varied import begun, check_reduced, obstacle, one_by_one, tidied, varied_for
from kane.motion.runner import Plan
from kane.motion.solution.checks import checking_functions
from kane.motion.start import check_span, sample_times
from kane.program.native.machine import Settings
from kane.progress import far, working


def simulate_many(
    eom: Equations,
    span: tuple[float, float],
    *,
    q: Any = None,
    u: Any = None,
    states: Any = None,
    parameters: Any = None,
    inputs: Mapping[Any, Any] | None = None,
    design: Any = None,
    sampler: str | None = None,
    count: int | None = None,
    seed: int | None = None,
    outputs: Mapping[str, Any] | None = None,
    by: Any = None,
    reduce: Any = None,
    threads: int | None = None,
    lanes: bool | None = None,
    store: Any = None,
    chunk: int | None = None,
    client: Any = None,
    method: str | AdaptiveStep | FixedStep | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    samples: int | Sequence[float] = 501,
    max_steps: int | None = None,
    max_step: float | None = None,
    first_step: float | None = None,
    breakpoints: Sequence[float] | None = None,
    max_seconds: float | None = None,
    settings: Settings | None = None,
    check: Sequence[Any] = (),
) -> Any:
    """Simulate many motions over one time span, on threads and in vector lanes where a kernel can run them without Python.

    Motions in lanes agree with `kn.simulate` by the same method to rounding, and bit for bit from the same initial state with
    `kn.Settings(contract=False)`; other motions agree bit for bit in any case. In lanes, "auto" selects "vern9" where it selects
    "gauss16" for a single motion. Initial states on constraints are computed for all instances together, on the branch nearest to
    the guesses, and agree with `kn.assemble` to rounding. An instance that stops or chatters in lanes is run again individually, by
    the specified method. Equations and kernels are prepared once. An instance that fails does not affect the others; `status` and
    `cause` report it. Motions with Python functions as inputs run one after the other.

    Parameters
    ----------
    eom : Equations
    span : (float, float)
        beginning and end (s)
    q, u, states, parameters : initial values and parameters, each a number for all instances or an array (n), by symbol or name, in
        a dict, a pandas DataFrame or an xarray Dataset; or an array (n × number of symbols) in order
    inputs : as for `kn.simulate`, the same for all instances; or an array (n) of constants. Parameters in expressions have the values
        of the instance
    design : a table as above with names of any kind, or, with a sampler, {name: (low, high)}
    sampler : "sobol", "latin", "halton" or "uniform" for `count` points between the bounds; "product" for all combinations of the
        numbers {name: [levels]}
    count, seed : number of instances that the sampler draws, and its seed; the default seed is fixed
    outputs : {name: expression, vector, or name}, recorded instead of the coordinates, speeds and states
    by : parameters, of the equations or of inputs that are expressions, and coordinates, speeds or states, which stand for their
        initial values: variables "…_by" (instance, t, by) are the derivatives of the recorded quantities, integrated as further
        states, in lanes, with saltation matrices at events. With contacts, actions in Python or under constraints, events that
        depend only on values set by other events, or breakpoints that depend on the parameters, each motion is differentiated
        separately as by `kn.fitting.sensitivities`, and a store is not possible
    reduce : "last", "max", "min", "mean" over t, or a function of the values (samples × …) of an instance, which are NaN beyond its
        end; or a dict of these by output
    threads : number of threads; by default the number of processors
    lanes : whether to use lanes for motions that support them; by default from 64 instances on, if vector registers of the processor
        have four lanes or more. Without lanes each motion equals that of `kn.simulate`, bit for bit
    store : path of a directory, such as "runs.zarr", to which results are written chunk by chunk in Zarr 3 format, so that memory
        does not grow with the number of instances. A repeated call, also after the process was killed, runs only the missing
        chunks. The Dataset reads from the store lazily
    chunk : number of instances written together, and lost if the process is killed meanwhile; by default thousands of short motions
    client : a `distributed.Client` of Dask, whose workers run chunks, each on one thread, and write them to the store, which must be
        accessible to all of them, or send them back
    method, rtol, atol, samples, max_steps, max_step, first_step, breakpoints, max_seconds, settings, check
        as for `kn.simulate`

    Returns
    -------
    xarray.Dataset
        dimensions instance, t and state. Variables by name, units in their attributes; `status` ("finished", "event", "stopped", or
        "failed" at the start), `cause`, `event`, `warning`, `steps`, `end_t` (s) and `end_state` of each instance. Values that differ
        between instances are coordinates: parameters and inputs by name, initial values as "q1(0)". NaN beyond the end of a motion

    Raises
    ------
    ImportError
        without xarray (`pip install 'kane[table]'`), or with a client without distributed (`pip install 'kane[cluster]'`)
    SimulationError
        if lengths of arrays differ, a number is not finite, there is no instance, an option is inadmissible, results without a store
        are larger than 2 GiB, or the cluster is lost
    SolutionFileError
        if the store belongs to another system, other settings or other initial values (the message names them), or cannot be
        written; chunks already written are kept
    ValueMissingError
        if a name is unknown

    Examples
    --------
    >>> runs = kn.simulate_many(eom, (0, 10), u=[0, 0], design={"q1": (-1, 1), "m": (1, 2)}, q={"q2": 0}, sampler="sobol", count=256)
    >>> runs["q1"].std("instance").plot()
    """
    check_equations(eom)
    package("xarray")
    client = None if client is None else checked(client)
    whole_span = check_span(span)
    checking_functions(eom.derived, check)
    plan = Plan(span, method, rtol, atol, samples, max_steps, max_step, first_step, breakpoints, max_seconds).spelled()
    given = {"q": q, "u": u, "states": states, "parameters": parameters, "inputs": inputs}
    many = instances(eom, given, designs.quantities(design, sampler, count, seed)).by_parameters(eom)
    kept = quantities(eom, outputs, reduce)
    check_names(kept, many)
    own = _Run(eom, many, kept, lambda found: found)
    if by is not None:
        own = _differentiated(own, plan, by, settings, store is not None)
    workers = _whole(threads, "threads=", "Leave it out for as many as there are processors.") or cores()
    size = _whole(chunk, "chunk=, instances of a chunk,", "Leave it out for chunks of seconds.")
    _warn_of_python(many)
    times = sample_times(plan.samples, whole_span)
    t = np.concatenate([whole_span[:1], times[(times > whole_span[0]) & (times < whole_span[1])], whole_span[1:]])
    alone = all(any(one.what is s for s in own.eom.state) for one in own.kept)
    job = Job(Ensemble(own.eom, plan, settings, check, own.many, lanes, alone), own.kept, t, _facts(plan, many))
    with working("Simulating many"):
        if store is not None:
            return own.finish(_stored(opened(store, job, size), job, workers, client))
        job.check_size()
        return own.finish(_in_memory(job, size, workers, client))


class _Run(NamedTuple):
    """Equations, instances, recorded quantities, and the final operation on the Dataset."""

    eom: Equations
    many: Instances
    kept: Sequence[RecordedQuantity]
    finish: Callable[[Any], Any]


def _differentiated(run: _Run, plan: Plan, by: Any, settings: Settings | None, stored: bool) -> _Run:
    """The same with derivatives: by equations with the derivatives as further states, or else for each motion separately."""
    eom, many, kept, _ = run
    wanted = unknowns(eom, many.at(0)["inputs"], by)
    check_reduced(kept)
    met = obstacle(eom, wanted, many.at(0)["inputs"])
    if not met:
        one = varied_for(eom, many, wanted, plan.span, settings)
        return _Run(
            one.eom,
            begun(one, many, plan.span, settings),
            [*kept, *map(one.derivative, kept)],
            lambda found: tidied(found, one),
        )
    if stored:
        raise SimulationError(f"Expected equations whose derivatives store= supports, got {met}. Leave store= out.")
    return run._replace(finish=lambda found: one_by_one(found, eom, plan, many, kept, wanted, settings))


def _in_memory(job: Job, size: int | None, threads: int, client: Any) -> Any:
    """The Dataset of all instances."""
    every = range(job.count)
    if client is None:
        doubles = len(job.t) * (len(job.family.eom.state) + 1)
        return job.results(tiles_of(every, threads, doubles), threads, _far(job.count)).dataset(job.facts)
    parts = spread(client, job, cut_into(every, size or job.chunk_size()), None, _far(job.count))
    whole = package("xarray").concat(
        parts, "instance", data_vars="minimal", coords="minimal", compat="override", join="override"
    )
    return whole.assign_attrs(job.facts)


def _stored(store: Store, job: Job, threads: int, client: Any) -> Any:
    """The Dataset of a store, after running the missing chunks."""
    missing = store.missing()
    done = job.count - sum(map(len, missing))
    if client is not None:
        spread(client, job, missing, store.path, _far(job.count, done))
    else:
        for rows in missing:
            write(store.path, job.chunk(rows, threads, _far(job.count, done)))
            done += len(rows)
    store.tidy()
    return store.opened(job)


def _far(count: int, before: int = 0) -> Callable[[int], None]:
    """A callback that reports the number of completed instances on the terminal."""
    return lambda done: far(lambda: f"{before + done} of {count}")


def _whole(given: Any, what: str, cure: str) -> int | None:
    expected = f"{what} as a whole number above 0"
    return None if given is None else expect.whole(given, expected, cure, least=1, error=SimulationError)


def _warn_of_python(many: Instances) -> None:
    """Warns once of inputs that require calls of Python during a motion."""
    asked = [str(s) for s, f in (many.common["inputs"] or {}).items() if isinstance(f, Sampled) or _asks(f)]
    if asked and many.count > 1:
        warn(
            f"Expected inputs that compiled code can evaluate, got Python functions for {', '.join(asked)}: the {many.count} "
            "motions run one after the other. Give expressions of time and state, or tables, to use threads."
        )


def _asks(given: Any) -> bool:
    if isinstance(given, tuple | list):
        return any(map(_asks, given))
    return isinstance(given, Signal) or (callable(given) and not isinstance(given, Expr | Table))


def _facts(plan: Plan, many: Instances) -> dict[str, Any]:
    """The options and parameters common to all motions."""
    own = {name: value for name, value in plan._asdict().items() if isinstance(value, str | float | int)}
    own |= {f"parameter {s}": float(v) for s, v in (many.common["parameters"] or {}).items()}
    own.pop("samples", None)
    return own
