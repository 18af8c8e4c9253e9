# SPDX-License-Identifier: BSD-3-Clause
"""Event location within a step in Python: quantities sampled on the dense output, and the kernels' search for crossings.

A pivot of W may vanish without a change of sign (x² of u = x² x'): its minimum is compared with its largest magnitude so far.
Crossings of a quantity that is at its threshold up to rounding are meaningless: at a start, the first nonzero derivative along the
motion determines the side to which it leaves.
"""

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from kane.dynamics.poles import SLIPS, KinematicsEnd, SlipEnd
from kane.errors import SimulationError, cut, warn
from kane.model.declarations import Event
from kane.motion.hybrid.automaton import End, Fresh, Leaves, Met, ended_by, glance, leaves_row, up_to_a_break
from kane.motion.right_hand_side import Given, Routines
from kane.motion.steppers.crossings import KINDS, LEAVES, MET, inspection_kernel, room
from kane.motion.steppers.watched import LOOSE
from kane.numeric.arrays import Array
from kane.numeric.polynomials import SMALL
from kane.numeric.scale import LATER, NEAR_TIME, SAME_TIME, UNRELATED
from kane.program.native.entry import CompiledKernel, Hook, aligned, doubles
from kane.program.native.machine import Settings

PARTS = 8
"""Number of parts into which a step is divided for samples."""
_ENDLESS = 1e300

Watch = Callable[[float, Array], Array]
Dense = Callable[[float], Array]


class ThresholdReturn(SimulationError):
    """The quantity of an `event`, expected to leave its threshold, crosses it backwards before a step shows it beyond."""

    def __init__(self, event: Event) -> None:
        super().__init__(
            f"Expected a quantity that leaves its threshold, got that of {event.name!r}, which crosses it back at once: where "
            "slip begins, the direction of friction changes faster than slip grows, and the forces before do not determine "
            "it. Give the contact static= slightly above its mu=: then slip begins with a definite acceleration."
        )
        self.event = event


class StepSeen(NamedTuple):
    """Samples of the quantities of events along a step.

    `values` (9 × events) are the quantities at `times` (9), s, `largest` (events) their largest magnitudes so far, and `since` the
    time of the last action.
    """

    now: Routines
    times: Array
    values: Array
    largest: Array
    since: float


def events_along(seen: StepSeen, dense: Dense, fresh: Fresh, rtol: float, end: float) -> tuple[list[Met], End | None]:
    """The events in a step, up to the first that ends or changes the motion, and the end that it causes; `end` is the final time."""
    now, times, values, largest, since = seen
    events, count = now.eom.events, len(now.eom.events)
    routine = now.routine(glance, *now.turning).flat

    def look(t: float) -> Array:
        state = dense(t)
        found = now.at(routine, t, state)
        return np.concatenate([now.watch(t, state)[:count], found[count + len(now.turning) :][:count]])

    found = crossings(events, look, times, values, thresholds(events, largest), fresh, steps_since(times, since, end))
    found += vanishing(events, now.watch, dense, times, values, largest, rtol)
    found = [(event, min(t, end)) for event, t in found]
    noted, at_once = up_to_a_break(found, float(times[-1] - times[0]))
    return noted, ended_by(at_once, noted)


def still_there(fresh: Fresh, events: Sequence[Event], gaps: Array) -> Fresh:
    """The departures of events still within the bands about their thresholds; `gaps` (events) are the distances after a step."""
    inside = {e.name: abs(gap) for e, gap in zip(events, gaps, strict=True) if e.name in fresh}
    return {name: leaves for name, leaves in fresh.items() if inside.get(name, np.inf) < leaves.band}


def thresholds(events: Sequence[Event], largest: Array) -> Array:
    """The thresholds (events); slip whose friction law specifies none ends at the fraction SLIPS of its `largest` speed."""
    slips = np.array([isinstance(e, SlipEnd) and e.by_share for e in events], dtype=bool)
    return np.where(slips, SLIPS * largest, [e.threshold for e in events])


