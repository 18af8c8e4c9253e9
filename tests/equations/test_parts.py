# SPDX-License-Identifier: BSD-3-Clause
"""A body of several parts: a dumb-bell that is one body is the same as two bodies."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.systems.dumbbell import FAR, NEAR, ONE, TWO, B, Dumbbell, L, N, O, derive

STATE = {"q": [0.4, -0.7], "u": [1.1, 0.6]}


@pytest.mark.parametrize(
    "read",
    [
        lambda eom: eom.accelerations,
        lambda eom: eom.reaction_values,
        lambda eom: eom.forcing,
        lambda eom: sum(eom.mass_matrix.rows, ()),
        lambda eom: eom.Fr,
        lambda eom: eom.Fr_star,
        lambda eom: [eom.kinetic_energy, eom.potential_energy, eom.power],
        lambda eom: eom.mass_center(O).components(N),
        lambda eom: eom.linear_momentum().components(N),
        lambda eom: eom.angular_momentum(O).components(N),
        lambda eom: eom.reaction("hinge").force.components(N),
        lambda eom: eom.reaction("hinge").torque.components(N),
    ],
)
def test_results_are_those_of_two_bodies(read):
    one, two = (np.array(eom.evaluate(list(read(eom)), **STATE)) for eom in (ONE, TWO))
    np.testing.assert_allclose(one, two, rtol=1e-14, atol=1e-15)


def test_contributions_are_those_of_the_whole_body():
    (body,) = ONE.system.bodies
    u = ONE.speeds[0]
    assert ONE.evaluate(ONE.Fr_star_contributions[u, body], **STATE) == pytest.approx(
        ONE.evaluate(ONE.Fr_star[0], **STATE), rel=1e-14
    )
    (share,) = ONE.mass_contributions(u, u)
    assert share.body is body
    value = ONE.evaluate(share.translation + share.rotation, **STATE)
    assert value == pytest.approx(ONE.evaluate(ONE.mass_matrix[0, 0], **STATE), rel=1e-14)
    assert [c.place for c in ONE.contributions(u).inertia] == [NEAR, FAR, B]


def test_units_checks_and_motions_know_the_parts():
    sol = kn.simulate(ONE, (0, 0.5), q=STATE["q"], u=STATE["u"])
    other = kn.simulate(TWO, (0, 0.5), q=STATE["q"], u=STATE["u"])
    assert sol[ONE.coordinates[0]][-1] == pytest.approx(other[TWO.coordinates[0]][-1], rel=1e-12)
    assert {p.name for p in ONE.system.parameters} == {"m", "M", "L", "r", "g"}
    long = Dumbbell("dumb-bell", L)
    with pytest.raises(kn.UnitError, match="the mass of dumb-bell"):
        derive(long)
