# SPDX-License-Identifier: BSD-3-Clause
"""Chains of pendulums: normal modes, absolute against relative angles, the cart's momentum."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import double_pendulum, pendulums


def modes(eom: kn.Equations) -> Any:
    """Squares of the angular frequencies of small motions about the hanging rest, ascending."""
    n = len(eom.coordinates)
    rest: dict[str, Any] = {"q": [0.0] * n, "u": [0.0] * n}
    stiffness = -eom.evaluate(kn.jacobian(eom.forcing, eom.coordinates), **rest)
    squares: Any = np.linalg.solve(eom.evaluate(eom.mass_matrix, **rest), stiffness)
    return np.sort(np.linalg.eigvals(squares).real)


@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("n", range(1, 7))
def test_modes_of_equal_particles_are_zeros_of_laguerre_polynomials(n: int, relative: bool) -> None:
    """ω² = (g/l) x with L_n(x) = 0: a light string loaded with n equal particles (D. Bernoulli's hanging chain)."""
    zeros = np.polynomial.laguerre.lagroots([0] * n + [1])
    np.testing.assert_allclose(
        modes(kn.derive(pendulums.system(n, bobs=True, relative=relative))), 9.81 * zeros, rtol=1e-9
    )


@pytest.mark.parametrize("relative", [False, True])
def test_modes_of_the_double_pendulum(relative: bool) -> None:
    """ω² = (g/l)(2 ± √2) for two equal particles, (g/l)(3 ± 6/√7) for two equal rods."""
    sign = np.array([-1, 1])
    particles = modes(kn.derive(double_pendulum.system(bobs=True, relative=relative)))
    np.testing.assert_allclose(particles, 9.81 * (2 + sign * np.sqrt(2)), rtol=1e-12)
    rods = modes(kn.derive(double_pendulum.system(relative=relative)))
    np.testing.assert_allclose(rods, 9.81 * (3 + sign * 6 / np.sqrt(7)), rtol=1e-12)


@pytest.mark.parametrize("speeds", pendulums.SPEEDS)
@pytest.mark.parametrize("bobs", [False, True])
def test_relative_angles_are_other_coordinates_of_the_same_motion(bobs: bool, speeds: str) -> None:
    absolute = kn.derive(pendulums.system(4, bobs=bobs))
    relative = kn.derive(pendulums.system(4, bobs=bobs, relative=True, speeds=speeds))
    rng = np.random.default_rng(3)
    q, v = rng.uniform(-3, 3, (4, 20)), rng.uniform(-3, 3, (4, 20))
    own, rates = np.diff(q, axis=0, prepend=0), np.diff(v, axis=0, prepend=0)
    values: dict[Any, Any] = {x: own[i] for i, x in enumerate(relative.coordinates)}
    values |= {x.dt: rates[i] for i, x in enumerate(relative.coordinates)}
    lengths = {p: p.default for p in relative.parameters}
    u = kn.evaluate(list(relative.system.speeds.values()), {**values, **lengths})
    found = relative.evaluate([relative.time_derivative(r) for r in relative.rates], q=list(own), u=u)
    np.testing.assert_allclose(np.cumsum(found, axis=0), absolute.evaluate(absolute.accelerations, q=q, u=v), rtol=1e-9)


@pytest.mark.parametrize("speeds", pendulums.SPEEDS)
def test_horizontal_momentum_of_a_chain_on_a_cart(speeds: str) -> None:
    eom = kn.derive(pendulums.system(3, cart=True, speeds=speeds))
    assert [q.name for q in eom.coordinates] == ["x", "q1", "q2", "q3"]
    momentum = eom.linear_momentum().dot(eom.system.inertial.x)
    q, u = np.random.default_rng(4).uniform(-1, 1, (2, 4, 20))
    np.testing.assert_allclose(eom.evaluate(eom.time_derivative(momentum), q=q, u=u), 0, atol=1e-12)


def test_no_links() -> None:
    with pytest.raises(kn.ModelError, match="at least one link, got 0"):
        pendulums.system(0)
