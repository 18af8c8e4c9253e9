# SPDX-License-Identifier: BSD-3-Clause
"""The route that takes the fewest operations.

Under constraints there stand beside the classical route motions in the independent speeds (`embedded`), along the tree or through the
particles that constraints hold, by the speeds as declared or with rates of constraints in the places of dependent ones (`contacts`).
Each is taken where it is shorter and divides by nothing of W by which the classical route does not.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar

from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.constraints.touches import contacts, touches
from kane.dynamics.derived import Derived
from kane.dynamics.routes.absolute import absolute
from kane.dynamics.routes.centre import by_mass_centre
from kane.dynamics.routes.classical import all_accelerations, unguarded_classical
from kane.dynamics.routes.contacts import by_definitions, twins
from kane.dynamics.routes.dependent import dependent_accelerations
from kane.dynamics.routes.embedded import Motions, embedded, holds_reactions, motions
from kane.dynamics.routes.power import homogeneous, power
from kane.dynamics.routes.rates import ConstraintRates
from kane.dynamics.routes.reactions import LARGE, reactions
from kane.dynamics.solved import Solved
from kane.errors import KaneError
from kane.expr.build import NODE_BUILDERS
from kane.expr.count import price
from kane.expr.evaluate import is_constant_in_time
from kane.expr.node import Expr, postorder
from kane.expr.ops import OPS
from kane.expr.regular import denominators, factors
from kane.kinematics.motion import Contact
from kane.space.point import Point

T = TypeVar("T")
Exprs = tuple[Expr, ...]

_FEW = 2
"""Of the ways so far those that are followed."""


class Found(NamedTuple):
    """A solution in the speeds of its own `derived`, the motions that it is made with, and which of these speeds vanish."""

    solution: Solved
    moving: Motions | None
    w: ConstraintRates | None = None


def shortest(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions by the route with the fewest operations, by absolute rates where links turn about parallel axes."""
    other = absolute(derived, partition)
    if other is not None:
        try:
            return other.declared(_shortest(other.derived, partition), derived, partition).guarded()
        except KaneError:  # what is wrong is said of the declared speeds
            pass
    return _shortest(derived, partition).guarded()


def _shortest(derived: Derived, partition: Partition | None) -> Solved:
    usual = unguarded_classical(derived, partition)
    coupled = holds_reactions(derived)
    way = Found(usual, None if coupled else all_speeds(derived))
    e = usual.embedding
    if e is None:
        free = [way, *by_centre(derived, usual, coupled)]
        return min((with_reactions(w, w.solution.accelerations, derived, None) for w in free), key=_cost)
    large = price((*derived.rates, *usual.accelerations, *usual.reactions)) > LARGE
    poles = _Poles(usual)
    best = _cheapest(
        [way, *ways(derived, e, coupled, large)],
        lambda w: (*derived.rates, *(w.solution.accelerations[i] for i in e.independent)),
    )
    found = _cheapest(
        [(w, x) for w in best for x in dependent_ways(derived, e, w, large) if poles.fewer(w.solution.derived, x)],
        lambda pair: (*derived.rates, *pair[1]),
    )
    whole = [with_reactions(w, u_dot, derived, e) for w, u_dot in found]
    if not any(w is way for w, _ in found):
        whole.append(with_reactions(way, usual.accelerations, derived, e))
    return min(whole, key=_cost)


def _cheapest(ways: Iterable[T], exprs: Callable[[T], Iterable[Expr]]) -> list[T]:
    """The few ways that take the fewest operations, each with what it needs."""
    return sorted(ways, key=lambda w: price(exprs(w)))[:_FEW]


def ways(derived: Derived, e: Embedding, coupled: bool, large: bool) -> Iterator[Found]:
    """The solutions for the independent speeds; of large systems those by rates of constraints alone, where there are any."""
    held = touches(derived.constraints.constraints, e.partition.rows, derived.kinematics)
    tried = False
    for twin, w in twins(derived, e.partition, held):
        tried = True
        if coupled or not large:
            solution = unguarded_classical(twin, e.partition).mapped(w.held)
            yield Found(solution, None if coupled else all_speeds(twin), w)
        if not coupled:
            own = embedding(twin.constraints, e.partition)
            particles = {p: replace(c, directions={}) for p, c in twin.kinematics.contacts.items()}
            yield _embedded(twin, own, particles, w)
            if not large and homogeneous(twin, own):
                yield Found(power(twin, own).mapped(w.held), all_speeds(twin), w)
    if coupled or (large and tried):
        return
    yield _embedded(derived, e, {})
    if not large and homogeneous(derived, e):
        yield Found(power(derived, e), all_speeds(derived))
    through = contacts(held, {}, derived.kinematics)
    if through:
        yield _embedded(derived, e, through)


