# SPDX-License-Identifier: BSD-3-Clause
"""Random systems on wheels, blades and disks: accelerations, and the forces of the constraints, against Newton and Euler.

Bodies in redundant coordinates, solved in plain NumPy, say what the equations and the multipliers must give, to
max(1e-9, 100 ε cond A_D), or to four times what changes of the state in its last digit do.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np
import pytest

import kane as kn
from tests.laws.test_regular_states import EPS, States, wide
from tests.oracles.loops.equations import Solution
from tests.systems.rolling import Contact, drawn

Array = Any
STATES, BLOCK, BLOCKS = 2, 20, 10
"""States of each system; systems of each of the full tests, and how many of these."""
ROUNDINGS = 8
"""Changes of a state in its last digit that tell how sensitive accelerations and forces are to it."""


def check(seed: int) -> str:
    """The route taken, where all holds."""
    case, contacts = drawn(seed)
    states = States(case, STATES, np.random.default_rng(seed))
    limit = np.maximum(1e-9, 100 * EPS * states.condition())
    solutions = states.solutions()
    expected = states.by_bodies(solutions)
    size = np.maximum(1, np.abs(expected).max(axis=1))
    for found in (states.by_evaluate(), states.by_code(kn.compile(states.eom), None)["rhs"]):
        off = np.abs(found - expected).max(axis=1)
        assert (off <= limit * size).all() or (off <= np.maximum(limit * size, last_digit(states))).all()
    for contact in contacts:
        compare(states, contact, solutions, limit)
    return states.eom.solved.route


def last_digit(states: States) -> Array:
    """Four times what changes of the states in their last digit do to the accelerations."""
    found, rng = states.by_evaluate(), np.random.default_rng(0)
    changed = []
    for _ in range(ROUNDINGS):
        other = copy(states)
        other.q, other.u = (x * (1 + EPS * rng.choice([-1, 1], x.shape)) for x in (states.q, states.u))
        changed.append(np.abs(other.by_evaluate() - found).max(axis=1))
    return 4 * np.max(changed, axis=0)


def compare(states: States, contact: Contact, solutions: Sequence[Solution], limit: Array) -> None:
    """The force of a contact along the inertial axes, where the oracle's is determined.

    It may be off by what the condition of A_D allows, or by four times what changes of the state in its last digit do: a force that
    holds nearly parallel rolling directions grows with the square of that condition.
    """
    eom, N = states.eom, states.case.system.inertial
    held = zip(contact.constraints, contact.directions, strict=True)
    force = sum((n * eom.multipliers[c] for c, n in held), start=kn.Vector())
    asked = list(force.components(N))

    def at(q: Array, u: Array) -> Array:
        told = eom.evaluate(asked, q=list(q.T), u=list(u.T), inputs=states.inputs)
        return np.stack([wide(x, len(q)) for x in told], axis=-1)[:, :2]

    found, rng = at(states.q, states.u), np.random.default_rng(0)
    rounded = [
        at(*(x * (1 + EPS * rng.choice([-1, 1], x.shape)) for x in (states.q, states.u))) for _ in range(ROUNDINGS)
    ]
    sensitive = 4 * np.abs(np.array(rounded) - found).max(axis=(0, 2))
    for here, one, share, last in zip(found, solutions, limit, sensitive, strict=True):
        reaction = one.reactions[contact.joint]
        level = reaction.determinate[:2]
        assert level.all()
        size = max(1.0, np.abs(one.multipliers).max())
        assert np.abs(here - reaction.force[:2]).max() <= max(share * size, last)


@pytest.mark.slow
def test_a_few_systems():
    routes = {check(seed) for seed in range(8)}
    assert "contacts" in routes


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_hundreds_of_systems(block):
    for seed in range(1000 + block * BLOCK, 1000 + (block + 1) * BLOCK):
        check(seed)
