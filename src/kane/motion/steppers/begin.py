# SPDX-License-Identifier: BSD-3-Clause
"""Kernels by which compiled programs without Python start a motion, and decide how to continue when a stepper asks about constraints.

`begin` sets the times of the samples, tolerances, hoisted values, the event quantities and the constraints at the start. Its array
`told` receives the index of the event or constraint that prevents the start, and the residuals of that constraint and of its rate.
"""

from collections.abc import Callable
from enum import IntEnum

from kane.motion.steppers.context import RATE, SIZE, Slot
from kane.motion.steppers.crossings import KINDS
from kane.motion.steppers.held import POORER
from kane.numeric.scale import EPS, ROUNDED_TERMS, SAME_TIME, UNUSABLE
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Array, Term, Variable, Writer

_OPEN = 1e-6
"""Residual of a constraint, as a share of its terms, up to which it is satisfied."""
_LONGEST_SPAN = 1e300


class Begun(IntEnum):
    """Results of `begin`: BEGUN; WRONG end, tolerance, longest step or sample count; OPEN constraint; an event ON_THRESHOLD."""

    BEGUN = 0
    WRONG = 1
    OPEN = 2
    ON_THRESHOLD = 3


def begin_kernel(fixed: bool, watched: bool, held: bool) -> Kernel:
    """The kernel `begin`: s has END, LONGEST, RTOL and ATOL, y the state, p and r their values; `samples` includes the start."""
    w = Writer("begin")
    n, samples, parameters = w.number("n"), w.number("samples"), w.number("parameters")
    s, y, lag, p, r, h = (w.array(name) for name in ("s", "y", "lag", "p", "r", "h"))
    times, states, told = (w.array(name) for name in ("times", "states", "told"))
    hoist = w.callee("hoist", "array", "array")
    back = w.variable("said", INT)
    end = s[int(Slot.END)]
    above = (end > 0.0) & (end < _LONGEST_SPAN) & (samples > 1)
    for slot in (Slot.RTOL, Slot.ATOL, Slot.LONGEST):
        above = above & (s[int(slot)] > 0.0)
    back.put(w.select(above, w.integer(Begun.BEGUN), w.integer(Begun.WRONG)))
    with w.when(above):
        given = (Slot.END, Slot.LONGEST, Slot.RTOL, Slot.ATOL)
        for slot_at in range(SIZE):
            if slot_at not in given:
                s[slot_at] = 0.0
        s[int(Slot.STEP)] = s[int(Slot.LONGEST)] if fixed else 0.0
        s[int(Slot.SHORTEST)] = EPS**2 * end
        s[int(Slot.FRESH)], s[int(Slot.SPAN)] = 1.0, end
        y[n - 1] = 0.0
        with w.count(n) as i:
            lag[i] = 0.0
            states[i] = y[i]
        step = end / w.compute("float", samples - 1)
        with w.count(samples - 1, start=1) as k:
            times[k - 1] = w.compute("float", k) * step
        times[samples - 2] = end
        times[samples - 1] = float("inf")
        hoist(p.at(0), h.at(0))
        if held:
            p[parameters] = 0.0
        at = (w.constant(0.0), y.at(0), p.at(0), r.at(0), h.at(0))
        if watched:
            _begin_events(w, at, back, told)
        if held:
            _begin_constraints(w, at, back, told, y)
    return w.finished(back)


_At = tuple[object, ...]


def _begin_events(w: Writer, at: _At, back: Variable, told: Array) -> None:
    """Evaluates the event quantities at the start; none of the system's own may be at its threshold."""
    watch, glance = w.callee("watch", *RATE), w.callee("glance", *RATE)
    count, leaving = w.number("events"), w.number("leaving")
    seen, largest, least, kinds, leaves, beside = (
        w.array(name) for name in ("seen", "largest", "least", "kinds", "leaves", "beside")
    )
    _call(watch, at, seen)
    _call(glance, at, beside)
    with w.count(count) as k:
        size = w.compute("abs", seen[k])
        largest[k] = size
        away = w.compute("abs", seen[k] - least[k]) > ROUNDED_TERMS * beside[count + k]
        with w.when((kinds[k * KINDS + 2] > 0.0) & ~away & (back.get() < 1)):
            back.put(int(Begun.ON_THRESHOLD))
            told[0] = w.compute("float", k)
    with w.count(leaving) as k:
        leaves[k] = 0.0


