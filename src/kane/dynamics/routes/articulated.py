# SPDX-License-Identifier: BSD-3-Clause
"""Joint accelerations by articulated inertias: from the tips to the base and back, in a number of operations that grows as the tree.

What hangs on a segment presses on it with n = J α + H a + …, f = Hᵀ α + M a + …. A joint speed w along s leaves no reaction along s:

    U = I s,   D = s·U,   ẇ = (−s·p − U·a)/D,      I − U Uᵀ/D,   p − U (s·p)/D

is what the segment before feels (Kane's equation of w, solved for ẇ; Featherstone 2008, ch. 7). Accelerations are those of points,
gravity is an acceleration of the ground, and no velocities but angular ones are needed.
"""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from kane.dynamics.routes.flexible import RIGID, Bent
from kane.dynamics.routes.sharing import (
    Mode,
    columns_less,
    found_modes,
    lowered,
    over,
    shared,
    shares_of,
    without_modes,
    wrench_at,
)
from kane.errors import SingularError
from kane.expr.build import add, div, mul, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.freedoms import Freedom
from kane.kinematics.segments import Segment
from kane.kinematics.travel import Rates, Travel, travel
from kane.space.rotation import NOTHING, Cosines, Triple, cross3, product, transposed
from kane.space.spatial import NO_INERTIA, Inertia, Rigid, as_rows, negative, of_rigid, summed, times, triple

Wrenches = Mapping[int, tuple[Triple, Triple]]


class Pivot(NamedTuple):
    """U/D, (−s·p)/D, D of a freedom, and s; whether it is a turn; n_k·s of the columns that it was eliminated from."""

    freedom: Freedom
    turning: bool
    t_n: Triple
    t_f: Triple
    rest: Expr
    d: Expr
    beside: Mapping[Expr, Expr] = MappingProxyType({})


class Inward(NamedTuple):
    """What is left of a tree on the way to the base: the pivots of each segment, what is felt of it at its origin, and its modes."""

    on: Travel
    pivots: Sequence[Sequence[Pivot]]
    felt: Mapping[int, Inertia]
    modes: Mapping[int, Sequence[Mode]] = MappingProxyType({})


class Passed(NamedTuple):
    """The rows of the joint speeds with their ẇ, the pivots, what is transmitted to segments that are asked for; α and a along B."""

    rows: list[tuple[Mapping[Expr, Expr], Expr]]
    pivots: list[Expr]
    transmitted: Mapping[int, tuple[Triple, Triple]]
    moving: Sequence[tuple[Triple, Triple]] = ()


def accelerations(
    steps: Sequence[Segment],
    bodies: Sequence[Rigid],
    loads: Wrenches,
    ground: Triple,
    asked: Iterable[int] = (),
    bent: Bent = RIGID,
) -> Passed:
    """ẇ of all freedoms, and what is transmitted to segments that are asked for, their moment about their origin, along A.

    A SingularError where a pivot is zero whatever the state.
    """
    return outward(inward(travel(steps), bodies, loads, bent), ground, asked)


def inward(on: Travel, bodies: Sequence[Rigid], loads: Wrenches, bent: Bent = RIGID) -> Inward:
    """From the tips to the base."""
    steps, base, rates, placed, known = on
    hung: list[Inertia | None] = [None] * len(steps)  # along B
    beside: list[Inertia | None] = [None] * len(steps)  # along the basis of work, where that is A
    pivots: list[list[Pivot]] = [[] for _ in steps]
    across: dict[int, Inertia] = {}
    modes: dict[int, Sequence[Mode]] = {}
    for i in reversed(range(0 if steps[0].modes else 1, len(steps))):
        step, (arm, slide) = steps[i], placed[i]
        felt: Inertia | None
        if step.modes or i in bent.bodies:
            own = bent.felt(i, step.modes, rates[i])
            felt, modes[i] = _bent(step, bodies[i], loads.get(i), rates[i], hung[i], own)
            felt = felt.before(step.turn) if step.turn is not None and base[i] else felt
            felt = felt if beside[i] is None else _joined(beside[i], felt)
        else:
            felt = _own(step, bodies[i], loads.get(i), base[i], rates[i], hung[i], beside[i])
        if i == 0:
            break
        if felt is None:
            across[i] = NO_INERTIA
            continue
        for freedom in reversed(step.spin.freedoms):
            felt = _eliminated(felt, freedom, True, pivots[i])
        felt = felt.at(known[i].spin, NOTHING)
        if step.late:
            for freedom in reversed(slide.freedoms):
                felt = _eliminated(felt, freedom, False, pivots[i])
            felt = felt.at(NOTHING, known[i].sliding)
        if step.turn is not None and not base[i]:
            felt = felt.before(step.turn)
        if not step.late:
            for freedom in reversed(slide.freedoms):
                felt = _eliminated(felt, freedom, False, pivots[i])
        across[i] = felt
        felt = shared(felt.at(NOTHING, known[i].shift), shares_of(step, slide)).moved(arm)
        if step.joins:
            beside[step.parent] = _joined(beside[step.parent], felt)
        elif step.parent or steps[0].modes:
            for turn in reversed(step.lead):
                felt = felt.before(turn)
            hung[step.parent] = _joined(hung[step.parent], felt)
    return Inward(on, pivots, across, modes)


