# SPDX-License-Identifier: BSD-3-Clause
"""The recursive routes: u̇ of trees by articulated inertias, or by composite ones.

They take systems without constraints; `closed` is for those that have some. Joint speeds are combinations of the generalized
speeds, one after the other: rates, sums and differences of rates, measure numbers of ω and v of a body in the one before; else rates
of coordinates, of which u̇ follows by the definitions of the speeds. M and f are assembled when they are read.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.block_solution import solved_reactions
from kane.dynamics.formulation.carried import falling, load_wrenches, regrouped, rigid_bodies
from kane.dynamics.formulation.crossings import Crossing, crossings, parted
from kane.dynamics.formulation.elastic import Bent, bending_bodies, bent_frames, gauged, shared_rates
from kane.dynamics.formulation.equations import evident, holds_reactions
from kane.dynamics.solved import Solved
from kane.errors import SingularError
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import Walk
from kane.expr.forms.count import price
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr, nodes
from kane.expr.symbols import Symbol
from kane.expr.visit import substituted
from kane.kinematics.freedoms import Unsuited, resolved
from kane.kinematics.links import Tree, repeated
from kane.kinematics.segments import JointStep, JointTree, Segments, joint_tree, segments
from kane.model.bodies import deforming
from kane.model.variables import EulerParameters
from kane.numeric.sampling import SEEDS, draws, unit, value_of
from kane.numeric.scale import bounded
from kane.tree.articulated import Articulated, Wrenches
from kane.tree.composite import Composite
from kane.tree.values import Rigid

Exprs = tuple[Expr, ...]

_BRANCH = 5
"""Joint speeds from the ground to one, on average, beyond which articulated inertias are shorter than composite ones."""
BENT = 16
"""Speeds of a system with flexible bodies from which on articulated inertias are shorter than anything else."""
_SAVED = 5
"""Operations with the state that a regrouped body saves, about."""
NO_MASS = "a speed that moves no mass"
_TIMES, _BESIDE, _KEPT = 16, 1e-10, 1e-3
"""Points at which a pivot is computed, how far they are from each other, and how much of a pivot may change between them."""


WAYS: Mapping[str, type[Articulated] | type[Composite]] = {"recursive": Articulated, "composite": Composite}
"""How joint accelerations are found, by the name of the route."""


def recursions(derived: Derived) -> Iterator[Solved]:
    """The solutions without the reactions, as far as the system is one of those."""
    try:
        carried = carrying(derived, flexible=True, shared=bool(deforming(derived.system.bodies)))
        yield from (by_recursion(derived, carried, route) for route in worth_trying(derived, carried))
    except Unsuited:
        return


def worth_trying(derived: Derived, carried: "Carrying") -> Iterable[str]:
    """The recursions that may be the shortest: one alone where the branches are long, or joints tell what they transmit."""
    crossed = derived.reactions and carried.crossings is not None  # the other way does not tell that
    steps = carried.segments.steps
    both = len(derived.speeds) < BENT if any(step.modes for step in steps) else depth(steps) <= _BRANCH
    return WAYS if both and not crossed else ("recursive",)


def depth(steps: Sequence[JointStep]) -> float:
    """The joint speeds from the ground to one, on average: about how many entries a row of M has."""
    ways: list[int] = []
    total = count = 0
    for i, step in enumerate(steps):
        own = len(step.slide.freedoms) + len(step.spin.freedoms)
        ways.append(own + (ways[step.parent] if i else 0))
        total, count = total + own * ways[i], count + own
    return total / max(count, 1)


class Carrying(NamedTuple):
    """The segments with what they carry."""

    segments: Segments
    bodies: Sequence[Rigid]
    loads: Wrenches
    bent: Bent
    crossings: Sequence[Crossing | None] | None
    """Where the reactions cross, where that is told by segments; those of constraints do nowhere."""

    @property
    def asked(self) -> set[int]:
        """The segments that reactions cross into."""
        return {c.segment for c in self.crossings or () if c is not None}

    def tree(self, *, balanced: bool, asked: Collection[int] = (), at_any_price: bool = True) -> JointTree:
        """The tree with bodies regrouped, but not across the joints whose wrenches are asked for.

        Between parallel axes that makes all shorter. Elsewhere it saves a few operations with the state for each body, by others of
        parameters alone: `at_any_price`, or where these are as few.
        """
        steps = self.segments.steps
        elastic = {
            i: self.bent.elastic(i, step.modes) for i, step in enumerate(steps) if step.modes or i in self.bent.bodies
        }
        bodies: Sequence[Rigid] = regrouped(self.bodies, steps, balanced, asked)
        if not (at_any_price or any(step.joins for step in steps)):
            before, after = (
                price([x for body in each for x in (body.m, *body.h, *chain(*body.j))])
                for each in (self.bodies, bodies)
            )
            bodies = bodies if after - before <= _SAVED * len(bodies) else self.bodies
        return joint_tree(steps, bodies, self.loads, elastic, elastic_along_a=not balanced)


def carrying(derived: Derived, *, flexible: bool = False, shared: bool = False) -> Carrying:
    """The segments of a tree; Unsuited, with what is in the way, where it is none of those, or has parts that are `flexible`.

    Coordinates that several joints have are left to other routes, too, unless these may be `shared`.
    """
    rates = shared_rates(derived)
    if rates and not flexible:
        raise Unsuited("flexible bodies")
    forces, on = gauged(derived)
    points = [p for p, _ in forces] + [p for c in derived.constraints.constraints for p, _ in c.forces]
    tree, roots = parted(derived, points, bent_frames(derived))
    found, rates = _segments(derived, tree, rates, shared)
    bodies = rigid_bodies(derived, found, tree.links)
    bent = Bent(bending_bodies(derived, found, tree.links, rates), on)
    across = None if roots is None else crossings(derived, roots, found)
    return Carrying(found, bodies, load_wrenches(derived, found, forces), bent, across)


def _segments(derived: Derived, tree: Tree, rates: Exprs, shared: bool) -> tuple[Segments, Exprs]:
    """The segments, and the rates that move several: those of flexible bodies, and others where there is no other way."""
    try:
        return segments(tree, derived.kinematics, rates), rates
    except Unsuited:
        every = derived.kinematical.rates
        more = tuple(dict.fromkeys((*rates, *repeated(tree, every)))) if shared else rates
        if len(more) == len(rates):
            raise
        return segments(tree, derived.kinematics, more), more


def by_recursion(derived: Derived, carried: Carrying, route: str) -> Solved:
    """u̇, with the reactions where these are transmitted by joints of the tree and the way tells what is."""
    own = route == "recursive"
    across = carried.crossings if own and derived.reactions else None
    asked = {c.segment for c in across or () if c is not None}
    if across is None and holds_reactions(derived):
        raise Unsuited("loads that hold reactions")
    try:
        tree = carried.tree(balanced=own, asked=asked, at_any_price=False)
        passed = WAYS[route](tree.segments, falling(derived), [tree.joint[i] for i in asked]).free
    except SingularError:
        raise Unsuited(NO_MASS) from None
    if not is_regular(passed.pivots, derived.system.euler_parameters):
        raise Unsuited(NO_MASS)
    if len(passed.rows) < len(derived.speeds):
        raise Unsuited(NO_MASS)
    values = resolved(passed.rows, derived.kinematics)
    u_dot, matrix = tuple(values[u] for u in derived.speeds), evident(derived)
    found = Solved(route, derived, None, u_dot, (), tuple(passed.pivots), matrix, matrix)
    if across is None:
        return found
    transmitted = {i: passed.transmitted[tree.joint[i]] for i in asked}
    return with_reactions(found, [ZERO if c is None else c.measured(transmitted) for c in across])


def with_reactions(found: Solved, transmitted: Sequence[Expr]) -> Solved:
    """The solution with R of G_a R = `transmitted`, which is affine in R where loads hold reactions, as u̇ is then."""
    reactions = found.derived.reactions
    forms = affine_forms(transmitted, reactions)
    held = Matrix([[c.get(r, ZERO) for r in reactions] for c, _ in forms])
    matrix = found.bare_reaction_matrix - held
    solution = tuple(solved_reactions(matrix, [rest for _, rest in forms]))
    values: dict[Expr, Expr] = dict(zip(reactions, solution, strict=True))
    memo: dict[Expr, Expr] = {}
    u_dot = tuple(substituted(x, values, memo) for x in found.accelerations)
    of_rows = found.of_rows and {r: substituted(x, values, memo) for r, x in found.of_rows.items()}
    return replace(found, accelerations=u_dot, reactions=solution, reaction_matrix=matrix, of_rows=of_rows)


def is_regular(pivots: Sequence[Expr], sets: Iterable[EulerParameters] = ()) -> bool:
    """Whether no pivot is zero but for rounding, at one of several samples.

    What cancels leaves other digits wherever it is computed: such a pivot does not keep its first ones a little beside the sample.
    """
    groups = [s.coordinates for s in sets]
    at = unit({s: value_of(s, SEEDS[0]) for s in nodes(pivots) if isinstance(s, Symbol)}, groups)
    if all(abs(x) > error for x, error in bounded(pivots, at)):
        return True
    walk = Walk(pivots)
    symbols = walk.symbols
    others = draws(_TIMES, symbols)
    for seed in SEEDS:
        beside = {s: value_of(s, seed) * (1 + _BESIDE * drawn) for s, drawn in zip(symbols, others, strict=True)}
        with np.errstate(all="ignore"):
            values = np.array([np.broadcast_to(x, _TIMES) for x in walk(unit(beside, groups))])
        if bool(np.all(np.ptp(values, axis=1) < _KEPT * np.abs(values[:, 0]))):
            return True
    return False
