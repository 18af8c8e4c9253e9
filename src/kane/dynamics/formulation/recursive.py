# SPDX-License-Identifier: BSD-3-Clause
"""Recursive formulations: u̇ by the articulated-body or the composite-rigid-body algorithm, of trees and of trees with constraints.

Joint speeds are constant combinations of the generalized speeds: rates, sums and differences of rates, measure numbers of ω and v of
a body relative to its parent; else rates of coordinates, from which u̇ follow by the definitions of the speeds. M and f are assembled
only when read. `closed` has the equations of constraints.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from kane.dynamics.constraints.partition import Partition, embedding
from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.carried import falling, regrouped, rigid_bodies
from kane.dynamics.formulation.classical import evident, holds_reactions, solved_reactions
from kane.dynamics.formulation.closed import TreeConstraints, products
from kane.dynamics.formulation.elastic import Bent, bending_bodies, bent_frames, gauged, shared_rates
from kane.dynamics.formulation.joint_cuts import ReactionDirection, crossings, parted
from kane.dynamics.formulation.reflected import Geared, geared_to_ground, reflected_to_joints
from kane.dynamics.solved import Solved
from kane.errors import SingularError
from kane.expr.build import add, mul, neg
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import Walk, price
from kane.expr.matrix import Matrix, ldl
from kane.expr.node import ZERO, Expr, Exprs, nodes
from kane.expr.regular import guards
from kane.expr.symbols import Symbol
from kane.expr.visit import substituted
from kane.kinematics.freedoms import Unsuited, resolved
from kane.kinematics.links import Tree, repeated, without
from kane.kinematics.segments import JointStep, JointTree, Segments, joint_tree, segments
from kane.kinematics.velocity_constraints import placed, together
from kane.model.constraints import constraint_of
from kane.model.declarations import EulerParameters
from kane.numeric.sampling import SEEDS, draws, unit, value_of
from kane.numeric.scale import bounded
from kane.tree.articulated import Articulated, Passed, Wrenches
from kane.tree.composite import Composite
from kane.tree.values import Reflected, Rigid, SpatialForce

_BRANCH = 5
"""Joint speeds from the ground to one, on average, beyond which articulated inertias are shorter than composite ones, or as good as
shorter: like limbs go in the lanes of vectors then."""
BENT = 16
"""Speeds of a system with flexible bodies from which on articulated inertias are shorter than anything else."""
_SAVED = 5
"""Operations with the state that a regrouped body saves, about."""
NO_MASS = "a speed that moves no mass"
_TIMES, _BESIDE, _KEPT = 16, 1e-10, 1e-3
"""Points at which a pivot is computed, how far they are from each other, and how much of a pivot may change between them."""


WAYS: Mapping[str, type[Articulated] | type[Composite]] = {"recursive": Articulated, "composite": Composite}
"""How joint accelerations are found, by the name of the route."""


def recursions(derived: Derived, partition: Partition | None) -> Iterator[Solved]:
    """The solutions by the recursions that may be the shortest; none if the system is not a tree, possibly with constraints."""
    try:
        carried = carrying(derived, shared=True)
        for route in _worth_trying(derived, carried, closed=partition is not None):
            yield by_recursion(derived, carried, route, partition)
    except Unsuited:
        return


def _worth_trying(derived: Derived, carried: "Carrying", *, closed: bool) -> Iterable[str]:
    """The names of the recursions to try: one alone for long branches, transmitted wrenches, or closed chains of parallel axes."""
    crossed = derived.reactions and carried.crossings is not None  # the CRBA computes no transmitted wrenches
    steps = carried.segments.steps
    bent = any(step.modes for step in steps)
    both = len(derived.speeds) < BENT if bent else depth(steps) <= _BRANCH
    planar = closed and not bent and any(step.joins for step in steps)
    return WAYS if both and not crossed and not planar else ("recursive",)


def depth(steps: Sequence[JointStep]) -> float:
    """The mean number of joint speeds on the path from the ground to a joint speed, about the nonzero entries in a row of M."""
    ways: list[int] = []
    total = count = 0
    for i, step in enumerate(steps):
        own = len(step.slide.freedoms) + len(step.spin.freedoms)
        ways.append(own + (ways[step.parent] if i else 0))
        total, count = total + own * ways[i], count + own
    return total / max(count, 1)


class Carrying(NamedTuple):
    """The segments of a tree with their bodies, loads, flexible parts, reactions and reflected inertias."""

    segments: Segments
    bodies: Sequence[Rigid]
    loads: Wrenches
    bent: Bent
    crossings: Sequence[ReactionDirection | None] | None
    """The directions of the reactions at joint cuts, None of those of constraints; None if some cut is not at a joint."""
    reflected: Mapping[int, Reflected]
    """The reflected inertias of geared bodies, by number of the joint speed."""

    @property
    def asked(self) -> set[int]:
        """The segments beyond joint cuts, whose transmitted wrenches are needed."""
        return {c.segment for c in self.crossings or () if c is not None}

    def tree(self, *, balanced: bool, asked: Collection[int] = (), at_any_price: bool = True) -> JointTree:
        """The tree with bodies regrouped, but not across the joints of `asked`, whose wrenches are needed.

        Between parallel axes regrouping shortens all equations. Elsewhere it saves a few operations per body and adds others of
        parameters alone: it is done `at_any_price`, or if these are few.
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
        return joint_tree(steps, bodies, self.loads, elastic, elastic_along_a=not balanced, reflected=self.reflected)


