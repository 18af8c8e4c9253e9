# SPDX-License-Identifier: BSD-3-Clause
"""What forces press with along a tree at rest whose articulated inertias are known, on the way to the base.

The share that a force has of each pivot is e = τ − s·p, of a rate that moves several segments e = τ − Q, and what is left on the way
p + U e/D, with Q + n_k·s e/D of the other such rates. Of two forces eᵀ D⁻¹ e′ is τᵀ M⁻¹ τ′, as L D Lᵀ has it.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from kane.dynamics.routes.articulated import Inward, Pivot, Wrenches, parts, unit
from kane.dynamics.routes.sharing import Mode, shares_of
from kane.expr.build import add, div, mul, sub
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.spatial import negative, summed, times, triple

Number = tuple[int, int] | Expr | int
"""A pivot: the segment and the place among its own, or the rate that moves several segments; the place in an order of all."""


class Pressed(NamedTuple):
    """What a force presses with: its share e of each pivot, and the moment and force felt of each segment where that is told."""

    shares: Mapping[Number, Expr]
    felt: Mapping[int, tuple[Triple, Triple]]


def pressed(found: Inward, forces: Mapping[Number, Expr], loads: Wrenches) -> Pressed:
    """The way to the base of `loads`, and of generalized forces τ on pivots, at rest."""
    way = _Way(found, forces, loads)
    steps = found.on.steps
    for i in reversed(range(0 if steps[0].modes else 1, len(steps))):
        if way.reaches(i):
            way.pass_on(i)
    return Pressed(way.shares, way.felt)


class _Way:
    """The forces on their way to the base, along B and beside, and Q of the rates that move several segments."""

    def __init__(self, found: Inward, forces: Mapping[Number, Expr], loads: Wrenches) -> None:
        self.found, self.forces, self.loads = found, forces, loads
        self.hung: dict[int, tuple[Triple, Triple]] = {}
        self.beside: dict[int, tuple[Triple, Triple]] = {}
        self.q: dict[Expr, Expr] = {}
        self.shares: dict[Number, Expr] = {}
        self.felt: dict[int, tuple[Triple, Triple]] = {}
        self.reached: Collection[int] = {k[0] for k in forces if isinstance(k, tuple)} | loads.keys()

    def reaches(self, i: int) -> bool:
        """Whether anything presses there."""
        own = (mode.rate for mode in self.found.modes.get(i, ()))
        return (
            i in self.reached or i in self.hung or i in self.beside or any(b in self.q or b in self.forces for b in own)
        )

    def pass_on(self, i: int) -> None:
        """From one segment to the one before."""
        (steps, base, _, placed, _), modes = self.found.on, self.found.modes
        step = steps[i]
        p = self.hung.get(i, (NOTHING, NOTHING))
        if i in self.loads:
            p = _both(p, tuple(map(negative, self.loads[i])))
        for mode in modes.get(i, ()):
            p = self._without(p, mode)
        if i == 0:
            return
        turn = step.turn
        if turn is not None and base[i]:
            p = turn.up(p[0]), turn.up(p[1])
        p = _both(p, self.beside.get(i, (NOTHING, NOTHING)))
        turned = turn is None or base[i]
        for k, pivot in enumerate(self.found.pivots[i]):
            if not turned and not pivot.turning and not step.late:
                assert turn is not None
                p, turned = (turn.up(p[0]), turn.up(p[1])), True
            p = self._taking(p, pivot, (i, k))
        if not turned:
            assert turn is not None
            p = turn.up(p[0]), turn.up(p[1])
        self.felt[i] = p
        arm, slide = placed[i]
        for b, spin, sliding in shares_of(step, slide):
            self._add(b, add(dot(spin, p[0]), dot(sliding, p[1])))
        p = summed(p[0], cross3(arm, p[1])), p[1]
        for lead in () if step.joins else reversed(step.lead):
            p = lead.up(p[0]), lead.up(p[1])
        if step.parent or steps[0].modes:
            onto = self.beside if step.joins else self.hung
            onto[step.parent] = _both(p, onto[step.parent]) if step.parent in onto else p

    def _add(self, b: Expr, x: Expr) -> None:
        if x is not ZERO:
            self.q[b] = add(self.q.get(b, ZERO), x)

    def _without(self, p: tuple[Triple, Triple], mode: Mode) -> tuple[Triple, Triple]:
        """What is pressed with before a rate that moves several segments."""
        e = self.shares[mode.rate] = sub(self.forces.get(mode.rate, ZERO), self.q.get(mode.rate, ZERO))
        for b, x in mode.beside.items():
            self._add(b, mul(x, e))
        return summed(p[0], times(e, mode.t_n)), summed(p[1], times(e, mode.t_f))

    def _taking(self, p: tuple[Triple, Triple], pivot: Pivot, number: Number) -> tuple[Triple, Triple]:
        """What is pressed with before a freedom that a force acts on."""
        s, slide = parts(pivot.freedom, pivot.turning)
        force, (n, f) = self.forces.get(number, ZERO), p
        e = self.shares[number] = sub(force, add(dot(s, n), dot(slide, f)))
        for b, x in pivot.beside.items():
            if x is not ZERO:
                self._add(b, mul(x, div(e, pivot.d)))
        n, f = summed(n, times(e, pivot.t_n)), summed(f, times(e, pivot.t_f))
        k = unit(pivot.freedom.axis)
        if k is not None and pivot.freedom.slide is NOTHING:  # the whole component is the force
            whole = triple(force if i == k else x for i, x in enumerate(n if pivot.turning else f))
            n, f = (whole, f) if pivot.turning else (n, whole)
        return n, f


def _both(p: tuple[Triple, Triple], q: Sequence[Triple]) -> tuple[Triple, Triple]:
    return summed(p[0], q[0]), summed(p[1], q[1])


def loaded(found: Inward, forces: Sequence[Pressed], amounts: Sequence[Expr]) -> Inward:
    """What is left with such forces besides, in these amounts."""

    def more(number: Number, rest: Expr, d: Expr) -> Expr:
        total = ZERO
        for each, x in zip(forces, amounts, strict=True):
            total = add(total, mul(each.shares.get(number, ZERO), x))
        return add(rest, div(total, d))

    pivots = [
        [pivot._replace(rest=more((i, k), pivot.rest, pivot.d)) for k, pivot in enumerate(own)]
        for i, own in enumerate(found.pivots)
    ]
    modes = {i: [replace(m, rest=more(m.rate, m.rest, m.d)) for m in own] for i, own in found.modes.items()}
    felt = {}
    for i, inertia in found.felt.items():
        for each, x in zip(forces, amounts, strict=True):
            if i in each.felt:
                n, f = each.felt[i]
                inertia = inertia._replace(n=summed(inertia.n, times(x, n)), f=summed(inertia.f, times(x, f)))
        felt[i] = inertia
    return Inward(found.on, pivots, felt, modes)
