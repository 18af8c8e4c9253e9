# SPDX-License-Identifier: BSD-3-Clause
"""Coordinates without mass: they are moved onto the constraints whatever their unit, and carry no more than they must."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.analysis.manifold import metric, mobility, nearest, reflected, step
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
    assert sol.energy_check.relative < 10 * tolerance
    # the arm's angle, and the block's place on it, from the crank's
    tip = 0.1 * np.exp(1j * sol["th"]) + 0.25j
    np.testing.assert_allclose(np.exp(1j * sol["ps"]), tip / np.abs(tip), atol=1e-12)
    np.testing.assert_allclose(sol["s"], np.abs(tip), atol=1e-12)


@pytest.mark.parametrize("singular", ["one without mass", "two without mass in a chain", "singular with a diagonal"])
def test_units_do_not_matter(singular, rng):
    """x in other units, x = D x': the same step, the same accelerations."""
    a, right, f = rng.normal(size=(3, 5)), rng.normal(size=3), rng.normal(size=5)
    root = rng.normal(size=(5, 5))
    if singular == "one without mass":
        root[0] = 0
    elif singular == "two without mass in a chain":
        root[:2] = 0
        a[0, 1:] = 0
        a[0, :2] = 0.7, -0.3
    else:
        root[:, 3:] = 0
    m = root @ root.T
    plain, other = step(m, a, right), nearest(m, a, f, right)
    np.testing.assert_allclose(a @ plain, right, atol=1e-12)
    np.testing.assert_allclose(a @ other, right, atol=1e-12)
    # the least change: no part of M δ lies along what the constraints leave free
    free = np.linalg.svd(a)[2][3:]
    assert np.abs(free @ m @ plain).max() < 1e-4
    np.testing.assert_allclose(free @ (m @ other - f), 0, atol=1e-10)
    d = np.array([1e5, 1e-4, 1.0, 1e3, 1e-6])
    scaled = d[:, None] * m * d
    np.testing.assert_allclose(d * step(scaled, a * d, right), plain, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(d * nearest(scaled, a * d, d * f, right), other, rtol=1e-7, atol=1e-7)


def test_a_massive_body_hardly_moves_for_one_without_mass():
    """Where a slide without mass can close a constraint, a flywheel of any inertia stays."""
    a = np.array([[0.2, -1.0, 0.0], [0.0, 0.5, -2.0]])
    for inertia in (1e-9, 1.0, 1e9):
        change = step(np.diag([inertia, 0.0, 0.0]), a, np.array([1e-6, -2e-6]))
        np.testing.assert_allclose(a @ change, [1e-6, -2e-6], atol=1e-20)
        assert abs(change[0]) < 1e-4 * abs(change[1])


def test_what_rounding_leaves_of_a_mass_is_none():
    """A partial velocity of 1e-17 where 0 is meant: the other rows are closed all the same."""
    a, right = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]), np.array([0.1, -0.2])
    for mass in (0.0, 1e-34):
        m = np.diag([2.0, 3.0, mass])
        np.testing.assert_allclose(a @ step(m, a, right), right, atol=1e-14)
        np.testing.assert_allclose(step(m, a, right), kkt(m, a, right), atol=1e-6)


def kkt(m, a, right):
    """δ of least δᵀM δ with A δ = right."""
    k = len(a)
    return np.linalg.solve(np.block([[m, a.T], [a, np.zeros((k, k))]]), np.append(np.zeros(len(m)), right))[: len(m)]


def test_what_is_reflected():
    """m (a_i/a)², through a part without mass between; own mass where there is one."""
    a = np.array([[0.2, -1.0, 0.0], [0.0, 0.5, -2.0]])
    np.testing.assert_allclose(reflected(np.array([3.0, 0, 0]), a), [3, 3 / 0.04, 3 / 0.04 * 16])
    np.testing.assert_allclose(reflected(np.zeros(3), a), [0.04, 1, 1])
    np.testing.assert_allclose(reflected(np.array([3.0, 0, 0]), np.zeros((0, 3))), [3, 1, 1])
    s = mobility(np.diag([3.0, 0, 0]), a)
    np.testing.assert_allclose(np.linalg.norm(s, axis=1) ** 2, [1 / 3, 0.04 / 3, 0.04 / 48])
    assert np.isfinite(metric(np.zeros((3, 3)), a)).all()


def test_a_force_on_what_has_no_mass_is_felt_by_what_has():
    """x1 + x2 = r, a force 2 on x2: x1 is pushed back by it."""
    found = nearest(np.diag([4.0, 0.0]), np.array([[1.0, 1.0]]), np.array([0.0, 2.0]), np.array([0.3]))
    np.testing.assert_allclose(found, [-0.5, 0.8])