def carrying(derived: Derived, *, shared: bool = False) -> Carrying:
    """The segments of a tree with what they carry. Unsuited, with the reason, if the system is not a tree of joint speeds.

    Coordinates that move several bodies, of flexible bodies or gears, are Unsuited too unless `shared`.
    """
    rates = shared_rates(derived)
    if rates and not shared:
        raise Unsuited("flexible bodies")
    forces, on = gauged(derived)
    points = [p for p, _ in forces] + [p for c in derived.constraints.constraints for p, _ in c.forces]
    tree, roots = parted(derived, points, bent_frames(derived))
    found, rates, geared, onto = _segments(derived, tree, rates, shared, {k for k in roots or () if k is not None})
    kept, number = without(tree, geared)
    roots = roots and [None if k is None else number[k] for k in roots]
    bodies = rigid_bodies(derived, found, kept.links)
    bent = Bent(bending_bodies(derived, found, kept.links, rates), on)
    across = None if roots is None else crossings(derived, roots, found)
    aligned, apart = derived.kinematics.aligned, {turn.basis for turn in geared.values()}
    torques = [x for load in derived.declared_loads for x in load.torques if aligned.rates(x[0])[0] not in apart]
    loads = together(placed(aligned, found, forces, torques))
    return Carrying(found, bodies, loads, bent, across, onto)


_Found = tuple[Segments, Exprs, Geared, Mapping[int, Reflected]]


def _segments(derived: Derived, tree: Tree, rates: Exprs, shared: bool, kept: Collection[int]) -> _Found:
    """The segments, the rates that move several of them, the links without segments, and reflected inertias by number.

    If joints have coordinates in common, bodies geared to a joint are reflected to it, except the links `kept`; coordinates that are
    still in several joints are treated as elastic coordinates.
    """
    try:
        return segments(tree, derived.kinematics, rates), rates, {}, {}
    except Unsuited as why:
        unsuited = why
    if geared := geared_to_ground(derived, tree, kept):
        try:
            found = segments(without(tree, geared)[0], derived.kinematics, rates)
        except Unsuited:
            pass
        else:
            if onto := reflected_to_joints(derived, found, geared):
                return found, rates, geared, onto
    more = tuple(dict.fromkeys((*rates, *repeated(tree, derived.kinematical.rates)))) if shared else rates
    if len(more) == len(rates):
        raise unsuited
    return segments(tree, derived.kinematics, more), more, {}, {}


class _Accelerated(NamedTuple):
    """The result of the recursion, with the multipliers λ of constraint rows, the pivots of their equations and the pivots' sizes."""

    passed: Passed
    transmitted: Mapping[int, SpatialForce]
    multipliers: Mapping[int, Expr]
    pivots: Sequence[Expr]
    sizes: Sequence[Expr]
    placed: Collection[int]
    """Rows whose forces are among what is transmitted."""


