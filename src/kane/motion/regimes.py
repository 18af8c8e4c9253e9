# SPDX-License-Identifier: BSD-3-Clause
"""Loads that switch, in machine code: the equations of the side on which a motion is, up to the place where a switch turns.

With every switch replaced by what it is on its side, rates are smooth across the place, so that a step sees it as an event on its own
polynomial. The step is taken again up to there, and another side begins. Where a motion comes back at once from both sides, as dry
friction at rest does, it does not get on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.readings.values import without_unknowns
from kane.equations.equations import Equations
from kane.expr.node import Expr, constant
from kane.expr.piecewise import Piecewise
from kane.expr.piecewise_sides import leaps
from kane.expr.substitute import substitute
from kane.expr.switches import on_sides
from kane.expr.switches import switches as switches_of
from kane.expr.symbols import Parameter
from kane.motion.bounds import SHARES, passages
from kane.motion.routines import Routines, rates, watched
from kane.motion.steps import Stepper
from kane.motion.switches import switches
from kane.numeric.arrays import Array
from kane.program.bundle import Bundle, Shaped

SOON, _NEARER = 1e-3, 1e-6
"""Shares of a step after which it shows on which side a motion is that began on none."""
_AT_END = 1e-9
"""Share of a step before its end at which a switch counts as turning there."""
_STILL = 1e-13
"""Share of its usual size that a quantity has which does not leave zero."""


def quantities(eom: Equations) -> tuple[Expr, ...]:
    """The quantities of all switches that the rates hold, but for those of tables that only bend."""
    return tuple(s.quantity for s in switches_of(rates(eom).task.roots) if not all(map(_bending, s.nodes)))


def _bending(node: Expr) -> bool:
    return isinstance(node.op, Piecewise) and not leaps(node.op)


def jumps(eom: Equations) -> bool:
    """Whether loads jump."""
    return any(s.jumps for s in switches(eom))


def unfit(eom: Equations) -> bool:
    """Whether loads jump and the rates hold switches with more than two sides, tables of steps, or with none: what chooses pivots."""
    if not jumps(eom):
        return False
    loads = eom.solved.regular.declared_loads
    scalars = [x for load in loads for _, v in (*load.forces, *load.torques) for x in v.scalars()]
    own = switches_of(without_unknowns(eom.solved, scalars))
    tables = any(isinstance(node.op, Piecewise) and leaps(node.op) for s in own for node in s.nodes)
    return tables or not set(quantities(eom)) <= {s.quantity for s in own}


def rates_on(eom: Equations, *sides: int) -> Bundle[tuple[Array, ...]]:
    """(q̇, u̇, P) with the switches on these sides."""
    return _on(eom, rates(eom), sides)


def watched_on(eom: Equations, *sides: int) -> Bundle[tuple[Array, ...]]:
    """The events' quantities, then those of the switches."""
    names = [*(e.name for e in eom.events), *map(str, range(len(sides)))]
    roots = [*without_unknowns(eom.solved, [e.quantity for e in eom.events]), *quantities(eom)]
    plain = watched(eom)
    return _on(eom, Bundle("watched", plain.ports, plain.record, {"events": roots}, names), sides)


def _on(eom: Equations, plain: Bundle[Any], sides: tuple[int, ...]) -> Bundle[Any]:
    symbols = {c: Parameter.declare(f"side{k}", description="of a switch") for k, c in enumerate(quantities(eom))}
    numbers = {symbols[c]: constant(side) for c, side in zip(symbols, sides, strict=True)}
    memo: dict[Expr, Expr] = {}

    def fixed(root: Expr) -> Expr:
        found: Expr = substitute(on_sides(root, symbols, memo), numbers)
        return found

    groups = {name: Shaped(g.shape, tuple(map(fixed, g.roots))) for name, g in plain.groups.items()}
    return Bundle(plain.name, plain.ports, plain.record, groups, plain.labels)


class Turns(Enum):
    """What switches do in a step."""

    NOT = "not"
    BEFORE = "before its end"
    AT_END = "at its end"
    BACK = "back at once"
    SOON = "on, but soon"
    STILL = "still at zero"


class Turn(NamedTuple):
    """What a step does, when, and which switches."""

    what: Turns
    t: float = 0.0
    which: tuple[int, ...] = ()


class Regimes:
    """The side of each switch; `fresh` are those whose quantities are zero now, `tried` those that came back from a side before."""

    def __init__(self, stepper: Stepper, t: float, y: Array) -> None:
        self.eom = stepper.eom
        self.events = len(self.eom.events)
        count = len(quantities(self.eom))
        self.sides = (1,) * count
        values = self.routines(stepper).watch(t, y)[self.events :]
        self.sides = tuple(-1 if v < 0 else 1 for v in values)
        self.fresh = frozenset(np.flatnonzero(values == 0).tolist())
        self.tried: frozenset[int] = frozenset()

    def routines(self, stepper: Stepper) -> Routines:
        """The equations on these sides, and what is watched."""
        numeric = stepper.eom.numeric(stepper.now.settings)
        found = numeric.routine(rates_on, *self.sides), numeric.routine(watched_on, *self.sides)
        return replace(stepper.now, rates=found[0].flat, events=found[1].flat)

    def turn(self, which: tuple[int, ...], tried: bool = False) -> None:
        """The other side of some switches, whose quantities are zero."""
        self.sides = tuple(-s if k in which else s for k, s in enumerate(self.sides))
        self.fresh = frozenset(which)
        self.tried = self.fresh if tried else frozenset()

    def gone_on(self) -> None:
        """A step was taken: every quantity is away from zero."""
        self.fresh = self.tried = frozenset()

    def look(self, now: Routines, state: Callable[[float], Array], start: float, h: float, values: Array) -> Turn:
        """What switches do in the step of length h from `start`; `values` are theirs at the places."""
        met: list[tuple[float, int]] = []
        largest = np.abs(values).max(axis=0, initial=0)
        for k, side in enumerate(self.sides):

            def ahead(t: float, k: int = k, side: int = side) -> float:
                return side * float(now.watch(t, state(t))[self.events + k])

            def each(times: Array, ahead: Callable[[float], float] = ahead) -> Array:
                return np.array([ahead(float(t)) for t in times])

            times, own = start + h * np.array(SHARES), side * values[:, k]
            if k in self.fresh:
                begin = start + SOON * h
                if not largest[k] > 0 or abs(ahead(begin)) <= _STILL * largest[k]:
                    return Turn(Turns.STILL, start, (k,))
                if ahead(begin) < 0:
                    soon = ahead(start + _NEARER * h) > 0
                    return Turn(Turns.SOON if soon else Turns.BACK, start, (k,))
                times = begin + (start + h - begin) * np.array(SHARES)
                own = np.append(each(times[:-1]), own[-1])
            for a, b, first, last in passages(each, times, own):
                if first > 0:
                    met.append((_located(ahead, a, b, last), k))
                    break
        if not met:
            return Turn(Turns.NOT)
        t = min(met)[0]
        which = tuple(k for at, k in met if at - t <= _AT_END * h)
        return Turn(Turns.AT_END if t >= start + (1 - _AT_END) * h else Turns.BEFORE, t, which)


def _located(gap: Callable[[float], float], a: float, b: float, last: float) -> float:
    """Where `gap` passes zero between a and b."""
    from scipy.optimize import brentq

    if last == 0 or gap(b) > 0:
        return b
    return a if gap(a) <= 0 else float(brentq(gap, a, b, xtol=1e-15 * max(abs(a), abs(b)), rtol=1e-15, maxiter=200))
