# SPDX-License-Identifier: BSD-3-Clause
"""Many motions of the same equations in vector lanes: the stepping kernel, printed for several instances at once, with a queue.

Each lane has its own time, step, end, parameters, inputs and events, and takes the next instance from the queue when its own has
ended. Motions are those of one kernel call of an explicit method, with inputs that are constant or expressions. Where a kernel needs
Python, it ends the instance with the corresponding `ReturnCode`; the instance must then be run individually.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from kane.dynamics.constraints.partition import Partition
from kane.errors import KaneError
from kane.motion.arguments import Arguments
from kane.motion.constraint_kernels import alike, among, choices, entries, holding, holding_one, stepping, wanted
from kane.motion.course import Method
from kane.motion.hybrid.automaton import are_beside, asks, evaluated
from kane.motion.inputs.expressions import Formula
from kane.motion.inputs.functions import constant
from kane.motion.native import first_slots
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Given, Routines, switches
from kane.motion.steppers.context import CLEARED, LOADED, QUEUE, SAVED, SIZE, ReturnCode, Slot, turned_over
from kane.motion.steppers.held import POORER
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steps import Stepper, unheld
from kane.numeric.arrays import Array, Mask
from kane.program.kernel.language import INT, ArrayOf, Callee, Kernel
from kane.program.kernel.rewriting import narrowed
from kane.program.kernel.writer import Array as KernelArray
from kane.program.kernel.writer import Term, Writer
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import CompiledKernel, Entry, Selection, aligned_copy, hoisted, masked_entries
from kane.program.native.machine import Settings

_TABLES = ("entry_at", "turn_at", "chosen_at", "dependent", "sphere_at", "ready", "quiet")
SHARED = frozenset(
    {*QUEUE, "pauses", "kinds", "least", "shares", "pivots", "actions", *(f"held_{name}" for name in _TABLES)}
)
"""The arrays that are common to all instances."""


class Ends(NamedTuple):
    """The results of k instances: samples (k × m × n), final state (k × n), time, `ReturnCode` and number of steps of each.

    A state is (q, u, a) and the work of the loads. Samples that were not reached are NaN; a sample at the instant of an action is
    the state after it. For each instance `events` contains the crossings (time, index of the event), and `jumps` the actions and
    ends (time, number of events so far, state before, state after). `told` are the slots (k × SIZE), `changes` the (time, index) of
    each change of dependent speeds.
    """

    samples: Array
    states: Array
    t: Array
    back: npt.NDArray[np.int64]
    steps: npt.NDArray[np.int64]
    events: tuple[Array, ...] = ()
    jumps: tuple[Array, ...] = ()
    told: Array = np.zeros((0, SIZE))
    changes: tuple[list[tuple[float, int]], ...] = ()

    def replaced(self, rows: Mask, own: "Ends") -> "Ends":
        """A copy with some rows replaced."""
        whole: list[Any] = [list(x) if isinstance(x, tuple) else x.copy() for x in self]
        parts: list[Any] = [*own]
        for mine, others in zip(whole, parts, strict=True):
            for k, row in zip(np.flatnonzero(rows).tolist(), others, strict=False):
                mine[k] = row
        table: Any = (tuple(x) if isinstance(x, list) else x for x in whole)
        return Ends(*table)


def runs_in_lanes(stepper: Stepper, method: Method) -> bool:
    """Whether lanes can run motions of such equations by this method."""
    eom = stepper.eom
    return (
        method.name in INTEGRATORS
        and INTEGRATORS[method.name].queues
        and not (eom.system.contacts or switches(eom, stepper.now.laws) or unheld(stepper))
        and not (bool(eom.events) and eom.numeric().value(asks))
        and not method.breakpoints
        and all(constant(f) is not None or isinstance(f, Formula) for f in stepper.now.drives)
    )


@cache
def _compiled(
    name: str, held: bool, watched: bool, width: int, settings: Settings
) -> tuple[CompiledKernel, CompiledKernel]:
    """The kernel of an integrator in lanes, and the kernel of their queue."""
    kernel = narrowed(INTEGRATORS[name].kernel(queued=True, held=held, watched=watched))
    queue = queue_kernel(width, turned_over(kernel.arguments))
    return CompiledKernel(kernel, settings, width=width, shared=SHARED), CompiledKernel(queue, settings)


def run_in_lanes(
    stepper: Stepper,
    method: Method,
    starts: Array,
    parameters: Array,
    inputs: Array,
    spans: Array,
    times: Array,
    reach: Array | None = None,
    width: int = 8,
) -> Ends:
    """The motions from `starts` (k × n), with `parameters` (k × p) and `inputs` (k × r), over `spans` (k × 2), at `times` (k × m).

    Parameters of inputs alone follow those of the equations. Inputs that are expressions are evaluated by the kernel.
    Times ascend in each row, after the beginning of the span. Starts satisfy the constraints; `reach` (k × rows × speeds) are the
    largest magnitudes of the entries of A so far. Runs without the interpreter's lock, in its own arrays. If instances require
    dependent speeds that are not compiled yet, these are compiled and the instances run again.
    """
    own = starts, parameters, inputs, spans, times
    known = {*stepper.numeric.value(wanted)}  # other threads may add more meanwhile
    ends = _run(stepper, method, own, reach, width)
    while True:
        again = _want_others(stepper, ends, known)
        if not again.any():
            return ends
        further = None if reach is None else reach[again]
        ends = ends.replaced(again, _run(stepper, method, tuple(x[again] for x in own), further, width))


def _want_others(stepper: Stepper, ends: Ends, known: set[Partition]) -> Mask:
    """The instances that ended because they need dependent speeds that were not `known`; adds these to the known ones."""
    held, which = ends.told[:, Slot.HELD], ends.told[:, Slot.WORST]
    asks = (ends.back == ReturnCode.LOOK) & (held == POORER) & (which >= 0.0)
    every = choices(stepper.eom)
    new = [k for k in range(len(every)) if every[k] not in known and k in which[asks]]
    known.update(every[k] for k in new)
    stepper.numeric.value(wanted).update(known)
    return np.asarray(asks & np.isin(which, new))


def _run(stepper: Stepper, method: Method, own: Sequence[Array], reach: Array | None, width: int) -> Ends:
    """The motions of `run_in_lanes` in the lanes of one kernel, with the compiled choices of dependent speeds."""
    starts, parameters, inputs, spans, times = own
    (count, m), n = times.shape, starts.shape[1] + 1
    now, settings = stepper.now, stepper.now.settings or Settings()
    held = is_constrained(now.eom)
    kernel, queue = _compiled(method.name, held, now.events is not None, width, settings)
    one = Arguments(method.name, now, float(spans[0, 0]), np.zeros(SIZE), np.zeros(n))
    given = one.given | {"times": np.zeros(m + 1), "rows": np.zeros(max(1, m * n))}
    if held:
        given |= holding_one(now, float(spans[0, 0]), np.append(starts[0], 0.0)) | {"held_marks": np.zeros(m + 1)}
    rates = _among(stepper, given, starts[0], width) if held else None
    turned = turned_over(kernel.kernel.arguments)
    sizes = {name: len(given[name]) for name in turned}
    table = {name: np.tile(given[name], (count, 1)) for name in LOADED if name in turned}
    table["s"][:] = _slots(method, spans)
    table["y"][:, :-1], table["y"][:, -1] = starts, 0.0
    table["p"][:, : parameters.shape[1]] = parameters
    table["r"][:, : inputs.shape[1]] = inputs
    table["times"][:, :m], table["times"][:, m] = times, np.inf
    if held and reach is not None:
        rows, columns = np.array(entries(now.eom), dtype=int).reshape(-1, 2).T
        table["held_reach"][:, :-1] = reach[:, rows, columns]
    begins = np.ones(count, bool)
    if now.events is not None:  # Python decides starts on a threshold
        begins, values = _beside_no_threshold(one, given, spans[:, 0], table["y"], table)
        table["seen"][:, : values.shape[1]], table["largest"][:, : values.shape[1]] = values, np.abs(values)
        table["leaves"][:] = 0.0
    stored = {name: sizes[name] for name in SAVED if name in turned}
    results = np.full((int(begins.sum()), sum(stored.values())), np.nan)
    names = [a.name for a in kernel.kernel.arguments if isinstance(a, ArrayOf)]
    kernel(
        {name: aligned_copy(np.repeat(given[name], width)) for name in names if name not in SHARED}
        | {name: given[name] for name in names if name in SHARED and name in given}
        | {
            "queue": np.array([0.0, len(results), *sizes.values(), *[-1.0] * width]),
            "instances": np.hstack(list(table.values()))[begins],
            "results": results,
            "next": queue.entry,
        }
        | _codes(now, one.driving, width, [a.name for a in kernel.kernel.arguments if isinstance(a, Callee)], rates)
        | ({} if rates is None else {"h": rates.table})
        | {name: value for name, value in given.items() if isinstance(value, int)}
        | {"n": n, "limit": method.max_steps, "samples": m, "breakpoints": 0}
    )
    whole = results
    if len(results) < count:
        whole = np.full((count, results.shape[1]), np.nan)
        whole[begins] = results
        whole[~begins, : SIZE + n] = np.hstack([table["s"], table["y"]])[~begins]
        whole[~begins, Slot.BACK] = ReturnCode.LOOK
    if now.events is not None:  # also where rounding may cross a threshold at the end
        beside, _ = _beside_no_threshold(one, given, spans[:, 1], whole[:, SIZE : SIZE + n], table)
        across = (whole[:, Slot.BACK] == ReturnCode.END) & ~beside
        whole[across, Slot.BACK], whole[across, Slot.HELD] = ReturnCode.LOOK, 0.0
    return _ends(dict(zip(stored, np.split(whole, np.cumsum([*stored.values()])[:-1], axis=1), strict=True)), times)


def _among(stepper: Stepper, given: Given, start: Array, width: int) -> Selection | None:
    """The rates for each compiled choice of dependent speeds, selected per lane; None if there is a single choice."""
    now, every, place = stepper.now, choices(stepper.eom), len(given["p"]) - 1
    if len(every) < 2:
        return None
    given |= among(every, place)
    selection = Selection(len(every), place, width, now.settings or Settings(), masked=True)
    for k, choice in enumerate(every):
        if k and choice not in stepper.numeric.value(wanted):
            continue
        given["held_ready"][k] = -1.0
        with suppress(KaneError):
            other = stepping(stepper, choice) if k else now
            if not k or alike(stepper.eom, other.eom):
                h = hoisted(other.rates, 0.0, start[: other.width], other.p, now.inputs(0.0, start))
                selection.put(k, other.rates, aligned_copy(np.repeat(h, width)))
                given["held_ready"][k] = 1.0
    return selection


def _codes(
    now: Routines, driving: CompiledRoutine | None, width: int, callees: list[str], rates: Selection | None
) -> dict[str, Entry]:
    """The routines that a kernel calls, in lanes; the rates fill arguments that are not called."""
    routines: dict[str, tuple[CompiledRoutine, str]] = {}
    if driving is not None:
        routines["drive"] = driving, "hoist_hd"
    if now.events is not None:
        routines |= {name: (routine, f"hoist_h{name[0]}") for name, routine in evaluated(now).items()}
    if is_constrained(now.eom):
        routines["constraints"] = now.eom.numeric(now.settings).routine(holding).flat, "hoist_held_h"
    run, hoist = masked_entries(now.rates, width)
    codes = {name: hoist if name.startswith("hoist") else run for name in callees if name != "next"}
    for name, (routine, hoisting) in routines.items():
        codes[name], codes[hoisting] = masked_entries(routine, width)
    return codes if rates is None else codes | {"rhs": rates.call, "hoist_h": rates.hoist}


def _beside_no_threshold(
    one: Arguments, given: Given, t: Array, y: Array, table: Mapping[str, Array]
) -> tuple[Mask, Array]:
    """The instances that are certainly not on a threshold of an event at times t and states y, and the event functions there."""
    now, count = one.now, given["events"]
    x, p, r = y[:, : now.width], table["p"], table["r"][:, : len(now.drives)]
    known: Mask = np.array(np.isfinite(np.hstack([x, p, r])).all(axis=1))
    found = np.full((len(t), 2 * count), np.nan)
    if known.any():
        at = t[known], x[known], p[known]
        own = r[known] if one.driving is None else _at_once(one.driving, *at, r[known])
        found[known] = _at_once(evaluated(now)["glance"], *at, own)
    values, terms = found[:, :count], found[:, count:]
    return are_beside(now, given, values, terms) & np.isfinite(found).all(axis=1), values


def _at_once(routine: CompiledRoutine, t: Array, x: Array, p: Array, r: Array) -> Array:
    """The results of a routine at many states; p may have more columns than its port."""
    wanted = sum(len(port.symbols) for port in routine.program.ports if port.name == "p")
    return routine(t, x, p[:, :wanted], r if r.shape[1] else None)


def _ends(stored: Mapping[str, Array], times: Array) -> Ends:
    """The results in the arrays that the kernel stored."""
    (count, m), n, s = times.shape, stored["y"].shape[1], stored["s"]
    samples = stored["rows"][:, : m * n].reshape(count, m, n)
    samples[np.arange(m) >= s[:, Slot.SAMPLE, None]] = np.nan
    back, steps, logged, jumped = s[:, [Slot.BACK, Slot.STEPS, Slot.LOGGED, Slot.JUMPS]].T.astype(np.int64)
    if "held_marks" in stored:  # Python projects these samples onto the constraints
        marked = (stored["held_marks"][:, :m] > 0.0) & (np.arange(m) < s[:, Slot.SAMPLE, None])
        back[marked.any(axis=1)] = ReturnCode.LOOK
    ends = Ends(samples, stored["y"], s[:, Slot.TIME], back, steps, told=s)
    if "held_log" in stored:
        counts = np.nan_to_num(stored["held_log"][:, 0]).astype(np.int64)
        pairs = stored["held_log"][:, 1 : 1 + 2 * counts.max(initial=0)].reshape(count, -1, 2).tolist()
        own = zip(pairs, counts.tolist(), strict=True)
        ends = ends._replace(changes=tuple([(t, int(k)) for t, k in row[:some]] for row, some in own))
    if "log" not in stored:
        return ends
    events = tuple(row[: 2 * k].reshape(-1, 2).copy() for row, k in zip(stored["log"], logged, strict=True))
    width = 2 * n + 2
    jumps = tuple(row[: width * k].reshape(-1, width).copy() for row, k in zip(stored["jumps"], jumped, strict=True))
    for k in np.flatnonzero(jumped):
        for t, row in zip(jumps[k][:, 0], jumps[k], strict=True):
            samples[k, times[k] == t] = row[2 + n :]
    return ends._replace(events=events, jumps=jumps)


def _slots(method: Method, spans: Array) -> Array:
    """The initial slots of each instance."""
    if (spans == spans[0]).all():
        different, which = spans[:1], np.zeros(len(spans), dtype=int)
    else:
        different, which = np.unique(spans, axis=0, return_inverse=True)
    found = np.zeros((len(different), SIZE))
    for s, (t0, t1) in zip(found, different.tolist(), strict=True):
        s[: Slot.FRESH + 1] = first_slots(method, (t0, t1), t0, t1)
        s[Slot.SPAN], s[Slot.PHASE] = t1 - t0, t0
    return np.asarray(found[which.reshape(-1)])


NEXT, COUNT, SIZES = 0, 1, 2
"""Indices in `queue`: the next instance, their number, the sizes of the arrays; then the instance of each lane, −1 for none."""
NEAR = 1 / 64
"""A lane that has ended waits for those whose rest is below this share of their steps: lanes with similar motions then stay abreast,
so that samples fall into the same steps and are written at once."""


def queue_kernel(width: int, names: Sequence[str]) -> Kernel:
    """The kernel that `width` lanes call when some have ended, those with nonzero BACK; it becomes zero if another one is loaded.

    A lane that waits has FRESH = 2: it projects its last state and has ended again. `names` are the arrays of an instance; of the logs
    of events and actions only the filled part is stored.
    """
    w = Writer(f"next{width}")
    w.number("lanes")
    arrays = {name: w.array(name) for name in names}
    queue, instances, results = (w.array(name) for name in QUEUE)
    back = w.variable("back", INT)
    sizes = {name: w.compute("int", queue[SIZES + k]) for k, name in enumerate(names)}
    own_at, back_at = SIZES + len(names), int(Slot.BACK) * width

    def places(of: Iterable[str], row: Term) -> Iterator[tuple[str, KernelArray, Term]]:
        """The arrays that exist, and the index of each in a row."""
        there, length = [name for name in of if name in arrays], w.integer(0)
        for name in there:
            length = length + sizes[name]
        at = row * length
        for name in there:
            yield name, arrays[name], at
            at = at + sizes[name]

    def slot(lane: Term, at: Slot) -> Term:
        return arrays["s"][lane + int(at) * width]

    def filled(name: str, lane: Term) -> Term:
        told = {"log": (Slot.LOGGED, w.integer(2)), "jumps": (Slot.JUMPS, sizes["y"] * 2 + 2)}
        if name not in told:
            return sizes[name]
        return w.compute("int", slot(lane, told[name][0])) * told[name][1]

    waits = w.variable("waits", INT)
    waits.put(0)
    with w.few(width) as lane, w.when(arrays["s"][lane + back_at].equals(0.0) & (queue[own_at + lane] >= 0.0)):
        end, t, h, steps = (slot(lane, at) for at in (Slot.END, Slot.TIME, Slot.STEP, Slot.STEPS))
        with w.when(end - t <= h * steps * NEAR):
            waits.put(1)
    with w.few(width) as lane, w.when(~arrays["s"][lane + back_at].equals(0.0)):
        own = w.compute("int", queue[own_at + lane])
        with w.when(own >= 0):
            for name, array, at in places(SAVED, own):
                with w.few(filled(name, lane)) as k:
                    results[at + k] = array[k * width + lane]
            queue[own_at + lane] = -1.0
        new = w.compute("int", queue[NEXT])
        with w.when(new < w.compute("int", queue[COUNT])):
            with w.when(waits.get() > 0):
                arrays["s"][lane + back_at] = 0.0
                arrays["s"][lane + int(Slot.FRESH) * width] = 2.0
            with w.otherwise():
                for name, array, at in places(LOADED, new):
                    with w.few(sizes[name]) as k:
                        array[k * width + lane] = instances[at + k]
                for name in CLEARED:
                    if name in arrays:
                        with w.few(sizes[name]) as k:
                            arrays[name][k * width + lane] = 0.0
                queue[own_at + lane] = queue[NEXT]
                queue[NEXT] = queue[NEXT] + 1.0
    return w.finished(back)
