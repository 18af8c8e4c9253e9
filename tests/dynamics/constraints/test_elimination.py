# SPDX-License-Identifier: BSD-3-Clause
"""Solutions at ordinary states where an order of elimination that is fixed would divide by zero.

The multiplier form [M −Aᵀ; A 0] [u̇; λ] = [f; −(Ȧ u + ḃ)], solved in numbers by least squares, is the independent route: it holds
wherever A has its rank, whatever speeds are dependent.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.systems.rotated_wheel import rotated_wheel

EPS = np.finfo(float).eps


def derived(system, dependent=None):
    """Equations with dependent speeds by place."""
    if dependent is None:
        return kn.derive(system)
    speeds = tuple(system.speeds)
    return kn.derive(system.replace(dependent_speeds=[speeds[k] for k in dependent]))


def numbers(eom, what, q, u):
    return np.array(eom.evaluate(what, q=q, u=u), dtype=float)


def by_multipliers(eom, q, u):
    """u̇ from M, A, f and the drift."""
    M, A = (numbers(eom, x, q, u) for x in (eom.mass_matrix, eom.A))
    f, drift = numbers(eom, list(eom.forcing), q, u), numbers(eom, list(eom.constraints.drift), q, u)
    n, m = len(M), len(A)
    whole = np.block([[M, -A.T], [A, np.zeros((m, m))]])
    return np.linalg.lstsq(whole, np.concatenate([f, -drift]), rcond=1e-13)[0][:n]


def condition(eom, q, u):
    p = eom.embedding.partition
    return np.linalg.cond(numbers(eom, eom.A, q, u)[np.ix_(p.rows, p.dependent)])


def check(eom, q, u):
    """`evaluate` and the compiled right-hand side give what the multiplier form gives."""
    wanted = by_multipliers(eom, q, u)
    limit = max(1e-10, 100 * EPS * condition(eom, q, u)) * max(1.0, np.abs(wanted).max())
    assert np.abs(numbers(eom, list(eom.accelerations), q, u) - wanted).max() <= limit
    x = np.concatenate([q, u])
    assert np.abs(kn.compile(eom).rhs(0.0, x)[len(q) :] - wanted).max() <= limit


WHEEL = derived(rotated_wheel(), (0, 1))


@pytest.mark.parametrize("yaw", [np.pi / 2, np.pi / 2 + 1e-8, -np.pi / 2, 0.0, 1e-8, np.pi, 0.4])
def test_a_wheel_whose_dependent_block_is_a_rotation(yaw):
    spin = 1.7
    forward = 0.3 * spin
    assert WHEEL.pivots == ()
    check(WHEEL, np.array([0.1, 0.2, yaw, 0.4]), np.array([forward * np.cos(yaw), forward * np.sin(yaw), 0.9, spin]))
