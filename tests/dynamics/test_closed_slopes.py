# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of u̇ of trees that constraints close are those of u̇ as they stand, off the constraints too."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.dynamics import WAYS, closed_slopes, forward, inverse_dynamics
from kane.expr import ONE, price
from kane.gallery import load, pendulums
from kane.kinematics import Unsuited
from tests.equations.test_jacobian import numbers
from tests.oracles.duals import values_and_slopes
from tests.systems.rings import ring

GALLERY = ("four_bar", "slider_crank", "n_four_bar", "knife_edge", "snakeboard")


def check(system, rng):
    eom = kn.derive(system, route="recursive")
    symbols = (*eom.coordinates, *eom.speeds, *eom.inputs, *eom.parameters)
    columns = closed_slopes(eom.solved, symbols)
    values = numbers(eom, rng)
    wanted, expected = values_and_slopes(eom.accelerations, values, symbols)
    assert np.isfinite(wanted).all()
    found = np.array(kn.evaluate([c[k] for k in range(len(eom.speeds)) for c in columns], values), dtype=float)
    scale = np.abs(expected).max(axis=0, initial=0) + 1e-5 * np.abs(expected).max()
    assert np.abs((found.reshape(expected.shape) - expected) / scale).max() < 1e-9


@pytest.mark.parametrize("name", GALLERY)
def test_the_gallery(name, rng):
    check(load(name).system(), rng)


@pytest.mark.slow
@pytest.mark.parametrize("spatial", [False, True])
def test_rings(spatial, rng):
    check(ring(5, spatial), rng)


@pytest.mark.parametrize("route", WAYS)
def test_they_are_shorter_than_expressions_differentiated(route):
    eom = kn.derive(ring(6, True), route=route)
    assert eom.route == route
    as_they_stand = [e for s in eom.coordinates for e in forward(eom.solved, [s], [ONE])]
    found = [e for column in closed_slopes(eom.solved, eom.coordinates) for e in column]
    assert price(found) < 0.8 * price(as_they_stand)


def test_linear_equations_of_a_closed_tree_are_those_of_the_classical_route():
    """`linearize` differentiates inverse dynamics of the tree, and the forces of the constraints beside it."""
    own, usual = (kn.derive(ring(3), route=route) for route in ("recursive", "classical"))
    (free,) = usual.independent_speeds
    at = kn.assemble(usual, q=[kn.guess(x) for x in (0.5, 0.9, -2.0)], u={free: 0.7})
    one, other = (kn.linearize(e, q=at.q, u=at.u, independent=[free], steady=False) for e in (own, usual))
    assert one.states == other.states
    assert pytest.approx(other.A, rel=1e-8, abs=1e-9 * np.abs(other.A).max()) == one.A


def test_m_and_f_are_those_of_the_tree(rng):
    eom = kn.derive(ring(4, True))
    values = numbers(eom, rng)
    m, f = inverse_dynamics.mass_matrix(eom.derived), inverse_dynamics.forcing(eom.derived)
    for own, usual in ((m.entries, eom.mass_matrix.entries), (f, eom.forcing)):
        one, other = (np.array(kn.evaluate(list(x), values), dtype=float) for x in (own, usual))
        assert one == pytest.approx(other, rel=1e-9, abs=1e-10 * np.abs(other).max())
    assert price(f) < price(eom.forcing)


def test_what_no_constraint_closes():
    with pytest.raises(Unsuited, match="no constraints"):
        closed_slopes(kn.derive(pendulums.system(2)).solved, ())
