# SPDX-License-Identifier: BSD-3-Clause
"""Segments of a tree in motion at given u̇, and what each of them presses on its origin with."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from kane.dynamics.assembly import sum_of
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.articulated import Wrenches, parts
from kane.dynamics.routes.carried import falling, regrouped
from kane.dynamics.routes.equations import holds_reactions
from kane.dynamics.routes.flexible import RIGID
from kane.dynamics.routes.places import Place, Way, way_along
from kane.dynamics.routes.recursive import WAYS, carrying
from kane.expr.build import add, mul
from kane.expr.matrix import dot
from kane.expr.node import ONE, Expr
from kane.kinematics.freedoms import Unsuited
from kane.kinematics.segments import Segment
from kane.kinematics.speeds import Row
from kane.kinematics.travel import travel
from kane.space.rotation import NOTHING, Triple, cross3, product
from kane.space.spatial import Rigid, Turn, Turns, negative, summed, times, triple

Vectors = tuple[Triple, ...]


@dataclass(frozen=True, eq=False)
class Line:
    """The segments, what they carry along the basis of work, what loads press with along B, and λ of the freedoms by number."""

    way: Way
    bodies: Sequence[Rigid]
    loads: Wrenches
    ground: Triple
    places: Sequence[Place]
    lambdas: Sequence[Expr]

    def step(self, i: int) -> Segment:
        """A segment."""
        return self.way.on.steps[i]

    def parent(self, i: int) -> int:
        """The number of the one before."""
        return self.way.on.steps[i].parent

    def own_turn(self, i: int) -> Turn | Turns | None:
        """From A to the basis of work, where these are two."""
        return None if self.way.on.base[i] else self.way.on.steps[i].turn

    def last_turn(self, i: int) -> Turn | Turns | None:
        """From the basis of work to B, where these are two."""
        return self.way.on.steps[i].turn if self.way.on.base[i] else None

    def back(self, i: int) -> list[Turn | Turns]:
        """The turns from A to the basis that the parent works in."""
        step = self.step(i)
        if step.joins:
            return []
        own = self.last_turn(step.parent)
        return [*reversed(step.lead), *([own] if own is not None else [])]

    def arm(self, i: int) -> Triple:
        """The origin from that of the parent, along A."""
        return self.way.on.placed[i][0]

    def velocity(self, i: int) -> Triple:
        """Its velocity from that of the parent's origin, along A."""
        slide, turn = self.way.on.placed[i][1], self.own_turn(i)
        own = turn.up(slide.total) if self.step(i).late and turn is not None else slide.total
        return summed(cross3(self.way.on.rates[i].before, self.arm(i)), own)

    def driven(self, places: Sequence[Place], by: Callable[[Expr], Expr] | None = None) -> tuple[Triple, Triple]:
        """Σ s λ of freedoms, what they add to α and to a; of the derivative of s where that is asked for."""
        alpha = a = NOTHING
        for p in places:
            spin, slide = (triple(map(by, v)) if by else v for v in parts(p.freedom, p.turning))
            alpha = summed(alpha, times(self.lambdas[p.number], spin))
            a = summed(a, times(self.lambdas[p.number], slide))
        return alpha, a


def line_of(derived: Derived, u_dot: Sequence[Expr], route: str) -> Line:
    """The segments of a tree at the u̇ that the `route` finds; Unsuited, with what is in the way, where it is no such tree.

    λ of rows in rates are those of the route.
    """
    if derived.constraints.constraints:
        raise Unsuited("constraints")
    line = line_at(derived, u_dot, balanced=route == "recursive")
    if all(u in derived.speeds for p in line.places for u in p.freedom.row):
        return line
    steps = line.way.on.steps
    found = {id(row): x for row, x in WAYS[route](steps, line.bodies, line.loads, line.ground, (), RIGID).rows}
    return replace(line, lambdas=[found[id(p.freedom.row)] for p in line.places])


