# SPDX-License-Identifier: BSD-3-Clause
"""Plates, arcs and solids of fewer symmetries against quadrature: the mass centre, and the inertia about it."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.model.test_inertia import M, around, gauss, integral, level, matrix, polar, spherical, spread

R, S, H, A, B, C = 0.7, 0.25, 1.3, 0.4, 0.9, 1.4
HALF = gauss(-np.pi / 2, np.pi / 2, 24)
SECTOR = gauss(-0.6, 0.6, 24)


def triangle(p, q):
    def point(s, t):
        return tuple(s * (1 - t) * a + s * t * b for a, b in zip(p, q, strict=True))

    return spread(point, lambda s, t: s, gauss(0, 1), gauss(0, 1))


def narrowing(f, p, z):
    r = f * (R + (S - R) * z / H)
    return r * np.cos(p), r * np.sin(p), z


SOLIDS = {
    "ellipsoid": (
        spread(
            lambda r, c, p: tuple(k * x for k, x in zip((A, B, C), spherical(r, c, p), strict=True)),
            lambda r, c, p: r**2,
            gauss(0, 1), gauss(-1, 1), around(),
        ),
        lambda f: kn.ellipsoid(f, M, A, B, C),
    ),
    "torus": (
        spread(
            lambda r, p, t: ((R + r * np.cos(t)) * np.cos(p), (R + r * np.cos(t)) * np.sin(p), r * np.sin(t)),
            lambda r, p, t: r * (R + r * np.cos(t)),
            gauss(0, S), around(), around(),
        ),
        lambda f: kn.torus(f, M, R, S, f.z),
    ),
    "frustum": (
        spread(narrowing, lambda f, p, z: f * (R + (S - R) * z / H) ** 2, gauss(0, 1), around(), gauss(0, H)),
        lambda f: kn.frustum(f, M, R, S, H, f.z),
    ),
    "half cylinder": (
        spread(polar, lambda r, p, z: r, gauss(0, R), HALF, gauss(-H / 2, H / 2)),
        lambda f: kn.half_cylinder(f, M, R, H, f.z, f.x),
    ),
    "hemisphere": (
        spread(spherical, lambda r, c, p: r**2, gauss(0, R), gauss(0, 1), around()),
        lambda f: kn.hemisphere(f, M, R, f.z),
    ),
    "cone": (
        spread(lambda f, p, z: (f * (1 - z) * np.cos(p), f * (1 - z) * np.sin(p), z * H),
               lambda f, p, z: f * (1 - z) ** 2, gauss(0, 1), around(), gauss(0, 1)),
        lambda f: kn.solid_cone(f, M, 1, H, f.z),
    ),
    "rectangular plate": (
        spread(lambda x, y: (x, y, 0 * x), lambda x, y: 1 + 0 * x, gauss(-A / 2, A / 2), gauss(-B / 2, B / 2)),
        lambda f: kn.rectangular_plate(f, M, A, B),
    ),
    "right triangle": (triangle((A, 0, 0), (0, B, 0)), lambda f: kn.right_triangle(f, M, A, B)),
    "triangular plate": (
        triangle((A, 0.2, -0.3), (-0.1, B, 0.5)),
        lambda f: kn.triangular_plate(f, M, A * f.x + 0.2 * f.y - 0.3 * f.z, -0.1 * f.x + B * f.y + 0.5 * f.z),
    ),
    "circular sector": (
        spread(polar, lambda r, p, z: r, gauss(0, R), SECTOR, level),
        lambda f: kn.circular_sector(f, M, R, 0.6, f.z, f.x),
    ),
    "circular arc": (
        spread(polar, lambda r, p, z: r, (np.full(1, R), np.ones(1)), SECTOR, level),
        lambda f: kn.circular_arc(f, M, R, 0.6, f.z, f.x),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SOLIDS)
def test_mass_centre_and_central_inertia(name):
    (points, mass), make = SOLIDS[name]
    F = kn.Frame("F")
    inertia = make(F)
    center = mass @ points
    np.testing.assert_allclose(kn.evaluate(inertia.shape.centroid.components(F), {}), center, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(matrix(inertia, F), integral(points - center, mass), rtol=1e-12, atol=1e-14)


TURNED = {
    "torus": lambda f, n, e: kn.torus(f, M, R, S, n),
    "frustum": lambda f, n, e: kn.frustum(f, M, R, S, H, n),
    "half cylinder": lambda f, n, e: kn.half_cylinder(f, M, R, H, n, e),
    "hemisphere": lambda f, n, e: kn.hemisphere(f, M, R, n),
    "circular sector": lambda f, n, e: kn.circular_sector(f, M, R, 0.6, n, e),
    "circular arc": lambda f, n, e: kn.circular_arc(f, M, R, 0.6, n, e),
}


@pytest.mark.parametrize("name", TURNED)
def test_any_axis(name):
    (points, mass), _ = SOLIDS[name]
    F = kn.Frame("F")
    n, e = (2 * F.x - F.y + 2 * F.z) / 3, (F.x + 2 * F.y).normalized()
    axis, towards = np.array([2, -1, 2]) / 3, np.array([1, 2, 0]) / np.sqrt(5)
    turned = points @ np.stack([towards, np.cross(axis, towards), axis])
    inertia, center = TURNED[name](F, n, e), mass @ turned
    np.testing.assert_allclose(kn.evaluate(inertia.shape.centroid.components(F), {}), center, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(matrix(inertia, F), integral(turned - center, mass), rtol=1e-12, atol=1e-14)


def test_a_right_triangle_is_a_triangular_plate():
    F = kn.Frame("F")
    one, other = kn.right_triangle(F, M, A, B), kn.triangular_plate(F, M, A * F.x, B * F.y)
    np.testing.assert_allclose(matrix(one, F), matrix(other, F), rtol=1e-14, atol=1e-16)


def test_special_sizes_are_the_plain_solids():
    F = kn.Frame("F")
    pairs = [
        (kn.frustum(F, M, R, 0, H, F.z), kn.solid_cone(F, M, R, H, F.z)),
        (kn.frustum(F, M, R, R, H, F.z), kn.solid_cylinder(F, M, R, H, F.z)),
        (kn.ellipsoid(F, M, R, R, R), kn.solid_sphere(F, M, R)),
        (kn.torus(F, M, R, 0, F.z), kn.ring(F, M, R, F.z)),
        (kn.circular_sector(F, M, R, np.pi, F.z, F.x), kn.thin_disk(F, M, R, F.z)),
        (kn.circular_arc(F, M, R, np.pi, F.z, F.x), kn.ring(F, M, R, F.z)),
        (kn.rectangular_plate(F, M, A, B), kn.box(F, M, A, B, 0)),
    ]
    for one, other in pairs:
        np.testing.assert_allclose(matrix(one, F), matrix(other, F), rtol=1e-13, atol=1e-15)


def test_the_round_side_is_across_the_axis():
    F = kn.Frame("F")
    with pytest.raises(kn.ModelError, match="across its axis"):
        kn.half_cylinder(F, M, R, H, F.z, (F.x + F.z).normalized())
    kn.half_cylinder(F, M, R, H, F.z, F.x)
    with pytest.raises(kn.ModelError, match="unit vector"):
        kn.hemisphere(F, M, R, 2 * F.z)
