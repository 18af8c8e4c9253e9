# SPDX-License-Identifier: BSD-3-Clause
"""Candidates of which the shortest solution is taken: in which speeds equations are written, and how.

    speeds      declared, rates of constraints in the places of dependent ones, velocities of the mass centre
    embedding   after M and f are assembled, or before, in motions that satisfy the constraints
    about       the mass centre, or a point at rest
    bias        inertia forces by accelerations, by the momenta that M has, by the power, by a sum of squares
    dependent   u̇_D by A_n and c_D, by the definitions of the speeds that rates of constraints replaced, or differentiated at once

By A_n and c_D, u̇_D = A_n u̇_I + c_D, each speed's share is differentiated by itself. With u̇_I put in first, the whole is at once:

    A_D u̇_D = −(d/dt)(A u + b) at u̇_D = 0

along the tree, from the accelerations of what is constrained, or of the rates A_q q̇ + b_q as they are written, with q̈ of each
coordinate.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Literal, NamedTuple

from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.manifold import Touch, contacts
from kane.dynamics.derivation import Derived, Exprs
from kane.dynamics.formulation.equations import (
    Motions,
    about_points_at_rest,
    embedded,
    embedded_motions,
    homogeneous,
    power,
    squares,
    unguarded_classical,
)
from kane.dynamics.formulation.reactions import reactions
from kane.dynamics.formulation.shorten import short_forms
from kane.dynamics.formulation.speeds import ConstraintRates, by_definitions, twins
from kane.dynamics.solved import Solved
from kane.expr.build import NODE_BUILDERS, neg
from kane.expr.evaluation import Prices, free_symbols, is_constant_in_time, price
from kane.expr.node import ZERO, Expr, nodes
from kane.expr.ops import DIV, OPS, REGULAR
from kane.expr.regular import factors
from kane.expr.square_system import square
from kane.expr.symbols import QuasiRate, rate
from kane.expr.visit import substituting
from kane.kinematics.velocities import ContactPoint, Following
from kane.kinematics.velocity_constraints import drift_of
from kane.model.variables import constraint_rate
from kane.space.frame import Point

_TAN = OPS["tan"]


class Choice(NamedTuple):
    """How equations are written in given speeds."""

    embedding: Literal["after", "before"]
    about: Literal["mass centre", "point at rest"] = "mass centre"
    bias: Literal["accelerations", "momenta", "power", "squares"] = "accelerations"


ASSEMBLED = (Choice("after"),)
"""Where loads hold reactions."""
LONG = (Choice("before"),)
"""Of long equations: there candidates differ by little, and each takes its time."""
DECLARED = (Choice("before"), Choice("after", bias="power"), Choice("before", "point at rest", "momenta"))
"""In the declared speeds, beside the assembled equations."""
BY_RATES = (Choice("after"), Choice("before", bias="momenta"), Choice("before", bias="squares"))
"""With rates of constraints as speeds."""


class Candidate(NamedTuple):
    """A solution in the speeds of its own `derived`, the motions that it is made with, and which of these speeds vanish."""

    solution: Solved
    moving: Motions | None
    w: ConstraintRates | None = None


def by_rates(
    derived: Derived, e: Embedding, touching: Sequence[Touch], coupled: bool, large: bool
) -> Iterator[list[Candidate]]:
    """Candidates with rates of constraints as speeds, for each choice of these."""
    choices = ASSEMBLED if coupled else LONG if large else BY_RATES
    for twin, w in twins(derived, e.partition, touching):
        own = embedding(twin.constraints, e.partition)
        own = own.guarded() if large and not coupled else own  # of what is long next to nothing cancels
        particles = {p: replace(c, directions={}) for p, c in twin.kinematics.contacts.items()}
        every = _candidates(choices, twin, own, particles, coupled)
        yield [Candidate(w.solution(c.solution), c.moving, w) for c in every]


def in_declared_speeds(derived: Derived, e: Embedding, touching: Sequence[Touch], large: bool) -> Iterator[Candidate]:
    """Candidates in the declared speeds, through the particles that constraints hold."""
    return _candidates(LONG if large else DECLARED, derived, e, contacts(touching, {}, derived.kinematics), False)


def _candidates(
    choices: Sequence[Choice], d: Derived, e: Embedding, particles: Mapping[Point, ContactPoint], coupled: bool
) -> Iterator[Candidate]:
    motions = cache(lambda: embedded_motions(d, e, particles))
    for choice in choices:
        if choice.bias in ("power", "squares"):
            if homogeneous(d, e):
                yield Candidate((power if choice.bias == "power" else squares)(d, e), all_speeds(d))
        elif choice.embedding == "after":
            yield Candidate(unguarded_classical(d, e.partition, e), None if coupled else all_speeds(d))
        else:
            moving = motions()
            resting = choice.about == "point at rest"
            bodies = about_points_at_rest(moving.bodies, moving.kinematics) if resting else None
            yield Candidate(embedded(d, e, moving, bodies, carried=choice.bias == "momenta"), moving)


def all_speeds(derived: Derived) -> Motions:
    """The motions by all speeds."""
    return Motions(derived.speeds, derived.kinematics, derived.bodies)


# Dependent speeds --------------------------------------------------------------------------------------------------------


def with_dependent(derived: Derived, e: Embedding, candidate: Candidate, large: bool) -> Iterator[Exprs]:
    """u̇ with those of the dependent speeds, which follow from those of the independent ones."""
    solution, w = candidate.solution, candidate.w
    own = [solution.accelerations[i] for i in e.independent]
    if w is None or not large or candidate.moving is None:
        yield e.every(own)
    if w is not None:
        yield by_definitions(derived, solution.derived, solution.accelerations, w)
    if not large:
        yield from _differentiated(derived, e, own)


def _differentiated(derived: Derived, e: Embedding, u_dot: Sequence[Expr]) -> Iterator[Exprs]:
    """u̇ of all speeds along the tree and from the rates of coordinates, `u_dot` being those of the independent ones."""
    own = dict(zip(e.independent, u_dot, strict=True))
    usual = derived.kinematics
    given = usual.with_following({u: Following({}, ZERO, own.get(i, ZERO)) for i, u in enumerate(derived.speeds)}, {})
    held = [derived.constraints.constraints[r] for r in e.partition.rows]
    solver = square(derived.constraints.a.take(e.partition.rows, e.partition.dependent).rows)

    def solved(right: Sequence[Expr]) -> Exprs:
        values = own | dict(zip(e.partition.dependent, solver.solve(list(map(neg, right))), strict=True))
        return tuple(values[i] for i in range(len(values)))

    yield solved([drift_of(c, given, usual) for c in held])
    rates = [constraint_rate(c) for c in held]
    if not any(isinstance(s, QuasiRate) for s in free_symbols(rates)):
        by_speeds: dict[Expr, Expr] = {
            rate(q): x for q, x in zip(derived.system.coordinates, derived.rates, strict=True)
        }
        yield solved(list(map(given.drift, map(substituting(by_speeds), rates))))


# Reactions ---------------------------------------------------------------------------------------------------------------


def with_reactions(
    candidate: Candidate, u_dot: Exprs, derived: Derived, e: Embedding | None, differentiated: bool = False
) -> Solved:
    """The solution with this u̇, and the reactions as they are shortest beside it; `differentiated` ones are others."""
    s, w = candidate.solution, candidate.w
    values: dict[Expr, Expr] = dict(zip(s.derived.speeds, u_dot if w is None else s.accelerations, strict=True))
    every = [s.reactions] if len(s.reactions) == len(s.derived.reactions) else []
    if s.derived.reactions and candidate.moving is not None:
        held = w.held if w is not None else lambda x: x
        every += reactions(s.derived, s.embedding, candidate.moving, values, s.reaction_matrix, held, differentiated)
    rates = derived.rates
    best = _cheapest(every, (*rates, *u_dot), derived, e if differentiated else None)
    whole = replace(s, accelerations=u_dot, reactions=best)
    if e is None or s.embedding is None:
        return whole
    known = e.watching({**s.embedding.guards_in_use, **e.guards_in_use})
    if w is None:
        return replace(whole, derived=derived, embedding=known)
    own = tuple(map(w.held, s.derived.rates))
    if any(x is not y for x, y in zip(own, rates, strict=True)) and divisors(own) <= divisors(rates):
        cost = Prices((*u_dot, *best))
        whole = replace(whole, shorter_rates=own if cost(own) < cost(rates) else None)
    return replace(whole, route="contacts", derived=derived, embedding=known)


def _cheapest(every: Sequence[Exprs], beside: Exprs, derived: Derived, e: Embedding | None) -> Exprs:
    """What takes the fewest operations; of those that take as few by what they take in the end, where `e` is given."""
    if len(every) == 1:
        return every[0]
    prices = list(map(Prices(beside), every))
    least = min(prices)
    equal = list({tuple(map(id, x)): x for p, x in zip(prices, every, strict=True) if p == least}.values())[::-1]
    if e is None or len(equal) == 1:
        return equal[0]
    return min(equal, key=lambda x: price(short_forms((*x, *beside), derived, e)))


# What solutions divide by ------------------------------------------------------------------------------------------------


def divisors(exprs: Sequence[Expr]) -> set[Expr]:
    """What expressions divide by, with its factors; of tangents their cosines."""
    below = nodes(exprs)
    found = {f for node in below if node.op is DIV for f in factors(node.args[1])}
    found |= {f for node in found if node.op is REGULAR for f in factors(node.args[0])}
    return found | {NODE_BUILDERS["cos"](node.args[0]) for node in below if node.op is _TAN}


def of_embedding(e: Embedding) -> set[Expr]:
    """What A_n = −A_D⁻¹ A_I surely divides by: what A_I does and A_D does not, as A_D⁻¹ vanishes nowhere where A_D is finite."""
    a = e.rows.a.take(e.partition.rows)
    return divisors(a.take(columns=e.independent).entries) - divisors(a.take(columns=e.partition.dependent).entries)


class Poles:
    """What usual ways divide by, as far as that has to be known: first what is known soonest, last what it is made of.

    A candidate may divide by nothing of W by which the usual solution does not. None of it is made where a candidate divides by
    nothing of W.
    """

    def __init__(self, *known: Callable[[], set[Expr]]) -> None:
        self._open, self._known = list(known), set[Expr]()

    def fewer(self, derived: Derived, exprs: Sequence[Expr]) -> bool:
        """Whether expressions divide by nothing of W that the usual solution does not divide by."""
        pivots = {f for p in derived.kinematical.pivots for f in factors(p)}
        moving = {f for f in pivots if not is_constant_in_time([f])}
        divided = moving & divisors(exprs) if moving else moving
        while self._open and not divided <= self._known:
            self._known |= self._open.pop(0)()
        return divided <= self._known
