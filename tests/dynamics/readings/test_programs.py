# SPDX-License-Identifier: BSD-3-Clause
"""Inverse dynamics, M and f of trees by recursion, centroidal momentum, inertia at a point: against M, f and partial velocities."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.systems import arm
from kane.dynamics import inverse_dynamics as trees
from kane.expr import price, rate
from kane.gallery import load
from kane.kinematics import Unsuited
from tests.equations.test_jacobian import given_as, numbers
from tests.examples import examples
from tests.systems import jointed


@cache
def derived(name):
    return kn.derive(arm(name) if set(name) <= set("xyz") else load(name).system())


def values_of(eom, rng):
    values = numbers(eom, rng)
    return values | {rate(u): rng.normal() for u in eom.speeds}


def array(exprs, values):
    return np.array(kn.evaluate(list(exprs), values), dtype=float)


def same(found, expected):
    assert np.abs(found - expected).max(initial=0) <= 1e-10 * np.abs(expected).max(initial=1e-300)


@given(st.integers(0, 10**6))
@examples(0.1, 4)
def test_trees_by_recursion_are_as_by_partial_velocities(seed):
    eom = kn.derive(jointed.system(seed, 1 + seed % 4, jointed.KINDS))
    d, values = eom.derived, values_of(eom, np.random.default_rng(seed))
    u_dot = np.array([values[rate(u)] for u in eom.speeds])
    m = array(d.mass_matrix.entries, values).reshape(len(u_dot), -1)
    f = array(d.forcing, values)
    try:
        same(array(trees.residual(d), values), m @ u_dot - f)
    except Unsuited:
        return
    same(array(trees.forcing(d), values), f)
    same(array(trees.mass_matrix(d).entries, values).reshape(m.shape), m)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["zyzyzyz", "double_pendulum", "four_bar", "rolling_disk"])
def test_compiled_inverse_dynamics(name, rng):
    eom = derived(name)
    code = eom.compile(not_finite="ignore")
    t, x, p, r = given_as(eom, numbers(eom, rng))
    a = rng.normal(size=len(eom.speeds))
    f = code.forcing(t, x, p, r)
    if not eom.reactions:
        same(code.inverse_dynamics(t, x, a, p, r), code.mass_matrix(t, x, p, r) @ a - f)
    if not eom.constraints.constraints:
        own = code.rhs(t, x, p, r)[len(eom.coordinates) :]
        assert np.abs(code.inverse_dynamics(t, x, own, p, r)).max() <= 1e-12 * np.abs(f).max()


def test_of_an_arm_they_take_fewer_operations_than_the_right_hand_side():
    eom = derived("zyzyzyz")
    assert price(eom.inverse_dynamics) < 0.6 * eom.operations.total
    code = eom.compile()
    assert code._program(("mass_matrix",)).routine("mass_matrix").body
    assert price(trees.mass_matrix(eom.derived).entries) < 0.3 * price(eom.mass_matrix.entries)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["double_pendulum", "rolling_disk", "four_bar", "free_body", "zyzyzyz"])
def test_centroidal_momentum(name, rng):
    """A_G u is the momentum, and the angular momentum about the mass centre."""
    eom = derived(name)
    values = numbers(eom, rng)
    O = next(p for p in eom.points if p.position(p).is_zero and p is eom.points[0])
    N = eom.system.inertial
    p, r = eom.linear_momentum(), eom.mass_center(O)
    about = eom.angular_momentum(O) - r.cross(p)
    expected = array((*p.components(N), *about.components(N)), values)
    a = array(eom.centroidal_momentum_matrix.entries, values).reshape(6, -1)
    same(a @ np.array([values[u] for u in eom.speeds]), expected)
    code = eom.compile(outputs={"A_G": eom.centroidal_momentum_matrix}, not_finite="ignore")
    same(code.outputs(*given_as(eom, values))["A_G"], a)


@pytest.mark.parametrize("name", ["four_bar", "zyzyzyz", "whipple_bicycle"])
def test_mobility_at_a_point_and_of_a_frame(name, rng):
    """J M⁻¹ Jᵀ with J of the independent speeds."""
    eom = derived(name)
    values, N = numbers(eom, rng), eom.system.inertial
    m = array(eom.mass_matrix_nh.entries if eom.dependent_speeds else eom.mass_matrix.entries, values)
    n = len(eom.independent_speeds)
    last = eom.bodies[-1].part.mass_center
    for place, by in ((last, eom.partial_velocities_nh), (eom.frames[-1], eom.partial_angular_velocities_nh)):
        axes = (N.x, N.y, (N.x + N.z).normalized())
        j = array([by[place][u].dot(a) for a in axes for u in eom.independent_speeds], values).reshape(3, n)
        expected = j @ np.linalg.solve(m.reshape(n, n), j.T)
        found = array(eom.operational_mobility(place, axes).entries, values).reshape(3, 3)
        same(found, expected)
    one, first = eom.operational_inertia(last, [N.x]), eom.operational_mobility(last, [N.x])
    assert array(one.entries, values) @ array(first.entries, values) == pytest.approx(1)


def test_a_force_accelerates_a_point_by_its_mobility(rng):
    N = kn.Frame("N")
    O, F = kn.Point("O", fixed_in=N), kn.input("F")
    q1, q2 = kn.coordinates("q1:3")
    A = N.rotate("A", q1, N.z)
    P = O.at("P", A.x)
    Q = P.at("Q", N.rotate("B", q2, N.z).x)
    bodies = [kn.Particle("P", P, 1.0), kn.Particle("Q", Q, 2.0)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[kn.Force(Q, F * N.y)]))
    values = numbers(eom, rng)
    slope = array(eom.jacobian("inputs").matrix.entries, values)[2:]
    by_y = array([eom.partial_velocities[Q][u].dot(N.y) for u in eom.speeds], values)
    (found,) = array(eom.operational_mobility(Q, [N.y]).entries, values)
    assert by_y @ slope == pytest.approx(found, rel=1e-12)
    inertia = eom.operational_inertia(Q, [N.x, N.y])
    mobility = eom.operational_mobility(Q, [N.x, N.y])
    product = array(inertia.entries, values).reshape(2, 2) @ array(mobility.entries, values).reshape(2, 2)
    assert product == pytest.approx(np.eye(2), abs=1e-9)


def test_axes_that_are_not_independent_are_named():
    eom = derived("double_pendulum")
    N = eom.system.inertial
    with pytest.raises(kn.SingularError, match="operational_mobility"):
        eom.operational_inertia(eom.points[-1], [N.z])
    assert eom.operational_mobility(eom.points[-1], [N.z]).entries[0].args == ()
    with pytest.raises(kn.ArgumentError, match="a point or a frame"):
        eom.operational_mobility("P")
    with pytest.raises(kn.ArgumentError, match="a list of unit vectors"):
        eom.operational_mobility(eom.points[-1], N.x)
