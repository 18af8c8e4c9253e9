# SPDX-License-Identifier: BSD-3-Clause
"""The particle on a spring: straight vertical motion, and the plane in space."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import particle_on_spring

m, k, l0, c, g = 1.5, 40.0, 0.8, 0.3, 9.81


@pytest.mark.parametrize("dimensions", [2, 3])
def test_it_hangs_at_rest(dimensions: int) -> None:
    eom = kn.derive(particle_on_spring.system(dimensions))
    height = -(l0 + m * g / k)
    rest = [0.0] * (dimensions - 1) + [height]
    np.testing.assert_allclose(eom.evaluate(eom.accelerations, q=rest, u=[0] * dimensions), 0, atol=1e-14)


def test_damped_vertical_motion() -> None:
    """ζ(t) = A e^(−δt) (cos ωt + (δ/ω) sin ωt), δ = c/(2m), ω² = k/m − δ², below the point of rest."""
    eom = kn.derive(particle_on_spring.system(2))
    rest, start = -(l0 + m * g / k), 0.2
    sol = kn.simulate(eom, (0, 4), q=[0, rest + start], u=[0, 0], rtol=1e-11, atol=1e-12)
    decay = c / (2 * m)
    w = np.sqrt(k / m - decay**2)
    expected = start * np.exp(-decay * sol.t) * (np.cos(w * sol.t) + decay / w * np.sin(w * sol.t))
    np.testing.assert_allclose(sol["y"] - rest, expected, atol=1e-9)
    np.testing.assert_allclose(sol["x"], 0, atol=1e-12)


def test_a_vertical_plane_in_space_is_the_plane() -> None:
    plane, space = (kn.derive(particle_on_spring.system(n)) for n in (2, 3))
    q, u = np.random.default_rng(1).uniform(0.2, 1.5, (2, 2, 20))
    zero = np.zeros(20)
    in_plane = plane.evaluate(plane.accelerations, q=q, u=u)
    x, y, z = space.evaluate(space.accelerations, q=[q[0], zero, q[1]], u=[u[0], zero, u[1]])
    np.testing.assert_allclose([x, z], in_plane, rtol=1e-13)
    np.testing.assert_array_equal(y, 0)


def test_other_dimensions() -> None:
    with pytest.raises(kn.ModelError, match="2 or 3 dimensions"):
        particle_on_spring.system(4)


@pytest.mark.parametrize("speeds", ["rates", "velocity", "scrambled"])
def test_polar_coordinates_describe_the_same_motion(speeds: str) -> None:
    """In the plane with r and θ: the place slides along axes that turn, and the spring is a force between points."""
    cartesian = kn.derive(particle_on_spring.system(2))
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    r, theta = kn.coordinates("r, theta")
    A = N.rotate("A", theta, N.z)
    P = O.at("P", r * A.x)
    v, (u1, u2) = P.velocity(N), kn.speeds("u1:3")
    choices: dict[str, Any] = {
        "rates": "rates",
        "velocity": {u1: v.dot(A.x), u2: v.dot(A.y)},
        "scrambled": {u1: r.dt + kn.sin(theta) * theta.dt, u2: theta.dt + kn.cos(r)},
    }
    loads = (kn.gravity(-g * N.y), kn.linear_spring(P, O, k, l0), kn.linear_damper(P, O, c))
    bodies = [kn.Particle("P", P, m)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds=choices[speeds], loads=loads, coordinates=(r, theta)))

    rng = np.random.default_rng(14)
    radius, angle, slide, turn = rng.uniform(0.4, 1.4, 20), *rng.uniform(-2, 2, (3, 20))
    place = {r: radius, theta: angle}
    definitions = list(eom.system.speeds.values())
    u = dict(zip(eom.speeds, kn.evaluate(definitions, {**place, r.dt: slide, theta.dt: turn}), strict=True))
    x, y, vx, vy = eom.evaluate([*P.position(O).components(N)[:2], *v.components(N)[:2]], q=place, u=u)
    expected = cartesian.evaluate(cartesian.accelerations, q=[x, y], u=[vx, vy])
    found = eom.evaluate(eom.point_accelerations[P].components(N)[:2], q=place, u=u)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)
    radial = eom.evaluate(eom.time_derivative(eom.rates[0]), q=place, u=u)
    along = expected[0] * np.cos(angle) + expected[1] * np.sin(angle)
    np.testing.assert_allclose(radial, along + radius * turn**2, rtol=1e-10, atol=1e-10)
