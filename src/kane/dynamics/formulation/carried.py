# SPDX-License-Identifier: BSD-3-Clause
"""Rigid-body inertias of the segments of a tree, and their regrouping to base inertial parameters (Khalil & Dombre 2002, sec. 9.4.2).

A body with its mass centre on an axis and inertia diag(j, j, 0) about an origin on the axis has the same effect on the motion whether
it rotates about that axis or not. So the mass, m r*_z and one moment of inertia of a segment that rotates about an axis are moved to
its parent, from the tips to the base; likewise the inertia of a segment that slides, and the mass of one that rotates about a point.
The regrouped parameters are computed once per set of parameters.

Of links that rotate about parallel axes, the component of m r* along the arm is replaced by a mass at the end of the arm, which is
attached to the next link (`balanced`): it enters that link's M by two additions.
"""

from collections.abc import Collection, Mapping, Sequence
from itertools import chain

from kane.dynamics.derivation import Derived, free_fall
from kane.dynamics.forcing import ConstantInertia
from kane.expr.build import add, mul, neg, sub
from kane.expr.evaluation import is_constant_in_time
from kane.expr.forms.collect import collected, quotient
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr, constant_value
from kane.expr.square_system import Contents, content, divider, over_number
from kane.kinematics.freedoms import Unsuited
from kane.kinematics.links import Link
from kane.kinematics.segments import JointStep, Segments
from kane.model.bodies import Part
from kane.space.frame import Point
from kane.space.rotation import NOTHING, Basis, Cosines, Triple, path
from kane.tree.triples import NO_ROWS, Turn, as_rows, mirrored, negative, summed, summed_rows, times, triple
from kane.tree.values import NO_MASS, Rigid


def rigid_bodies(derived: Derived, segments: Segments, links: Sequence[Link]) -> list[Rigid]:
    """The rigid-body inertia of each segment about its origin, along its B."""
    bodies, inertias = [NO_MASS] * len(segments.steps), inertias_of(derived)
    for number, link in zip(segments.ends, links, strict=True):
        if number:
            bodies[number] = bodies[number].plus(rigid_body(inertias, link, segments.steps[number].shift))
    return bodies


Inertias = Mapping[tuple[str, Point], ConstantInertia | None]


def inertias_of(derived: Derived) -> Inertias:
    """The central inertias of the parts of bodies, by part name and mass centre."""
    return {(part.name, part.mass_center): inertia for _, part, inertia in derived.inertias}


def rigid_body(inertias: Inertias, link: Link, shift: Triple = NOTHING) -> Rigid:
    """The rigid-body inertia of a link along its basis, about the point from which its origin lies at `shift`."""
    body = NO_MASS
    for part, arm in link.parts:
        if part.momenta:  # those are in `flexible`
            continue
        own = arm.components(link.basis)
        if not is_constant_in_time((part.mass, *own)):
            raise Unsuited(f"{part.name}, whose mass or mass centre is not constant in it")
        inertia = inertias[part.name, part.mass_center]
        body = body.plus(_rigid(part, summed(own, shift), inertia, link.basis))
    return body


def _rigid(part: Part, r: Triple, inertia: ConstantInertia | None, basis: Basis) -> Rigid:
    rows = NO_ROWS if inertia is None else _along(inertia, basis)
    m, rr = part.mass, dot(r, r)
    own = [[sub(rr if a == b else ZERO, mul(r[a], r[b])) for b in range(3)] for a in range(3)]
    return Rigid(m, times(m, r), mirrored(summed_rows(rows, as_rows([[mul(m, x) for x in row] for row in own]))))


def _along(inertia: ConstantInertia, basis: Basis) -> Cosines:
    """The central inertia along another basis, in which it must be constant. Unsuited if it is not."""
    up, down = path(inertia.frame, basis)
    rows = inertia.rows
    for f in up:
        rows = Turn(f).up_symmetric(rows)
    for f in down:
        rows = Turn(f, inverse=True).up_symmetric(rows)
    if not is_constant_in_time(x for row in rows for x in row):
        raise Unsuited("an inertia that is not constant in its body")
    return rows


def regrouped(
    bodies: Sequence[Rigid], steps: Sequence[JointStep], balanced: bool, crossed: Collection[int] = ()
) -> list[Rigid]:
    """The bodies regrouped to the parents; `balanced` with masses moved to the next of parallel axes.

    Nothing is moved across the joints of the segments `crossed`, whose transmitted wrenches are asked for.
    """
    own = list(bodies)
    flat = {} if crossed else _flat(steps)
    for i, axis in flat.items():
        own[i] = _about_axis(own[i], axis)
    tips = {i: tip for i, tip in _tips(steps).items() if tip not in crossed} if balanced else {}
    at_tip: dict[int, Expr] = {}
    for i in reversed(range(1, len(steps))):
        step, body = steps[i], own[i]
        if i in tips:
            tip = tips[i]
            body, mass = _balanced(step, body, at_tip.get(i, ZERO), steps[tip].arm, flat.get(i))
            own[tip] = own[tip].plus(Rigid(mass, NOTHING, NO_ROWS))
        kept, moved = (body, NO_MASS) if i in crossed else _shared(step, body)
        own[i] = kept
        if moved.is_nothing or step.parent == 0:  # inertia of the ground has no effect
            continue
        if tips.get(step.parent) == i and moved._replace(m=ZERO).is_nothing:
            at_tip[step.parent] = moved.m
            continue
        moved = moved.moved(step.arm)
        for turn in reversed(step.lead):
            moved = moved.turned(turn)
        own[step.parent] = own[step.parent].plus(_about_axis(moved, flat[i]) if i in flat else moved)
    return own