def by_centre(derived: Derived, usual: Solved, coupled: bool) -> Iterator[Found]:
    """The solution by velocities of the mass centre, where one body is free to translate."""
    found = by_mass_centre(derived)
    if found is not None:
        twin, solution = found
        if _Poles(usual).fewer(twin, (*solution.accelerations, *solution.reactions)):
            yield Found(solution, None if coupled else all_speeds(derived))


def _embedded(
    derived: Derived, e: Embedding, particles: Mapping[Point, Contact], w: ConstraintRates | None = None
) -> Found:
    moving = motions(derived, e, particles)
    solution = embedded(derived, e, moving)
    return Found(solution if w is None else solution.mapped(w.held), moving, w)


def all_speeds(derived: Derived) -> Motions:
    """The motions by all speeds."""
    return Motions(derived.speeds, derived.kinematics, derived.bodies)


def dependent_ways(derived: Derived, e: Embedding, way: Found, large: bool) -> Iterator[Exprs]:
    """u̇ with those of the dependent speeds, which follow from those of the independent ones."""
    solution, w = way.solution, way.w
    own = [solution.accelerations[i] for i in e.independent]
    yield all_accelerations(e, own)
    if w is not None:
        yield by_definitions(derived, solution.derived, solution.accelerations, w)
    if not large:
        yield from dependent_accelerations(derived, e, own)


def with_reactions(way: Found, u_dot: Exprs, derived: Derived, e: Embedding | None) -> Solved:
    """The solution with this u̇, and the reactions as they are shortest beside it."""
    s, w = way.solution, way.w
    values: dict[Expr, Expr] = dict(zip(s.derived.speeds, u_dot if w is None else s.accelerations, strict=True))
    ways = [s.reactions] if len(s.reactions) == len(s.derived.reactions) else []
    if s.derived.reactions and way.moving is not None:
        held = _as_it_is if w is None else w.held
        ways += reactions(s.derived, s.embedding, way.moving, values, s.reaction_matrix, held)
    rates = derived.rates
    best = min(ways, key=lambda r: price((*rates, *u_dot, *r)))
    whole = replace(s, accelerations=u_dot, reactions=best)
    if e is None or s.embedding is None:
        return whole
    guards = {**s.embedding.guards, **e.guards}
    if w is None:
        return replace(whole, derived=derived, embedding=replace(e, guards=guards))
    own = tuple(map(w.held, s.derived.rates))
    shorter = price((*own, *u_dot, *best)) < price((*rates, *u_dot, *best)) and _divisors(own) <= _divisors(rates)
    return replace(
        whole,
        route="contacts",
        derived=derived,
        embedding=replace(e, guards=guards),
        shorter_rates=own if shorter else None,
    )


def _as_it_is(e: Expr) -> Expr:
    return e


def _cost(s: Solved) -> int:
    return price((*(s.shorter_rates or s.derived.rates), *s.accelerations, *s.reactions))


class _Poles:
    """What W is divided by, and the usual solution is not."""

    def __init__(self, usual: Solved) -> None:
        self.usual = usual
        self.allowed: set[Expr] | None = None

    def fewer(self, derived: Derived, found: Sequence[Expr]) -> bool:
        """Whether what was found divides by nothing of W that the usual solution does not divide by."""
        pivots = {f for p in derived.kinematical.pivots for f in factors(p)}
        moving = {f for f in pivots if not is_constant_in_time([f])}
        if moving and self.allowed is None:
            self.allowed = _divisors((*self.usual.accelerations, *self.usual.reactions))
        more = moving - (self.allowed or set())
        return not more or more.isdisjoint(_divisors(found))


def _divisors(exprs: Sequence[Expr]) -> set[Expr]:
    """What expressions divide by, with its factors; of tangents their cosines."""
    tangents = (node for node in postorder(exprs) if node.op is OPS["tan"])
    found = {f for d in denominators(exprs) for f in factors(d)}
    return found | {NODE_BUILDERS["cos"](node.args[0]) for node in tangents}
