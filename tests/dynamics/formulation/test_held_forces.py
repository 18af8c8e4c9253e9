# SPDX-License-Identifier: BSD-3-Clause
"""Loads along what constraints hold: exactly absent from u̇ and F̃_r, and taken off the reactions that hold it."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane import free_symbols
from kane.expr import as_expr
from kane.gallery import load
from kane.model import constraint_of
from tests.dynamics.formulation.test_shortest import admissible

EACH = ["car_with_trailer", "snakeboard", "n_four_bar", "slider_crank", "knife_edge", "pure_rolling_disk", "rattleback"]
LONG = [pytest.param(name, marks=pytest.mark.slow) for name in ("whipple_bicycle", "andrews_squeezer", "four_bar")]


def pushed(system):
    """The system with a force of its own, an input, along each of its constraints."""
    pushes, loads = [], []
    for k, c in enumerate(system.constraints):
        pushes.append(kn.input(f"X{k}"))
        loads += [kn.Force(p, pushes[-1] * e) for p, e in c.forces]
    return system.replace(loads=[*system.gravities, *system.loads, *loads]), pushes


@pytest.mark.slow
@pytest.mark.parametrize("name", [*EACH, *LONG])
def test_a_force_along_each_constraint_changes_its_reaction_alone(name, rng):
    system = load(name).system()
    usual = kn.derive(system)
    loaded, pushes = pushed(system)
    eom = kn.derive(loaded)
    n = len(eom.independent_speeds)
    for read in (eom.accelerations, eom.Fr_nh[:n], eom.forcing_nh):
        assert not set(free_symbols(map(as_expr, read))) & set(pushes)
    values = dict(zip(pushes, rng.uniform(1, 2, len(pushes)) * 1e12, strict=True))
    quiet = dict.fromkeys(usual.inputs, 0.3)
    for q, u in admissible(usual, name, rng, 2):
        here, there = {"q": q, "u": u, "inputs": quiet}, {"q": q, "u": u, "inputs": quiet | values}
        for read in ("accelerations", "forcing_nh"):
            assert eom.evaluate(list(getattr(eom, read)), **there) == usual.evaluate(list(getattr(usual, read)), **here)
        small = {**there, "inputs": quiet | {x: v / 1e12 for x, v in values.items()}}
        before = np.array(usual.evaluate(list(usual.multipliers.values()), **here), dtype=float)
        after = np.array(eom.evaluate(list(eom.multipliers.values()), **small), dtype=float)
        size = np.abs(before).max() + 2
        assert before - after == pytest.approx(np.array([v / 1e12 for v in values.values()]), abs=1e-9 * size)
        of = dict(zip(usual.reactions, usual.evaluate(list(usual.reactions), **here), strict=True))
        now = dict(zip(eom.reactions, eom.evaluate(list(eom.reactions), **small), strict=True))
        for r, x in of.items():
            c = constraint_of(r)
            push = values[pushes[list(system.constraints).index(c)]] / 1e12 if c is not None else 0.0
            assert now[r] == pytest.approx(x - push, abs=1e-9 * size)


def test_what_is_not_along_it_stays(rng):
    """A wind across the sleigh at its blade: what pushes along the heading is left, and what reads F̃_r by load still tells of all."""
    system = load("chaplygin_sleigh").system()
    edge = system.constraints[0]
    (P, _), wind, N = edge.forces[0], kn.input("wind"), system.inertial
    eom = kn.derive(system.replace(loads=[*system.loads, kn.Force(P, wind * N.x, name="wind")]))
    for q, u in admissible(kn.derive(system), "chaplygin_sleigh", rng, 2):
        state = {"q": q, "u": u, "inputs": {"wind": 2.0}}
        heading = eom.evaluate(system.coordinates[2], **state)
        calm = eom.evaluate(list(eom.accelerations), q=q, u=u, inputs={"wind": 0.0})
        pushed = eom.evaluate(list(eom.accelerations), **state)
        mass = next(p.default for p in eom.parameters if p.name == "m")
        assert pushed[0] - calm[0] == pytest.approx(2 * np.cos(heading) / mass, rel=1e-9)
    assert wind in set(free_symbols([eom.Fr[1]]))


def test_loads_that_hold_reactions_are_left_alone():
    """Friction by the reaction of the edge that a load pushes against."""
    system = load("chaplygin_sleigh").system()
    edge = system.constraints[0]
    P, across = edge.forces[0]
    push, grip = kn.input("push"), kn.parameter("grip", 0.1)
    drag = kn.Force(P, -grip * system.reactions[0] * across.cross(system.inertial.z), name="drag")
    eom = kn.derive(system.replace(loads=[*system.loads, drag, kn.Force(P, push * across)]))
    assert push in set(free_symbols(eom.accelerations))
    assert eom.solved.lightened is None
