# SPDX-License-Identifier: BSD-3-Clause
"""Coordinates without mass: they are moved onto the constraints whatever their unit, and carry no more than they must."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.systems.quick_return import QUICK, START

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def residuals(sol):
    """The largest residual of the constraints, and of their rates."""
    rates = [sol[kn.time_derivative(c.expr)] for c in sol.equations.system.holonomic]
    return max(np.abs(r).max() for r in sol.constraint_residuals.values()), np.abs(rates).max()


def driven_piston():
    """A crank at Ω t moves a piston by a rod without mass: torque T on the crank, force O_x on its bearing."""
    r, l, omega = kn.parameter("r", 0.1, "m"), kn.parameter("l", 0.3, "m"), kn.parameter("Omega", 20.0, "rad/s")
    beta, x = kn.coordinate("beta", "rad"), kn.coordinate("x", "m")
    crank, rod = N.rotate("crank", omega * kn.time, N.z), N.rotate("rod", beta, N.z)
    bearing = O.at("bearing", 0)
    wrist = bearing.at("wrist", r * crank.x + l * rod.x)
    piston = O.at("piston", x * N.x)
    torque, force = kn.reaction("T", frame=crank, along=N.z), kn.reaction("O_x", at=bearing, along=N.x)
    system = kn.System(
        N,
        bodies=[kn.Particle("piston", piston, kn.parameter("m", 1.0, "kg"))],
        speeds="rates",
        holonomic=kn.coincident(wrist, piston, along=(N.x, N.y), name="wrist"),
        reactions=[torque, force],
    )
    return kn.derive(system), torque, force, x


def test_a_rod_without_mass_between_crank_and_piston():
    """T Ω = m ẍ ẋ and O_x = m ẍ, at the dead centres too."""
    eom, torque, force, x = driven_piston()
    given = {"q": {"beta": kn.guess(0), "x": kn.guess(0.4)}, "u": {}, "samples": 41}
    for tolerance in (1e-6, 1e-10):
        sol = kn.simulate(eom, (0, np.pi / 10), rtol=tolerance, atol=tolerance, **given)
        assert max(residuals(sol)) < 1e-12
    angle = 20 * sol.t
    height = np.sqrt(0.3**2 - (0.1 * np.sin(angle)) ** 2)
    slope = -0.1 * np.sin(angle) - 0.1**2 * np.sin(angle) * np.cos(angle) / height
    np.testing.assert_allclose(sol["x"], 0.1 * np.cos(angle) + height, atol=1e-12)
    np.testing.assert_allclose(sol[torque], sol[x.dt.dt] * slope, atol=1e-10)
    np.testing.assert_allclose(sol[force], sol[x.dt.dt], atol=1e-10)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
def test_a_block_without_mass_on_an_arm(tolerance):
    sol = kn.simulate(QUICK, (0, 2), rtol=tolerance, atol=tolerance, samples=101, **START)
    assert max(residuals(sol)) < 1e-12
    assert sol.energy_check.relative < 20 * tolerance
    # the arm's angle, and the block's place on it, from the crank's
    tip = 0.1 * np.exp(1j * sol["th"]) + 0.25j
    np.testing.assert_allclose(np.exp(1j * sol["ps"]), tip / np.abs(tip), atol=1e-12)
    np.testing.assert_allclose(sol["s"], np.abs(tip), atol=1e-12)


def test_parameters_that_no_body_can_have_are_named():
    """Values of parameters are held to what defaults are."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q, x = kn.coordinates("q x")
    m, I = kn.parameter("m", 1.0), kn.parameter("I", 0.5)
    B = N.rotate("B", q, N.z)
    body = kn.RigidBody("disk", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, I, I, I))
    bob = kn.Particle("bob", O.at("P", x * N.x), m)
    eom = kn.derive(kn.System(N, bodies=[body, bob], speeds="rates", loads=[kn.Force(bob.point, 2 * N.x)]))
    start = {"q": [0, 0], "u": [1, 1]}
    assert kn.simulate(eom, (0, 1), **start, parameters={I: 0.1, m: 2}).status == "finished"
    with pytest.raises(kn.SimulationError, match=r"principal moments of inertia ≥ 0 for disk, got -0.3 at the values"):
        kn.simulate(eom, (0, 1), **start, parameters={"I": -0.3})
    with pytest.raises(kn.SimulationError, match="a mass ≥ 0 for bob, got m = -2"):
        kn.simulate(eom, (0, 1), **start, parameters={"m": -2})
    with pytest.raises(
        kn.SimulationError, match=r"finite rates.*bob without mass and inertia at the values of the parameters"
    ):
        kn.simulate(eom, (0, 1), **start, parameters={"m": 0})


@pytest.mark.parametrize("varying", ["time", "place", "speed", "input"])
def test_a_mass_that_varies_is_refused(varying):
    N = kn.Frame("N")
    x = kn.coordinate("x")
    mass = {"time": 2 - kn.time, "place": 1 + x, "speed": 1 + x.dt, "input": kn.input("m")}[varying]
    with pytest.raises(
        kn.ModelError,
        match=r"Expected a constant mass of rocket, got one that depends on .*: the momentum .* ṁ v, would",
    ):
        kn.Particle("rocket", kn.Point("O", fixed_in=N).at("P", x * N.x), mass)