def by_recursion(derived: Derived, carried: Carrying, route: str, partition: Partition | None = None) -> Solved:
    """u̇ of a tree, possibly with constraints, by the recursion `route`; also the reactions, if it computes transmitted wrenches.

    Unsuited, with the reason, if the system is not such a tree.
    """
    if route != "recursive" or carried.crossings is None:
        if holds_reactions(derived):
            raise Unsuited("loads that contain reactions" + " that no joint transmits" * (partition is not None))
        carried = carried._replace(crossings=None)
    try:
        whole = _accelerated(derived, carried, route, partition)
    except SingularError:
        raise Unsuited(NO_MASS) from None
    pivots = tuple(whole.passed.pivots)
    if not is_regular(pivots, derived.system.euler_parameters):
        raise Unsuited(NO_MASS)
    values, matrix = resolved(whole.passed.rows, derived.kinematics), evident(derived)
    u_dot = tuple(values[u] for u in derived.speeds)
    e = None if partition is None else embedding(derived.constraints, partition)
    e = e and e.watching(guards(zip(whole.pivots, whole.sizes, strict=True), (), u_dot))
    of_rows = None if e is None else whole.multipliers
    result = Solved(route, derived, e, u_dot, (), pivots, matrix, matrix, of_rows=of_rows)
    if not derived.reactions or carried.crossings is None:
        return result
    return _with_reactions(result, _transmitted_forces(derived, carried.crossings, whole))


def _accelerated(derived: Derived, carried: Carrying, route: str, partition: Partition | None) -> _Accelerated:
    rows = () if partition is None else partition.rows
    tree = carried.tree(balanced=route == "recursive", asked=carried.asked, at_any_price=partition is not None)
    ground, asked = falling(derived), {i: tree.joint[i] for i in carried.asked}
    freed = WAYS[route](tree.segments, ground, list(asked.values()))
    if len(freed.free.rows) < len(derived.speeds):
        raise Unsuited(NO_MASS)
    holding = TreeConstraints(derived, carried.segments, tree, freed, ground)
    pairs = list(map(holding.row, rows))
    forces = [force for force, _ in pairs]
    matrix = products(freed.divisors, forces)
    factors = ldl(matrix)
    solution = factors.solve([neg(right) for _, right in pairs])
    passed = freed.passed(forces, solution) if rows else freed.free
    transmitted = {i: passed.transmitted[k] for i, k in asked.items()} if passed.transmitted else {}
    sizes = [row[k] for k, row in enumerate(matrix)]
    multipliers = dict(zip(rows, solution, strict=True))
    return _Accelerated(passed, transmitted, multipliers, factors.pivots, sizes, holding.placed(rows))


def _transmitted_forces(
    derived: Derived, across: Sequence[ReactionDirection | None], whole: _Accelerated
) -> list[Expr]:
    """G_a R by reaction: the transmitted component, less that of the constraint forces on the far side."""
    result = []
    for a, crossing in enumerate(across):
        total = ZERO if crossing is None else crossing.measured(whole.transmitted)
        for r, multiplier in whole.multipliers.items():
            if r not in whole.placed or constraint_of(derived.auxiliary_speeds[a]) is not None:
                total = add(total, neg(mul(derived.constraints.a_auxiliary[r, a], multiplier)))
        result.append(total)
    return result


def _with_reactions(found: Solved, transmitted: Sequence[Expr]) -> Solved:
    """The solution with R from G_a R = `transmitted`; both this and u̇ are affine in R if loads depend on reactions."""
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
    """Whether all pivots are nonzero beyond rounding at one of several random states."""
    groups = [s.coordinates for s in sets]
    symbols = [s for s in nodes(pivots) if isinstance(s, Symbol)]
    at = unit({s: value_of(s, SEEDS[0]) for s in symbols}, groups)
    if all(abs(x) > error for x, error in bounded(pivots, at)):
        return True
    return any(keep_digits(pivots, {s: value_of(s, seed) for s in symbols}, groups) for seed in SEEDS)


def keep_digits(pivots: Sequence[Expr], values: Mapping[Expr, float], groups: Iterable[Sequence[Expr]] = ()) -> bool:
    """Whether all pivots change little under a small change of `values`; the rounding residue of a vanishing pivot does not."""
    walk = Walk(pivots)
    others = draws(_TIMES, walk.symbols)
    beside = {s: values[s] * (1 + _BESIDE * drawn) for s, drawn in zip(walk.symbols, others, strict=True)}
    with np.errstate(all="ignore"):
        found = np.array([np.broadcast_to(x, _TIMES) for x in walk(unit(beside, groups))])
    return bool(np.all(np.ptp(found, axis=1) < _KEPT * np.abs(found[:, 0])))
