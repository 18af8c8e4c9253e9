# SPDX-License-Identifier: BSD-3-Clause
"""Every way to u̇ and the reactions that is looked at gives the numbers of the classical route, and the shortest is taken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kane as kn
from kane import count_operations, free_symbols
from kane.dynamics import LARGE, classical, holds_reactions, touches, unguarded_classical
from kane.dynamics import candidates as routes
from kane.expr import price
from kane.gallery import GALLERY, load, rolling_disk
from tests.systems.closed_states import states

CONSTRAINED = [name for name in GALLERY if load(name).system().constraints]
NEAR = 0.05
"""How far about the start of the gallery coordinates are drawn."""


def every_way(eom):
    """Each solution that is looked at, and the classical one."""
    derived, partition = eom.derived, eom.embedding.partition
    coupled = holds_reactions(derived)
    usual = unguarded_classical(derived, partition)
    e, own = usual.embedding, routes.Candidate(usual, None if coupled else routes.all_speeds(derived))
    touching = touches(derived.constraints.constraints, partition.rows, derived.kinematics)
    others = [c for group in routes.by_rates(derived, e, touching, coupled, large=False) for c in group]
    if not coupled:
        others += routes.in_declared_speeds(derived, e, touching, large=False)
    for found in (own, *others):
        for u_dot in routes.with_dependent(derived, e, found, large=False):
            whole = routes.with_reactions(found, u_dot, derived, e)
            yield whole
            if derived.reactions:
                known = found._replace(solution=replace(found.solution, reactions=whole.reactions))
                yield routes.with_reactions(known, u_dot, derived, e, differentiated=True)


def admissible(eom, name, rng, count):
    """States on the constraints."""
    start = getattr(load(name), "START", None)
    if start is None:
        yield from states(eom, rng, count, reach=0.8)
        return
    inputs = dict.fromkeys(eom.inputs, 0.3)
    first = kn.assemble(eom, q=start["q"], u=start.get("u"), inputs=inputs)
    for _ in range(count):
        q = {s: kn.guess(x + rng.uniform(-NEAR, NEAR)) for s, x in first.q.items()}
        at = kn.assemble(eom, q=q, u={u: rng.normal() for u in eom.independent_speeds}, inputs=inputs)
        yield at.q, at.u


@pytest.mark.slow
@pytest.mark.parametrize("name", CONSTRAINED)
def test_every_way_gives_the_numbers_of_the_classical_route(name, rng):
    eom = kn.derive(load(name).system())
    usual = classical(eom.derived, eom.embedding.partition)
    every = list(every_way(eom))
    assert len(every) >= 3
    for q, u in admissible(eom, name, rng, 3):
        inputs = dict.fromkeys(eom.inputs, 0.3)
        wanted, *found = (
            np.array(eom.evaluate([*s.accelerations, *s.reactions], q=q, u=u, inputs=inputs), dtype=float)
            for s in (usual, *every)
        )
        for numbers, s in zip(found, every, strict=True):
            assert np.abs(numbers - wanted).max() <= 1e-10 * np.abs(wanted).max(), s.route


@pytest.mark.slow
@pytest.mark.parametrize("name", CONSTRAINED)
def test_the_shortest_of_them_is_taken(name):
    eom = kn.derive(load(name).system())
    usual = classical(eom.derived, eom.embedding.partition)
    taken = eom.solved.operations.total
    assert taken <= usual.operations.total
    if usual.operations.total < LARGE:
        every = (s.guarded() for s in every_way(eom))
        assert taken <= min(count_operations((*eom.rates, *s.accelerations, *s.reactions)).total for s in every)


def test_ways_are_compared_by_what_is_counted():
    for name in CONSTRAINED[:4]:
        solved = kn.derive(load(name).system()).solved
        roots = (*solved.right_hand_side, *solved.reactions)
        assert price(roots) == count_operations(roots).total


def test_a_load_that_holds_a_reaction_is_left_to_the_classical_route():
    """Rolling that is braked by a torque in proportion to the normal force: u̇ and the force are solved for together."""
    m = rolling_disk.model(contact="rolling")
    mu = kn.parameter("mu_r", 0.01, "m")
    brake = kn.Torque(m.C, -mu * m.normal * m.C.z, name="rolling resistance")
    eom = kn.derive(m.system.replace(loads=[*m.system.loads, brake]))
    assert eom.solved.route in ("classical", "contacts")
    assert m.normal not in set(free_symbols(eom.solved.accelerations))
    assert mu in set(free_symbols(eom.solved.accelerations))
