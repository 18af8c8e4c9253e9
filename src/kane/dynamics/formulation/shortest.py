# SPDX-License-Identifier: BSD-3-Clause
"""The search for the fewest operations: of the `candidates` the shortest that divides by nothing of W by which the classical does not.

One price, `kane.expr.forms.count.price`, compares them all. Candidates are priced by q̇ and u̇ of the independent speeds first; few are
followed to the other accelerations, and to the reactions.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.manifold import touches
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived, Exprs
from kane.dynamics.formulation.candidates import (
    Candidate,
    Poles,
    all_speeds,
    by_rates,
    divisors,
    in_declared_speeds,
    of_embedding,
    with_dependent,
    with_reactions,
    without_constraints,
)
from kane.dynamics.formulation.equations import holds_reactions, unguarded_classical
from kane.dynamics.formulation.reactions import LARGE
from kane.dynamics.formulation.shorten import with_short_forms, with_short_quotients, with_short_rates
from kane.dynamics.formulation.speeds import absolute
from kane.dynamics.formulation.trees import compared, is_grown, recursive
from kane.dynamics.solved import Solved
from kane.errors import KaneError
from kane.expr.forms.count import Prices, exceeds, price

_FEW = 2
"""Candidates that are followed."""
_LONG = 400
"""Operations of q̇ and A, times the bodies, from which on rates of constraints as speeds are shorter than the classical route."""


def shortest(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions by the route with the fewest operations, by absolute rates where links turn about parallel axes."""
    found = recursive(derived, partition)
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
    every = [(c, c.solution.accelerations) for c in without_constraints(derived, coupled)]
    return _with_reactions(every, derived, None, coupled)


def _with_reactions(
    every: Sequence[tuple[Candidate, Exprs]], derived: Derived, e: Embedding | None, coupled: bool
) -> Solved:
    """The shortest with its reactions, which are looked for in all ways beside the u̇ that is best with the usual ones."""
    whole = [(with_reactions(c, u_dot, derived, e), c, u_dot) for c, u_dot in every]
    best, candidate, u_dot = min(whole, key=lambda each: _cost(each[0])) if len(whole) > 1 else whole[0]
    if coupled or not derived.reactions:
        return best
    known = candidate._replace(solution=replace(candidate.solution, reactions=best.reactions))
    return with_reactions(known, u_dot, derived, e, differentiated=True)


@dataclass(frozen=True, eq=False)
class _Search:
    """The candidates of a system whose dependent speeds are those of `e`; `coupled` where loads hold reactions."""

    derived: Derived
    e: Embedding
    coupled: bool

    @cached_property
    def usual(self) -> Candidate:
        """The classical route."""
        solution = unguarded_classical(self.derived, self.e.partition, self.e)
        return Candidate(solution, None if self.coupled else all_speeds(self.derived))

    @cached_property
    def price(self) -> Prices:
        """Of what stands beside q̇."""
        return Prices(self.derived.rates)

    def cost(self, candidate: Candidate) -> int:
        """Operations of q̇ and u̇ of the independent speeds."""
        return self.price(candidate.solution.accelerations[i] for i in self.e.independent)

    def candidates(self) -> tuple[list[Candidate], bool]:
        """Solutions for u̇ of the independent speeds, and whether they are long, so that fewer are tried.

        Where rates of constraints as speeds shorten the classical route nothing is shorter than what comes of them.
        """
        d, e, rows = self.derived, self.e, self.derived.constraints
        touching = touches(rows.constraints, e.partition.rows, d.kinematics)
        if not self.coupled and exceeds((*d.rates, *rows.a.entries), _LONG // len(d.inertias)):
            every = [c for group in by_rates(d, e, touching, coupled=False, large=True) for c in group]
            if every:
                return every, True
        usual = self.usual.solution
        large = self.price((*usual.accelerations, *usual.reactions)) > LARGE
        every, least = [self.usual], self.cost(self.usual)
        for group in by_rates(d, e, touching, self.coupled, large):
            every += group
            if min(map(self.cost, group)) < least:
                return every, large
        if not self.coupled and not (large and len(every) > 1):
            every += in_declared_speeds(d, e, touching, large)
        return every, large

    def accelerations(self) -> list[tuple[Candidate, Exprs]]:
        """A few candidates with u̇ of all speeds."""
        every, large = self.candidates()
        sooner = (lambda: of_embedding(self.e), lambda: divisors(self.e.a_n.entries))
        poles = Poles(lambda: self.usual.solution, *sooner)
        priced = [(self.cost(c), c) for c in every] if len(every) > 1 else [(0, every[0])]
        pairs: list[tuple[int, int, Candidate, Exprs]] = []
        for cost, c in sorted(priced, key=lambda pair: pair[0])[:_FEW]:
            if pairs and cost >= min(pairs)[0]:
                break
            for u_dot in with_dependent(self.derived, self.e, c, large):
                if poles.fewer(c.solution.derived, u_dot):
                    pairs.append((self.price(u_dot), len(pairs), c, u_dot))
        return [(c, u_dot) for _, _, c, u_dot in sorted(pairs)[:_FEW]]

    def shortest(self) -> Solved:
        """Of these the shortest with its reactions."""
        every = self.accelerations()
        if not every or (self.derived.reactions and all(c is not self.usual for c, _ in every)):
            every.append((self.usual, self.usual.solution.accelerations))
        return _with_reactions(every, self.derived, self.e, self.coupled)


def _cost(s: Solved) -> int:
    return price((*(s.shorter_rates or s.derived.rates), *s.accelerations, *s.reactions))
