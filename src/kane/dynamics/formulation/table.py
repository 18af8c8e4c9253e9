# SPDX-License-Identifier: BSD-3-Clause
"""The formulations by name (`route`), and the search for the one with the fewest operations.

The shortest of the `candidates` is taken that adds no divisor of W to those of the classical formulation. All are compared by
`kane.expr.evaluation.price`: first of q̇ and u̇ of the independent speeds; the other accelerations and the reactions are derived for
the few cheapest.

Recursions are tried for trees of a few bodies, and used alone from one more body on, where they are shorter and derived faster; M and
f are then assembled only when read. For trees with constraints both numbers are larger, and recursions are used alone if there are
many speeds per constraint.

Noncontributing loads along constraint forces are left out before u̇ is solved for, so that they need not cancel. A force X e on a
particle whose velocity along e is prescribed, or X e and −X e on two particles with equal velocities along e, contributes nothing
(Kane & Levinson 1985, sec. 4.5). Without it the multiplier is λ + X, and nothing else changes.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce

from kane.dynamics.constraints.manifold import touches
from kane.dynamics.constraints.partition import Embedding, Partition, embedding
from kane.dynamics.derivation import Derived, check_reactions_independent
from kane.dynamics.formulation.candidates import (
    LARGE,
    SHORT,
    TRIED,
    Candidate,
    Poles,
    Tried,
    all_speeds,
    by_rates,
    divisors,
    in_declared_speeds,
    of_embedding,
    with_dependent,
    with_half_speeds,
    with_reactions,
    with_short_forms,
    with_short_quotients,
    with_short_rates,
)
from kane.dynamics.formulation.change_of_speeds import absolute, by_mass_centre, constraint_speeds
from kane.dynamics.formulation.classical import classical, holds_reactions, unguarded_classical
from kane.dynamics.formulation.recursive import BENT, WAYS, by_recursion, carrying, recursions
from kane.dynamics.solved import Solved
from kane.errors import KaneError, ModelError, ReactionError, SingularError
from kane.expr.build import mul, neg, sub, sum_of
from kane.expr.differentiation import Affine
from kane.expr.evaluation import Prices, exceeds, price
from kane.expr.forms.collect import collected
from kane.expr.node import ONE, ZERO, Expr, Exprs
from kane.kinematics.freedoms import Unsuited
from kane.model.bodies import deforming
from kane.model.constraints import Constraint, constraint_of
from kane.model.loads import Load
from kane.space.frame import Point
from kane.space.rotation import UNITS, Basis, single
from kane.space.vector import Vector

_TREE, _GROWN = 5, 6
"""The numbers of bodies from which on recursions are tried, and from which on they are used alone."""
_LOOP, _WIDE, _SPEEDS_A_ROW = 6, 12, 3
"""The same with constraints; the third is the number of speeds per row for recursions alone."""


def recursive(derived: Derived, partition: Partition | None) -> list[Solved]:
    """The solutions by recursion, of large or flexible trees, whose divisors of W are those of velocities alone."""
    if len(derived.inertias) < (_TREE if partition is None else _LOOP) and not deforming(derived.system.bodies):
        return []
    return [_finished(derived, s) for s in recursions(derived, partition) if has_no_poles(derived, s)]


def _finished(derived: Derived, s: Solved) -> Solved:
    """The solution with reactions, and with guards or short q̇."""
    whole = tree_with_reactions(derived, s)
    return with_half_speeds(whole) if s.embedding is None else whole.guarded()


def has_no_poles(derived: Derived, s: Solved) -> bool:
    """Whether the divisors of W in a solution are those of velocities alone."""
    return Poles(lambda: _of_velocities(derived)).fewer(derived, s.accelerations)


def _of_velocities(derived: Derived) -> set[Expr]:
    """The divisors of the partial velocities of bodies, which every formulation has."""
    motions = [m for b in derived.bodies for m in (b.center, b.rotation and b.rotation.motion) if m]
    return divisors([x for m in motions for v in m.partials.values() for x in v.scalars()])


def is_grown(derived: Derived, partition: Partition | None) -> bool:
    """Whether a tree has enough bodies for recursions to be used alone."""
    if deforming(derived.system.bodies):
        return partition is None and len(derived.speeds) >= BENT
    if partition is None:
        return len(derived.inertias) >= _GROWN
    return len(derived.inertias) >= _WIDE and len(derived.speeds) >= _SPEEDS_A_ROW * len(partition.rows)


def tree_with_reactions(derived: Derived, s: Solved) -> Solved:
    """A solution of a tree, completed by its reactions."""
    if len(s.reactions) == len(derived.reactions):
        return s
    motions = all_speeds(derived) if derived.reactions else None
    return with_reactions(Candidate(s, motions), s.accelerations, derived, s.embedding)


def compared(found: Sequence[Solved]) -> Solved:
    """The solution with the fewest operations, the first of several, with the operations of all of them by route.

    Those of one alone are counted when they are read.
    """
    if len(found) == 1:
        return found[0]
    costs = [s.price for s in found]
    by_route: dict[str, int] = {}
    for s, cost in zip(found, costs, strict=True):
        by_route[s.route] = min(cost, by_route.get(s.route, cost))
    return replace(found[costs.index(min(costs))], routes=by_route)


def forced(route: str) -> Callable[[Derived, Partition | None], Solved]:
    """u̇ and the reactions by one of the recursions. ModelError if the system is not a tree of joint speeds."""

    def solve(derived: Derived, partition: Partition | None) -> Solved:
        try:
            found = by_recursion(derived, carrying(derived, shared=True), route, partition)
            if not has_no_poles(derived, found):
                raise Unsuited("speeds whose W has poles that the velocities in these speeds do not have")
            return _finished(derived, found)
        except Unsuited as why:
            raise ModelError(
                f"Expected a tree of joint speeds for route={route!r}, got {why}. Leave out route=, or take "
                "route='classical'."
            ) from None

    return solve


_FEW = 2
"""The number of candidates for which all accelerations are derived."""
_LONG = 400
"""Operations of q̇ and A, times bodies, from which on rates of constraints as speeds are shorter than the classical formulation."""


FINISHES = (with_short_quotients, with_short_rates, with_short_forms)
"""Functions that shorten the solution found, applied in this order."""


def shortest(
    derived: Derived,
    partition: Partition | None,
    tried: Tried = TRIED,
    finishes: Sequence[Callable[[Solved], Solved]] = FINISHES,
) -> Solved:
    """u̇ and the reactions in the fewest operations; absolute rates are tried as speeds if links rotate about parallel axes."""
    found = recursive(derived, partition)
    if found and is_grown(derived, partition):
        return compared(found)
    usual = reduce(lambda s, finish: finish(s), finishes, _by_speeds(derived, partition, tried)).guarded()
    return compared([usual, *found]) if found else usual


def _by_speeds(derived: Derived, partition: Partition | None, tried: Tried) -> Solved:
    other = absolute(derived, partition) if "absolute" in tried.speeds else None
    if other is not None:
        try:
            return other.declared(shortest_in_given_speeds(other.derived, partition, tried), derived, partition)
        except KaneError:  # what is wrong is said of the declared speeds
            pass
    return shortest_in_given_speeds(derived, partition, tried)


def shortest_in_given_speeds(derived: Derived, partition: Partition | None, tried: Tried = TRIED) -> Solved:
    """The shortest solution in the speeds of `derived`."""
    e = None if partition is None else embedding(derived.constraints, partition)
    return _Search(derived, e, holds_reactions(derived), tried).shortest()


@dataclass(frozen=True, eq=False)
class _Search:
    """The candidates of a system with the embedding `e`, if any; `coupled` if loads depend on reactions."""

    derived: Derived
    e: Embedding | None
    coupled: bool
    tried: Tried

    @cached_property
    def usual(self) -> Candidate:
        """The classical formulation."""
        solution = unguarded_classical(self.derived, None if self.e is None else self.e.partition, self.e)
        return Candidate(solution, None if self.coupled else all_speeds(self.derived))

    def of_usual(self) -> set[Expr]:
        """The divisors of the classical formulation."""
        return divisors((*self.usual.solution.accelerations, *self.usual.solution.reactions))

    def without_constraints(self) -> list[Candidate]:
        """Candidates by velocities of the mass centre, if the only body translates freely, and assembled unless that is short."""
        by_centre = by_mass_centre(self.derived) if "mass centre" in self.tried.speeds else None
        if by_centre is not None:
            twin, solution = by_centre
            solved = (*solution.accelerations, *solution.reactions)
            if Poles(lambda: divisors(self.derived.blocks.forcing), self.of_usual).fewer(twin, solved):
                own = Candidate(solution, None if self.coupled else all_speeds(self.derived))
                return [self.usual, own] if exceeds(solved, SHORT) else [own]
        return [self.usual]

    @cached_property
    def price(self) -> Prices:
        """The price of expressions beside q̇."""
        return Prices(self.derived.rates)

    def candidates(self, e: Embedding, cost: Callable[[Candidate], int]) -> tuple[list[Candidate], bool]:
        """Solutions for u̇ of the independent speeds, and whether they are long, so that fewer are tried.

        Where rates of constraints as speeds shorten the classical route nothing is shorter than what comes of them.
        """
        d, rows = self.derived, self.derived.constraints
        touching = touches(rows.constraints, e.partition.rows, d.kinematics)
        if not self.coupled and exceeds((*d.rates, *rows.a.entries), _LONG // len(d.inertias)):
            every = [
                c for group in by_rates(d, e, touching, coupled=False, large=True, tried=self.tried) for c in group
            ]
            if every:
                return every, True
        usual = self.usual.solution
        large = self.price((*usual.accelerations, *usual.reactions)) > LARGE
        every, least = [self.usual], cost(self.usual)
        for group in by_rates(d, e, touching, self.coupled, large, self.tried):
            every += group
            if min(map(cost, group)) < least:
                return every, large
        if not self.coupled and not (large and len(every) > 1):
            every += in_declared_speeds(d, e, touching, large, self.tried)
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
        pairs: list[tuple[Candidate, Exprs]] = []
        prices: list[int] = []
        for least, c in sorted(priced, key=lambda pair: pair[0])[:_FEW]:
            prices += [self.price(u_dot) for _, u_dot in pairs[len(prices) :]]
            if pairs and least >= min(prices):
                break
            ways = with_dependent(self.derived, e, c, large, self.tried.dependent)
            pairs += [(c, u_dot) for u_dot in ways if poles.fewer(c.solution.derived, u_dot)]
        if len(pairs) < 2:
            return pairs
        prices += [self.price(u_dot) for _, u_dot in pairs[len(prices) :]]
        return [pairs[k] for k in sorted(range(len(pairs)), key=prices.__getitem__)[:_FEW]]

    def shortest(self) -> Solved:
        """The shortest solution with reactions; other forms of these are tried for the u̇ that is best with the usual form."""
        every, d, e = self.accelerations(), self.derived, self.e
        if e is not None and (not every or (d.reactions and all(c is not self.usual for c, _ in every))):
            every.append((self.usual, self.usual.solution.accelerations))
        whole: list[tuple[Solved, Candidate, Exprs]] = []
        for c, u_dot in every:  # no longer with reactions than another one is without them
            if not whole or price(u_dot) < min(s.price for s, _, _ in whole):
                whole.append((with_reactions(c, u_dot, d, e), c, u_dot))
        best, candidate, u_dot = min(whole, key=lambda each: each[0].price) if len(whole) > 1 else whole[0]
        if self.coupled or not d.reactions:
            return best
        known = candidate._replace(solution=replace(candidate.solution, reactions=best.reactions))
        return with_reactions(known, u_dot, d, e, differentiated=True)


# Loads along what constraints hold -----------------------------------------------------------------------------------


Route = Callable[[Derived, Partition | None], Solved]
"""A formulation: u̇ and the reactions from a derived system and the partition of its constraints, if any."""
Forces = dict[Point, Vector]


def without_constraint_forces(route: Route) -> Route:
    """The formulation applied to the system without loads along constraint forces."""

    def solved(derived: Derived, partition: Partition | None) -> Solved:
        held, loads = _forces_along_constraints(derived, partition) if partition is not None else ({}, ())
        if not held:
            return route(derived, partition)
        light = replace(derived, system=derived.system.with_loads(loads))
        found = route(light, partition)
        if found.twin is not None or found.derived is not light:
            return route(derived, partition)
        memo: dict[Expr, Affine] = {}
        reactions, constraints = list(found.reactions), derived.constraints.constraints
        for i, r in enumerate(derived.reactions):
            c = constraint_of(r)
            if c is not None and c in held:
                reactions[i] = sub(reactions[i], derived.kinematical.in_speeds(held[c], memo))
        of_rows = found.of_rows and {
            r: sub(x, derived.kinematical.in_speeds(held[c], memo)) if (c := constraints[r]) in held else x
            for r, x in found.of_rows.items()
        }
        return replace(found, derived=derived, lightened=light, reactions=tuple(reactions), of_rows=of_rows)

    return solved


def _forces_along_constraints(
    derived: Derived, partition: Partition
) -> tuple[Mapping[Constraint, Expr], Sequence[Load]]:
    """The components X of loads along the forces of nonredundant constraints, and the loads without them."""
    constraints = [derived.constraints.constraints[r] for r in sorted(partition.rows)]
    loaded = _plain(derived.system.loads, {p for c in constraints for p, _ in c.forces})
    left = dict(loaded)
    held: dict[Constraint, Expr] = {}
    waiting = [
        c for c in constraints if not c.torques and len(c.forces) in (1, 2) and all(p in left for p, _ in c.forces)
    ]
    while waiting:  # the plainest force first: what is left is plainer for the others
        found = [(c, *_components(c, left)) for c in waiting]
        c, x, after = min(found, key=lambda each: (each[1] is ZERO, price([each[1]])))
        if x is ZERO:
            break
        held[c] = x
        left |= after
        waiting.remove(c)
    if not held or holds_reactions(derived):
        return {}, ()
    changed = {p: v for p, v in left.items() if v is not loaded[p]}
    kept = [_elsewhere(load, changed) for load in derived.system.loads]
    rests = [Load(f"rest at {p.name}", ((p, v),)) for p, v in changed.items() if not v.is_zero]
    return held, [*(load for load in kept if load.forces or load.torques), *rests]


def _is_plain(load: Load) -> bool:
    return load.potential is None and load.slip is None


def _plain(loads: Iterable[Load], points: set[Point]) -> Forces:
    """The resultant force of plain loads at each point."""
    total: Forces = {}
    for load in loads:
        for p, v in load.forces if _is_plain(load) else ():
            if p in points:
                total[p] = total[p] + v if p in total else v
    return total


def _elsewhere(load: Load, points: Mapping[Point, Vector]) -> Load:
    """The load without its forces at `points`, whose resultants are given separately."""
    if not _is_plain(load) or not any(p in points for p, _ in load.forces):
        return load
    return Load(load.name, tuple((p, v) for p, v in load.forces if p not in points), load.torques)


def _components(c: Constraint, loaded: Forces) -> tuple[Expr, Forces]:
    """X of the forces X e, or X e and −X e, along the constraint, and the remaining forces at its points, if these are shorter."""
    places: list[tuple[Point, Basis, int, Expr]] = []
    for p, e in c.forces:
        frame, axis = e.parts[0]
        i = single(axis)
        if len(e.parts) > 1 or i is None or not (axis[i] is ONE or neg(axis[i]) is ONE):
            return ZERO, {}
        places.append((p, frame, i, axis[i]))
    least = (*_scalars(loaded[p] for p, *_ in places), 0)
    best: tuple[Expr, Forces] = ZERO, {}
    for p, frame, i, sign in places:
        own = sum_of([v[i] for f, v in loaded[p].parts if f is frame])
        for number in (own, loaded[p].components(frame)[i]):
            x = mul(sign, number)
            left = {p: _less(loaded[p], frame, i, mul(sign, x)) for p, frame, i, sign in places}
            found = (*_scalars(left.values()), price([x]))
            if x is not ZERO and found < least:
                best, least = (x, left), found
    return best


def _less(v: Vector, frame: Basis, i: int, x: Expr) -> Vector:
    """v minus x along axis i of a frame, written along its present frames or along that frame."""
    rest = (v - Vector(((frame, UNITS[i]),)) * x).map(collected)
    return min((rest, rest.express(frame).map(collected)), key=lambda w: _scalars([w]))


def _scalars(vectors: Iterable[Vector]) -> tuple[int, int]:
    """The number of nonzero measure numbers, and their price."""
    scalars = [x for v in vectors for x in v.scalars() if x is not ZERO]
    return len(scalars), price(scalars)


# Routes by name -------------------------------------------------------------------------------------------------------


ROUTES: dict[str, Route] = {
    "classical": classical,
    "constraint speeds": constraint_speeds,
    "shortest": without_constraint_forces(shortest),
    **{name: forced(name) for name in WAYS},
}
ASKED = ("classical", *WAYS)
"""The names of formulations that a user may ask for."""


def solved(derived: Derived, partition: Partition | None, route: str = "shortest") -> Solved:
    """u̇ and the reactions by the formulation `route`, with constraints also u_D in u_I."""
    try:
        solution = ROUTES[route](derived, partition)
    except SingularError as error:
        raise ReactionError(f"Expected linearly independent reactions: {error}") from error
    check_reactions_independent(derived.system, derived.reactions, solution.reaction_matrix)
    return solution