def crossings(
    events: Sequence[Event],
    look: Callable[[float], Array],
    times: Array,
    values: Array,
    least: Array,
    fresh: Fresh,
    steps: float = math.inf,
) -> list[Met]:
    """The events in a step, in order of time; quantities that stay at their thresholds are omitted, with a warning.

    `look` returns quantities at a time, then magnitudes of their terms; `values` (9 × events) are quantities at `times` (9), from the
    beginning to the end of the step; `least` (events) are thresholds. Events in `fresh`, by name, are at their thresholds at the
    beginning; the state has accumulated the rounding errors of `steps` steps.
    """
    count, start, h = len(events), float(times[0]), float(times[-1] - times[0])
    kinds = np.zeros((count, KINDS))
    kinds[:, 1] = [e.direction for e in events]
    given: Given = {
        "events": count,
        "values": np.append(values.T, np.zeros(8)),
        "least": np.array([*least, 0.0]),
        "told": np.array([min(steps, _ENDLESS), 0.0]),
        "rests": np.zeros(count + 1),
        "kinds": kinds.reshape(-1),
        "leaves": np.array([*(leaves_row(fresh.get(e.name)) for e in events), np.zeros(LEAVES)]).reshape(-1),
        "met": np.zeros(2 * MET),
        "zoom": aligned(room(count)),
    }

    def glance_at(share: float, x: int, out: int) -> None:
        doubles(out, 2 * count)[:] = look(start + share * h)

    hook = Hook(glance_at)
    found = inspection()(given | {"glance": hook})
    if hook.raised is not None:
        raise hook.raised
    if found < 0:
        for e, v, at in zip(events, values.T, least, strict=False):
            if _returns(fresh.get(e.name), v - at):
                raise ThresholdReturn(e)
        raise SimulationError(
            f"Expected at most {MET} events in a step, got more in the step of {h:.3g} s from t = {start:.6g}. Give max_step= "
            "of a tenth of that, or leave out the events that occur so often."
        )
    for event, rests in zip(events, given["rests"].tolist(), strict=False):
        if rests:
            warn(
                f"Expected a quantity of the event {event.name!r} that crosses {event.threshold:g}, got one that stays there, "
                f"except for rounding errors, near t = {start:.6g}: {cut(event.quantity)}. The event is ignored. Give it a "
                "quantity that changes."
            )
    # at a kinematic singularity the energy may be infinite: the state just before is returned
    early = [SAME_TIME * isinstance(e, KinematicsEnd) for e in events]
    met = [(int(k), share) for share, k in given["met"][: 2 * found].reshape(-1, 2).tolist()]
    return [(events[k], start + max(share - early[k], 0.0) * h) for k, share in met]


def _returns(leaves: Leaves | None, beyond: Array) -> bool:
    """Whether a quantity that should leave its threshold to a side is on the other side at all later samples of a step."""
    return leaves is not None and leaves.side != 0.0 and bool((leaves.side * beyond[1:] < 0.0).all())


def steps_since(times: Array, since: float, end: float) -> float:
    """The number of steps of this length since the time `since`; infinite for the shortest steps of a motion to `end`."""
    h = float(times[-1] - times[0])
    return math.inf if h < NEAR_TIME * (end - since) else (float(times[0]) - since) / h + 2.0


@cache
def inspection() -> CompiledKernel:
    """The compiled search for events in a step."""
    return CompiledKernel(inspection_kernel(), Settings())


def leapt(watch: Watch, dense: Dense, times: Array, values: Array) -> float | None:
    """A time at which the sign of a switching quantity differs from that at both ends of a step; None if there is none.

    `watch` returns the quantities, `values` (k × switches) are those at `times` (k). Near a local minimum of a magnitude between two
    times, the minimum is located.
    """
    found: list[float] = []
    for k in range(values.shape[1]):
        side = np.sign(values[:, k])
        if side[0] * side[-1] <= 0:
            continue
        within = np.flatnonzero(side == -side[0])
        if len(within):
            found.append(float(times[within[0]]))
            continue

        def beyond(t: float, k: int = k, sign: float = float(side[0])) -> float:
            return sign * float(watch(t, dense(t))[k])

        for start, end in _valleys(beyond, times, np.abs(values[:, k])):
            t = _smallest(beyond, start, end)
            if beyond(t) < 0:
                found.append(t)
                break
    return min(found, default=None)


def _valleys(size: Callable[[float], float], times: Array, sizes: Array) -> list[tuple[float, float]]:
    """Intervals of time that contain local minima of `size`."""
    found: list[tuple[int, int]] = []
    if sizes[0] <= sizes[1] and size(float(times[0] + LATER * (times[1] - times[0]))) < sizes[0]:
        found.append((0, 1))
    least = np.flatnonzero((sizes[1:-1] < sizes[:-2]) & (sizes[1:-1] <= sizes[2:]))
    found += [(int(i), int(i) + 2) for i in least]
    if sizes[-1] < sizes[-2] and size(float(times[-1] - LATER * (times[-1] - times[-2]))) < sizes[-1]:
        found.append((len(times) - 2, len(times) - 1))
    return [(float(times[i]), float(times[j])) for i, j in found]


def vanishing(
    events: Sequence[Event], watch: Watch, dense: Dense, times: Array, values: Array, largest: Array, rtol: float
) -> list[Met]:
    """The pivots of W that vanish in a step, at their minima; `largest` (events) are the largest magnitudes so far."""
    met: list[Met] = []
    gone = max(UNRELATED, LOOSE * rtol)
    for k, event in enumerate(events):
        size = np.abs(values[:, k])
        if not isinstance(event, KinematicsEnd) or not size.min() < SMALL * largest[k]:
            continue
        i = int(np.argmin(size))

        def left(t: float, k: int = k) -> float:
            return abs(float(watch(t, dense(t))[k]))

        t = _smallest(left, float(times[max(i - 1, 0)]), float(times[min(i + 1, len(times) - 1)]))
        least, t = min((size[i], float(times[i])), (left(t), t))
        if least <= gone * largest[k]:
            met.append((event, t))
    return met


def _smallest(size: Callable[[float], float], start: float, end: float) -> float:
    """The time between `start` and `end` at which `size` is smallest."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(size, bounds=(start, end), method="bounded", options={"xatol": 1e-7 * (end - start)})
    return float(found.x)