def _begin_constraints(w: Writer, at: _At, back: Variable, told: Array, y: Array) -> None:
    """Tests whether the start satisfies the constraints; A u is judged against the fastest speed: those of a row may be rounding."""
    constraints = w.callee("constraints", *RATE)
    closures, rows, skipped = w.number("held_closures"), w.number("held_rows"), w.number("held_branches")
    entries, speeds, coordinates = w.number("held_entries"), w.number("held_speeds"), w.number("held_coordinates")
    room, entry_at, reach, log = (w.array(f"held_{name}") for name in ("room", "entry_at", "reach", "log"))
    fastest, rate, size = w.variable("fastest"), w.variable("rate"), w.variable("size")
    _call(constraints, at, room)
    fastest.put(0.0)
    with w.count(speeds) as j:
        fastest.put(w.compute("max", fastest.get(), w.compute("abs", y[coordinates + j])))
    with w.count(rows) as i:
        b = room[closures * 2 + i]
        rate.put(b)
        size.put(w.compute("abs", b))
        with w.count(entries) as e, w.when(w.compute("int", entry_at[e * 3 + 1]).equals(i)):
            entry = room[closures * 2 + rows + skipped + e]
            rate.put(rate.get() + entry * y[coordinates + w.compute("int", entry_at[e * 3 + 2])])
            size.put(size.get() + w.compute("abs", entry) * fastest.get())
        ends = i < closures
        left = w.select(ends, room[i], 0.0)
        terms = w.select(ends, room[closures + i], 0.0)
        kept = (w.compute("abs", left) <= _OPEN * terms) & (w.compute("abs", rate.get()) <= _OPEN * size.get())
        with w.when(~kept & (back.get() < 1)):
            back.put(int(Begun.OPEN))
            told[0], told[1], told[2] = w.compute("float", i), left, rate.get()
    with w.count(entries) as e:
        reach[e] = 0.0
    log[0] = 0.0


def _call(routine: Callable[..., None], at: _At, out: Array) -> None:
    routine(*at, out.at(0))


def look_kernel() -> Kernel:
    """The kernel `look`: returns 1 if the stepper is to continue after it returned because of the constraints.

    It accepts a step at whose end the dependent speeds are poorly determined but usable; a step that may have passed a state where
    they are singular is repeated at half its size.
    """
    w = Writer("look")
    s = w.array("s")
    back = w.variable("goes_on", INT)

    def get(slot: Slot) -> Term:
        return s[int(slot)]

    shortest = get(Slot.SHORTEST) + 10 * EPS * w.compute("abs", get(Slot.TIME))
    left = (get(Slot.END) - get(Slot.TIME)) - get(Slot.TIME_LAG)
    wished = w.compute("min", w.compute("max", get(Slot.STEP), shortest), get(Slot.LONGEST))
    half = 0.5 * w.compute("min", wished, left)
    asked = (get(Slot.HELD) > 0.0) & ~(get(Slot.LOOKED) > 0.0)
    poorer = asked & get(Slot.HELD).equals(POORER) & (get(Slot.SHARE) <= 1 / UNUSABLE)
    shorter = asked & ~poorer & (half > SAME_TIME * get(Slot.SPAN))
    with w.when(poorer):
        s[int(Slot.LOOKED)] = 1.0
    with w.when(shorter):
        s[int(Slot.STEP)] = half
    back.put(w.select(poorer | shorter, w.integer(1), w.integer(0)))
    return w.finished(back)
