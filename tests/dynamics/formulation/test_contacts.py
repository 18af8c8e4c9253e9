# SPDX-License-Identifier: BSD-3-Clause
"""Velocities through contacts: the classical route's numbers, in fewer operations, and no pole that the classical route has not."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane import free_symbols
from kane.dynamics import classical
from kane.gallery import GALLERY, load, pure_rolling_disk, rolling_disk

ROLLING = ("pure_rolling_disk", "rattleback", "car_with_trailer", "chaplygin_sleigh", "knife_edge", "whipple_bicycle")
SPECIAL = (0.0, np.pi / 2, -np.pi / 2, np.pi)


def both(eom):
    """u̇ and reactions by the route taken and by the classical one."""
    usual = classical(eom.derived, eom.embedding.partition)
    return [(*s.accelerations, *s.reactions) for s in (eom.solved, usual)]


def on_constraints(eom, rng, q):
    """A state with those coordinates, parameters at their defaults, and speeds that the constraints admit."""
    at = {p: p.default for p in eom.parameters} | dict(zip(eom.coordinates, q, strict=True))
    at |= dict.fromkeys(eom.inputs, 0.3) | dict(zip(eom.speeds, rng.normal(size=len(eom.speeds)), strict=True))
    roots = [*both(eom)[0], *eom.A_n.entries, *eom.b_n]
    at |= {s: 0.1 for s in free_symbols(roots) if s not in at}
    with np.errstate(all="ignore"):
        a_n = np.array(kn.evaluate(list(eom.A_n.entries), at), dtype=float).reshape(eom.A_n.shape)
        b_n = np.array(kn.evaluate(list(eom.b_n), at), dtype=float)
    own = np.array([at[u] for u in eom.independent_speeds])
    return at | dict(zip(eom.dependent_speeds, a_n @ own + b_n, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("name", GALLERY)
def test_the_route_is_taken_where_bodies_roll_and_is_shorter(name):
    eom = kn.derive(load(name).system())
    assert (eom.solved.route == "contacts") == (name in ROLLING)
    if eom.solved.route == "contacts":
        usual = classical(eom.derived, eom.embedding.partition)
        assert eom.solved.operations.total < usual.operations.total


@pytest.mark.slow
@pytest.mark.parametrize("name", ROLLING)
def test_the_numbers_are_those_of_the_classical_route(name, rng):
    eom = kn.derive(load(name).system())
    here, usual = both(eom)
    for _ in range(10):
        at = on_constraints(eom, rng, rng.uniform(-0.6, 0.6, len(eom.coordinates)))
        wanted = np.array(kn.evaluate(usual, at), dtype=float)
        assert np.array(kn.evaluate(here, at), dtype=float) == pytest.approx(wanted, rel=1e-11, abs=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("name", ROLLING)
def test_no_pole_is_added(name, rng):
    """Each coordinate at each multiple of a right angle: where the classical route is regular, this one gives the same."""
    eom = kn.derive(load(name).system())
    routes, seen = both(eom), 0
    for k in range(len(eom.coordinates)):
        for special in SPECIAL:
            q, seed = rng.uniform(-0.6, 0.6, len(eom.coordinates)), rng.integers(1 << 30)
            with np.errstate(all="ignore"):
                numbers = []
                for near in (0.0, 1e-6, -1e-6):
                    q[k] = special + near
                    at = on_constraints(eom, np.random.default_rng(seed), q)
                    numbers.append([np.array(kn.evaluate(e, at), dtype=float) for e in routes])
            (found, wanted), (_, after), (_, before) = numbers
            size = np.abs(wanted).max()
            if np.isfinite(size) and np.abs(wanted - (before + after) / 2).max() <= 1e-6 * size:
                seen += 1
                assert np.abs(found - wanted).max() <= 1e-9 * size
    assert seen > 2 * len(eom.coordinates)


def test_the_disk_reads_as_by_hand():
    eom = kn.derive(pure_rolling_disk.system())
    _, u2, u3 = eom.independent_speeds
    assert str(eom.accelerations[2]) == "2*u1*u2/3"
    assert set(free_symbols([eom.accelerations[0]])) >= {u2, u3}


def test_forces_at_the_contact_are_exactly_absent():
    """A force on the particle in contact contributes nothing, however large it is."""
    m = rolling_disk.model(contact="rolling")
    push = kn.parameter("push", 1e12, "N")
    system = m.system.replace(loads=[*m.system.loads, kn.Force(m.Ch, push * m.N.x + push * m.N.y, name="push")])
    eom = kn.derive(system)
    assert push not in set(free_symbols(eom.accelerations))
    assert push in set(free_symbols(eom.solved.reactions))


@pytest.mark.parametrize("given", [(0, 1), (0, 2)])
def test_other_dependent_speeds_are_solved_for(given, rng):
    """A choice by which the constraints are divided by angles leaves the speeds as they are."""
    system = pure_rolling_disk.system()
    speeds = list(system.speeds)
    names = [speeds[4 - k] for k in given]
    eom = kn.derive(system.replace(dependent_speeds=names))
    here, usual = both(eom)
    at = on_constraints(eom, rng, rng.uniform(0.2, 0.5, len(eom.coordinates)))
    found, wanted = (np.array(kn.evaluate(e, at), dtype=float) for e in (here, usual))
    assert found == pytest.approx(wanted, rel=1e-10, abs=1e-10)
    assert (eom.solved.route == "contacts") == (set(given) == {0, 1})


def test_the_whole_contact_force_of_a_wheel_is_two_reactions(rng):
    """That in the tree and that of rolling, together m (a^C* + g): Newton's law for the mass centre."""
    m = rolling_disk.model(contact="rolling")
    eom = kn.derive(m.system)
    whole = eom.reaction(m.P).force + eom.reaction(m.rolling).force
    law = m.m * (eom.point_accelerations[m.Cs] + m.g * m.N.z)
    u_dot = {u.dt: x for u, x in zip(eom.speeds, eom.accelerations, strict=True)}
    wanted = [kn.substitute(x, u_dot) for x in law.components(m.N)]
    q, u = rng.uniform(-0.5, 0.5, 5), dict(zip(("u1", "u2", "u3"), rng.normal(size=3), strict=True))
    numbers = np.array(eom.evaluate([*whole.components(m.N), *wanted], q=q, u=u), dtype=float)
    assert numbers[:3] == pytest.approx(numbers[3:], rel=1e-11, abs=1e-11)
