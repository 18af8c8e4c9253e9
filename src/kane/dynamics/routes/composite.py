# SPDX-License-Identifier: BSD-3-Clause
"""Joint accelerations by composite bodies: M of the joint speeds, factored along the branches, and forces at no ẇ.

What hangs on a segment moves as one body at the acceleration of one freedom: J s of the composite body is its wrench, and
M_rs = s·(I s_r) along the way to the ground (Featherstone 2008, ch. 6). M is eliminated from the tips, without fill. What is left at
no ẇ is that of composite bodies, too (`gyroscopic`). Shorter than articulated inertias along short branches.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from kane.dynamics.routes.articulated import Passed, Wrenches, parts
from kane.dynamics.routes.block_solution import sparse_order
from kane.dynamics.routes.flexible import RIGID, Bent
from kane.dynamics.routes.gyroscopic import forces_left
from kane.dynamics.routes.places import Body, Composite, Place, Way, Wrench, composites, way_along, working
from kane.dynamics.routes.trial import are_slender, forces_at_trial
from kane.expr.build import add, mul
from kane.expr.node import ONE, TWO, ZERO, Expr
from kane.expr.solve import LDL, finish, forward, ldl
from kane.kinematics.freedoms import Freedom
from kane.kinematics.segments import Segment
from kane.kinematics.travel import Travel, travel
from kane.space.mass_moments import Moments, moments
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.spatial import Inertia, Rigid, times, to_rigid


def accelerations(
    steps: Sequence[Segment],
    bodies: Sequence[Rigid],
    loads: Wrenches,
    ground: Triple,
    asked: Iterable[int] = (),
    bent: Bent = RIGID,
    *,
    body_by_body: bool | None = None,
) -> Passed:
    """ẇ of all freedoms; a SingularError where a pivot is zero whatever the state. What is transmitted is not found on this way."""
    found = factored(steps, bodies, loads, ground, bent, body_by_body=body_by_body)
    return Passed(found.rows(found.values(found.eliminated)), list(found.factors.pivots), {})


class Factored(NamedTuple):
    """L D Lᵀ of M in an order of the freedoms, trial accelerations by number, and the forces left there eliminated, L⁻¹ f."""

    way: Way
    places: Sequence[Place]
    order: Sequence[int]
    factors: LDL
    trial: Sequence[Expr]
    eliminated: Sequence[Expr]

    def values(self, eliminated: Sequence[Expr]) -> list[Expr]:
        """ẇ by number."""
        value = dict(zip(self.order, finish(self.factors, eliminated), strict=True))
        return [add(x, value[k]) for k, x in enumerate(self.trial)]

    def rows(self, values: Sequence[Expr]) -> list[tuple[Mapping[Expr, Expr], Expr]]:
        """The rows of the joint speeds with their ẇ, by number."""
        modes: list[Mapping[Expr, Expr]] = [{b: ONE} for b in self.way.modes]
        return list(zip([*(p.freedom.row for p in self.places), *modes], values, strict=True))


def factored(
    steps: Sequence[Segment],
    bodies: Sequence[Rigid],
    loads: Wrenches,
    ground: Triple,
    bent: Bent = RIGID,
    *,
    body_by_body: bool | None = None,
) -> Factored:
    """M of the freedoms, eliminated; a SingularError where a pivot is zero whatever the state."""
    on = travel(steps)
    way = way_along(on)
    places = way.places
    bending = bending_along(on, bent)
    carried = [working(on, i, body) for i, body in enumerate(bodies)]
    count = len(places) + len(way.modes)
    felt = {i: to_rigid(own) for i, own in bending.items()}
    if are_slender(bodies) if body_by_body is None else body_by_body:
        trial, right = forces_at_trial(way, carried, loads, ground, count, bending)
        mass = freedom_mass(way, composites(way, with_more(carried, felt)), count, bending)
    else:
        spread = [moments(body) for body in carried]
        whole = composites(way, spread)
        trial, right = [ZERO] * count, forces_left(way, whole, loads, ground, count, bending)
        if bending:
            whole = composites(way, with_more(spread, {i: moments(body) for i, body in felt.items()}))
        mass = freedom_mass(way, whole, count, bending)
    order = sparse_order(mass)
    factors = ldl([[mass[i][j] for j in order] for i in order])
    return Factored(way, places, order, factors, trial, forward(factors.lower, [right[i] for i in order]))


def bending_along(on: Travel, bent: Bent) -> dict[int, Inertia]:
    """What segments feel of their flexible parts alone, along the basis they work in."""
    found = {}
    for i, (step, w) in enumerate(zip(on.steps, on.rates, strict=True)):
        if step.modes or i in bent.bodies:
            own = bent.felt(i, step.modes, w)
            found[i] = own.before(step.turn) if step.turn is not None and on.base[i] else own
    return found


def with_more(bodies: Sequence[Body], more: Mapping[int, Body]) -> list[Body]:
    """The bodies with what some of them carry besides."""
    return [body.plus(more[i]) if i in more else body for i, body in enumerate(bodies)]


def freedom_mass(
    way: Way,
    whole: Sequence[Composite[Rigid]] | Sequence[Composite[Moments]],
    count: int,
    bending: Mapping[int, Inertia] = MappingProxyType({}),
) -> list[list[Expr]]:
    """M of the freedoms, of the composite bodies of all segments."""
    rows = [[ZERO] * count for _ in range(count)]
    for number, felt in bending.items():
        for b, column in felt.columns.items():
            for other, x in column.row.items():
                r, k = way.modes[b], way.modes[other]
                rows[r][k] = add(rows[r][k], x)
            mode = Place(Freedom(NOTHING, {b: ONE}), way.modes[b], True)
            _entries(rows, mode, (), way.up(number, Wrench(column.n, column.f)))
    for i in range(len(whole) - 1, 0, -1):
        body = whole[i]
        for place in way.inner[i]:
            _entries(rows, place, way.inner[i], way.up(i, _moved(body.work, place)))
        outer = (*way.outer[i], *way.shared[i])
        for place in outer:
            _entries(rows, place, outer, way.from_outer(i, _moved(body.along_a, place)))
    return rows


def _entries(
    rows: list[list[Expr]], place: Place, beside: Sequence[Place], found: Iterator[tuple[Place, Expr]]
) -> None:
    """What the wrench at one place adds to M; of the places `beside` it each pair comes twice."""
    before = {id(p) for p in beside[: [p is place for p in beside].index(True)]} if beside else ()
    for other, value in found:
        if id(other) in before:
            continue
        r, s = place.number, other.number
        if r == s and place is not other:
            value = mul(TWO, value)
        rows[r][s] = rows[s][r] = add(rows[r][s], value)


def _moved(body: Rigid | Moments, place: Place) -> Wrench:
    """The wrench of a body at the acceleration 1 of a freedom."""
    spin, slide = parts(place.freedom, place.turning)
    turned = Wrench(body.turned_by(spin), cross3(spin, body.h))
    return turned.plus(Wrench(cross3(body.h, slide), times(body.m, slide)))
