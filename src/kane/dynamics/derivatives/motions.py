# SPDX-License-Identifier: BSD-3-Clause
"""Segments of a tree with their motion at known u̇, and how it changes relative to the segment before with one symbol."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from kane.dynamics.derivatives.stages import Stage, Vectors, total
from kane.dynamics.derivatives.wholes import Change, primed
from kane.dynamics.derived import Derived
from kane.dynamics.routes.articulated import Wrenches, parts
from kane.dynamics.routes.carried import falling, regrouped
from kane.dynamics.routes.composite import Place, Way, way_along
from kane.dynamics.routes.embedded import holds_reactions
from kane.dynamics.routes.recursive import WAYS, carrying
from kane.expr.diff import tangent
from kane.expr.matrix import dot
from kane.expr.node import ONE, TWO, ZERO, Expr
from kane.expr.symbols import Symbol
from kane.kinematics.freedoms import Unsuited
from kane.kinematics.segments import Segment
from kane.kinematics.travel import travel
from kane.space.rotation import NOTHING, Triple, cross3, product
from kane.space.spatial import Rigid, Turn, Turns, negative, summed, times, triple

Changes = dict[Symbol, Change]


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
    """The segments of a tree; Unsuited, with what is in the way, where it is none of those.

    λ of rows in speeds follow from u̇, those of rows in rates are found by the `route`.
    """
    if derived.constraints.constraints:
        raise Unsuited("constraints")
    if holds_reactions(derived):
        raise Unsuited("loads that hold reactions")
    carried = carrying(derived)
    steps, bodies, loads = carried.segments.steps, carried.bodies, carried.loads
    own, ground = regrouped(bodies, steps, balanced=route == "recursive"), falling(derived)
    on = travel(steps)
    way = way_along(on)
    places = sorted((p for of in (way.inner, way.outer) for own in of for p in own), key=lambda p: p.number)
    if len(places) != len(derived.speeds):
        raise Unsuited("speeds that are not those of the joints")
    value: dict[Expr, Expr] = dict(zip(derived.speeds, u_dot, strict=True))
    if all(u in value for p in places for u in p.freedom.row):
        lambdas = [dot(list(p.freedom.row.values()), [value[u] for u in p.freedom.row]) for p in places]
    else:
        found = {id(row): x for row, x in WAYS[route](steps, own, loads, ground, ()).rows}
        lambdas = [found[id(p.freedom.row)] for p in places]
    return Line(way, own, loads, ground, places, lambdas)


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
        entered = _entered(line, i, *found[line.parent(i)].work[1:])
        alpha, a = entered
        a = summed(a, summed(cross3(alpha, line.arm(i)), on.known[i].shift))
        a = summed(a, line.driven(line.way.outer[i])[1])
        before, turn = on.rates[i].before, line.own_turn(i)
        work = (alpha, a) if turn is None else (turn.down(alpha), turn.down(a))
        spun, slid = line.driven(line.way.inner[i])
        spun = summed(summed(work[0], on.known[i].spin), spun)
        slid = summed(summed(work[1], on.known[i].sliding), slid)
        found.append(Motion((before, *entered), (before, alpha, a), (on.rates[i].work, spun, slid)))
    return found


def _entered(line: Line, i: int, *vectors: Triple) -> Vectors:
    """Along A."""
    for turn in reversed(line.back(i)):
        vectors = tuple(map(turn.down, vectors))
    return vectors


def changes(line: Line, moving: Sequence[Motion], symbols: Sequence[Symbol]) -> list[Changes]:
    """How the motion of each segment changes with each symbol, that of the one before held."""
    falls = {x: triple(tangent(e, {x: ONE}) for e in line.ground) for x in symbols}
    found: list[Changes] = [{x: Change(NOTHING, NOTHING, v) for x, v in falls.items() if any(e is not ZERO for e in v)}]
    for i in range(1, len(moving)):
        stages = _stages(line, i, moving[line.parent(i)].work, moving[i])
        found.append({})
        for x in symbols:
            change: Vectors | None = None
            for stage, freedoms in zip(stages, ((), line.way.outer[i], line.way.inner[i]), strict=True):
                alpha, a = line.driven(freedoms, lambda e, x=x: tangent(e, {x: ONE}))  # type: ignore[misc]
                own = (NOTHING, alpha, a) if any(e is not ZERO for e in (*alpha, *a)) else None
                change = total([None if change is None else stage.along(change), stage.slope(x), own])
            if change is not None:
                found[i][x] = primed(moving[i].work[0], *change)
    return found


def _stages(line: Line, i: int, before: Vectors, own: Motion) -> list[Stage]:
    """From the motion of the parent to that of a segment, at λ = 0."""
    step, slide, turn = line.step(i), line.way.on.placed[i][1], line.own_turn(i)

    def moved(w: Triple, alpha: Triple, a: Triple) -> Vectors:
        r = line.arm(i)
        a = summed(a, summed(cross3(alpha, r), cross3(w, cross3(w, r))))
        if not step.late:
            a = summed(summed(a, slide.drift), times(TWO, cross3(w, slide.total)))
        return w, alpha, a

    def turned(w: Triple, alpha: Triple, a: Triple) -> Vectors:
        if turn is not None:
            w, alpha, a = map(turn.down, (w, alpha, a))
        if step.late:
            doubled = summed(times(TWO, w), step.spin.total)
            a = summed(summed(a, slide.drift), cross3(doubled, slide.total))
        alpha = summed(alpha, summed(step.spin.drift, cross3(w, step.spin.total)))
        return summed(w, step.spin.total), alpha, a

    def entered(*vectors: Triple) -> Vectors:
        return _entered(line, i, *vectors)

    return [Stage(entered, before), Stage(moved, own.entered), Stage(turned, own.placed)]


def pressing(line: Line, i: int, motion: Motion) -> tuple[Vectors, Stage]:
    """What a segment alone presses on its origin with, along the basis of work; the same by its motion."""
    turn, load = line.last_turn(i), line.loads.get(i, (NOTHING, NOTHING))

    def own(w: Triple, alpha: Triple, a: Triple, square: Expr | None = None) -> Vectors:
        body = line.bodies[i] if turn is None else line.bodies[i].before(turn)
        on_it = load if turn is None else (turn.up(load[0]), turn.up(load[1]))
        n, f = body.bias(w, dot(w, w) if square is None else square)
        n = summed(n, summed(product(body.j, alpha), cross3(body.h, a)))
        f = summed(f, summed(cross3(alpha, body.h), times(body.m, a)))
        return summed(n, negative(on_it[0])), summed(f, negative(on_it[1]))

    w, alpha, a = motion.work
    return own(w, alpha, a, line.way.on.rates[i].square), Stage(own, motion.work)
