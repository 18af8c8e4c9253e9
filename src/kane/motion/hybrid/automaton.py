# SPDX-License-Identifier: BSD-3-Clause
"""Events and switches as a kernel takes them: routines of their quantities, tables of what they do and how they leave thresholds.

A kernel decides what follows from numbers: passages of events that are noted or end the motion, switches, and actions that set
speeds, states and parameters to expressions, and coordinates where no constraints hold them. Pivots of W, actions that are functions
of Python, set inputs, moments of inertia, or what turns at times or inputs depend on, are asked of Python.
"""

from typing import Any

import numpy as np

from kane.dynamics.poles import SLIPS, KinematicsEnd, SlipEnd
from kane.equations.equations import Equations
from kane.model.declarations import Event
from kane.motion.hybrid.contact_starts import ends_force
from kane.motion.hybrid.event_routines import actions, bundles, glance, tendency, values_set
from kane.motion.hybrid.events import Fresh, Leaves, leaves_row
from kane.motion.inputs.expressions import Formula
from kane.motion.right_hand_side import Given, Routines
from kane.motion.steppers.crossings import KINDS, LEAVES, Kind
from kane.motion.steppers.crossings import room as zoomed
from kane.motion.steppers.watched import rooms
from kane.numeric.arrays import Array, Mask
from kane.numeric.polynomials import DEGREE as PARTS
from kane.numeric.scale import ROUNDED_TERMS
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import aligned, entry, hoist_entry, hoisted, wide_entry


def kind(eom: Equations, event: Event, acting: bool) -> Kind:
    """What an event does."""
    if isinstance(event, KinematicsEnd) or (event.then is not None and not acting):
        return Kind.ASKED
    return Kind.ACTS if acting else Kind.ENDS if event.terminal else Kind.NOTED


def tables(eom: Equations, n: int, switches: int = 0) -> Given:
    """What is the same for all motions of n components: counts, what events do, at which thresholds, and room."""
    events, count, own = eom.events, len(eom.events) + switches, {e.name for e in eom.system.events}
    values = values_set(eom)
    acting, none = {k for k, _, _ in values}, [0.0] * switches
    shared = np.array([isinstance(e, SlipEnd) and e.by_share for e in events], dtype=bool)
    kinds = np.array([[float(Kind.TURNS), 0.0, 0.0, 0.0]] * count).reshape(-1, KINDS)
    for k, event in enumerate(events):
        kinds[k] = kind(eom, event, k in acting), event.direction, event.name in own, bool(event.terminal)
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


def automaton(now: Routines, t: float, y: Array, fresh: Fresh, wide: bool = True) -> Given:
    """What tells a kernel of events, and of switches behind them, from t on."""
    assert now.events is not None
    numeric, seen, at = now.eom.numeric(now.settings), now.watch(t, y), (t, y[: now.width])
    given = {name: _own(what) for name, what in numeric.value(tables, len(y), len(now.quantities)).items()}
    given |= {"seen": seen, "largest": np.nan_to_num(np.abs(seen)), "sides_at": len(now.eom.parameters)}
    given["watch"] = wide_entry(now.events, PARTS) if wide else entry(now.events)
    begin_at(given, now.eom.events, fresh)
    given["kinds"][[k * KINDS for k in asks_for(now)]] = float(Kind.ASKED)
    for name, routine in evaluated(now).items():
        own = {} if name == "watch" else {name: entry(routine)}
        h = f"h{name[0]}"
        given |= own | {h: hoisted(routine, *at, now.parameters(routine), now.inputs(t, y))}
        given[f"hoist_{h}"] = hoist_entry(routine)
    return given


def _own(what: Any) -> Any:
    """A copy of an array, which vectors may be read from without crossing lines of the cache; an integer itself."""
    if isinstance(what, int):
        return what
    copy = aligned(len(what))
    copy[:] = what
    return copy


def evaluated(now: Routines) -> dict[str, CompiledRoutine]:
    """What a kernel evaluates of events, by the names of its arguments; the rates stand for what it does not."""
    assert now.events is not None
    numeric = now.eom.numeric(now.settings)
    if not now.quantities:
        numeric.compile(*bundles(now.eom))
    acting = bool(numeric.value(values_set))
    found = {"watch": now.events, "glance": now.routine(glance, *now.turning).flat}
    return found | {
        name: now.routine(bundle).flat if acting else now.rates
        for name, bundle in (("tendency", tendency), ("act", actions))
    }


def asks(eom: Equations) -> bool:
    """Whether Python is asked wherever there is an event: for actions that kernels do not take."""
    acting = {k for k, _, _ in values_set(eom)}
    return any(e.then is not None and k not in acting for k, e in enumerate(eom.events))


def asks_for(now: Routines) -> list[int]:
    """The events for which Python is asked as they set parameters of inputs."""
    eom, first = now.eom, len(now.eom.state) + 1
    read = {s for f in now.drives if isinstance(f, Formula) for s in f.values}
    set_ = eom.numeric(now.settings).value(values_set) if read else []
    return [k for k, place, _ in set_ if place >= first and eom.parameters[place - first] in read]


def stands_beside(now: Routines, given: Given, t: float, y: Array) -> bool:
    """Whether no quantity is at its threshold at a start, which `given` then tells of, nor a force beyond its cone; all are finite."""
    count = len(given["seen"])
    routine = now.routine(glance, *now.turning).flat
    found = routine(t, y[: now.width], now.parameters(routine), now.inputs(t, y) if now.drives else None)
    given["seen"][:], given["largest"][:], given["leaves"][:] = found[:count], np.abs(found[:count]), 0.0
    return bool(are_beside(now, given, found[:count], found[count:])) and bool(np.isfinite(found).all())


def are_beside(now: Routines, given: Given, values: Array, terms: Array) -> Mask:
    """Whether quantities (… × n) are at no threshold, and no force is beyond its cone, at starts (…)."""
    count = values.shape[-1]
    own = given["kinds"].reshape(-1, KINDS)[:count, 2] > 0
    forces = np.array([bool(kind) for kind in now.eom.numeric().value(ends_force)] + [False] * count)[:count]
    away = np.abs(values - given["least"][:count]) > ROUNDED_TERMS * terms
    return np.asarray(((away | ~own) & ~(forces & (values < 0))).all(axis=-1))


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
