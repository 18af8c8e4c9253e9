# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of the right-hand side: against dual numbers, products against the matrix, patterns, NaN where values are."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import kane as kn
from benchmarks.random_trees import random_tree
from kane.gallery import GALLERY, load
from tests.examples import examples
from tests.oracles.duals import values_and_slopes
from tests.program.emitted import from_c, module
from tests.systems import jointed

KINDS = ("state", "inputs", "parameters", "time")


@cache
def derived(name):
    return kn.derive(load(name).system())


def numbers(eom, rng):
    """A value for every symbol: sets of Euler parameters of length 1, parameters at their defaults."""
    values = {kn.time: 0.3, **{r: rng.uniform(-1, 1) for r in eom.inputs}}
    values |= {s: rng.uniform(0.3, 1.1) for s in (*eom.coordinates, *eom.speeds, *eom.states)}
    for group in eom.system.euler_parameters:
        length = np.sqrt(sum(values[e] ** 2 for e in group.coordinates))
        values |= {e: values[e] / length for e in group.coordinates}
    return values | {p: rng.uniform(0.9, 1.1) * (1.0 if p.default is None else p.default) for p in eom.parameters}


def given_as(eom, values):
    """t, x, p, r."""
    groups = ((*eom.coordinates, *eom.speeds, *eom.states), eom.parameters, eom.inputs)
    return values[kn.time], *(np.array([values[s] for s in group]) for group in groups)


def close(found, expected, size=None):
    """Equal to 1e-9 of the largest of each row, which is zero where it is 1e-5 of the largest of all."""
    assert np.array_equal(np.isfinite(found), np.isfinite(expected))
    sizes = np.abs(expected if size is None else size)
    scale = sizes.max(axis=-1, keepdims=True, initial=1e-300) + 1e-5 * sizes.max(initial=0)
    assert np.abs(np.nan_to_num(found - expected) / scale).max(initial=0) < 1e-9


def tangents(eom, columns, values):
    """Directions of the columns that leave sets of Euler parameters of length 1."""
    project, place = np.eye(len(columns)), {s: k for k, s in enumerate(columns)}
    for group in eom.system.euler_parameters:
        own = [place[e] for e in group.coordinates if e in place]
        e = np.array([values[columns[k]] for k in own])
        project[np.ix_(own, own)] -= np.outer(e, e)
    return project


def check(eom, rng, kinds=KINDS):
    values = numbers(eom, rng)
    for kind in kinds:
        j = eom.jacobian(kind)
        _, expected = values_and_slopes(eom.right_hand_side, values, j.columns)
        if not eom.system.euler_parameters:
            close(np.where(j.pattern, expected, 0.0), expected)
        found = np.array(kn.evaluate(list(j.matrix.entries), values), dtype=float).reshape(j.matrix.shape)
        along = tangents(eom, j.columns, values)
        close(found @ along, expected @ along, expected)
    return values


@pytest.mark.slow
@pytest.mark.parametrize("name", list(GALLERY))
def test_the_gallery_against_dual_numbers(name, rng):
    check(derived(name), rng)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_random_trees_against_dual_numbers(seed, rng):
    check(kn.derive(jointed.system(seed, 1 + seed % 4, jointed.PLAIN)), rng, ("state", "inputs"))


@given(st.integers(0, 10**6))
@examples(0.02, 2)
def test_trees_of_joints_of_every_kind(seed):
    check(kn.derive(jointed.system(seed, 1 + seed % 3, jointed.KINDS)), np.random.default_rng(seed), ("state",))


