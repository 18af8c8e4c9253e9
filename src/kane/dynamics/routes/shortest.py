# SPDX-License-Identifier: BSD-3-Clause
"""The route that takes the fewest operations: of the `ways` the shortest that divides by nothing of W by which the classical does not.

A way is priced by q̇ and u̇ of the independent speeds first; few are followed to the other accelerations, and to the reactions.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.constraints.touches import touches
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.absolute import absolute
from kane.dynamics.routes.classical import unguarded_classical
from kane.dynamics.routes.divisors import Poles, divisors, of_embedding
from kane.dynamics.routes.embedded import holds_reactions
from kane.dynamics.routes.quotients import with_short_quotients
from kane.dynamics.routes.reactions import LARGE
from kane.dynamics.routes.short_forms import with_short_forms
from kane.dynamics.routes.short_rates import with_short_rates
from kane.dynamics.routes.trees import compared, is_grown, loops, trees
from kane.dynamics.routes.ways import (
    Exprs,
    Found,
    all_speeds,
    by_centre,
    by_motions,
    by_rates,
    dependent_ways,
    with_reactions,
)
from kane.dynamics.solved import Solved
from kane.errors import KaneError
from kane.expr.count import Prices, exceeds, price

_FEW = 2
"""Of the ways so far those that are followed."""
_LONG = 400
"""Operations of q̇ and A, times the bodies, from which on rates of constraints as speeds are shorter than the classical route."""


def shortest(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions by the route with the fewest operations, by absolute rates where links turn about parallel axes."""
    found = trees(derived) if partition is None else loops(derived, partition)
    if found and is_grown(derived, partition):
        return compared(found)
    usual = with_short_forms(with_short_rates(with_short_quotients(_by_speeds(derived, partition)))).guarded()
    return compared([usual, *found]) if found else usual


def _by_speeds(derived: Derived, partition: Partition | None) -> Solved:
    other = absolute(derived, partition)
    if other is not None:
        try:
            return other.declared(shortest_in_given_speeds(other.derived, partition), derived, partition)
        except KaneError:  # what is wrong is said of the declared speeds
            pass
    return shortest_in_given_speeds(derived, partition)


def shortest_in_given_speeds(derived: Derived, partition: Partition | None) -> Solved:
    """The shortest solution in the speeds of `derived`."""
    coupled = holds_reactions(derived)
    if partition is not None:
        return _Search(derived, embedding(derived.constraints, partition), coupled).shortest()
    usual = unguarded_classical(derived, None)
    free = [Found(usual, None if coupled else all_speeds(derived)), *by_centre(derived, usual, coupled)]
    return _with_reactions([(w, w.solution.accelerations) for w in free], derived, None, coupled)


def _with_reactions(
    found: Sequence[tuple[Found, Exprs]], derived: Derived, e: Embedding | None, coupled: bool
) -> Solved:
    """The shortest with its reactions, which are looked for in all ways beside the u̇ that is best with the usual ones."""
    whole = [(with_reactions(w, u_dot, derived, e), w, u_dot) for w, u_dot in found]
    best, way, u_dot = min(whole, key=lambda each: _cost(each[0])) if len(whole) > 1 else whole[0]
    if coupled or not derived.reactions:
        return best
    known = way._replace(solution=replace(way.solution, reactions=best.reactions))
    return with_reactions(known, u_dot, derived, e, differentiated=True)


@dataclass(frozen=True, eq=False)
class _Search:
    """The ways of a system whose dependent speeds are those of `e`; `coupled` where loads hold reactions."""

    derived: Derived
    e: Embedding
    coupled: bool

    @cached_property
    def usual(self) -> Found:
        """The classical route."""
        solution = unguarded_classical(self.derived, self.e.partition, self.e)
        return Found(solution, None if self.coupled else all_speeds(self.derived))

    @cached_property
    def price(self) -> Prices:
        """Of what stands beside q̇."""
        return Prices(self.derived.rates)

    def cost(self, way: Found) -> int:
        """Operations of q̇ and u̇ of the independent speeds."""
        return self.price(way.solution.accelerations[i] for i in self.e.independent)

    def solutions(self) -> tuple[list[Found], bool]:
        """Ways to u̇ of the independent speeds, and whether they are long, so that fewer are tried.

        Where rates of constraints as speeds shorten the classical route nothing is shorter than what comes of them.
        """
        d, e, rows = self.derived, self.e, self.derived.constraints
        held = touches(rows.constraints, e.partition.rows, d.kinematics)
        if not self.coupled and exceeds((*d.rates, *rows.a.entries), _LONG // len(d.inertias)):
            found = [way for ways in by_rates(d, e, held, coupled=False, large=True) for way in ways]
            if found:
                return found, True
        usual = self.usual.solution
        large = self.price((*usual.accelerations, *usual.reactions)) > LARGE
        found, least = [self.usual], self.cost(self.usual)
        for ways in by_rates(d, e, held, self.coupled, large):
            found += ways
            if min(map(self.cost, ways)) < least:
                return found, large
        if not self.coupled and not (large and len(found) > 1):
            found += by_motions(d, e, held, large)
        return found, large

    def accelerations(self) -> list[tuple[Found, Exprs]]:
        """A few ways to u̇ of all speeds."""
        solutions, large = self.solutions()
        told = (lambda: of_embedding(self.e), lambda: divisors(self.e.a_n.entries))
        poles = Poles(lambda: self.usual.solution, *told)
        if len(solutions) == 1:  # what is alone need not be counted
            (way,) = solutions
            every = [(way, u_dot) for u_dot in dependent_ways(self.derived, self.e, way, large)]
            alone = [pair for pair in every if poles.fewer(way.solution.derived, pair[1])]
            return alone if len(alone) < 2 else sorted(alone, key=lambda pair: self.price(pair[1]))[:_FEW]
        found: list[tuple[int, int, Found, Exprs]] = []
        for own, way in sorted(((self.cost(w), w) for w in solutions), key=lambda pair: pair[0])[:_FEW]:
            if found and own >= min(found)[0]:
                break
            for u_dot in dependent_ways(self.derived, self.e, way, large):
                if poles.fewer(way.solution.derived, u_dot):
                    found.append((self.price(u_dot), len(found), way, u_dot))
        return [(way, u_dot) for _, _, way, u_dot in sorted(found)[:_FEW]]

    def shortest(self) -> Solved:
        """Of these the shortest with its reactions."""
        found = self.accelerations()
        if self.derived.reactions or not found:
            found += (
                [(self.usual, self.usual.solution.accelerations)] if all(w is not self.usual for w, _ in found) else []
            )
        return _with_reactions(found, self.derived, self.e, self.coupled)


def _cost(s: Solved) -> int:
    return price((*(s.shorter_rates or s.derived.rates), *s.accelerations, *s.reactions))
