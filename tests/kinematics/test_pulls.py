# SPDX-License-Identifier: BSD-3-Clause
"""Rows of constraints along the tree are those of the partial velocities, in operations that grow as the tree."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.dynamics import derived
from kane.kinematics import placed_form, rows_along_tree
from tests.dynamics.formulation.test_recursive import state
from tests.systems import jointed, rings


def closing(system: kn.System, seed: int) -> list[kn.Constraint]:
    """Rods, a plane and directions held between bodies of a tree, and to the ground."""
    rng = np.random.default_rng(seed)
    N, bodies = system.inertial, system.bodies
    O = next(p for p in system.points if p.parent is None)
    a, b = (bodies[k] for k in rng.choice(len(bodies), 2, replace=False))
    P = a.mass_center.at("P", a.frame.x * 0.3 + a.frame.z * 0.1)
    Q = b.mass_center.at("Q", b.frame.y * 0.2)
    return [
        kn.distance(P, Q, 1.5),
        kn.distance(Q, O, kn.parameter("L", 1.1)),
        *kn.coincident(P, O, along=(N.x, N.z)),
        *kn.coincident(P, Q, along=(b.frame.y,)),
        kn.perpendicular(a.frame.x, b.frame.z),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_rows_of_trees_of_any_joints(seed):
    plain = jointed.system(seed, 3 + seed % 3)
    plain = jointed.by_mixed_speeds(plain, seed) if seed % 2 else plain
    constraints = closing(plain, seed)
    kinematics = derived(plain).kinematics
    found = rows_along_tree(constraints, kinematics)
    assert len(found) == len(constraints)
    for c in constraints:
        own, usual = found[c], placed_form(c, kinematics)
        speeds = dict.fromkeys((*own.coefficients, *usual.coefficients))
        roots = [f.coefficients.get(u, kn.expr.ZERO) for f in (own, usual) for u in speeds] + [
            own.rest,
            usual.rest,
        ]
        values = np.array(kn.evaluate(roots, state(roots, 1)), dtype=float)
        n = len(speeds)
        size = np.abs(values[:n]).max()
        assert np.abs(values[:n] - values[n : 2 * n]).max() <= 1e-12 * size
        assert abs(values[-1] - values[-2]) <= 1e-11 * max(size, abs(values[-1]))


@pytest.mark.slow
def test_a_long_ring_is_derived_in_operations_that_grow_as_it_does():
    """A, the lengths of the loop and u̇."""
    counts = []
    for n in (20, 40):
        eom = kn.derive(rings.ring(n, spatial=True))
        counts.append([kn.count_operations(x).total for x in (eom.A.entries, [c.expr for c in eom.system.holonomic])])
        assert eom.route == "recursive"
    for few, many in zip(*counts, strict=True):
        assert many / few < 2.2