def on_a_curve():
    """A pendulum that hangs on a bead, which slides along a curve that moves: directions of freedom hold symbols of every kind."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    s, theta = kn.coordinates("s theta")
    m, l, a, b = (kn.parameter(name, x) for name, x in (("m", 1.2), ("l", 0.7), ("a", 0.4), ("b", 0.3)))
    F = kn.input("F")
    P = O.at("P", b * s * N.x + a * (kn.sin(s) + kn.sin(kn.time) * s) * N.y)
    A = N.rotate("A", theta, N.z)
    Q = P.at("Q", l * A.x)
    bodies = [kn.Particle("P", P, m), kn.Particle("Q", Q, m)]
    return kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-9.81 * N.y), kn.Force(Q, F * N.x)])


@pytest.mark.parametrize("route", ["classical", "recursive"])
def test_columns_of_any_kind_and_order(route, rng):
    eom = kn.derive(on_a_curve(), route=route)
    values = check(eom, rng)
    by = {
        s: column
        for j in map(eom.jacobian, KINDS)
        for s, column in zip(j.columns, zip(*j.matrix, strict=True), strict=True)
    }
    asked = [s for s in by if s is not kn.time and rng.random() < 0.5]
    rng.shuffle(asked)
    j = eom.jacobian(asked)
    assert j.columns == tuple(asked)
    found, expected = (
        np.array(kn.evaluate([e for column in columns for e in column], values))
        for columns in (zip(*j.matrix, strict=True), map(by.get, asked))
    )
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["double_pendulum", "rolling_disk", "four_bar", "pendulum_on_cart"])
def test_compiled_products_are_those_of_the_matrix(name, rng):
    eom = derived(name)
    code = eom.compile(not_finite="ignore")
    t, x, p, r = given_as(eom, numbers(eom, rng))
    j, v, w = code.jac(t, x, p, r), rng.normal(size=len(x)), rng.normal(size=len(x))
    assert j.shape == (len(x), len(x))
    close(code.jvp(t, x, v, p, r), j @ v, np.abs(j) @ np.abs(v))
    close(code.vjp(t, x, w, p, r), w @ j, np.abs(w) @ np.abs(j))
    assert code.jvp(t, x, np.eye(len(x)), p, r).shape == j.shape  # variational equations: many directions in one call
    h = 1e-6
    ahead, behind = (w @ code.jac(t, x + s * h * v, p, r) for s in (1, -1))
    assert code.hvp(t, x, v, w, p, r) == pytest.approx((ahead - behind) / (2 * h), rel=1e-6, abs=1e-6 * np.abs(j).max())
    assert code.jac_parameters(t, x, p, r).shape == (len(x), len(p))
    assert code.jac_inputs(t, x, p, r).shape == (len(x), len(r))
    assert code.jac_time(t, x, p, r).shape == (len(x), 1)


def test_the_pendulum_in_text():
    eom = derived("pendulum")
    j = eom.jacobian()
    assert [str(s) for s in (*j.rows, *j.columns)] == ["theta'", "u_theta'", "theta", "u_theta"]
    assert j.pattern.tolist() == [[False, True], [True, True]]
    assert {f"{r}/{c}": str(e) for (r, c), e in j.entries.items()} == {
        "theta'/u_theta": "1",
        "u_theta'/theta": "-m*g*l*cos(theta)/(m*l^2 + I)",
        "u_theta'/u_theta": "-c/(m*l^2 + I)",
    }
    assert repr(j).startswith("Jacobian(2 × 2, 3 entries not zero, ")
    assert eom.jacobian(["theta"]).columns == eom.coordinates
    assert eom.jacobian("u_theta").columns == eom.speeds


def test_what_is_none_of_the_columns_is_named():
    with pytest.raises(kn.ValueMissingError, match="wind"):
        derived("pendulum").jacobian(["wind"])
    with pytest.raises(kn.ArgumentError, match="by= one of 'state', 'inputs', 'parameters', 'time', or a list"):
        derived("pendulum").jacobian(3)


@pytest.mark.parametrize(("name", "coordinate"), [("slider_crank", "q1"), ("rolling_disk", "q2")])
def test_it_is_nan_where_the_values_are(name, coordinate):
    """At a dead centre the dependent speeds do not follow, and at a pole of W the rates: then derivatives are no numbers either."""
    eom = derived(name)
    code = eom.compile(not_finite="ignore")
    t, x, p, r = given_as(eom, numbers(eom, np.random.default_rng(0)))
    assert np.isfinite(code.rhs(t, x, p, r)).all()
    assert np.isfinite(code.jac(t, x, p, r)).all()
    x[[q.name for q in eom.coordinates].index(coordinate)] = np.pi / 2
    lost = ~np.isfinite(code.rhs(t, x, p, r))
    assert lost.any()
    bad = ~np.isfinite(code.jac(t, x, p, r))
    assert bad[lost].any(axis=1).all()
    assert not bad[~lost].any()
    assert not np.isfinite(code.jvp(t, x, np.ones(len(x)), p, r)[lost]).any()
    assert not np.isfinite(code.vjp(t, x, 1.0 * lost, p, r)).all()


def test_a_size_of_a_velocity_at_rest_has_the_mean_slope_of_all_sides():
    N = kn.Frame("N")
    x, v, m, k = kn.coordinate("x"), kn.speed("v"), kn.parameter("m", 2.0), kn.parameter("k", 3.0)
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    drag = kn.Force(P, -k * kn.sqrt(v * v) * v * N.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("P", P, m)], speeds={v: x.dt}, loads=[drag]))
    code = eom.compile()
    assert code.jac(0.0, np.zeros(2)).tolist() == [[0, 1], [0, 0]]
    assert code.vjp(0.0, np.zeros(2), np.ones(2)).tolist() == [0, 1]
    assert code.jac(0.0, np.array([0, 2.0]))[1, 1] == pytest.approx(-3 / 2 * 2 * 2)


def test_a_tree_of_ten_bodies(rng):
    check(kn.derive(random_tree((-1, -1, 1, 0, -1, -1, 4, -1, 1, 0), 1)), rng, ("state",))


def on_a_track(load):
    """A particle along x, pushed by `load` of its place and speed."""
    N = kn.Frame("N")
    x, v = kn.coordinate("x"), kn.speed("v")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x)
    return kn.derive(
        kn.System(N, bodies=[kn.Particle("P", P, 2.0)], speeds={v: x.dt}, loads=[kn.Force(P, load(x, v) * N.x)])
    )


def test_a_corner_has_no_derivative_and_is_named():
    eom = on_a_track(lambda x, v: -3 * abs(x) - x * abs(v))
    j = eom.jacobian()
    assert j.at(q=[0.5], u=[0.2])[1].tolist() == [-1.6, -0.25]
    with pytest.raises(kn.CornerError, match=r"got a corner: abs\(x\) switches at x = 0"):
        j.at(q=[0], u=[0.2])
    assert j.at(q=[0.5], u=[[0.2, 0.3]]).shape == (2, 2, 2)
    with pytest.raises(kn.CornerError, match="a corner at"):
        j.at(q=[[0.5, 0.0]], u=[0.2])


def test_what_is_smooth_at_a_switch_has_its_derivative():
    eom = on_a_track(lambda x, v: x * abs(x) + kn.max(x, x) - v * abs(v))
    assert eom.jacobian().at(q=[0], u=[0]).tolist() == [[0, 1], [0.5, 0]]


def test_at_a_state_without_values_it_raises_as_they_do():
    eom = derived("slider_crank")
    q = {"q1": np.pi / 2, "q2": 0.1, "x": 0.4}
    (own,) = eom.independent_speeds
    for ask in (eom.jacobian().at, lambda **state: eom.evaluate(list(eom.accelerations), **state)):
        with pytest.raises(kn.SingularError, match="u1"):
            ask(q=q, u={own: 0.2})


@pytest.mark.parametrize("routine", ["jac", "jvp", "inverse_dynamics"])
def test_emitted_text_gives_the_same(routine, rng, tmp_path):
    eom = derived("double_pendulum")
    code = eom.compile()
    t, x, p, r = given_as(eom, numbers(eom, rng))
    more = {"jac": (), "jvp": (rng.normal(size=len(x)),), "inverse_dynamics": (rng.normal(size=2),)}[routine]
    expected = np.ravel(getattr(code, routine)(t, x, *more, p, r))
    values = np.concatenate([[t], x, *more, p, r])
    program = code._program((routine,))
    assert from_c(program, tmp_path, contract=True)(routine, [values])[0] == pytest.approx(expected, rel=1e-12)
    printed = module(code.emit("numpy", [routine]), tmp_path / "printed.py")
    assert np.ravel(getattr(printed, routine)(t, x, *more, p, r)) == pytest.approx(expected, rel=1e-12)


def test_sensitivities_of_a_motion_are_those_of_the_flow():
    """x and S = ∂x/∂(x₀, p) together, against motions beside it; the adjoint gives the gradient of wᵀx at the end."""
    eom = derived("double_pendulum")
    code = eom.compile()
    p, x0 = code.parameters(), np.array([0.4, 0.9, 0.1, -0.2])
    n, m = len(x0), len(p)
    v0, s = np.vstack([np.eye(n), np.zeros((m, n))]), np.vstack([np.zeros((n, m)), np.eye(m)])

    def both(t, y):
        x, v = y[:n], y[n:].reshape(n + m, n)
        return np.concatenate([code.rhs(t, x, p), code.sensitivity(t, x, v, s, p).ravel()])

    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-11}
    whole = solve_ivp(both, (0, 1), np.concatenate([x0, v0.ravel()]), **options)
    found = whole.y[n:, -1].reshape(n + m, n)

    def end(x, own):
        return solve_ivp(lambda t, y: code.rhs(t, y, own), (0, 1), x, **options).y[:, -1]

    h = 1e-5
    for k in range(n + m):
        (ahead, one), (behind, other) = ((x0 + d * v0[k], p + d * s[k]) for d in (h, -h))
        assert found[k] == pytest.approx((end(ahead, one) - end(behind, other)) / (2 * h), abs=1e-6)
    w = np.array([1.0, -0.5, 0.3, 0.2])

    def back(t, y):
        x, a = y[:n], y[n : 2 * n]
        return np.concatenate([code.rhs(t, x, p), -code.vjp(t, x, a, p), -code.vjp_parameters(t, x, a, p)])

    start = np.concatenate([end(x0, p), w, np.zeros(m)])
    adjoint = solve_ivp(back, (1, 0), start, **options).y[n:, -1]
    assert adjoint == pytest.approx(found @ w, abs=1e-7)
