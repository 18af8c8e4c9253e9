# SPDX-License-Identifier: BSD-3-Clause
"""Arguments of the automaton's kernel: tables of the contacts, and of each mode that it may enter."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from kane.equations.equations import Equations
from kane.equations.mode_equations import layout, touching
from kane.expr.node import Expr
from kane.expr.symbols import Symbol
from kane.model.contacts import LAWS, ContactLaw, ContactMode, Modes
from kane.model.declarations import Event
from kane.motion.hybrid.contact_automaton import NOTED, Record
from kane.motion.hybrid.contact_decisions import NO_PLACE, room
from kane.motion.hybrid.contact_events import KINDS
from kane.motion.hybrid.contact_turning import ROOM
from kane.motion.right_hand_side import Given
from kane.motion.steppers.crossings import LEAVES
from kane.numeric.arrays import Array

KNOWN = ("slack", "fastest", "highest", "rebound", "slip_rate")
"""Data of each contact, one number each, as in `kane.motion.contact_motion`."""
MODES, ROWS = 32, 1024
"""Largest number of modes with kernels; number of modes of a motion after which results are collected."""
LIMIT = 10_000
"""Largest number of steps of a mode in the kernel; Python runs longer modes."""
_BEGIN = ("closes", "sticks")
"""Kinds of events whose quantities may leave their thresholds upward when the mode begins."""


def end_of(contacts: Sequence[ContactLaw], event: Event) -> tuple[int, str] | None:
    """The contact whose mode an event ends, and the kind of the event; None for other events."""
    for i, c in enumerate(contacts):
        name, _, kind = event.name.rpartition(" ")
        if name == c.name and kind in KINDS:
            return i, kind
    return None


def code_of(modes: Modes) -> float:
    """The number that identifies a mode in the kernel."""
    code = 0.0
    for m in modes:
        code = code * 5 + int(m)
    return code


def possible(contacts: Sequence[ContactLaw]) -> list[Modes]:
    """The modes in which each closed contact has constraints of its own."""

    def alone(c: ContactLaw) -> list[ContactMode]:
        slips = [ContactMode.STRAIGHT, ContactMode.SLIP][: len(c.slips)]
        return [ContactMode.SEPARATED] * (c.gap is not None or c.pressed_by is not None) + [ContactMode.STICK, *slips]

    places = {c: i for i, c in enumerate(contacts)}
    pressed = [(i, places[c.pressed_by]) for i, c in enumerate(contacts) if c.pressed_by is not None]
    return [
        modes
        for modes in product(*map(alone, contacts))
        if all((modes[i] is ContactMode.SEPARATED) == (modes[by] is ContactMode.SEPARATED) for i, by in pressed)
    ]


def symbols(eom: Equations) -> list[list[Symbol | None]]:
    """For each contact the parameters that its mode sets: direction of slip (d − 1, padded with None), slowest slip and slack."""
    d = eom.numeric().value(layout).d
    return [[*c.direction, *[None] * (d - 1 - len(c.direction)), c.slowest, c.slack] for c in eom.system.contacts]


def numbers_of(eom: Equations, rows: Array) -> list[dict[Expr, float]]:
    """The contact parameters, by symbol, of the mode of each row of `records`."""
    flat = [s for own in symbols(eom) for s in own]
    named = [(int(Record.MORE) + k, s) for k, s in enumerate(flat) if s is not None]
    own, table = [s for _, s in named], rows[:, [k for k, _ in named]].tolist()
    return [dict(zip(own, values, strict=True)) for values in table]


def structure(eom: Equations, most: int = ROWS) -> Given:
    """Arguments of the kernel: counts, indices of contact rows, laws of restitution, and work arrays for `most` modes per call."""
    where, contacts = eom.numeric().value(layout), eom.system.contacts
    derived, k, d, n = eom.numeric().value(touching), len(contacts), where.d, len(eom.state) + 1
    width, always = len(derived.blocks.forcing) + len(derived.blocks.forcing_a), len(where.always)
    ints = {
        "contacts": k, "dimension": d, "width": width, "rows": len(derived.constraints.b), "always_count": always,
        "speeds": len(eom.speeds), "coordinates": len(eom.coordinates), "n": n, "room_for": most,
        "event_count": len(eom.system.events) + 4 * k + 16, "p_count": len(eom.parameters) + k * (d + 1) + 8,
    }  # fmt: skip
    small = {
        name: np.zeros(k)
        for name in (*KNOWN, "modes", "leaving", "next_modes", "friction", "touching", "hits", "off", "part")
    }
    wide = {name: np.zeros(k * d) for name in ("next_ways", "sliding", "impulse", "grown")}
    return {
        **ints,
        **small,
        **wide,
        "directions": np.zeros(k * (d - 1)),
        "extra": np.zeros(k * (d + 1)),
        "kept": np.zeros(len(KNOWN) * k + 1),
        "turning": np.zeros(ROOM),
        "places": np.array([NO_PLACE if p is None else float(p) for own in where.places for p in own]),
        "always": np.array([*where.always, 0.0], dtype=float),
        "pressed_by": np.array([-1.0 if m is None else float(m) for m in where.pressed_by]),
        "slip_count": np.array([float(len(c.slips)) for c in contacts]),
        "law": np.array([float(LAWS.index(c.law)) for c in contacts]),
        "room": np.zeros(room(k, d, width, always)),
        "records": np.zeros(2 + row_of(k, d, n) * (most + 1)),
        "noted": np.zeros(2 * (NOTED * most + 1)),
        "glanced": np.zeros(2 * ints["event_count"]),
        "lag": np.zeros(n),
    }


def row_of(k: int, d: int, n: int) -> int:
    """The length of a row of `records`."""
    return int(Record.MORE) + k * (d + 1) + 2 * n


def of_modes(given: Given, count: int) -> dict[str, Array]:
    """The arrays with one part per mode, for `count` modes."""
    most, extra = given["event_count"], given["contacts"] * (given["dimension"] + 1)
    return {
        "ps": np.zeros((count, given["p_count"])),
        **{name: np.zeros((count, most)) for name in ("seen", "largest", "least", "begun")},
        "leaves": np.zeros((count, most * LEAVES)),
        "meaning": np.full((count, most, 2), -1.0),
        "p_at": np.full((count, extra), -1.0),
        "own_events": np.zeros(count),
    }


def reach_of(mode: Equations) -> Array:
    """The largest magnitude in each column of A (speeds), a scale for entries that may be almost zero when a mode begins."""
    if mode.embedding is None:
        return np.zeros((0, len(mode.speeds)))
    reach: Array = np.abs(mode.derived.compared.a).max(axis=0)
    return reach


def put_mode(arrays: dict[str, Array], m: int, eom: Equations, mode: Equations) -> None:
    """Writes to part m the contact and kind of each event of a mode of `eom`, and the indices of contact parameters in its p."""
    own = {e.name for e in mode.system.events}
    for e, event in enumerate(mode.events):
        meant = end_of(eom.system.contacts, event)
        arrays["begun"][m, e] = -1.0 if event.name not in own else float(meant is not None and meant[1] in _BEGIN)
        if meant is not None:
            arrays["meaning"][m, e] = meant[0], KINDS.index(meant[1])
    at: dict[Expr, int] = {s: k for k, s in enumerate(mode.parameters)}
    flat = [s for row in symbols(eom) for s in row]
    arrays["p_at"][m] = [-1.0 if s is None else float(at.get(s, -1)) for s in flat]
    arrays["own_events"][m] = len(mode.events)
