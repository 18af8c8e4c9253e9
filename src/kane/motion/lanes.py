# SPDX-License-Identifier: BSD-3-Clause
"""Many motions of the same equations in lanes: the kernel that runs one, printed for several at once, which go through a queue.

Each lane has a time, step, end, parameters and inputs of its own, and takes up the next instance where its own has ended. Motions are
those of one kernel's call: explicit methods, equations without constraints and events, inputs that are numbers.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from kane.motion.arguments import Arguments
from kane.motion.course import Method
from kane.motion.inputs.functions import constant
from kane.motion.native import first_slots
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import switches
from kane.motion.steppers.context import QUEUE, SIZE, Slot
from kane.motion.steppers.queue import ARRAYS, LOADED, SAVED, SIZES, queue_kernel
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array
from kane.program.kernel.language import ArrayOf, Callee
from kane.program.native.entry import CompiledKernel, aligned, own_entries
from kane.program.native.machine import Settings

SHARED = (*QUEUE, "pauses")


class Ends(NamedTuple):
    """Of each instance its samples (k × m × n), and its last state (k × n), time, `ReturnCode`, and steps.

    A state is (q, u, a) and the work of the loads. Samples that were not reached are NaN.
    """

    samples: Array
    states: Array
    t: Array
    back: npt.NDArray[np.int64]
    steps: npt.NDArray[np.int64]


def runs_in_lanes(stepper: Stepper, method: Method) -> bool:
    """Whether lanes run such motions."""
    eom = stepper.eom
    return (
        method.name in INTEGRATORS
        and INTEGRATORS[method.name].queues
        and not (is_constrained(eom) or eom.events or eom.system.contacts or switches(eom))
        and not method.breakpoints
        and all(constant(f) is not None for f in stepper.now.drives)
    )


@cache
def _compiled(name: str, width: int, settings: Settings) -> tuple[CompiledKernel, CompiledKernel]:
    """The kernel of an integrator in lanes, and that of their queue."""
    kernel = INTEGRATORS[name].kernel(queued=True)
    return CompiledKernel(kernel, settings, width=width, shared=SHARED), CompiledKernel(queue_kernel(width), settings)


def run_in_lanes(
    stepper: Stepper,
    method: Method,
    starts: Array,
    parameters: Array,
    inputs: Array,
    spans: Array,
    times: Array,
    width: int = 8,
) -> Ends:
    """The motions from `starts` (k × n), with `parameters` (k × p) and `inputs` (k × r), over `spans` (k × 2), at `times` (k × m).

    Times ascend in each row, after the beginning of the span. It runs without the interpreter's lock, in arrays of its own.
    """
    count, n = starts.shape[0], starts.shape[1] + 1
    now, settings = stepper.now, stepper.now.settings or Settings()
    kernel, queue = _compiled(method.name, width, settings)
    one = Arguments(method.name, now, float(spans[0, 0]), np.zeros(SIZE), np.zeros(n))
    m = times.shape[1]
    given = one.given | {"times": np.zeros(m + 1), "rows": np.zeros(max(1, m * n))}
    lanes = {
        a.name: _in_lanes(given[a.name], width)
        for a in kernel.kernel.arguments
        if isinstance(a, ArrayOf) and a.name not in SHARED
    }
    table = _rows(given, count)
    table["s"][:] = _slots(method, spans)
    table["y"][:, :-1], table["y"][:, -1] = starts, 0.0
    table["p"][:, : parameters.shape[1]] = parameters
    table["r"][:, : inputs.shape[1]] = inputs
    table["times"][:, :m], table["times"][:, m] = times, np.inf
    sizes = {name: len(given[name]) for name in ARRAYS}
    results = np.full((count, sum(sizes[name] for name in SAVED)), np.nan)
    run, hoist = own_entries(now.rates, width)
    routines = {a.name: hoist if a.name.startswith("hoist") else run for a in kernel.kernel.arguments if isinstance(a, Callee)}
    shared = {
        "queue": np.array([0.0, count, *sizes.values(), *[-1.0] * width]),
        "instances": np.hstack([table[name] for name in LOADED]),
        "results": results,
        "pauses": given["pauses"],
    }
    integers = {"n": n, "limit": method.max_steps, "samples": m, "driven": 0, "breakpoints": 0}
    kernel(lanes | shared | routines | {"next": queue.entry} | integers)
    s, y, rows = np.split(results, np.cumsum([SIZE, n]), axis=1)
    samples = rows[:, : m * n].reshape(count, m, n)
    samples[np.arange(m) >= s[:, Slot.SAMPLE, None]] = np.nan
    back, steps = s[:, [Slot.BACK, Slot.STEPS]].T.astype(np.int64)
    return Ends(samples, y, s[:, Slot.TIME], back, steps)


def _in_lanes(array: Array, width: int) -> Array:
    """Each number once for each lane."""
    made = aligned(len(array) * width)
    made[:] = np.repeat(array, width)
    return made


def _rows(given: dict[str, Array], count: int) -> dict[str, Array]:
    """The arrays that are loaded, of all instances as they are of one."""
    return {name: np.tile(given[name], (count, 1)) for name in LOADED}


def _slots(method: Method, spans: Array) -> Array:
    """What the kernel is told of each instance."""
    found: dict[bytes, Array] = {}
    for span in spans:
        if span.tobytes() not in found:
            t0, t1 = map(float, span)
            s = found[span.tobytes()] = np.zeros(SIZE)
            s[: Slot.FRESH + 1] = first_slots(method, (t0, t1), t0, t1)
            s[Slot.SPAN], s[Slot.PHASE] = t1 - t0, t0
    return np.array([found[span.tobytes()] for span in spans])
