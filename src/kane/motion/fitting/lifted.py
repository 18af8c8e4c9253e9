# SPDX-License-Identifier: BSD-3-Clause
"""Motions whose inputs are linear in the unknowns z, as simultaneous steps with independent initial states (direct multiple shooting).

x_{k+1} = Φ_k(x_k, z) by an explicit method of order 9, with ∫L dt of each step. First derivatives are those of the discretization,
second derivatives are differences of these. The states between steps are unknowns as well, and are eliminated by condensation, δx_k
= S_k δz + s_k (Bock & Plitt 1984; Albersmeyer & Diehl 2010, "lifted Newton").
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.expr.differentiation import gradient, tangent
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, Expr
from kane.expr.symbols import Parameter, Symbol, time
from kane.expr.visit import substituted
from kane.motion.derivatives.moved_breakpoints import clocks, moves_breakpoints
from kane.motion.derivatives.parameter_slopes import symbol_slopes
from kane.motion.derivatives.parametric_motion import ParametricMotion
from kane.motion.derivatives.pulling import Integrand
from kane.motion.inputs.breakpoints import on_from, up_to
from kane.motion.inputs.expressions import Formula
from kane.motion.right_hand_side import Routines, entries, has_jumps, is_long, only, routines
from kane.motion.solution.phases import Indices, Phase
from kane.motion.steppers.vern9 import VERN9
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED_CHAIN
from kane.program.from_expressions import Bundle, Shaped

_C, _B = np.array(VERN9.c[: len(VERN9.b)]), np.array(VERN9.b)
_A = [np.zeros(0), *map(np.array, VERN9.a[: len(VERN9.b) - 1])]
_MOVE = 2.0**-22
"""Difference step for second derivatives, relative to the size of a state."""


class StepEnds(NamedTuple):
    """Final states (b × n) of steps and their costs (b), with derivatives by (x, the components of z that affect the step)."""

    x: Array
    x_slopes: Array
    cost: Array
    cost_slopes: Array


def readings(eom: Equations, *values: Expr) -> Bundle[Array]:
    """Each expression, its derivatives by the state and by the inputs, as a row."""
    wanted = [*eom.state, *eom.inputs]
    rows = [e for value in without_unknowns(eom.solved, values) for e in (value, *gradient(value, wanted))]
    return Bundle("readings", ports(eom.derived), only, {"x": Shaped((len(values), 1 + len(wanted)), tuple(rows))})


@dataclass(frozen=True, eq=False)
class Steps:
    """Steps of lengths h (m) with stage times t; inputs are base + gain z (stages × m × inputs …), with z[active] (m × a)."""

    now: Routines
    values: tuple[Expr, ...]
    t: Array
    h: Array
    base: Array
    gain: Array
    active: Indices

    @property
    def edges(self) -> Array:
        """The start times of steps, and the final time."""
        return np.append(self.t[0, 0] + np.append(0.0, np.cumsum(self.h[:-1])), self.t[0, 0] + self.h.sum())

    def read(self, t: Array, x: Array, r: Array) -> Array:
        """L, final cost and conditions, with derivatives by state and inputs (b × values × 1 + …)."""
        return self.now.routine(readings, *self.values)(t, x, self.now.p, r)

    def flow(self, k: Indices, x: Array, z: Array) -> StepEnds:
        """The steps k (b) from states x (b × n), with z (b × a)."""
        now, (b, n), a, h = self.now, x.shape, self.active.shape[1], self.h[k]
        fx, fr = now.routine(entries), now.routine(symbol_slopes, *now.eom.inputs)
        unit = np.broadcast_to(np.eye(n, n + a), (b, n, n + a))
        f, df = np.empty((len(_B), b, n)), np.empty((len(_B), b, n, n + a))
        c, dc = np.empty((len(_B), b)), np.empty((len(_B), b, n + a))
        for i, row in enumerate(_A):
            at = x + h[:, None] * np.tensordot(row, f[:i], 1)
            d = unit + h[:, None, None] * np.tensordot(row, df[:i], 1)
            t, gain = self.t[i, k], self.gain[i, k]
            r = self.base[i, k] + np.einsum("bra,ba->br", gain, z)
            f[i] = now.rates(t, at, now.p, r)[:, :n]
            df[i] = fx(t, at, now.p, r)[:, :n, :n] @ d
            df[i, :, :, n:] += fr(t, at, now.p, r) @ gain
            cost = self.read(t, at, r)[:, 0]
            c[i], dc[i] = cost[:, 0], np.einsum("bn,bnm->bm", cost[:, 1 : n + 1], d)
            dc[i, :, n:] += np.einsum("br,bra->ba", cost[:, n + 1 :], gain)
        return StepEnds(
            x + h[:, None] * np.tensordot(_B, f, 1),
            unit + h[:, None, None] * np.tensordot(_B, df, 1),
            h * np.tensordot(_B, c, 1),
            h[:, None] * np.tensordot(_B, dc, 1),
        )

    def condensed(self, flow: StepEnds, defects: Array, count: int) -> tuple[Array, Array]:
        """S and s (m + 1 × n …) of δx_k = S_k δz + s_k, z with `count` components."""
        (m, n), a = flow.x.shape, flow.x_slopes[:, :, : flow.x.shape[1]]
        S, s = np.zeros((m + 1, n, count)), np.zeros((m + 1, n))
        for k in range(m):
            S[k + 1] = a[k] @ S[k]
            S[k + 1][:, self.active[k]] += flow.x_slopes[k, :, n:]
            s[k + 1] = a[k] @ s[k] + defects[k]
        return S, s

    def resized(self, factors: Array) -> "Steps":
        """The same with unknowns in units that are larger by `factors`."""
        return replace(self, gain=self.gain * factors[self.active][None, :, None])

    def curvature(self, x: Array, z: Array, at: StepEnds, weights: Array, size: Array) -> Array:
        """∂²(L_k + λ_{k+1}·Φ_k)/∂(x, z)² of each step (m × n + a × n + a), by differences of first derivatives."""
        (m, n), a = x.shape, z.shape[1]
        moves = _MOVE * np.append(size, np.ones(a))
        k = np.repeat(np.arange(m), n + a)
        shifts = np.tile(np.diag(moves), (m, 1))
        near = self.flow(k, x[k] + shifts[:, :n], z[k] + shifts[:, n:])

        def slopes(flow: StepEnds, rows: Indices) -> Array:
            return np.asarray(flow.cost_slopes + np.einsum("bn,bnm->bm", weights[rows], flow.x_slopes))

        found = (slopes(near, k).reshape(m, n + a, n + a) - slopes(at, np.arange(m))[:, None]) / moves[:, None]
        return np.asarray((found + found.transpose(0, 2, 1)) / 2)

    def end(self, x: Array) -> tuple[Array, Array]:
        """Final cost and conditions (1 + e), and their derivatives by the state."""
        (at,) = self.read(self.t[-1, -1:], x[None], np.zeros((1, self.base.shape[2])))
        return at[1:, 0], at[1:, 1 : len(x) + 1]

    def end_by(self, x: Array, z: Array) -> tuple[Array, Array]:
        """The conditions (e) and their derivatives by z (e × count), at states x between steps that need not join."""
        flow = self.flow(np.arange(len(self.h)), x[:-1], z[self.active])
        values, slopes = self.end(x[-1])
        return values[1:], slopes[1:] @ self.condensed(flow, 0 * flow.x, len(z))[0][-1]

    def end_curvature(self, x: Array, weights: Array, size: Array) -> Array:
        """∂²(cost + weights·conditions)/∂x² at the final state (n × n)."""
        n, moves = len(x), _MOVE * size
        near = np.vstack([x, x + np.diag(moves)])
        at = self.read(np.repeat(self.t[-1, -1:], n + 1), near, np.zeros((n + 1, self.base.shape[2])))
        slopes = np.append(1.0, weights) @ at[:, 1:, 1 : n + 1]
        found = (slopes[1:] - slopes[0]) / moves[:, None]
        return np.asarray((found + found.T) / 2)


def steps_of(course: ParametricMotion, wanted: Sequence[Expr], sizes: Array, count: int) -> Steps | None:
    """At least `count` steps of a motion, with the values `wanted`, the first of which is the integrand.

    None if equations or inputs do not qualify, or breakpoints depend on the unknowns.
    """
    eom, drives = course.map.eom, _drives(course)
    if drives is None:
        return None
    by = tuple(s for s in course.by if isinstance(s, Parameter))
    known: set[Expr] = {*eom.state, *eom.parameters, *eom.inputs, time}
    given = {law: s for s, law in _given(course).items()}
    values = tuple(substituted(e, given) for e in wanted)
    inputs, unknown = set(eom.inputs), set(by)
    strange = any(not set(free_symbols([e])) <= known for e in values)
    if strange or any(inputs & set(free_symbols([e])) for e in values[1:]):
        return None
    slopes = [[tangent(f.expr, {p: ONE}) for p in by] for f in drives]
    if any(unknown & set(free_symbols([e])) for row in slopes for e in row):
        return None
    along = Integrand(wanted[0], np.ones(1), course.map.drives(course.parameters)).checked(eom)
    if moves_breakpoints(eom, [*(f.expr for f in drives), *along], course.by):
        return None
    edges = cut_at_bends(course, count, along)
    h = np.diff(edges)
    inside = [np.array([side(t) for t in part.tolist()]) for side, part in ((on_from, edges[:-1]), (up_to, edges[1:]))]
    t = np.clip(edges[:-1] + _C[:, None] * h, *inside)
    base, gain = np.zeros((*t.shape, len(drives))), np.zeros((*t.shape, len(drives), len(by)))
    for i, (f, row) in enumerate(zip(drives, slopes, strict=True)):
        at: dict[Any, Any] = {**f.values, **dict.fromkeys(by, 0.0), time: t.reshape(-1)}
        for place, value in zip(
            (base[..., i], *np.moveaxis(gain[..., i, :], -1, 0)), evaluate([f.expr, *row], at), strict=True
        ):
            place[...] = np.broadcast_to(value, t.size).reshape(t.shape)
    gain *= sizes
    acts = np.any(gain != 0, axis=(0, 2))
    active = np.argsort(~acts, axis=1, kind="stable")[:, : max(1, int(acts.sum(axis=1).max()))]
    own = np.take_along_axis(gain, active[None, :, None, :], axis=3)
    p = np.array([course.parameters[s] for s in eom.parameters])
    now = routines(eom, p, drives, course.map.settings)
    return None if is_long(now) else Steps(now, values, t, h, base, own, active)


def cut_at_bends(course: ParametricMotion, count: int, more: Sequence[Expr] = ()) -> Array:
    """The time span divided at breakpoints of rates and `more`, and further into at least `count` intervals of similar length."""
    span, known = (course.map.t0, course.end), course.parameters
    every = clocks(course.map.eom, Phase(known, course.map.drives(known)), more)
    bends = sorted({*span}.union(*(found.breakpoints(values, span) for found, values in every)))
    parts = [max(1, math.ceil(count * (b - a) / (span[1] - span[0]) - ROUNDED_CHAIN)) for a, b in pairwise(bends)]
    return np.unique(
        np.concatenate([np.linspace(a, b, 1 + k) for (a, b), k in zip(pairwise(bends), parts, strict=True)])
    )


def _given(course: ParametricMotion) -> dict[Symbol, Expr]:
    """The inputs that are specified as expressions."""
    names = {s.name: s for s in course.map.eom.inputs}
    found = dict(course.map.inputs or {})
    return {names[str(getattr(s, "name", s))]: e for s, e in found.items() if isinstance(e, Expr)}


def _drives(course: ParametricMotion) -> tuple[Formula, ...] | None:
    """The inputs, for equations without constraints, contacts and events whose unknowns occur in inputs of time alone; else None."""
    eom = course.map.eom
    system, own = eom.system, set(eom.parameters)
    plain = not (eom.constraints.constraints or system.euler_parameters or system.contacts or eom.events)
    if not plain or has_jumps(eom) or course.free or any(s in own for s in course.by):
        return None
    drives = course.map.drives(course.parameters)
    timed = tuple(f for s in eom.inputs if isinstance(f := drives[s], Formula) and not f.of_state)
    return timed if timed and len(timed) == len(eom.inputs) else None
