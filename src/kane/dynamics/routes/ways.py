# SPDX-License-Identifier: BSD-3-Clause
"""The ways to u̇ and the reactions of which the shortest is taken.

Under constraints there stand beside the classical route motions in the independent speeds (`embedded`), along the tree or through the
particles that constraints hold, by the speeds as declared or with rates of constraints in the places of dependent ones (`contacts`).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.touches import Touch, contacts, touches
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.centre import by_mass_centre
from kane.dynamics.routes.classical import unguarded_classical
from kane.dynamics.routes.contacts import by_definitions, twins
from kane.dynamics.routes.dependent import dependent_accelerations
from kane.dynamics.routes.divisors import Poles, divisors
from kane.dynamics.routes.embedded import Motions, embedded, embedded_motions
from kane.dynamics.routes.pivoted import about_points_at_rest
from kane.dynamics.routes.power import homogeneous, power
from kane.dynamics.routes.rates import ConstraintRates
from kane.dynamics.routes.reactions import reactions
from kane.dynamics.routes.short_forms import LONG, short_forms
from kane.dynamics.routes.squares import squares
from kane.dynamics.solved import Solved
from kane.expr.count import Prices, price
from kane.expr.node import Expr
from kane.kinematics.motion import Contact
from kane.space.point import Point

Exprs = tuple[Expr, ...]
_NEAR = 1.05
"""Share of the fewest operations up to which ways are compared by what they take in the end."""


class Found(NamedTuple):
    """A solution in the speeds of its own `derived`, the motions that it is made with, and which of these speeds vanish."""

    solution: Solved
    moving: Motions | None
    w: ConstraintRates | None = None


def ways(derived: Derived, e: Embedding, coupled: bool, large: bool) -> Iterator[Found]:
    """The solutions for the independent speeds; of large systems those by rates of constraints alone, where there are any."""
    held = touches(derived.constraints.constraints, e.partition.rows, derived.kinematics)
    tried = False
    for found in by_rates(derived, e, held, coupled, large):
        tried = True
        yield from found
    if not coupled and not (large and tried):
        yield from by_motions(derived, e, held, large)


def by_rates(
    derived: Derived, e: Embedding, held: Sequence[Touch], coupled: bool, large: bool
) -> Iterator[list[Found]]:
    """Solutions with rates of constraints as speeds, for each choice of these; of large systems those by motions in u_I."""
    for twin, w in twins(derived, e.partition, held):
        found = []
        if coupled or not large:
            solution = w.solution(unguarded_classical(twin, e.partition))
            found.append(Found(solution, None if coupled else all_speeds(twin), w))
        if not coupled:
            own = embedding(twin.constraints, e.partition)
            own = own.guarded() if large else own  # of what is long next to nothing cancels, and nothing is built twice
            particles = {p: replace(c, directions={}) for p, c in twin.kinematics.contacts.items()}
            moving = embedded_motions(twin, own, particles)
            for carried in (False,) if large else (False, True):
                found.append(Found(w.solution(embedded(twin, own, moving, carried=carried)), moving, w))
            if not large and homogeneous(twin, own):
                found += [Found(w.solution(f(twin, own)), all_speeds(twin), w) for f in (power, squares)]
        yield found


def by_motions(derived: Derived, e: Embedding, held: Sequence[Touch], large: bool) -> Iterator[Found]:
    """Solutions by motions in the independent speeds as declared: along the tree, and through the particles that constraints hold."""
    yield _embedded(derived, e, {})
    if not large and homogeneous(derived, e):
        yield Found(power(derived, e), all_speeds(derived))
        if any(derived.constraints.constraints[r].kind == "motion" for r in e.partition.rows):
            yield Found(squares(derived, e), all_speeds(derived))
    through = contacts(held, {}, derived.kinematics)
    if through:
        yield _embedded(derived, e, through)
    if not large:
        yield from _pivoted(derived, e, through)


def by_centre(derived: Derived, usual: Solved, coupled: bool) -> Iterator[Found]:
    """The solution by velocities of the mass centre, where one body is free to translate."""
    found = by_mass_centre(derived)
    if found is not None:
        twin, solution = found
        if Poles(lambda: usual).fewer(twin, (*solution.accelerations, *solution.reactions)):
            yield Found(solution, None if coupled else all_speeds(derived))


def _embedded(derived: Derived, e: Embedding, particles: Mapping[Point, Contact]) -> Found:
    moving = embedded_motions(derived, e, particles)
    return Found(embedded(derived, e, moving), moving)


def _pivoted(derived: Derived, e: Embedding, particles: Mapping[Point, Contact]) -> Iterator[Found]:
    moving = embedded_motions(derived, e, particles)
    bodies = about_points_at_rest(moving.bodies, moving.kinematics)
    if bodies is not None:
        yield Found(embedded(derived, e, moving, bodies), moving)
    yield Found(embedded(derived, e, moving, bodies, carried=True), moving)


def all_speeds(derived: Derived) -> Motions:
    """The motions by all speeds."""
    return Motions(derived.speeds, derived.kinematics, derived.bodies)


def dependent_ways(derived: Derived, e: Embedding, way: Found, large: bool) -> Iterator[Exprs]:
    """u̇ with those of the dependent speeds, which follow from those of the independent ones."""
    solution, w = way.solution, way.w
    own = [solution.accelerations[i] for i in e.independent]
    if w is None or not large or way.moving is None:
        yield e.every(own)
    if w is not None:
        yield by_definitions(derived, solution.derived, solution.accelerations, w)
    if not large:
        yield from dependent_accelerations(derived, e, own)


def with_reactions(
    way: Found, u_dot: Exprs, derived: Derived, e: Embedding | None, differentiated: bool = False
) -> Solved:
    """The solution with this u̇, and the reactions as they are shortest beside it; `differentiated` ones are others."""
    s, w = way.solution, way.w
    values: dict[Expr, Expr] = dict(zip(s.derived.speeds, u_dot if w is None else s.accelerations, strict=True))
    ways = [s.reactions] if len(s.reactions) == len(s.derived.reactions) else []
    if s.derived.reactions and way.moving is not None:
        held = _as_it_is if w is None else w.held
        ways += reactions(s.derived, s.embedding, way.moving, values, s.reaction_matrix, held, differentiated)
    rates = derived.rates
    best = _cheapest(ways, (*rates, *u_dot), derived, e if differentiated else None)
    whole = replace(s, accelerations=u_dot, reactions=best)
    if e is None or s.embedding is None:
        return whole
    known = e.watching({**s.embedding.guards_in_use, **e.guards_in_use})
    if w is None:
        return replace(whole, derived=derived, embedding=known)
    own = tuple(map(w.held, s.derived.rates))
    shorter = _is_shorter(own, rates, (*u_dot, *best)) and divisors(own) <= divisors(rates)
    return replace(
        whole,
        route="contacts",
        derived=derived,
        embedding=known,
        shorter_rates=own if shorter else None,
    )


def _cheapest(ways: Sequence[Exprs], beside: Exprs, derived: Derived, e: Embedding | None) -> Exprs:
    """The way that takes the fewest operations; of those that take few, by what they take in the end, where `e` is given."""
    if len(ways) == 1:
        return ways[0]
    prices = list(map(Prices(beside), ways))
    least = min(prices)
    # of equal ones the last, which is collected
    near = [x for p, x in zip(prices, ways, strict=True) if p <= least * _NEAR][::-1]
    if e is None or len(near) == 1 or least > LONG:
        return next(x for p, x in zip(reversed(prices), reversed(ways), strict=True) if p == least)
    distinct = {tuple(map(id, x)): x for x in near}
    return min(distinct.values(), key=lambda x: price(short_forms((*x, *beside), derived, e)))


def _is_shorter(own: Exprs, usual: Exprs, beside: Exprs) -> bool:
    """Whether expressions take fewer operations than the usual ones, both beside others."""
    if all(x is y for x, y in zip(own, usual, strict=True)):
        return False
    price = Prices(beside)
    return price(own) < price(usual)


def _as_it_is(e: Expr) -> Expr:
    return e
