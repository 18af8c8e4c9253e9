# SPDX-License-Identifier: BSD-3-Clause
"""The motion does not depend on the choice of generalized speeds, for every system of the gallery.

A state is given as (q, q'). Each choice of speeds turns it into its own (q, u) by its definitions and must then find the same
q'', the same accelerations of all bodies, the same reactions, energies and power.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from tests.gallery.cases import CASES, Case, States, equations, random_states
from tests.oracles.compare import tolerance

STATES = 25
PAIRS = [pytest.param(c, s, id=f"{c.name}, {s}") for c in CASES for s in c.speeds[1:]]
ALL = [pytest.param(c, s, id=f"{c.name}, {s}") for c in CASES for s in c.speeds]


def off(value: Any, expected: Any) -> Any:
    """Largest difference over the largest expected magnitude, at least 1, for each state (the last axis)."""
    return np.abs(value - expected).max(axis=0) / np.maximum(1.0, np.abs(expected).max(axis=0))


def limit(states: States, *eoms: kn.Equations) -> Any:
    """1e-10, or 100 eps cond for each state, with the largest of the condition numbers of Y and M."""
    conditions = [np.linalg.cond(states.matrix(e, m)) for e in eoms for m in (e.Y, e.mass_matrix)]
    return np.array([tolerance(1e-10, c) for c in np.max(conditions, axis=0)])


def motion(eom: kn.Equations) -> dict[str, list[Any]]:
    """What may not depend on the speeds."""
    N = eom.system.inertial
    found = {
        "q''": [eom.time_derivative(r) for r in eom.rates],
        "energies and power": [eom.kinetic_energy, eom.potential_energy, eom.power],
    }
    for b in (part for body in eom.system.bodies for part in body.parts()):
        found[f"acceleration of {b.name}"] = list(eom.point_accelerations[b.mass_center].components(N))
        if b.frame is not None:
            found[f"angular velocity of {b.name}"] = list(eom.angular_velocities[b.frame].components(N))
            found[f"angular acceleration of {b.name}"] = list(eom.angular_accelerations[b.frame].components(N))
    if eom.reactions:
        found["reactions"] = list(eom.reactions)
    return found


def test_every_system_has_three_choices_of_speeds() -> None:
    for case in CASES:
        assert len(case.speeds) >= 3
        assert "rates" in case.speeds


@pytest.mark.slow
@pytest.mark.parametrize(("case", "speeds"), ALL)
def test_rates_are_recovered(case: Case, speeds: str) -> None:
    eom, states = equations(case, speeds), random_states(case, STATES)
    found = states.evaluate(eom, eom.rates)
    assert np.all(off(found, np.array(list(states.rates.values()))) <= limit(states, eom))


@pytest.mark.parametrize(("case", "speeds"), ALL)
def test_second_derivative_of_coordinates_has_two_names(case: Case, speeds: str) -> None:
    eom, states = equations(case, speeds), random_states(case, 3)
    found = states.evaluate(eom, [q.dt.dt for q in eom.coordinates])
    np.testing.assert_allclose(found, states.evaluate(eom, [eom.time_derivative(r) for r in eom.rates]), rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("case", "speeds"), PAIRS)
def test_accelerations(case: Case, speeds: str) -> None:
    first, second = equations(case, case.speeds[0]), equations(case, speeds)
    states = random_states(case, STATES)
    bound = limit(states, first, second)
    one, two = motion(first), motion(second)
    assert list(one) == list(two)
    for name, exprs in one.items():
        expected = states.evaluate(first, exprs)
        assert np.all(np.isfinite(expected)), name
        gap = off(states.evaluate(second, two[name]), expected)
        assert np.all(gap <= bound), f"{name}: off by {gap.max():.1e}, state {np.argmax(gap - bound)}"


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=str)
def test_simulated_motion(case: Case) -> None:
    states = random_states(case, 1, seed=case.start)
    ends = []
    for speeds in case.speeds:
        eom = equations(case, speeds)
        q = {x: float(v[0]) for x, v in states.q.items()}
        u = {x: float(v[0]) for x, v in states.speeds(eom.system).items()}
        t = float(states.t[0])
        sol = kn.simulate(eom, (t, t + 0.4), q=q, u=u, rtol=1e-10, atol=1e-12, samples=3)
        assert sol.status == "finished", f"{speeds}: {sol.message}"
        assert sol.energy_check.relative < 1e-7, f"{speeds}: {sol.energy_check}"
        ends.append(sol.q[-1])
    for speeds, end in zip(case.speeds, ends, strict=True):
        np.testing.assert_allclose(end, ends[0], rtol=1e-8, atol=1e-8, err_msg=speeds)
