# SPDX-License-Identifier: BSD-3-Clause
"""Loads along what constraints hold contribute nothing: u̇ is solved without them, so that none of them is left there to cancel.

A force X e on a particle whose velocity along e is given, or X e and −X e on two that have it in common, is part of what holds them
(Kane & Levinson 1985, sec. 4.5). Without it λ + X takes the place of the multiplier λ, and nothing else changes.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.equations import holds_reactions
from kane.dynamics.solved import Solved
from kane.expr.build import mul, neg, sub, sum_of
from kane.expr.differentiation import Affine
from kane.expr.forms.collect import collected
from kane.expr.forms.count import price
from kane.expr.node import ONE, ZERO, Expr
from kane.model.constraints import Constraint, constraint_of
from kane.model.loads import Load
from kane.space.point import Point
from kane.space.rotation import UNITS, Basis, single
from kane.space.vector import Vector

Route = Callable[[Derived, Partition | None], Solved]
Forces = dict[Point, Vector]


def without_held_forces(route: Route) -> Route:
    """The route taken with what is left of the loads."""

    def solved(derived: Derived, partition: Partition | None) -> Solved:
        held, loads = _held(derived, partition) if partition is not None else ({}, ())
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


def _held(derived: Derived, partition: Partition) -> tuple[Mapping[Constraint, Expr], Sequence[Load]]:
    """The loads' measure numbers along constraints that do not follow from others, and the loads without them."""
    constraints = [derived.constraints.constraints[r] for r in sorted(partition.rows)]
    loaded = _plain(derived.system.loads, {p for c in constraints for p, _ in c.forces})
    left = dict(loaded)
    held: dict[Constraint, Expr] = {}
    waiting = [
        c for c in constraints if not c.torques and len(c.forces) in (1, 2) and all(p in left for p, _ in c.forces)
    ]
    while waiting:  # the plainest force first: what is left is plainer for the others
        found = [(c, *_along(c, left)) for c in waiting]
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
    """The forces of plain loads at points, all of one point together."""
    total: Forces = {}
    for load in loads:
        for p, v in load.forces if _is_plain(load) else ():
            if p in points:
                total[p] = total[p] + v if p in total else v
    return total


def _elsewhere(load: Load, points: Mapping[Point, Vector]) -> Load:
    """The load without its forces at points that are told anew."""
    if not _is_plain(load) or not any(p in points for p, _ in load.forces):
        return load
    return Load(load.name, tuple((p, v) for p, v in load.forces if p not in points), load.torques)


def _along(c: Constraint, loaded: Forces) -> tuple[Expr, Forces]:
    """X of the forces X e, or X e and −X e, along the constraint, and what is left at its points, where that is less."""
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
    """v without x along an axis, over its own frames or along that of the axis."""
    rest = (v - Vector(((frame, UNITS[i]),)) * x).map(collected)
    return min((rest, rest.express(frame).map(collected)), key=lambda w: _scalars([w]))


def _scalars(vectors: Iterable[Vector]) -> tuple[int, int]:
    """Measure numbers that there are, and what they cost."""
    scalars = [x for v in vectors for x in v.scalars() if x is not ZERO]
    return len(scalars), price(scalars)
