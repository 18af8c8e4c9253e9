# SPDX-License-Identifier: BSD-3-Clause
"""What kernels evaluate to decide events: their quantities, the sizes of the terms, their rates, the values that actions set."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.dynamics.readings.quantities import time_derivative, without_unknowns
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.errors import ExpressionError
from kane.expr.build import add
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Rate, Reaction
from kane.expr.visit import substituted
from kane.model.beams.beam import Beam
from kane.model.bodies import parts_of
from kane.model.declarations import Event, target
from kane.motion.inputs.expressions import law_ports
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import timed
from kane.motion.start import moves_pivots
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle


def glance(eom: Equations, *more: Expr) -> Bundle[tuple[Array, ...]]:
    """The quantities of events, and `more` of switches, then the sizes of their terms and thresholds; 0 where nothing is known."""
    roots, memo = [*without_unknowns(eom.solved, [e.quantity for e in eom.events]), *more], Sizes()
    return _bundle(eom, "glance", [*roots, *map(_size, eom.events), *(size(c, memo) for c in more)], more)


def _size(event: Event) -> Expr:
    if any(isinstance(s, Reaction | Rate) for s in free_symbols([event.quantity])):
        return ZERO
    return add(size(event.quantity, {}), as_expr(abs(event.threshold)))


def tendency(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """The rates of the quantities of the system's own events along the motion; 0 where they are not known."""
    known, own = {s for port in ports(eom.derived) for s in port.symbols}, {e.name for e in eom.system.events}

    def rate(event: Event) -> Expr:
        if event.name not in own:
            return ZERO
        try:
            (found,) = without_unknowns(eom.solved, [time_derivative(eom.solved.derived, event.quantity)])
        except ExpressionError:
            return ZERO
        return found if known.issuperset(free_symbols([found])) else ZERO

    return _bundle(eom, "tendency", list(map(rate, eom.events)))


def actions(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """The values that events set which act in a kernel."""
    return _bundle(eom, "act", [value for _, _, value in values_set(eom)])


def _bundle(eom: Equations, name: str, roots: list[Expr], laws: Sequence[Expr] = ()) -> Bundle[tuple[Array, ...]]:
    given = law_ports(eom, laws) if laws else ports(eom.derived)
    return Bundle(name, given, _parts, {name: roots}, list(map(str, range(len(roots)))))


def _parts(*parts: Array) -> tuple[Array, ...]:
    return parts


def values_set(eom: Equations) -> list[tuple[int, int, Expr]]:
    """Of the events that act in a kernel: which one, the place that it sets, to what.

    Places of parameters stand behind the components of a motion, (q, u, a) and the work; what has the place −1 is to be above zero.
    """
    if moves_pivots(eom) or (is_constrained(eom) and eom.system.contacts):
        return []
    place, known = _places(eom), {s for port in ports(eom.derived) for s in port.symbols}
    found = []
    for k, event in enumerate(eom.events):
        if not isinstance(event.then, Mapping):
            continue
        set_ = {target(eom.system, event, key): as_expr(what) for key, what in event.then.items() if _is_value(what)}
        values = without_unknowns(eom.solved, list(set_.values()))
        if len(set_) == len(event.then) and set_.keys() <= place.keys() and known.issuperset(free_symbols(values)):
            new: dict[Expr, Expr] = dict(zip(set_, values, strict=True))
            found += [(k, place[s], value) for s, value in new.items()]
            found += [
                (k, -1, substituted(mass, new))
                for mass in _masses(eom)
                if not new.keys().isdisjoint(free_symbols([mass]))
            ]
    return found


def _places(eom: Equations) -> dict[Expr, int]:
    """What kernels set: the state, but for coordinates that constraints hold, and parameters that only rates and masses depend on."""
    place: dict[Expr, int] = {s: k for k, s in enumerate(eom.state)}
    if is_constrained(eom):
        place = {s: k for s, k in place.items() if s not in set(eom.coordinates)}
    parts, clock = list(parts_of(eom.system.bodies)), timed(eom)
    if eom.system.contacts:
        return place
    judged = [x for part in parts if part.inertia for pair in part.inertia.dyads for v in pair for x in v.scalars()]
    judged += [*clock.pulses, *(turning.quantity for turning in clock.turning)]
    judged += [x for body in eom.system.bodies if isinstance(body, Beam) for _, x in body.measures()]
    fixed, n = free_symbols(judged), len(eom.state) + 1
    return place | {s: n + k for k, s in enumerate(eom.parameters) if s not in fixed}


def _masses(eom: Equations) -> list[Expr]:
    return list(dict.fromkeys(part.mass for part in parts_of(eom.system.bodies) if not part.momenta))


def _is_value(what: object) -> bool:
    return isinstance(what, Expr | int | float | np.number) and not isinstance(what, bool)


def bundles(eom: Equations) -> list[Callable[[Equations], Bundle[Any]]]:
    """What a kernel needs besides the quantities."""
    if not eom.events:
        return []
    return [glance, *([tendency, actions] if values_set(eom) else [])]
