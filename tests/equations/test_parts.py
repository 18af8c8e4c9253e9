# SPDX-License-Identifier: BSD-3-Clause
"""A body of several parts: a dumb-bell that is one body is the same as two bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import kane as kn
from kane.model.bodies import Part

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
m, M, L, r = (
    kn.parameter(n, v, u) for n, v, u in (("m", 0.5, "kg"), ("M", 1.2, "kg"), ("L", 0.7, "m"), ("r", 0.1, "m"))
)
g = kn.parameter("g", 9.81, "m/s^2")
HINGE = kn.universal("hinge", O, N, axes=(N.x, N.y))
B = HINGE.frame
NEAR = HINGE.point.at("near", L * B.z)
FAR = HINGE.point.at("far", 3 * L * B.z)


@dataclass(frozen=True, eq=False)
class Dumbbell:
    """A particle and a ball on one rod."""

    name: str
    near: kn.Expr = m

    def parts(self):
        return (Part(self.name, self.near, NEAR), Part(self.name, M, FAR, B, kn.solid_sphere(B, M, r)))


def derive(*bodies):
    push = kn.Force(FAR, 0.3 * N.x + 0.2 * B.y, name="push")
    drag = kn.Torque(B, -0.05 * B.angular_velocity(N), name="drag")
    pull = kn.reaction("R", at=HINGE.point, along=N.z)
    return kn.derive(
        kn.System(N, bodies=bodies, joints=[HINGE], loads=[kn.gravity(-g * N.z), push, drag], reactions=[pull])
    )


ONE = derive(Dumbbell("dumb-bell"))
TWO = derive(
    kn.Particle("particle", NEAR, m),
    kn.RigidBody("ball", frame=B, mass_center=FAR, mass=M, inertia=kn.solid_sphere(B, M, r)),
)
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


def test_a_report_lists_each_part(tmp_path):
    page = kn.report(ONE, tmp_path / "dumbbell.html").read_text()
    assert page.count("<td>dumb-bell</td>") >= 2
    for shown in (repr(ONE), ONE._repr_html_(), ONE.system._repr_html_()):
        assert "dumb-bell" in shown
