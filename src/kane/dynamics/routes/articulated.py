# SPDX-License-Identifier: BSD-3-Clause
"""Joint accelerations by articulated inertias: from the tips to the base and back, in a number of operations that grows as the tree.

What hangs on a segment presses on it with n = J α + H a + …, f = Hᵀ α + M a + …. A joint speed w along s leaves no reaction along s:

    U = I s,   D = s·U,   ẇ = (−s·p − U·a)/D,      I − U Uᵀ/D,   p − U (s·p)/D

is what the segment before feels (Kane's equation of w, solved for ẇ; Featherstone 2008, ch. 7). Accelerations are those of points,
gravity is an acceleration of the ground, and no velocities but angular ones are needed.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

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
    """U/D, (−s·p)/D, D of a freedom, and s; whether it is a turn."""

    freedom: Freedom
    turning: bool
    t_n: Triple
    t_f: Triple
    rest: Expr
    d: Expr


class Passed(NamedTuple):
    """The rows of the joint speeds with their ẇ, the pivots, and what is transmitted to segments, where that is asked for."""

    rows: list[tuple[Mapping[Expr, Expr], Expr]]
    pivots: list[Expr]
    transmitted: Mapping[int, tuple[Triple, Triple]]


def accelerations(
    steps: Sequence[Segment], bodies: Sequence[Rigid], loads: Wrenches, ground: Triple, asked: Iterable[int] = ()
) -> Passed:
    """ẇ of all freedoms, and what is transmitted to segments that are asked for, their moment about their origin, along A.

    A SingularError where a pivot is zero whatever the state.
    """
    on = travel(steps)
    pivots, felt = _inward(on, bodies, loads)
    return _outward(on, pivots, ground, {i: felt[i] for i in asked})


def _inward(on: Travel, bodies: Sequence[Rigid], loads: Wrenches) -> tuple[list[list[Pivot]], dict[int, Inertia]]:
    """From the tips to the base, with what is felt of each segment before it is moved to the origin of the one before."""
    steps, base, rates, placed, known = on
    hung: list[Inertia | None] = [None] * len(steps)  # along B
    beside: list[Inertia | None] = [None] * len(steps)  # along the basis of work, where that is A
    pivots: list[list[Pivot]] = [[] for _ in steps]
    across: dict[int, Inertia] = {}
    for i in reversed(range(1, len(steps))):
        step, (arm, slide) = steps[i], placed[i]
        felt = _own(step, bodies[i], loads.get(i), base[i], rates[i], hung[i], beside[i])
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
        felt = felt.at(NOTHING, known[i].shift).moved(arm)
        if step.joins:
            beside[step.parent] = _joined(beside[step.parent], felt)
        elif step.parent:
            for turn in reversed(step.lead):
                felt = felt.before(turn)
            hung[step.parent] = _joined(hung[step.parent], felt)
    return pivots, across


def _joined(a: Inertia | None, b: Inertia) -> Inertia:
    return b if a is None else a.plus(b)


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
    s = freedom.axis
    spin, slide = parts(freedom, turning)
    u_n = summed(product(felt.j, spin), product(felt.h, slide))
    u_f = summed(product(transposed(felt.h), spin), product(felt.m, slide))
    d, pressed = add(dot(spin, u_n), dot(slide, u_f)), add(dot(spin, felt.n), dot(slide, felt.f))
    if d is ZERO:
        raise SingularError("Expected every joint speed to move some mass.")
    t_n, t_f = (triple(div(x, d) for x in u) for u in (u_n, u_f))
    rest = neg(div(pressed, d))
    pivots.append(Pivot(freedom, turning, t_n, t_f, rest, d))
    j, h, m = _less(felt.j, t_n, u_n, True), _less(felt.h, t_n, u_f, False), _less(felt.m, t_f, u_f, True)
    n, f = summed(felt.n, times(rest, u_n)), summed(felt.f, times(rest, u_f))
    k = unit(s)
    if k is None or freedom.slide is not NOTHING:
        return Inertia(j, h, m, n, f)
    if turning:
        return Inertia(_without(j, k, True), _without(h, k, False), m, _zero(n, k), f)
    columns = transposed(h)
    return Inertia(j, transposed(_without(columns, k, False)), _without(m, k, True), n, _zero(f, k))


def _less(rows: Cosines, t: Triple, u: Triple, symmetric: bool) -> Cosines:
    """A − t uᵀ."""
    out = [list(row) for row in rows]
    for a in range(3):
        for b in range(a if symmetric else 0, 3):
            x = sub(rows[a][b], mul(t[a], u[b]))
            out[a][b] = x
            if symmetric:
                out[b][a] = x
    return as_rows(out)


def _without(rows: Cosines, k: int, symmetric: bool) -> Cosines:
    """The rows with zeros in row k, and column k of symmetric ones: they cancel."""
    return as_rows(
        [[ZERO if a == k or (symmetric and b == k) else x for b, x in enumerate(row)] for a, row in enumerate(rows)]
    )


def _zero(v: Triple, k: int) -> Triple:
    return triple(ZERO if i == k else x for i, x in enumerate(v))


def _outward(on: Travel, pivots: Sequence[list[Pivot]], ground: Triple, asked: Mapping[int, Inertia]) -> Passed:
    """From the base to the tips."""
    steps, base, _, placed, known = on
    transmitted: dict[int, tuple[Triple, Triple]] = {}
    rows: list[tuple[Mapping[Expr, Expr], Expr]] = []
    own: list[tuple[Triple, Triple]] = [(NOTHING, ground)]  # along B
    work: list[tuple[Triple, Triple]] = [(NOTHING, ground)]
    for i, step in enumerate(steps):
        if i == 0:
            continue
        alpha, a = work[step.parent] if step.joins else own[step.parent]
        for turn in step.lead:
            alpha, a = turn.down(alpha), turn.down(a)
        a = summed(a, summed(cross3(alpha, placed[i][0]), known[i].shift))
        if i in asked:
            at = asked[i].at(alpha, a)
            transmitted[i] = at.n, at.f
        left = list(reversed(pivots[i]))
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
    return Passed(rows, [p.d for of in pivots for p in reversed(of)], transmitted)


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
