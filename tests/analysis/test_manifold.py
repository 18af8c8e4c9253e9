# SPDX-License-Identifier: BSD-3-Clause
"""Back onto the constraints by the least change in the mass metric."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.analysis.manifold import manifold, metric, step
from tests.systems.four_bar import BAR, EOM, N, O, state


def spd(n, rng):
    x = rng.normal(size=(n, n))
    return x @ x.T + 0.1 * np.eye(n)


def kkt(m, a, right):
    """δ of least δᵀM δ with A δ = right."""
    n, k = len(m), len(a)
    return np.linalg.solve(np.block([[m, a.T], [a, np.zeros((k, k))]]), np.append(np.zeros(n), right))[:n]


@pytest.mark.parametrize(("n", "k"), [(1, 1), (4, 1), (5, 3), (6, 6)])
def test_a_step_is_the_least_in_the_mass_metric(n, k, rng):
    m, a, right = spd(n, rng), rng.normal(size=(k, n)), rng.normal(size=k)
    np.testing.assert_allclose(step(m, a, right, np.abs(a)), kkt(m, a, right), atol=1e-10)


def test_redundant_rows_do_no_harm(rng):
    m, a, right = spd(5, rng), rng.normal(size=(2, 5)), rng.normal(size=2)
    mix = np.array([[1, 0], [0, 1], [2.0, -1], [1e3, 0]])
    found = step(m, mix @ a, mix @ right, np.abs(mix @ a))
    np.testing.assert_allclose(found, kkt(m, a, right), atol=1e-9)


def test_a_row_that_vanishes_now_is_no_row_in_small_units():
    """Sizes that entries have had tell the two apart: a rod along x, and one that would be along y were it not for rounding."""
    a, right, m = np.array([[1.0, 0.0], [0.0, 1e-9]]), np.array([0.1, 1e-12]), np.eye(2)
    np.testing.assert_allclose(step(m, a, right, np.abs(a)), [0.1, 1e-3])
    np.testing.assert_allclose(step(m, a, right, np.ones((2, 2))), [0.1, 0.0], atol=1e-10)


def test_the_metric_is_a_root_of_the_inverse(rng):
    m = spd(4, rng)
    s = metric(m)
    np.testing.assert_allclose(s @ s.T @ m, np.eye(4), atol=1e-10)


def test_what_moves_no_mass_is_free_to_move():
    """The second speed is massless: it takes the whole change, and no more than that."""
    change = step(np.diag([1.0, 0.0]), np.array([[1.0, 1.0]]), np.array([0.3]), np.ones((1, 2)))
    assert change.sum() == pytest.approx(0.3)
    assert abs(change[0]) < 1e-3


def project(eom, x):
    nothing = np.zeros(0)
    return manifold(eom).project(0.0, x, nothing, nothing, np.zeros((len(eom.b), len(eom.speeds))))


def perturbed(size):
    found = state()
    x = np.array([*found["q"].values(), *found["u"].values()])
    return x + size * np.sin(np.arange(1, len(x) + 1))


def test_projection_closes_the_constraints():
    x, numbers = project(EOM, perturbed(1e-4))
    assert np.abs(numbers.f).max() < 1e-13
    assert np.abs(numbers.a @ x[3:] + numbers.b).max() < 1e-13


def test_projection_is_the_least_change():
    """To first order in what is missed: of q by one KKT step, of u exactly."""
    x = perturbed(1e-5)
    before = manifold(EOM).numbers(0.0, x, np.zeros(0), np.zeros(0))
    kept, after = project(EOM, x)
    np.testing.assert_allclose(kept[:3] - x[:3], kkt(before.m, before.a, -before.f), atol=1e-9)
    np.testing.assert_allclose(kept[3:] - x[3:], kkt(after.m, after.a, -(after.a @ x[3:])), atol=1e-13)


def test_a_state_on_the_constraints_stays():
    x = perturbed(0.0)
    kept, _ = project(EOM, x)
    np.testing.assert_allclose(kept, x, atol=1e-13)


def test_euler_parameters_are_divided_by_their_length():
    e = kn.coordinates("e0:4")
    B = N.rotate_euler_parameters("B", e)
    body = kn.RigidBody("b", frame=B, mass_center=O.at("b*", 0), mass=1, inertia=kn.inertia(B, 0.1, 0.2, 0.3))
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates"))
    x = np.array([0.8, 0.2, -0.4, 0.5, 1, 2, 3])
    kept, _ = project(eom, x)
    np.testing.assert_allclose(kept[:4], x[:4] / np.linalg.norm(x[:4]), atol=1e-15)
    np.testing.assert_array_equal(kept[4:], x[4:])


def test_without_constraints_there_is_nothing_to_keep():
    assert manifold(kn.derive(BAR.system(holonomic=()))) is None