def line_at(derived: Derived, u_dot: Sequence[Expr], *, balanced: bool = False) -> Line:
    """The segments of a tree at given u̇, as if nothing closed it; Unsuited, with what is in the way, where it is no such tree."""
    if holds_reactions(derived):
        raise Unsuited("loads that hold reactions")
    carried = carrying(derived)
    steps, loads = carried.segments.steps, carried.loads
    own = regrouped(carried.bodies, steps, balanced=balanced)
    way = way_along(travel(steps))
    places = way.places
    if len(places) != len(derived.speeds):
        raise Unsuited("speeds that are not those of the joints")
    value: dict[Expr, Expr] = dict(zip(derived.speeds, u_dot, strict=True))
    lambdas = [change_of(p.freedom.row, value, derived) for p in places]
    return Line(way, own, loads, falling(derived), places, lambdas)


def change_of(row: Row, value: Mapping[Expr, Expr], derived: Derived) -> Expr:
    """λ of a row in speeds and rates, at u̇ by speed."""
    return sum_of(mul(c, _change(s, value, derived)) for s, c in row.items())


def _change(s: Expr, value: Mapping[Expr, Expr], derived: Derived) -> Expr:
    """u̇ of a speed; q̈ of a rate, d/dt (W u + X)."""
    if s in value:
        return value[s]
    form = derived.kinematical.form({s: ONE})
    changed = sum_of(mul(w, value[u]) for u, w in form.coefficients.items())
    return add(derived.kinematics.drift(form.total()), changed)


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """ω, α, a of the origin: along A at the parent's origin, along A, and along the basis of work."""

    entered: Vectors
    placed: Vectors
    work: Vectors


def motions(line: Line) -> list[Motion]:
    """The motion of each segment."""
    on = line.way.on
    still: Vectors = (NOTHING, NOTHING, line.ground)
    found = [Motion(still, still, still)]
    for i in range(1, len(on.steps)):
        before_arm = entered(line, i, *found[line.parent(i)].work[1:])
        alpha, a = before_arm
        a = summed(a, summed(cross3(alpha, line.arm(i)), on.known[i].shift))
        a = summed(a, line.driven(line.way.outer[i])[1])
        before, turn = on.rates[i].before, line.own_turn(i)
        work = (alpha, a) if turn is None else (turn.down(alpha), turn.down(a))
        spun, slid = line.driven(line.way.inner[i])
        spun = summed(summed(work[0], on.known[i].spin), spun)
        slid = summed(summed(work[1], on.known[i].sliding), slid)
        found.append(Motion((before, *before_arm), (before, alpha, a), (on.rates[i].work, spun, slid)))
    return found


def entered(line: Line, i: int, *vectors: Triple) -> Vectors:
    """Vectors along the basis that the parent works in, along A."""
    for turn in reversed(line.back(i)):
        vectors = tuple(map(turn.down, vectors))
    return vectors


def pressing(line: Line, i: int) -> Callable[..., Vectors]:
    """What a segment alone presses on its origin with, along the basis of work, by its ω, α, a, and ω·ω where that is known."""
    turn, load = line.last_turn(i), line.loads.get(i, (NOTHING, NOTHING))

    def own(w: Triple, alpha: Triple, a: Triple, square: Expr | None = None) -> Vectors:
        body = line.bodies[i] if turn is None else line.bodies[i].before(turn)
        on_it = load if turn is None else (turn.up(load[0]), turn.up(load[1]))
        n, f = body.bias(w, dot(w, w) if square is None else square)
        n = summed(n, summed(product(body.j, alpha), cross3(body.h, a)))
        f = summed(f, summed(cross3(alpha, body.h), times(body.m, a)))
        return summed(n, negative(on_it[0])), summed(f, negative(on_it[1]))

    return own


def passed_on(line: Line, i: int) -> Iterator[Callable[[Triple, Triple], Vectors]]:
    """What is done to a moment and a force on the way to the parent: first from the basis of work to A."""
    turn = line.own_turn(i)
    yield lambda n, f: (n, f) if turn is None else (turn.up(n), turn.up(f))
    if line.parent(i):
        yield lambda n, f: (summed(n, cross3(line.arm(i), f)), f)
        for back in line.back(i):
            yield lambda n, f, back=back: (back.up(n), back.up(f))  # type: ignore[misc]
