# SPDX-License-Identifier: BSD-3-Clause
"""Reflected inertia (Featherstone 2008, sec. 9.6) of bodies geared to a joint, as the rotor of a motor or a counterweight.

A body that moves in the ground at a constant ratio to one joint speed w, along a line or about an axis through its mass centre, has
the kinetic energy a w² / 2 with constant a, and affects no other joint: a is added to M at that joint speed, and the body is no
segment of the tree.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from itertools import chain
from typing import NamedTuple

from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.carried import Inertias, falling, inertias_of, rigid_body
from kane.expr.build import add, div, mul, sub
from kane.expr.differentiation import affine_forms, time_derivative
from kane.expr.evaluation import is_constant_in_time
from kane.expr.matrix import dot
from kane.expr.node import ONE, ZERO, Expr
from kane.kinematics.links import Link, Tree
from kane.kinematics.segments import Segments
from kane.space.rotation import Basis, cross3, product
from kane.space.vector import Vector
from kane.tree.triples import is_zero, triple
from kane.tree.values import Reflected


class _Turn(NamedTuple):
    """The basis and the rate of a body that moves in the ground, and the inertia reflected to a joint with that rate."""

    basis: Basis
    rate: Expr
    own: Reflected


Geared = Mapping[int, _Turn]
"""Links, by number, that move in the ground by rates of other joints."""


def geared_to_ground(derived: Derived, tree: Tree, kept: Collection[int]) -> Geared:
    """The links geared to other joints that have no children, forces, reactions or constraints, except those `kept`."""
    busy = {*kept, *(number for number, _ in tree.places.values()), *(link.parent for link in tree.links)}
    rates, count = derived.kinematics.aligned.rates, Counter(link.basis for link in tree.links)
    torques: dict[Basis, list[Vector]] = {}
    for load in derived.declared_loads:
        for frame, torque in load.torques:
            torques.setdefault(rates(frame)[0], []).append(torque)
    held = [rates(frame)[0].lineage for c in derived.constraints.constraints for frame, _ in c.torques]
    crowded = {*chain(*held, *(basis.lineage[1:] for basis in torques)), *(b for b in torques if count[b] > 1)}
    crowded.discard(derived.system.inertial)
    found, inertias = dict[int, _Turn](), inertias_of(derived)
    for k, link in enumerate(tree.links):
        if link.parent == 0 and link.parts and k not in busy and link.basis not in crowded:
            turn = _turning(derived, inertias, link, torques.get(link.basis, ()))
            if turn is not None:
                found[k] = turn
    others = {s for k, link in enumerate(tree.links) if k not in found for s in link.rates}
    return {k: turn for k, turn in found.items() if turn.rate in others}


def _turning(derived: Derived, inertias: Inertias, link: Link, torques: Iterable[Vector]) -> _Turn | None:
    """The motion of a link by one rate, about a fixed axis through its mass centre and along a fixed line; None of another motion."""
    if any(part.momenta for part, _ in link.parts):
        return None
    slide = link.offset.map(time_derivative).components(derived.system.inertial)
    forms = affine_forms((*link.rotation.components(link.basis), *slide), derived.kinematical.rates)
    by = {s for row, _ in forms for s in row}
    if len(by) != 1 or any(rest is not ZERO for _, rest in forms):
        return None
    (b,) = by
    axes = [row.get(b, ZERO) for row, _ in forms]
    spin, along = triple(axes[:3]), triple(axes[3:])
    body = rigid_body(inertias, link)
    if not is_constant_in_time(axes) or not is_zero(cross3(spin, body.h)):
        return None
    inertia = add(mul(body.m, dot(along, along)), dot(spin, product(body.j, spin)))
    force = mul(body.m, dot(along, falling(derived)))
    for torque in torques:
        force = sub(force, dot(spin, derived.kinematics.aligned.vector(torque).components(link.basis)))
    return _Turn(link.basis, b, Reflected(inertia, force))


def reflected_to_joints(derived: Derived, segments: Segments, geared: Geared) -> Mapping[int, Reflected]:
    """The reflected inertias by number of the joint speed; empty if a rate is not in constant ratio to any joint speed."""
    rows = [f.row for step in segments.steps for f in (*step.slide.freedoms, *step.spin.freedoms)]
    result: dict[int, Reflected] = {}
    for turn in geared.values():
        (form,) = derived.kinematics.speeds.forms([turn.rate])
        alone = len(form.coefficients) == 1 and form.rest is ZERO
        by = {turn.rate: ONE, **(form.coefficients if alone else {})}
        ratios = {k: div(by[s], c) for k, row in enumerate(rows) if len(row) == 1 for s, c in row.items() if s in by}
        number = next((k for k, x in ratios.items() if is_constant_in_time([x])), None)
        if number is None:
            return {}
        ratio, before = ratios[number], result.get(number, Reflected(ZERO, ZERO))
        inertia, force = mul(mul(ratio, ratio), turn.own.inertia), mul(ratio, turn.own.force)
        result[number] = Reflected(add(before.inertia, inertia), add(before.force, force))
    return result
