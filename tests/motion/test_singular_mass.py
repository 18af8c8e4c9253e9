# SPDX-License-Identifier: BSD-3-Clause
"""A start at which the mass matrix does not determine u̇ is refused, whatever rounding leaves of its pivots."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums, spinning_top

UPRIGHT = "got none for u_psi', u_phi' at t = 0: the equations are singular at this state"


@pytest.mark.parametrize("u", [[0, 0, 5.0], [0.1, 0.2, 5.0]])
@pytest.mark.parametrize("unit", [1e-9, 1.0, 3e7])
def test_an_upright_top_by_eulers_angles(u, unit, rng):
    """ψ' and φ' turn about one axis; of moments of inertia in other units it is told as well."""
    eom = kn.derive(spinning_top.system())
    names = {p.name: p for p in eom.parameters}
    inertia = {names[n]: unit * rng.uniform(0.5, 2) for n in ("I", "J")} | {names["m"]: unit}
    with pytest.raises(kn.SimulationError, match=UPRIGHT):
        kn.simulate(eom, (0, 0.1), q=[0, 0, 0], u=u, parameters=inertia)


def test_beside_it_the_top_moves():
    eom = kn.derive(spinning_top.system())
    solution = kn.simulate(eom, (0, 0.1), q=[0, 1e-3, 0], u=[0, 0, 5.0])
    assert np.isfinite(solution[list(eom.speeds)]).all()


@pytest.mark.parametrize("route", ["classical", "recursive", "composite"])
def test_every_route_is_told_whatever_sin_pi_leaves(route):
    """A body with an arm turned by z-x-z angles, the second half a turn: sin π is 1e-16, and so is a pivot along the tree."""
    N = kn.Frame("N")
    turns = [kn.coordinate(f"a{k}", "rad") for k in range(3)]
    B, O = N.rotate_body("B", turns, "zxz"), kn.Point("O", fixed_in=N)
    arm = kn.pin("arm", O.at("P", 0.3 * B.x + 0.1 * B.y), B, axis=B.x)
    tip = arm.point.at("tip", 0.2 * arm.frame.x + 0.1 * arm.frame.z)
    bodies = [
        kn.RigidBody("B", frame=B, mass_center=O.at("C", 0.1 * B.x), mass=5.0, inertia=kn.inertia(B, 1.0, 1.3, 1.7)),
        kn.RigidBody("arm", frame=arm.frame, mass_center=tip, mass=1.0, inertia=kn.inertia(arm.frame, 0.1, 0.12, 0.15)),
    ]
    speeds = {kn.speed(f"u{k}"): q.dt for k, q in enumerate(turns)}
    eom = kn.derive(kn.System(N, bodies=bodies, joints=[arm], speeds={**speeds, **arm.speeds}), route=route)
    u = {"u0": 0.3, "u1": -0.4, "u2": 0.5, "u_arm": 0.6}

    def start(second):
        return kn.simulate(eom, (0, 0.01), q={"a0": 0.7, "a1": second, "a2": -0.9, "q_arm": 0.2}, u=u)

    for _ in range(2):  # the second time by what the first has compiled
        for angle in (np.pi, -np.pi):
            with pytest.raises(kn.SimulationError, match="got none for u0', u2' at t = 0: the equations are singular"):
                start(angle)
        assert start(0.1).status == "finished"


def test_masses_far_apart_are_no_singularity():
    eom = kn.derive(pendulums.system(3))
    names = {p.name: p for p in eom.parameters}
    solution = kn.simulate(
        eom, (0, 0.1), q=[0.1, 0.2, 0.3], u=[0, 0, 0], parameters={names["m1"]: 1e9, names["m3"]: 1e-9}
    )
    assert np.isfinite(solution[list(eom.speeds)]).all()


def test_a_coordinate_without_mass_that_a_constraint_gives():
    """M has a row of zeros, which constraints make up for: the second motion is as the first."""
    N, q, x = kn.Frame("N"), kn.coordinate("q"), kn.coordinate("x")
    O = kn.Point("O", fixed_in=N)
    tip = O.at("tip", N.rotate("A", q, N.z).x)
    shadow = kn.coincident(tip, O.at("shadow", x * N.x), along=(N.x,), name="shadow")
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("tip", tip, 1.0)], holonomic=shadow, speeds="rates"))
    start = {"q": {"q": 1.0, "x": kn.guess(0.5)}, "u": {"u_q": 0.1}}
    first, again = (kn.simulate(eom, (0, 1), samples=3, method="vern9", **start) for _ in range(2))
    np.testing.assert_allclose(first["q"], 1.0 + 0.1 * first.t, rtol=1e-6)
    np.testing.assert_allclose(again.states, first.states, rtol=0, atol=1e-9)


def test_accelerations_have_no_value_there_either():
    """sin π is 1e-16: what is divided by its square is a number, and means nothing. θ'' is not of what is left open."""
    eom = kn.derive(spinning_top.system())
    angles, u = np.array([0.0, 0.1, np.pi, 2.0]), [0.1, 0.2, 5.0]
    for angle in (0.0, np.pi, 1e-9):
        with pytest.raises(kn.SingularError, match="leaves u_psi', u_phi' undetermined"):
            eom.evaluate(eom.accelerations, q=[0, angle, 0], u=u)
        assert np.isfinite(eom.evaluate([*eom.rates, eom.accelerations[1]], q=[0, angle, 0], u=u)).all()
    with pytest.warns(kn.KaneWarning, match="at index 0 and 1 more: the values there are NaN"):
        psi, theta, phi = eom.evaluate(eom.accelerations, q=[0, angles, 0], u=u)
    np.testing.assert_array_equal(np.isnan([psi, phi]), [[True, False, True, False]] * 2)
    assert np.isfinite(theta).all()