def _flat(steps: Sequence[JointStep]) -> dict[int, int]:
    """The axis of each segment in planar motion, reached from the ground by slides and rotations about parallel axes alone."""
    result: dict[int, int] = {}
    for i, step in enumerate(steps):
        axis = None if step.turn is None or step.modes else step.turn.axis
        if i and axis is not None and (not step.parent or (step.joins and step.parent in result)):
            result[i] = axis
    return result


def _about_axis(body: Rigid, axis: int) -> Rigid:
    """A body with the entries that matter for rotations about one axis; the others are zero."""
    rows = [[ZERO] * 3 for _ in range(3)]
    rows[axis][axis] = body.j[axis][axis]
    return Rigid(body.m, triple([ZERO if k == axis else x for k, x in enumerate(body.h)]), as_rows(rows))


def _tips(steps: Sequence[JointStep]) -> dict[int, int]:
    """The first segment that rotates in each segment about a parallel axis, without slide."""
    result: dict[int, int] = {}
    for i, step in enumerate(steps):
        if step.joins and not step.slide.freedoms and is_constant_in_time(step.arm):
            result.setdefault(step.parent, i)
    return result


def _balanced(step: JointStep, body: Rigid, held: Expr, arm: Triple, axis: int | None) -> tuple[Rigid, Expr]:
    """Replaces the component of h along an arm by a mass at the arm's end: the body without it, and that mass.

    The mass `held` at the end already is added to that mass, or to the body if h has no such component. With an `axis`, only the
    moment of inertia about it is kept up to date.
    """
    along = [k for k in range(3) if arm[k] is not ZERO]
    mass = _mass_at(body.h[along[0]], arm[along[0]]) if len(along) == 1 and not any(step.slide.freedoms) else None
    if mass is None:
        return body.plus(Rigid(held, NOTHING, NO_ROWS).moved(arm)) if held is not ZERO else body, ZERO
    own = along[0]
    less = mul(neg(mass), dot(arm, arm))
    counted = (0, 1, 2) if axis is None else (axis,)
    j = [
        [add(x, less) if a == b != own and a in counted else x for b, x in enumerate(row)]
        for a, row in enumerate(body.j)
    ]
    h = triple([ZERO if k == own else x for k, x in enumerate(body.h)])
    short = {x: collected(x) for x in dict.fromkeys(chain.from_iterable(j))}
    kept = Rigid(collected(sub(body.m, mass)), h, as_rows([[short[x] for x in row] for row in j]))
    return kept, mass if held is ZERO else collected(add(held, mass))


def _mass_at(h: Expr, r: Expr) -> Expr | None:
    """h / r collected, if r is a number times parameters that are factors of h; else, or if h is zero, None."""
    result = quotient(h, r) if h is not ZERO else None
    if result is None:
        result = shares(h, r)
        return None if result is None else collected(result)
    return result


def shares(h: Expr, r: Expr) -> Expr | None:
    """h / r if r is a number times parameters that are factors of h; else, or if h is zero, None."""
    if h is ZERO or r is ZERO:
        return None
    memo: Contents = {}
    by = content([r], memo)
    divided = divider(memo)
    number = divided(r, by)
    held = content([h], memo)
    if constant_value(number) is None or any(held.get(p, 0) < k for p, k in by.items()):
        return None
    return over_number(divided(h, by), number)


def _shared(step: JointStep, body: Rigid) -> tuple[Rigid, Rigid]:
    """The parts of a body that its segment keeps and that can be moved to the parent, about the origin, along A."""
    still = not step.slide.freedoms and all(x is ZERO for x in step.slide.total)
    turns = any(x is not ZERO for x in step.spin.total)
    if not turns and step.turn is not None:
        return body, NO_MASS
    if not turns:
        return (NO_MASS, body) if still else (body._replace(j=NO_ROWS), Rigid(ZERO, NOTHING, body.j))
    if not still:
        return body, NO_MASS
    k = None if step.turn is None else step.turn.axis
    if k is None:
        return body._replace(m=ZERO), Rigid(body.m, NOTHING, NO_ROWS)
    i, j = (k + 1) % 3, (k + 2) % 3
    common = body.j[j][j]
    rows = [[ZERO] * 3 for _ in range(3)]
    rows[i][i] = rows[j][j] = common
    taken = [[sub(x, rows[a][b]) for b, x in enumerate(row)] for a, row in enumerate(body.j)]
    h, along = list(body.h), [ZERO, ZERO, ZERO]
    h[k], along[k] = ZERO, body.h[k]
    kept = Rigid(ZERO, (h[0], h[1], h[2]), as_rows(taken))
    return kept, Rigid(body.m, (along[0], along[1], along[2]), as_rows(rows))


def falling(derived: Derived) -> Triple:
    """−g along the inertial frame: the acceleration of the ground that has the effect of gravity."""
    return negative(free_fall(derived.system).components(derived.system.inertial))