def _joined(a: Inertia | None, b: Inertia) -> Inertia:
    return b if a is None else a.plus(b)


def _bent(
    step: Segment, body: Rigid, load: tuple[Triple, Triple] | None, w: Rates, hung: Inertia | None, own: Inertia
) -> tuple[Inertia, Sequence[Mode]]:
    """What is felt along B of a segment with flexible parts, without its modes; beside one that has some nothing hangs."""
    whole = _own(step, body, load, False, w, _joined(hung, own), None)
    return without_modes(own if whole is None else whole, step.modes)


def _own(
    step: Segment,
    body: Rigid,
    load: tuple[Triple, Triple] | None,
    in_a: bool,
    w: Rates,
    hung: Inertia | None,
    beside: Inertia | None,
) -> Inertia | None:
    """All that a segment carries, along the basis it works in."""
    n, f = (negative(x) for x in load) if load is not None else (NOTHING, NOTHING)
    own: Inertia | None
    if in_a and step.turn is not None and hung is None:
        turned = body.before(step.turn)
        n, f = step.turn.up(n), step.turn.up(f)
        n_w, f_w = turned.bias(w.work, w.square)
        own = None if body.is_nothing and load is None else of_rigid(turned, summed(n, n_w), summed(f, f_w))
    else:
        n_w, f_w = body.bias(w.own, w.square)
        own = None if body.is_nothing and load is None else of_rigid(body, summed(n, n_w), summed(f, f_w))
        if hung is not None:
            own = hung if own is None else own.plus(hung)
        if in_a and step.turn is not None and own is not None:
            own = own.before(step.turn)
    if beside is not None:
        own = beside if own is None else own.plus(beside)
    return own


def unit(axis: Triple) -> int | None:
    """The place of the only component, where that is 1."""
    k = [i for i, x in enumerate(axis) if x is not ZERO]
    return k[0] if len(k) == 1 and axis[k[0]] is ONE else None


def parts(freedom: Freedom, turning: bool) -> tuple[Triple, Triple]:
    """What a freedom has of ω, and of ṙ."""
    return (freedom.axis, freedom.slide) if turning else (NOTHING, freedom.axis)


def _eliminated(felt: Inertia, freedom: Freedom, turning: bool, pivots: list[Pivot]) -> Inertia:
    """What is felt before a freedom."""
    spin, slide = parts(freedom, turning)
    k = unit(freedom.axis) if freedom.slide is NOTHING else None
    if k is None:
        u_n = summed(product(felt.j, spin), product(felt.h, slide))
        u_f = summed(product(transposed(felt.h), spin), product(felt.m, slide))
        d, pressed = add(dot(spin, u_n), dot(slide, u_f)), add(dot(spin, felt.n), dot(slide, felt.f))
    else:  # one of the entries is all that a product with a unit vector has
        u_n, u_f = transposed(felt.j if turning else felt.h)[k], (felt.h if turning else felt.m)[k]
        d, pressed = (u_n[k], felt.n[k]) if turning else (u_f[k], felt.f[k])
    if d is ZERO:
        raise SingularError("Expected every joint speed to move some mass.")
    t_n, t_f = over(u_n, d), over(u_f, d)
    rest = neg(div(pressed, d))
    beside = {b: c.along(spin, slide) for b, c in felt.columns.items()}
    pivots.append(Pivot(freedom, turning, t_n, t_f, rest, d, beside))
    j, h, m = lowered(felt.j, t_n, u_n, True), lowered(felt.h, t_n, u_f, False), lowered(felt.m, t_f, u_f, True)
    n, f = summed(felt.n, times(rest, u_n)), summed(felt.f, times(rest, u_f))
    left = columns_less(felt.columns, beside, (t_n, t_f), d, rest)
    if k is None:
        return Inertia(j, h, m, n, f, left)
    if turning:
        return Inertia(_without(j, k, True), _without(h, k, False), m, _zero(n, k), f, left)
    columns = transposed(h)
    return Inertia(j, transposed(_without(columns, k, False)), _without(m, k, True), n, _zero(f, k), left)


