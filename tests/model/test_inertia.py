# SPDX-License-Identifier: BSD-3-Clause
"""Inertias of solids against ∫ (r² 1 − r r) dm by quadrature, about any axis, and the parallel axis theorem."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.expr import as_expr
from kane.model import Inertia

Array = Any
Mass = tuple[Array, Array]  # points (n, 3) and their masses, of total 1

R, H, M = 0.7, 1.3, 2.5
A, B, C = 0.4, 0.9, 1.4


def gauss(low: float, high: float, n: int = 8) -> tuple[Array, Array]:
    """Gauss–Legendre points and weights: exact for polynomials of degree 15."""
    x, w = np.polynomial.legendre.leggauss(n)
    return low + (high - low) * (x + 1) / 2, w * (high - low) / 2


def around(n: int = 12) -> tuple[Array, Array]:
    """Equidistant angles: exact for trigonometric polynomials of degree 11."""
    return 2 * np.pi * np.arange(n) / n, np.full(n, 2 * np.pi / n)


def spread(point: Callable[..., tuple[Array, Array, Array]], density: Callable[..., Array], *rules: Any) -> Mass:
    """Point masses of a product rule, divided by the total."""
    grids = np.meshgrid(*[x for x, _ in rules], indexing="ij")
    weights = np.prod(np.meshgrid(*[w for _, w in rules], indexing="ij"), axis=0)
    mass = (weights * density(*grids)).ravel()
    points = np.stack([np.broadcast_to(x, grids[0].shape).ravel() for x in point(*grids)], axis=1)
    return points, mass / mass.sum()


def polar(r: Array, p: Array, z: Array) -> tuple[Array, Array, Array]:
    return r * np.cos(p), r * np.sin(p), z


def spherical(r: Array, c: Array, p: Array) -> tuple[Array, Array, Array]:
    s = r * np.sqrt(1 - c**2)
    return s * np.cos(p), s * np.sin(p), r * c


def cone(f: Array, p: Array, z: Array) -> tuple[Array, Array, Array]:
    """z from the base, f the share of the radius there; the mass centre is H/4 above the base."""
    r = f * R * (1 - z / H)
    return r * np.cos(p), r * np.sin(p), z - H / 4


level = (np.zeros(1), np.ones(1))
edge = (np.full(1, R), np.ones(1))
height = gauss(-H / 2, H / 2)


# Each body of revolution about the third axis, and what kane says of it.
ROUND: dict[str, tuple[Mass, Callable[[kn.Frame, kn.Vector], kn.Dyadic]]] = {
    "thin disk": (
        spread(polar, lambda r, p, z: r, gauss(0, R), around(), level),
        lambda F, axis: kn.thin_disk(F, M, R, axis),
    ),
    "ring": (
        spread(polar, lambda r, p, z: r, edge, around(), level),
        lambda F, axis: kn.ring(F, M, R, axis),
    ),
    "rod": (
        spread(lambda z: (0 * z, 0 * z, z), np.ones_like, height),
        lambda F, axis: kn.rod(F, M, H, axis),
    ),
    "solid cylinder": (
        spread(polar, lambda r, p, z: r, gauss(0, R), around(), height),
        lambda F, axis: kn.solid_cylinder(F, M, R, H, axis),
    ),
    "cylindrical shell": (
        spread(polar, lambda r, p, z: r, edge, around(), height),
        lambda F, axis: kn.cylindrical_shell(F, M, R, H, axis),
    ),
    "solid cone": (
        spread(cone, lambda f, p, z: f * (1 - z / H) ** 2, gauss(0, 1), around(), gauss(0, H)),
        lambda F, axis: kn.solid_cone(F, M, R, H, axis),
    ),
}
OTHERS: dict[str, tuple[Mass, Callable[[kn.Frame], kn.Dyadic]]] = {
    "solid sphere": (
        spread(spherical, lambda r, c, p: r**2, gauss(0, R), gauss(-1, 1), around()),
        lambda F: kn.solid_sphere(F, M, R),
    ),
    "spherical shell": (
        spread(spherical, lambda r, c, p: r**2, edge, gauss(-1, 1), around()),
        lambda F: kn.spherical_shell(F, M, R),
    ),
    "box": (
        spread(lambda x, y, z: (x, y, z), lambda x, y, z: 1 + 0 * x, *(gauss(-e / 2, e / 2) for e in (A, B, C))),
        lambda F: kn.box(F, M, A, B, C),
    ),
}
CENTRAL: dict[str, tuple[Mass, Callable[[kn.Frame], kn.Dyadic]]] = {
    **OTHERS,
    **{name: (mass, lambda F, make=make: make(F, F.z)) for name, (mass, make) in ROUND.items()},  # type: ignore[misc]
}


def integral(points: Array, mass: Array) -> Array:
    """∫ (r² 1 − r r) dm for the total mass M."""
    square = np.einsum("k,ki,ki", mass, points, points)
    return M * (square * np.eye(3) - np.einsum("k,ki,kj->ij", mass, points, points))


def matrix(dyadic: kn.Dyadic, frame: kn.Frame, **values: Any) -> Array:
    return kn.evaluate(dyadic.components(frame), values)


@pytest.mark.parametrize("name", CENTRAL)
def test_central_inertia(name: str) -> None:
    (points, mass), make = CENTRAL[name]
    F = kn.Frame("F")
    np.testing.assert_allclose(mass @ points, 0, atol=1e-15)  # about the mass centre
    np.testing.assert_allclose(matrix(make(F), F), integral(points, mass), rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("name", ROUND)
@pytest.mark.parametrize(
    "axis", [(1, 0, 0), (0, 1, 0), (0, 0, -1), (0.6, 0, 0.8), (0.48, -0.6, 0.64), (1, 2, -2), (1, -1, 1)]
)
def test_any_axis(name: str, axis: tuple[float, float, float]) -> None:
    """The body turned so that its third axis lies along `axis`."""
    (points, mass), make = ROUND[name]
    F = kn.Frame("F")
    x, y, z = axis
    direction = x * F.x + y * F.y + z * F.z
    if np.linalg.norm(axis) > 1.1:
        direction = direction.normalized()
    unit = np.array(axis) / np.linalg.norm(axis)
    frame, _ = np.linalg.qr(np.stack([unit, [0.3, 0.5, 0.7], [0.9, -0.1, 0.2]], axis=1))
    turned = points @ np.stack([frame[:, 1], frame[:, 2], unit])
    np.testing.assert_allclose(matrix(make(F, direction), F), integral(turned, mass), rtol=1e-13, atol=1e-14)


def test_a_unit_vector_is_needed() -> None:
    F = kn.Frame("F")
    with pytest.raises(kn.ModelError, match="unit vector"):
        kn.thin_disk(F, M, R, axis=F.x + F.y)


def test_axis_along_parameters() -> None:
    F = kn.Frame("F")
    a = kn.parameter("a", 0.4)
    found = matrix(kn.rod(F, M, H, (F.x + a * F.y).normalized()), F)
    n = np.array([1, 0.4, 0]) / np.hypot(1, 0.4)
    np.testing.assert_allclose(found, M * H**2 / 12 * (np.eye(3) - np.outer(n, n)), rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("name", CENTRAL)
def test_parallel_axis(name: str) -> None:
    (points, mass), make = CENTRAL[name]
    F = kn.Frame("F")
    offset = np.array([0.3, -0.8, 0.5])
    found = kn.parallel_axis(make(F), M, 0.3 * F.x - 0.8 * F.y + 0.5 * F.z)
    np.testing.assert_allclose(matrix(found, F), integral(points + offset, mass), rtol=1e-13, atol=1e-14)


def test_parallel_axis_with_offset_along_another_frame() -> None:
    """Inertia along one frame, offset along two others."""
    (points, mass), make = CENTRAL["box"]
    F = kn.Frame("F")
    G = F.rotate("G", kn.Rational(7, 10), F.z)
    found = kn.parallel_axis(make(F), M, 0.3 * G.x - 0.8 * F.y)
    offset = np.array([0.3 * np.cos(0.7), 0.3 * np.sin(0.7) - 0.8, 0])
    np.testing.assert_allclose(matrix(found, F), integral(points + offset, mass), rtol=1e-13, atol=1e-14)


def test_parallel_axis_without_offset() -> None:
    F = kn.Frame("F")
    central = kn.box(F, M, A, B, C)
    np.testing.assert_array_equal(matrix(kn.parallel_axis(central, M, 0 * F.x), F), matrix(central, F))


def test_measure_numbers_are_not_products() -> None:
    """Ixy is −∫ x y dm: for two particles at ±(1, 2, 3) it is negative."""
    F = kn.Frame("F")
    points, mass = np.array([[1.0, 2, 3], [-1, -2, -3]]), np.full(2, 0.5)
    found = kn.inertia(F, M * 13, M * 10, M * 5, Ixy=-2 * M, Iyz=-6 * M, Izx=-3 * M)
    np.testing.assert_allclose(matrix(found, F), integral(points, mass), rtol=1e-15)


SIZE = kn.parameter("size", 0.4, "m")


@pytest.mark.parametrize(
    ("solid", "kind", "sizes", "axis"),
    [
        (lambda f: kn.rod(f, M, SIZE, f.x), "rod", {"length": SIZE}, "x"),
        (lambda f: kn.thin_disk(f, M, SIZE, f.z), "thin disk", {"radius": SIZE}, "z"),
        (
            lambda f: kn.solid_cylinder(f, M, SIZE, 2, f.y),
            "solid cylinder",
            {"radius": SIZE, "height": as_expr(2)},
            "y",
        ),
        (lambda f: kn.solid_sphere(f, M, SIZE), "solid sphere", {"radius": SIZE}, None),
        (lambda f: kn.box(f, M, 1, SIZE, 3), "box", {"a": as_expr(1), "b": SIZE, "c": as_expr(3)}, None),
    ],
)
def test_the_inertia_of_a_solid_remembers_its_shape(solid, kind, sizes, axis):
    frame = kn.Frame("F")
    inertia = solid(frame)
    assert isinstance(inertia, Inertia)
    shape = inertia.shape
    assert (shape.kind, shape.frame) == (kind, frame)
    assert shape.sizes.keys() == sizes.keys()
    assert all(shape.sizes[name] is size for name, size in sizes.items())
    assert shape.axis is (None if axis is None else getattr(frame, axis))
    plain = kn.Dyadic(inertia.dyads)
    assert str(inertia) == str(plain)
    for made in (inertia + inertia, inertia * 2, -inertia, inertia / 2, inertia - plain, inertia.express(frame)):
        assert type(made) is kn.Dyadic
