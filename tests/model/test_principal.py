# SPDX-License-Identifier: BSD-3-Clause
"""Principal moments and axes: I·n = I_n n, for numbers and for symbols."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn


def check(found, inertia, frame, values=None):
    """I n_k = I_k n_k, right-handed unit vectors."""
    values = values or {}
    n = np.array([kn.evaluate(a.components(frame), values) for a in found.axes])
    i = np.array([kn.evaluate(x, values) for x in found.moments])
    matrix = kn.evaluate(inertia.components(frame), values)
    np.testing.assert_allclose(n @ n.T, np.eye(3), atol=1e-13)
    assert np.linalg.det(n) > 0
    np.testing.assert_allclose(matrix @ n.T, n.T * i, rtol=1e-12, atol=1e-12 * np.abs(matrix).max())
    return i


def test_of_numbers(rng):
    F = kn.Frame("F")
    for _ in range(20):
        points = rng.normal(size=(5, 3))
        rows = np.trace(points.T @ points) * np.eye(3) - points.T @ points
        inertia = kn.Dyadic.of(F, rows.tolist())
        found = kn.principal(inertia)
        moments = check(found, inertia, F)
        assert (np.diff(moments) >= 0).all()
        assert found.minimum[0] is found.moments[0]
        assert found.maximum[1] is found.axes[2]


def test_blocks_of_symbols_stay_symbols():
    F = kn.Frame("F")
    m, a, b = (kn.parameter(n) for n in "mab")
    for shape in (kn.right_triangle(F, m, a, b), kn.inertia(F, a, m, b, Iyz=m / 3), kn.inertia(F, a, m, b, Izx=m / 3)):
        check(kn.principal(shape), shape, F, {m: 2.0, a: 1.2, b: 1.7})
    equal = kn.principal(kn.inertia(F, a, a, b, Ixy=m))
    assert [str(x) for x in equal.moments] == ["a - m", "m + a", "b"]
    check(equal, kn.inertia(F, a, a, b, Ixy=m), F, {m: 2.0, a: 1.2, b: 1.7})


def test_symbols_need_an_axis_or_values():
    F = kn.Frame("F")
    m = kn.parameter("m", 2.0, "kg")
    full = kn.inertia(F, 3 * m, 4 * m, 5 * m, m / 2, m / 3, m / 4)
    with pytest.raises(kn.ModelError, match=r"values=\{…\}"):
        kn.principal(full)
    check(kn.principal(full, values={}), full, F)
    check(kn.principal(full, values={"m": 3}), full, F, {m: 3.0})
    blocks = kn.principal(kn.inertia(F, 3 * m, 4 * m, 5 * m, m / 2))
    with pytest.raises(kn.ModelError, match=r"values=\{…\}"):
        _ = blocks.maximum


def test_along_another_frame():
    F = kn.Frame("F")
    q = kn.coordinate("q")
    G = F.rotate("G", q, F.z)
    I = kn.inertia(F, 1, 2, 3) + kn.inertia(G, 1, 2, 3)
    with pytest.raises(kn.ModelError, match=r"along F, G\. Name it"):
        kn.principal(I)
    check(kn.principal(I, F, values={q: 0.3}), I, F, {q: 0.3})


def test_planes_ellipsoid_and_radii():
    F = kn.Frame("F")
    found = kn.principal(kn.inertia(F, 9, 4, 1))
    assert [str(x) for x in found.moments] == ["1", "4", "9"]
    assert [str(n) for n in found.axes] == ["F.z", "F.y", "-F.x"]
    assert [str(r) for r in found.ellipsoid()] == ["1", "1/2", "1/3"]
    assert [str(r) for r in found.ellipsoid(6)] == ["6", "3", "2"]
    assert [str(r) for r in found.radii_of_gyration(4)] == ["1/2", "1", "3/2"]
    for normal, (a, b) in zip(found.axes, found.planes, strict=True):
        assert str(a.cross(b)) == str(normal)
    with pytest.raises(kn.ModelError, match="infinite along"):
        kn.principal(kn.rod(F, 2, 1, F.x)).ellipsoid()
    assert "9 about" in repr(found)


def test_what_is_no_inertia():
    F = kn.Frame("F")
    with pytest.raises(kn.ModelError, match=r"kn.inertia_about\(bodies, point\)"):
        kn.principal(F)
    with pytest.raises(kn.ModelError, match="symmetric"):
        kn.principal(kn.Dyadic.of(F, [[1, 1, 0], [0, 1, 0], [0, 0, 1]]))
    a, b = kn.parameter("a", 2.0), kn.parameter("b")
    for rows in ([[a, b, 0], [0, 1, 0], [0, 0, 1]], [[a, b, 0], [-b, 1, 0], [0, 0, 1]]):
        with pytest.raises(kn.ModelError, match="symmetric"):
            kn.principal(kn.Dyadic.of(F, rows))
