# SPDX-License-Identifier: BSD-3-Clause
"""Distributed forces: resultant and moment against integrals in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
B = N.rotate("B", kn.Rational(1, 2), N.y)
P = O.at("P", 0.3 * N.x)


def both(load):
    found = kn.force_system(load)
    return [np.asarray(kn.evaluate(v.components(B), {}), dtype=float) for v in (found.resultant, found.moment(P))]


@pytest.mark.parametrize("degree", range(6))
def test_lines(degree):
    """Of a load w sⁿ across a line of length L: w L/(n + 1), and w L²/(n + 2) about its start."""
    L, w = kn.parameter("L", 2.0, "m"), kn.parameter("w", 3.0, "N/m")
    force, moment = both(kn.line_load(B, P, L * B.x, lambda s: w * s**degree * B.y, degree=degree))
    np.testing.assert_allclose(force, [0, 3 * 2 / (degree + 1), 0], atol=1e-14)
    np.testing.assert_allclose(moment, [0, 0, 3 * 4 / (degree + 2)], rtol=1e-13, atol=1e-14)


def test_a_uniform_load_is_one_force_at_the_middle():
    w, L = kn.parameter("w", 3.0, "N/m"), kn.parameter("L", 2.0, "m")
    uniform = kn.line_load(B, P, L * B.x, w * B.y, degree=0)
    assert len(uniform.forces) == 1
    assert str(kn.force_system(uniform).moment(P)) == "L^2*w/2 B.z"


@pytest.mark.parametrize("degree", range(4))
def test_rectangles(degree):
    """Water on a wall: p = p₀ sⁿ (1 + t) over a × b."""
    a, b, p0 = 1.5, 0.8, 7.0
    load = kn.pressure_on_rectangle(
        B, P, a * B.x, b * B.y, lambda s, t: p0 * s**degree * (1 + t), degree=max(degree, 1)
    )
    force, moment = both(load)
    mean_t, first_t = 1.5, 1 / 2 + 1 / 3
    whole = p0 * a * b * mean_t / (degree + 1)
    np.testing.assert_allclose(force, [0, 0, -whole], rtol=1e-13, atol=1e-14)
    x, y = a * (degree + 1) / (degree + 2), b * first_t / mean_t
    np.testing.assert_allclose(moment, np.cross([x, y, 0], [0, 0, -whole]), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("degree", range(4))
def test_disks(degree):
    """p = p₀ (1 + k x)ⁿ: ∫ and ∫ x by the moments of a disk, ∫ x² = π R⁴/4, ∫ x⁴ = π R⁶/8."""
    radius, p0, k = 0.6, 5.0, 0.7
    load = kn.pressure_on_disk(B, P, B.z, radius, lambda x, y: p0 * (1 + k * x) ** degree, degree=degree)
    moments = [np.pi * radius**2, 0, np.pi * radius**4 / 4, 0, np.pi * radius**6 / 8, 0]
    from math import comb

    whole = p0 * sum(comb(degree, i) * k**i * moments[i] for i in range(degree + 1))
    first = p0 * sum(comb(degree, i) * k**i * moments[i + 1] for i in range(degree + 1))
    force, moment = both(load)
    np.testing.assert_allclose(force, [0, 0, -whole], rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(moment, [0, first, 0], rtol=1e-12, atol=1e-12)


def test_they_move_with_their_body():
    """A hinged plate under uniform pressure turns as by its resultant at the middle."""
    q = kn.coordinate("q")
    D = N.rotate("D", q, N.x)
    C = O.at("C", kn.Rational(1, 2) * D.y)
    plate = kn.RigidBody("plate", frame=D, mass_center=C, mass=2, inertia=kn.rectangular_plate(D, 2, 3, 1))
    load = kn.pressure_on_rectangle(D, O.at("corner", -1.5 * D.x), 3 * D.x, D.y, 4.0)
    eom = kn.derive(kn.System(N, bodies=[plate], speeds="rates", loads=[load]))
    assert float(eom.evaluate(eom.accelerations[0], q=[0.4], u=[0])) == pytest.approx(-4 * 3 * 0.5 / (2 / 12 + 2 / 4))


def test_errors():
    with pytest.raises(kn.ModelError, match="degree="):
        kn.line_load(B, P, B.x, B.y, degree=-1)
    with pytest.raises(kn.ModelError, match="force per length"):
        kn.line_load(B, P, B.x, 3)
    with pytest.raises(kn.ModelError, match="Frame of the body"):
        kn.line_load(P, P, B.x, B.y)
    with pytest.raises(kn.ModelError, match="Point of the body"):
        kn.line_load(B, N, B.x, B.y)
    with pytest.raises(kn.ModelError, match="across="):
        kn.pressure_on_disk(B, P, (B.x + B.y + B.z) / kn.sqrt(3), 1, 1)
    with pytest.raises(kn.ModelError, match="across= in the disk across its normal"):
        kn.pressure_on_disk(B, P, B.z, 1, 1, across=(B.x + B.z) / kn.sqrt(2))
