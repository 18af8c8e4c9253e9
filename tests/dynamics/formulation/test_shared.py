# SPDX-License-Identifier: BSD-3-Clause
"""Recursions of trees whose joints share coordinates: the accelerations, reactions and multipliers of the classical route."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import WAYS
from tests.examples import examples
from tests.oracles.compare import tolerance
from tests.systems import shared
from tests.systems.closed_states import states


def off(system):
    """The largest difference of what the recursions give from the classical route, over the largest value and what rounding allows.

    None where no recursion expresses the tree.
    """
    usual, rng = kn.derive(system, route="classical"), np.random.default_rng(1)
    try:
        recursions = [kn.derive(system, route=route) for route in WAYS]
    except kn.ModelError as error:
        assert "turn in others by several absolute angles" in str(error)  # noqa: PT017
        return None
    if system.constraints:
        given_states = list(states(usual, rng, 2, reach=1.0))
    else:
        given_states = [tuple(rng.uniform(-1, 1, (2, len(usual.speeds)))) for _ in range(2)]
    worst = 0.0
    for q, u in given_states:
        size = tolerance(1e-9, np.linalg.cond(np.array(usual.evaluate(usual.mass_matrix, q=q, u=u))) ** 2)
        wanted, *found = (
            np.array(e.evaluate([*e.accelerations, *e.reactions, *e.multipliers.values()], q=q, u=u))
            for e in (usual, *recursions)
        )
        worst = max(worst, *(np.abs(x - wanted).max() / (np.abs(wanted).max() * size) for x in found))
    return worst


@examples(0.2)
@given(st.integers(0, 10**6), st.integers(2, 6), st.integers(1, 3), st.sampled_from(["rates", "mixed"]))
def test_trees(seed, bodies, coordinates, chosen):
    found = off(shared.system(seed, bodies, min(coordinates, bodies), chosen=chosen))
    assert found is None or found <= 1


@pytest.mark.slow
@examples(0.2)
@given(st.integers(0, 10**6), st.integers(2, 6), st.integers(2, 3), st.sampled_from(["rates", "mixed"]))
def test_trees_on_an_edge(seed, bodies, coordinates, chosen):
    found = off(shared.system(seed, bodies, min(coordinates, bodies), chosen=chosen, held=True))
    assert found is None or found <= 1


@pytest.mark.slow
@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_most_are_expressed(seed, held):
    assert off(shared.system(seed, 3 + seed, 2, held=held)) <= 1


def follower() -> kn.System:
    """A wheel that drives another by teeth, and lifts a rod by a cam; a block hangs on the rod by a spring."""
    N, g = kn.Frame("N"), kn.parameter("g", 9.81)
    O = kn.Point("O", fixed_in=N)
    q, s = kn.coordinates("q s")
    A, B = N.rotate("A", q, N.z), N.rotate("B", -3 * q, N.z)
    rod = O.at("rod", (0.5 + 0.1 * kn.cos(2 * q)) * N.y)
    block = rod.at("block", (0.2 + s) * N.y)
    J = kn.parameter("J", 0.3)
    bodies = [
        kn.RigidBody("wheel", frame=A, mass_center=O, mass=2.0, inertia=kn.inertia(A, J, J, 2 * J)),
        kn.RigidBody(
            "pinion", frame=B, mass_center=O.at("C", 0.4 * N.x), mass=0.5, inertia=kn.inertia(B, 0.1, 0.1, 0.2)
        ),
        kn.Particle("rod", rod, 0.7),
        kn.Particle("block", block, 0.4),
    ]
    return kn.System(
        N,
        bodies=bodies,
        speeds="rates",
        loads=[kn.gravity(-g * N.y), kn.Force(block, -30 * s * N.y), kn.Force(rod, 30 * s * N.y)],
    )


@pytest.mark.parametrize("route", WAYS)
def test_wheels_with_teeth_and_a_cam(route):
    """By hand: M q̈ of wheel, pinion and what the cam lifts, y = 0.5 + 0.1 cos 2q; the block at y + 0.2 + s."""
    eom = kn.derive(follower(), route=route)
    q, s, w, v = 0.4, 0.1, 1.7, -0.6
    slope, bend = -0.2 * np.sin(2 * q), -0.4 * np.cos(2 * q)
    mass = np.array([[0.6 + 9 * 0.2 + 1.1 * slope**2, 0.4 * slope], [0.4 * slope, 0.4]])
    lift = 9.81 + bend * w**2
    right = [-1.1 * slope * lift, -0.4 * lift - 30 * s]  # the spring's forces on both have no power but for s'
    found = eom.evaluate(eom.accelerations, q=[q, s], u=[w, v])
    assert np.array(found) == pytest.approx(np.linalg.solve(mass, right), rel=1e-12)
    assert eom.route == route


@pytest.mark.parametrize("seed", range(3))
def test_gears_in_larger_trees(seed):
    """By default they are derived by the recursion, which is shorter there."""
    system = shared.system(seed, 5, 2)
    found, usual = (
        kn.derive(system, **route).compile().operations["rhs"].total for route in ({}, {"route": "classical"})
    )
    assert found < 0.9 * usual
