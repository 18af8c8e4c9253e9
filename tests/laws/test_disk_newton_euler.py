# SPDX-License-Identifier: BSD-3-Clause
"""The sliding disk against Newton's and Euler's equations in redundant coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import rolling_disk
from tests.oracles import disk as oracle
from tests.oracles.compare import error, tolerance

STATES = 100
J = kn.parameter("J", unit="kg m^2", description="moment of inertia about the axis")
I = kn.parameter("I", unit="kg m^2", description="moment of inertia about a diameter")


def any_inertia(C: kn.Frame, m: Any, R: Any) -> kn.Dyadic:
    return kn.inertia(C, I, I, J)


@pytest.fixture(scope="module", params=["thin", "any axisymmetric"])
def case(
    request: pytest.FixtureRequest,
) -> tuple[Any, kn.Equations, list[oracle.Disk], np.ndarray, np.ndarray]:
    """The model and its equations, with a disk, a place and rates for each of the states."""
    thin = request.param == "thin"
    model = rolling_disk.model() if thin else rolling_disk.model(inertia=any_inertia)
    rng = np.random.default_rng(20 if thin else 21)
    disks = [oracle.random_disk(rng, thin) for _ in range(STATES)]
    q, qdot = oracle.random_states(rng, STATES)
    return model, kn.derive(model.system), disks, q, qdot


def evaluate(case: Any, exprs: Any, motions: list[oracle.Motion]) -> np.ndarray:
    """Values of shape (number of expressions, states)."""
    model, eom, disks, q, _ = case
    parameters = {
        model.m: np.array([d.m for d in disks]),
        model.R: np.array([d.R for d in disks]),
        model.g: np.array([d.g for d in disks]),
        model.mu: np.array([d.mu for d in disks]),
    }
    if J in set(eom.parameters):
        parameters[J] = np.array([d.axial for d in disks])
        parameters[I] = np.array([d.diametral for d in disks])
    values = eom.evaluate(
        list(exprs),
        q=dict(zip(model.q, q, strict=True)),
        u=dict(zip(model.u, np.array([x.speeds for x in motions]).T, strict=True)),
        parameters=parameters,
    )
    return np.array([np.broadcast_to(value, (STATES,)) for value in values])


@pytest.fixture(scope="module")
def motions(case: Any) -> list[oracle.Motion]:
    _, _, disks, q, qdot = case
    return [oracle.solve(d, q[:, k], qdot[:, k]) for k, d in enumerate(disks)]


def test_accelerations_and_normal_force(case: Any, motions: list[oracle.Motion]) -> None:
    model, eom, *_ = case
    solved = dict(zip(eom.speeds, eom.accelerations, strict=True))
    groups = {
        "speeds": [solved[u] for u in model.u],
        "a": eom.point_accelerations[model.Cs].components(model.N),
        "alpha": eom.angular_accelerations[model.C].components(model.N),
        "normal": [model.normal],
        "solved normal": eom.reaction_values,
        "slip": model.slip.components(model.N),
    }
    found = {name: evaluate(case, exprs, motions) for name, exprs in groups.items()}
    for k, motion in enumerate(motions):
        limit = tolerance(1e-10, motion.condition)
        expected: dict[str, Any] = {
            "speeds": motion.accelerations,
            "a": motion.a,
            "alpha": motion.alpha,
            "normal": [motion.normal],
            "solved normal": [motion.normal],
            "slip": motion.slip,
        }
        for name, value in expected.items():
            off = error(found[name][:, k], value)
            assert off <= limit, f"{name}, state {k}: off by {off:.1e}, cond {motion.condition:.1e}"


def test_rates(case: Any, motions: list[oracle.Motion]) -> None:
    model, eom, _, _, qdot = case
    rates = dict(zip(eom.coordinates, eom.rates, strict=True))
    assert error(evaluate(case, [rates[x] for x in model.q], motions), qdot) <= 1e-13
    assert error(evaluate(case, [x.dt for x in model.q], motions), qdot) <= 1e-13


def test_energy_is_lost_to_friction(case: Any, motions: list[oracle.Motion]) -> None:
    _, eom, *_ = case
    derivative, power = evaluate(case, [eom.time_derivative(eom.energy), eom.power], motions)
    for k, motion in enumerate(motions):
        limit = tolerance(1e-10, motion.condition)
        for value in (derivative[k], power[k]):
            off = error(value, motion.friction_power)
            assert off <= limit, f"state {k}: off by {off:.1e}, cond {motion.condition:.1e}"
