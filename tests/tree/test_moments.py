# SPDX-License-Identifier: BSD-3-Clause
"""Moments of mass against sums over particles."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.expr import as_expr
from kane.tree import NO_MOMENTS, Moments, Rigid, Turn, moments


def triple(v):
    return tuple(as_expr(float(x)) for x in v)


def rows(a):
    return tuple(triple(row) for row in a)


def of_particles(masses, places):
    """m, h and E by NumPy."""
    return masses.sum(), masses @ places, np.einsum("i,ij,ik->jk", masses, places, places)


def inertia(e):
    return np.trace(e) * np.eye(3) - e


def numbers(found):
    m, h, e = found[:3]
    return (
        float(kn.evaluate([m], {})[0]),
        np.array(kn.evaluate(list(h), {})),
        np.array([kn.evaluate(list(r), {}) for r in e]),
    )


@pytest.fixture
def particles(rng):
    return rng.uniform(0.5, 2, 5), rng.normal(size=(5, 3))


def agree(found, expected):
    for a, b in zip(numbers(found), expected, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-13)


def test_those_of_an_inertia(particles):
    m, h, e = of_particles(*particles)
    found = moments(Rigid(as_expr(float(m)), triple(h), rows(inertia(e))))
    agree(found, (m, h, e))
    assert moments(Rigid(as_expr(0), triple(np.zeros(3)), rows(np.zeros((3, 3))))) is NO_MOMENTS
    for known in (found, found._replace(j=None)):
        assert float(known.about(1)) == pytest.approx(inertia(e)[1, 1])
        w = np.array([0.3, 0, -2.0])
        np.testing.assert_allclose(
            np.array(kn.evaluate(list(known.turned_by(triple(w))), {})), inertia(e) @ w, atol=1e-13
        )


def test_about_another_point_and_along_another_basis(particles):
    masses, places = particles
    m, h, e = of_particles(masses, places)
    found = Moments(as_expr(float(m)), triple(h), rows(e))
    r = np.array([0.7, 0, -0.4])
    agree(found.moved(triple(r)), of_particles(masses, places + r))
    A = kn.Frame("A")
    turn = Turn(A.rotate("B", 0.8, A.y))
    c, s = np.cos(0.8), np.sin(0.8)
    agree(found.turned(turn), of_particles(masses, places @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T))
    both = of_particles(np.tile(masses, 2), np.concatenate((places, places + r)))
    agree(found.plus(found.moved(triple(r))), both)


def test_what_a_body_presses_with_as_it_turns(particles, rng):
    """ω × J ω = (E ω) × ω, and Σ m r × (a × (b × r)) = (E a) × b."""
    masses, r = particles
    _, _, e = of_particles(masses, r)
    a, b = rng.normal(size=(2, 3))
    np.testing.assert_allclose(np.cross(b, inertia(e) @ b), np.cross(e @ b, b), atol=1e-12)
    np.testing.assert_allclose(masses @ np.cross(r, np.cross(a, np.cross(b, r))), np.cross(e @ a, b), atol=1e-12)
