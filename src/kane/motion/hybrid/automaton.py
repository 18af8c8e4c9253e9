# SPDX-License-Identifier: BSD-3-Clause
"""Events and switches as a kernel takes them: routines of their quantities, tables of what they do and how they leave thresholds.

A kernel decides what follows from numbers: passages of events that are noted or end the motion, and actions that set the state of
systems without constraints to expressions. Pivots of W, actions that are functions of Python, set parameters or inputs, or act under
constraints, and all events beside loads that switch are asked of Python.
"""

from typing import Any

import numpy as np

from kane.dynamics.poles import SLIPS, KinematicsEnd, SlipEnd
from kane.equations.equations import Equations
from kane.model.declarations import Event
from kane.motion.hybrid.event_routines import actions, bundles, decided, glance, tendency, values_set
from kane.motion.hybrid.events import Fresh, Leaves, leaves_row
from kane.motion.right_hand_side import Given, Routines
from kane.motion.steppers.crossings import KINDS, LEAVES, Kind
from kane.motion.steppers.crossings import room as zoomed
from kane.motion.steppers.watched import rooms
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED_TERMS
from kane.numeric.sign_changes import DEGREE as PARTS
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import aligned, entry, hoisted, wide_entry


def kind(eom: Equations, event: Event, acting: bool) -> Kind:
    """What an event does."""
    if isinstance(event, KinematicsEnd) or (event.then is not None and not acting):
        return Kind.ASKED
    return Kind.ACTS if acting else Kind.ENDS if event.terminal else Kind.NOTED


def tables(eom: Equations, n: int, switches: int = 0) -> Given:
    """What is the same for all motions of n components: counts, what events do, at which thresholds, and room."""
    events, count, own = eom.events, len(eom.events) + switches, {e.name for e in eom.system.events}
    decides = decided(eom) and not switches
    values = values_set(eom) if decides else []
    acting, none = {k for k, _, _ in values}, [0.0] * switches
    shared = np.array([isinstance(e, SlipEnd) and e.by_share for e in events], dtype=bool)
    kinds = np.full((count, KINDS), float(Kind.ASKED))
    for k, event in enumerate(events):
        if decides:
            kinds[k, 0] = kind(eom, event, k in acting)
        kinds[k, 1:] = event.direction, event.name in own, bool(event.terminal)
    lengths = rooms(count, len(events), len(values), n)
    return {
        "events": count,
        "own": len(events),
        "acts": len(values),
        "least": np.array([*np.where(shared, 0.0, [e.threshold for e in events]), *none]),
        "shares": np.array([*np.where(shared, SLIPS, 0.0), *none]),
        "pivots": np.array([*(float(isinstance(e, KinematicsEnd)) for e in events), *none]),
        "kinds": kinds.reshape(-1),
        "leaves": np.zeros(count * LEAVES + 1),
        "actions": np.array([*((k, place) for k, place, _ in values), (0, 0)], dtype=float).reshape(-1),
        "zoom": aligned(zoomed(count)),
        **{name: aligned(length) for name, length in lengths.items()},
    }


def automaton(now: Routines, t: float, y: Array, fresh: Fresh, switches: int = 0, wide: bool = True) -> Given:
    """What tells a kernel of events, and of so many switches behind them, from t on."""
    assert now.events is not None
    numeric, seen, at = now.eom.numeric(now.settings), now.watch(t, y), (t, y[: now.width])
    given = {name: _own(what) for name, what in numeric.value(tables, len(y), switches).items()}
    given |= {"seen": seen, "largest": np.nan_to_num(np.abs(seen))}
    given["watch"] = wide_entry(now.events, PARTS) if wide else entry(now.events)
    begin_at(given, now.eom.events, fresh)
    for name, routine in evaluated(now, switches).items():
        own = {} if name == "watch" else {name: entry(routine)}
        given |= own | {f"h{name[0]}": hoisted(routine, *at, now.parameters(routine), now.inputs(t, y))}
    return given


def _own(what: Any) -> Any:
    """A copy of an array, which vectors may be read from without crossing lines of the cache; an integer itself."""
    if isinstance(what, int):
        return what
    copy = aligned(len(what))
    copy[:] = what
    return copy


def evaluated(now: Routines, switches: int = 0) -> dict[str, CompiledRoutine]:
    """What a kernel evaluates of events, by the names of its arguments; the rates stand for what it does not."""
    assert now.events is not None
    numeric, decides = now.eom.numeric(now.settings), decided(now.eom) and not switches
    numeric.compile(*bundles(now.eom))
    acting = decides and bool(numeric.value(values_set))
    wanted = (("glance", glance, decides), ("tendency", tendency, acting), ("act", actions, acting))
    return {"watch": now.events} | {
        name: numeric.routine(bundle).flat if needed else now.rates for name, bundle, needed in wanted
    }


def asks(eom: Equations) -> bool:
    """Whether Python is asked wherever there is an event: for actions that kernels do not take, and beside loads that switch."""
    acting = {k for k, _, _ in values_set(eom)}
    return not decided(eom) or any(e.then is not None and k not in acting for k, e in enumerate(eom.events))


def stands_beside(now: Routines, given: Given, t: float, y: Array) -> bool:
    """Whether no quantity is at its threshold at a start, which `given` then tells of; they are finite."""
    count = len(now.eom.events)
    routine = now.eom.numeric(now.settings).routine(glance).flat
    found = routine(t, y[: now.width], now.p, now.inputs(t, y) if now.drives else None)
    given["seen"][:], given["largest"][:], given["leaves"][:] = found[:count], np.abs(found[:count]), 0.0
    own = given["kinds"].reshape(-1, KINDS)[:count, 2] > 0
    away = np.abs(found[:count] - given["least"][:count]) > ROUNDED_TERMS * found[count:]
    return bool((away | ~own).all()) and bool(np.isfinite(found).all())


def begin_at(given: Given, events: tuple[Event, ...], fresh: Fresh) -> None:
    """The events at whose thresholds a motion is leave them as `fresh` says."""
    rows = given["leaves"][: len(events) * LEAVES].reshape(-1, LEAVES)
    rows[:] = 0.0
    for k, event in enumerate(events):
        if event.name in fresh:
            rows[k] = leaves_row(fresh[event.name])
            given["seen"][k] = given["least"][k]


def leaving(given: Given, events: tuple[Event, ...]) -> dict[str, Leaves]:
    """How quantities leave their thresholds, as the kernel has it now."""
    rows = given["leaves"][: len(events) * LEAVES].reshape(-1, LEAVES)
    return {
        event.name: Leaves(float(row[1]), int(row[2]), float(row[3]))
        for event, row in zip(events, rows, strict=True)
        if row[0]
    }
