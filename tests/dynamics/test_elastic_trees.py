# SPDX-License-Identifier: BSD-3-Clause
"""What is left of the equations of trees with beams, f and M along their segments: those that partial velocities give."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane import free_symbols
from kane.dynamics import derived, mass_matrix
from kane.dynamics import inverse_dynamics as trees
from kane.expr import price, rate
from tests.dynamics.formulation.test_flexible import LOOPS, SYSTEMS, pinned_rod
from tests.systems import flexible

EVERY = {
    **SYSTEMS,
    **LOOPS,
    "pinned rod": lambda: pinned_rod("nonlinear"),
    "arm of four": lambda: flexible.flexible_arm(4),
}


def values(expressions, seed=1):
    """Those of expressions near the straight state."""
    rng = np.random.default_rng(seed)
    symbols = sorted(free_symbols([x for e in expressions for x in e]), key=lambda s: s.name)
    at = {s: s.default if getattr(s, "default", None) is not None else 0.3 * rng.uniform(-1, 1) for s in symbols}
    return [np.array(kn.evaluate(list(e), at), dtype=float) for e in expressions]


@pytest.mark.slow
@pytest.mark.parametrize("name", EVERY)
def test_inverse_dynamics_f_and_m(name):
    d = derived(EVERY[name]())
    u_dot = [rate(u) for u in d.speeds]
    usual = [x - f for x, f in zip(d.mass_matrix @ u_dot, d.forcing, strict=True)]
    found = [trees.residual(d), trees.forcing(d), trees.mass_matrix(d).entries]
    *own, left, f, m = values([*found, usual, d.forcing, d.mass_matrix.entries])
    for a, b in zip(own, (left, f, m), strict=True):
        assert np.abs(a - b).max() <= 1e-12 * np.abs(b).max()


@pytest.mark.slow
def test_operations_grow_as_the_arm():
    counts = [price(kn.derive(flexible.flexible_arm(n)).inverse_dynamics) for n in (3, 4, 5)]
    assert counts[2] - counts[1] <= 1.05 * (counts[1] - counts[0])
    assert counts[2] < 1400


def test_the_shorter_of_both_is_read():
    """M of two booms by stations takes more along the segments."""
    eom = kn.derive(flexible.booms(2, form="nonlinear"))
    along, usual = price(trees.mass_matrix(eom.derived).entries), price(eom.derived.mass_matrix.entries)
    assert price(mass_matrix(eom.solved).entries) == min(along, usual) == usual
