# SPDX-License-Identifier: BSD-3-Clause
"""The search for the fewest operations: of the `candidates` the shortest that divides by nothing of W by which the classical does not.

One price, `kane.expr.forms.count.price`, compares them all. Candidates are priced by q̇ and u̇ of the independent speeds first; few are
followed to the other accelerations, and to the reactions.
"""

from collections.abc import Callable
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
)
from kane.dynamics.formulation.equations import holds_reactions, unguarded_classical
from kane.dynamics.formulation.reactions import LARGE
from kane.dynamics.formulation.shorten import SHORT, with_short_forms, with_short_quotients, with_short_rates
from kane.dynamics.formulation.speeds import absolute, by_mass_centre
from kane.dynamics.formulation.trees import compared, is_grown, recursive
from kane.dynamics.solved import Solved
from kane.errors import KaneError
from kane.expr.forms.count import Prices, exceeds
from kane.expr.node import Expr

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
    e = None if partition is None else embedding(derived.constraints, partition)
    return _Search(derived, e, holds_reactions(derived)).shortest()


@dataclass(frozen=True, eq=False)
class _Search:
    """The candidates of a system whose dependent speeds are those of `e`, if any; `coupled` where loads hold reactions."""

    derived: Derived
    e: Embedding | None
    coupled: bool

    @cached_property
    def usual(self) -> Candidate:
        """The classical route."""
        solution = unguarded_classical(self.derived, None if self.e is None else self.e.partition, self.e)
        return Candidate(solution, None if self.coupled else all_speeds(self.derived))

    def of_usual(self) -> set[Expr]:
        """What that divides by."""
        return divisors((*self.usual.solution.accelerations, *self.usual.solution.reactions))

    def without_constraints(self) -> list[Candidate]:
        """By velocities of the mass centre, where one body is free to translate, and assembled, unless those are short already."""
        by_centre = by_mass_centre(self.derived)
        if by_centre is not None:
            twin, solution = by_centre
            solved = (*solution.accelerations, *solution.reactions)
            if Poles(self.of_usual).fewer(twin, solved):
                own = Candidate(solution, None if self.coupled else all_speeds(self.derived))
                return [self.usual, own] if exceeds(solved, SHORT) else [own]
        return [self.usual]

    @cached_property
    def price(self) -> Prices:
        """Of what stands beside q̇."""
        return Prices(self.derived.rates)

    def candidates(self, e: Embedding, cost: Callable[[Candidate], int]) -> tuple[list[Candidate], bool]:
        """Solutions for u̇ of the independent speeds, and whether they are long, so that fewer are tried.

        Where rates of constraints as speeds shorten the classical route nothing is shorter than what comes of them.
        """
        d, rows = self.derived, self.derived.constraints
        touching = touches(rows.constraints, e.partition.rows, d.kinematics)
        if not self.coupled and exceeds((*d.rates, *rows.a.entries), _LONG // len(d.inertias)):
            every = [c for group in by_rates(d, e, touching, coupled=False, large=True) for c in group]
            if every:
                return every, True
        usual = self.usual.solution
        large = self.price((*usual.accelerations, *usual.reactions)) > LARGE
        every, least = [self.usual], cost(self.usual)
        for group in by_rates(d, e, touching, self.coupled, large):
            every += group
            if min(map(cost, group)) < least:
                return every, large
        if not self.coupled and not (large and len(every) > 1):
            every += in_declared_speeds(d, e, touching, large)
        return every, large

    def accelerations(self) -> list[tuple[Candidate, Exprs]]:
        """A few candidates with u̇ of all speeds."""
        e = self.e
        if e is None:
            return [(c, c.solution.accelerations) for c in self.without_constraints()]

        def cost(c: Candidate) -> int:
            return self.price(c.solution.accelerations[i] for i in e.independent)

        every, large = self.candidates(e, cost)
        poles = Poles(lambda: of_embedding(e), lambda: divisors(e.a_n.entries), self.of_usual)
        priced = [(cost(c), c) for c in every] if len(every) > 1 else [(0, every[0])]
        pairs: list[tuple[int, int, Candidate, Exprs]] = []
        for least, c in sorted(priced, key=lambda pair: pair[0])[:_FEW]:
            if pairs and least >= min(pairs)[0]:
                break
            for u_dot in with_dependent(self.derived, e, c, large):
                if poles.fewer(c.solution.derived, u_dot):
                    pairs.append((self.price(u_dot), len(pairs), c, u_dot))
        return [(c, u_dot) for _, _, c, u_dot in sorted(pairs)[:_FEW]]

    def shortest(self) -> Solved:
        """The shortest with its reactions, which are looked for in all ways beside the u̇ that is best with the usual ones."""
        every, d, e = self.accelerations(), self.derived, self.e
        if e is not None and (not every or (d.reactions and all(c is not self.usual for c, _ in every))):
            every.append((self.usual, self.usual.solution.accelerations))
        whole = [(with_reactions(c, u_dot, d, e), c, u_dot) for c, u_dot in every]
        best, candidate, u_dot = min(whole, key=lambda each: each[0].price) if len(whole) > 1 else whole[0]
        if self.coupled or not d.reactions:
            return best
        known = candidate._replace(solution=replace(candidate.solution, reactions=best.reactions))
        return with_reactions(known, u_dot, d, e, differentiated=True)
