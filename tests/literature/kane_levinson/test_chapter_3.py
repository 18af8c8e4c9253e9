# SPDX-License-Identifier: BSD-3-Clause
"""Kane & Levinson 1985, chapter 3: mass distribution, without a system.

Each problem is of the kind of its section; what is expected is in closed form, or computed in NumPy without `kane`.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def body(name, center, mass, inertia):
    return kn.RigidBody(name, frame=N, mass_center=center, mass=mass, inertia=inertia)


def numbers(v):
    return np.asarray(kn.evaluate(v.components(N), {}), dtype=float)


# 3.1 Mass centre ----------------------------------------------------------------------------------------------------------------


def test_a_top_of_a_cone_on_a_hemisphere():
    """Of one density: the mass centre is at the common face where h = √3 R, above it for taller cones."""
    R, h = kn.parameter("R", 1.0, "m"), kn.parameter("h", 1.5, "m")
    below, above = 2 * kn.pi * R**3 / 3, kn.pi * R**2 * h / 3
    half, cone = kn.hemisphere(N, below, R, axis=-N.z), kn.solid_cone(N, above, R, h, axis=N.z)
    parts = [
        body("half", O.at("A", half.shape.centroid), below, half),
        body("cone", O.at("B", cone.shape.centroid), above, cone),
    ]
    height = kn.mass_center(parts, O).dot(N.z)
    for x in (0.5, 1.0, 1.5, 2.5):
        wanted = (x**2 / 12 - 1 / 4) / (2 / 3 + x / 3)
        assert float(kn.evaluate(height, {R: 1.0, h: x})) == pytest.approx(wanted, rel=1e-13)
    assert float(kn.evaluate(height, {R: 1.0, h: np.sqrt(3)})) == pytest.approx(0, abs=1e-15)


def test_a_bent_wire():
    """A wire of three legs along the edges of a box, and a half circle on top."""
    a, b, c, r = 2.0, 3.0, 1.0, 0.5
    arc = kn.circular_arc(N, np.pi * r, r, kn.pi / 2, normal=N.z, towards=N.y)
    parts = [
        body("x", O.at("X", a / 2 * N.x), a, kn.rod(N, a, a, axis=N.x)),
        body("y", O.at("Y", a * N.x + b / 2 * N.y), b, kn.rod(N, b, b, axis=N.y)),
        body("z", O.at("Z", a * N.x + b * N.y + c / 2 * N.z), c, kn.rod(N, c, c, axis=N.z)),
        body("arc", O.at("A", r * N.x + arc.shape.centroid), np.pi * r, arc),
    ]
    whole = a + b + c + np.pi * r
    wanted = (
        a * np.array([a / 2, 0, 0]) + b * np.array([a, b / 2, 0]) + c * np.array([a, b, c / 2])
        + np.pi * r * np.array([r, 2 * r / np.pi, 0])
    ) / whole  # fmt: skip
    np.testing.assert_allclose(numbers(kn.mass_center(parts, O)), wanted, rtol=1e-13)


def test_a_plate_with_a_round_hole():
    """Mass centre and moment of inertia of what is left, by areas."""
    sigma, a, b, r = 3.0, 2.0, 1.0, 0.3
    plate = body(
        "plate", O.at("P", a / 2 * N.x + b / 2 * N.y), sigma * a * b, kn.rectangular_plate(N, sigma * a * b, a, b)
    )
    m = sigma * np.pi * r**2
    hole = body("hole", O.at("H", 1.5 * N.x + 0.5 * N.y), m, kn.thin_disk(N, m, r, axis=N.z))
    left = kn.composite("left", plate, N, without=hole)
    mass = sigma * a * b - m
    x = (sigma * a * b * 1.0 - m * 1.5) / mass
    np.testing.assert_allclose(numbers(left.mass_center.position(O)), [x, 0.5, 0], rtol=1e-13)
    polar = sigma * a * b * ((a * a + b * b) / 12 + (x - 1) ** 2) - m * (r * r / 2 + (x - 1.5) ** 2)
    assert float(kn.evaluate(left.inertia.components(N)[2, 2], {})) == pytest.approx(polar, rel=1e-13)


# 3.2 to 3.5 Inertia vector, inertia scalars, matrix, dyadic ---------------------------------------------------------------------


def test_a_cube_about_its_diagonals():
    """Through the centre m a²/6 about every line; through a corner m a²/6 about the diagonal, 2 m a²/3 about an edge."""
    m, a = kn.parameter("m", 2.0, "kg"), kn.parameter("a", 0.5, "m")
    cube = body("cube", O.at("C", a / 2 * (N.x + N.y + N.z)), m, kn.box(N, m, a, a, a))
    diagonal = (N.x + N.y + N.z) / kn.sqrt(3)
    assert float(kn.evaluate(kn.moment_of_inertia(cube, O, diagonal), {})) == pytest.approx(2 * 0.25 / 6)
    assert float(kn.evaluate(kn.moment_of_inertia(cube, O, N.z), {})) == pytest.approx(2 * 2 * 0.25 / 3)
    assert float(kn.evaluate(kn.radius_of_gyration(cube, O, diagonal), {})) == pytest.approx(0.5 / np.sqrt(6))
    assert float(kn.evaluate(kn.product_of_inertia(cube, O, N.x, N.y), {})) == pytest.approx(-2 * 0.25 / 4)


def test_inertia_vectors_of_particles():
    """I_a = Σ m p × (n_a × p), which is not along n_a; I_a·n_b = I_b·n_a."""
    places, masses = np.array([[1.0, 2, 0], [0, -1, 3], [2, 1, 1]]), np.array([1.0, 2, 3])
    bodies = [
        kn.Particle(f"P{i}", O.at(f"P{i}", float(r[0]) * N.x + float(r[1]) * N.y + float(r[2]) * N.z), float(w))
        for i, (r, w) in enumerate(zip(places, masses, strict=True))
    ]
    n_a, n_b = (2 * N.x + N.y - 2 * N.z) / 3, (N.x + 2 * N.y + 2 * N.z) / 3
    a, b = np.array([2, 1, -2]) / 3, np.array([1, 2, 2]) / 3
    wanted = sum(w * np.cross(r, np.cross(a, r)) for r, w in zip(places, masses, strict=True))
    np.testing.assert_allclose(numbers(kn.inertia_vector(bodies, O, n_a)), wanted, rtol=1e-13)
    both = [kn.product_of_inertia(bodies, O, *pair) for pair in ((n_a, n_b), (n_b, n_a))]
    assert [float(kn.evaluate(x, {})) for x in both] == pytest.approx([wanted @ b] * 2)


def test_the_inertia_matrix_depends_on_the_frame_and_the_dyadic_does_not():
    """Iᴮ = Cᵀ Iᴬ C for a plate seen along axes that are turned."""
    B = N.rotate_body("B", (kn.pi / 6, kn.pi / 4, 0.3), "zxz")
    plate = body("plate", O, 3, kn.right_triangle(N, 3, 1, 2))
    C = kn.evaluate(N.dcm(B), {})
    one, other = (kn.evaluate(kn.inertia_matrix(plate, O, f), {}) for f in (N, B))
    np.testing.assert_allclose(other, C.T @ one @ C, rtol=1e-13, atol=1e-15)


# 3.6, 3.7 Parallel axes, evaluation of inertia scalars --------------------------------------------------------------------------


def test_half_a_cylinder_about_its_edge():
    """Central, then about a corner line of the flat side: 3 m R²/2 about the edge of the flat side, along the axis."""
    m, R, h = kn.parameter("m", 2.0, "kg"), kn.parameter("R", 0.3, "m"), kn.parameter("h", 1.0, "m")
    inertia = kn.half_cylinder(N, m, R, h, axis=N.z, towards=N.x)
    half = body("half", O.at("S", R * N.y + inertia.shape.centroid), m, inertia)
    assert float(kn.evaluate(kn.moment_of_inertia(half, O, N.z), {})) == pytest.approx(1.5 * 2 * 0.09)
    back = kn.central_inertia(kn.inertia_about(half, O), m, half.mass_center.position(O))
    np.testing.assert_allclose(
        kn.evaluate(back.components(N), {}), kn.evaluate(inertia.components(N), {}), rtol=1e-12, atol=1e-16
    )


def test_an_equilateral_plate():
    """m a²/24 about every central axis in its plane, m a²/12 across it: exactly."""
    m, a = kn.parameter("m"), kn.parameter("a")
    plate = kn.triangular_plate(N, m, a * N.x, a / 2 * N.x + kn.sqrt(3) * a / 2 * N.y)
    rows = kn.evaluate(plate.components(N), {m: 1.0, a: 1.0})
    np.testing.assert_allclose(rows, np.diag([1 / 24, 1 / 24, 1 / 12]), rtol=1e-14, atol=1e-16)


# 3.8, 3.9 Principal axes, greatest and least moments ----------------------------------------------------------------------------


def test_a_rectangular_plate_about_its_corner():
    """tan 2θ = (3/2) a b/(a² − b²): the axes of the corner; moments by the roots of the quadratic."""
    m, a, b = kn.parameter("m", 1.2, "kg"), kn.parameter("a", 0.7, "m"), kn.parameter("b", 0.4, "m")
    plate = body("plate", O.at("S", a / 2 * N.x + b / 2 * N.y), m, kn.rectangular_plate(N, m, a, b))
    found = kn.principal(kn.inertia_about(plate, O), values={})
    matrix = 1.2 * np.array([[0.16 / 3, -0.28 / 4], [-0.28 / 4, 0.49 / 3]])
    low, high = np.linalg.eigvalsh(matrix)
    assert [float(x) for x in found.moments] == pytest.approx([low, high, 1.2 * (0.49 + 0.16) / 3], rel=1e-13)
    x, y, _ = numbers(found.axes[0])
    assert np.tan(2 * np.arctan2(y, x)) == pytest.approx(1.5 * 0.28 / (0.49 - 0.16), rel=1e-12)
    assert str(found.axes[2]) == "N.z"


def test_a_crank_shaft():
    """A Z of three rods: principal moments and axes against NumPy's; n·I·n is never below the least nor above the greatest."""
    rods = [
        body("left", O.at("A", -0.5 * N.x), 1, kn.rod(N, 1, 1, axis=N.x)),
        body(
            "web",
            O.at("B", 0.4 * N.y + 0.2 * N.z),
            0.9,
            kn.rod(N, 0.9, 2 * 0.2**0.5, axis=(2 * N.y + N.z) / kn.sqrt(5)),
        ),
        body("right", O.at("C", 0.5 * N.x + 0.8 * N.y + 0.4 * N.z), 1, kn.rod(N, 1, 1, axis=N.x)),
    ]
    center = O.at("S", kn.mass_center(rods, O))
    whole = kn.inertia_about(rods, center)
    points, weights = [], []
    for lo, hi, m in (((-1, 0, 0), (0, 0, 0), 1), ((0, 0, 0), (0, 0.8, 0.4), 0.9), ((0, 0.8, 0.4), (1, 0.8, 0.4), 1)):
        x, w = np.polynomial.legendre.leggauss(4)
        points += [np.array(lo) + (np.array(hi) - np.array(lo)) * (1 + t) / 2 for t in x]
        weights += [m * h / 2 for h in w]
    r, w = np.array(points), np.array(weights)
    r = r - w @ r / w.sum()
    matrix = np.einsum("k,ki,ki", w, r, r) * np.eye(3) - np.einsum("k,ki,kj->ij", w, r, r)
    np.testing.assert_allclose(kn.evaluate(whole.components(N), {}), matrix, rtol=1e-12, atol=1e-14)
    found = kn.principal(whole, N, values={})
    np.testing.assert_allclose([float(x) for x in found.moments], np.linalg.eigvalsh(matrix), rtol=1e-12)
    for k, axis in enumerate(found.axes):
        n = numbers(axis)
        np.testing.assert_allclose(matrix @ n, float(found.moments[k]) * n, rtol=1e-11, atol=1e-13)
    rng = np.random.default_rng(1985)
    n = rng.normal(size=(200, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    sizes = np.einsum("ki,ij,kj->k", n, matrix, n)
    assert float(found.minimum[0]) <= sizes.min() * (1 + 1e-12)
    assert float(found.maximum[0]) >= sizes.max() * (1 - 1e-12)


def test_the_ellipsoid_tells_moments_about_all_lines():
    """The distance from its centre to its surface along n is 1/√(n·I·n)."""
    found = kn.principal(kn.box(N, 6, 1, 2, 3))
    half = np.array([float(x) for x in found.ellipsoid()])
    rng = np.random.default_rng(1985)
    for _ in range(20):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        along = np.array([n @ numbers(axis) for axis in found.axes])
        distance = 1 / np.sqrt(((along / half) ** 2).sum())
        moment = n @ np.diag([13 / 2, 5.0, 5 / 2]) @ n
        assert distance == pytest.approx(1 / np.sqrt(moment), rel=1e-12)