def _without(rows: Cosines, k: int, symmetric: bool) -> Cosines:
    """The rows with zeros in row k, and column k of symmetric ones: they cancel."""
    return as_rows(
        [[ZERO if a == k or (symmetric and b == k) else x for b, x in enumerate(row)] for a, row in enumerate(rows)]
    )


def _zero(v: Triple, k: int) -> Triple:
    return triple(ZERO if i == k else x for i, x in enumerate(v))


def outward(found: Inward, ground: Triple, asked: Iterable[int] = ()) -> Passed:
    """From the base to the tips."""
    on, pivots, felt, modes = found
    wanted = set(asked)
    steps, base, _, placed, known = on
    transmitted: dict[int, tuple[Triple, Triple]] = {}
    rows: list[tuple[Mapping[Expr, Expr], Expr]] = []
    own: list[tuple[Triple, Triple]] = [(NOTHING, ground)]  # along B
    work: list[tuple[Triple, Triple]] = [(NOTHING, ground)]
    values = found_modes(modes.get(0, ()), NOTHING, ground, {})
    for i, step in enumerate(steps):
        if i == 0:
            continue
        alpha, a = work[step.parent] if step.joins else own[step.parent]
        for turn in step.lead:
            alpha, a = turn.down(alpha), turn.down(a)
        a = summed(a, summed(cross3(alpha, placed[i][0]), known[i].shift))
        for b, spin, sliding in shares_of(step, placed[i][1]):
            alpha, a = summed(alpha, times(values[b], spin)), summed(a, times(values[b], sliding))
        if i in wanted:
            transmitted[i] = wrench_at(felt[i], alpha, a, values)
        left = [_knowing(pivot, values) for pivot in reversed(pivots[i])]
        if not step.late:
            while left and not left[0].turning:
                alpha, a = _taken(left.pop(0), alpha, a, rows)
        if step.turn is not None and not base[i]:
            alpha, a = step.turn.down(alpha), step.turn.down(a)
        a, alpha = summed(a, known[i].sliding), summed(alpha, known[i].spin)
        for pivot in left:
            alpha, a = _taken(pivot, alpha, a, rows)
        work.append((alpha, a))
        at_b = (alpha, a)
        if base[i] and step.turn is not None:
            at_b = step.turn.down(alpha), step.turn.down(a)
        own.append(at_b)
        values = found_modes(modes.get(i, ()), *at_b, values)
    rows += [({b: ONE}, x) for b, x in values.items()]
    divided = [p.d for of in pivots for p in reversed(of)] + [mode.d for of in modes.values() for mode in of]
    return Passed(rows, divided, transmitted, own)


def _knowing(pivot: Pivot, values: Mapping[Expr, Expr]) -> Pivot:
    """A pivot with λ of the rates that move segments beyond it."""
    rest = pivot.rest
    for b, x in pivot.beside.items():
        if x is not ZERO:
            rest = sub(rest, div(mul(x, values[b]), pivot.d))
    return pivot._replace(rest=rest)


def _taken(
    pivot: Pivot, alpha: Triple, a: Triple, rows: list[tuple[Mapping[Expr, Expr], Expr]]
) -> tuple[Triple, Triple]:
    """The accelerations with ẇ of a freedom."""
    s = pivot.freedom.axis
    k = unit(s)
    known = alpha if pivot.turning else a
    if k is None or pivot.freedom.slide is not NOTHING:
        value = sub(pivot.rest, add(dot(pivot.t_n, alpha), dot(pivot.t_f, a)))
        after = summed(known, times(value, s))
        a = summed(a, times(value, pivot.freedom.slide))
    else:  # the whole component first, as U/D is 1 there
        n = alpha if not pivot.turning else _zero(alpha, k)
        f = a if pivot.turning else _zero(a, k)
        whole = sub(pivot.rest, add(dot(pivot.t_n, n), dot(pivot.t_f, f)))
        value = sub(whole, known[k])
        after = triple(whole if i == k else x for i, x in enumerate(known))
    rows.append((pivot.freedom.row, value))
    return (after, a) if pivot.turning else (alpha, after)
