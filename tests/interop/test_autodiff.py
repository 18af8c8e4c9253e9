# SPDX-License-Identifier: BSD-3-Clause
"""Equations as functions of JAX, PyTorch and CasADi: values and derivatives of our own machine code and of the tools' rules."""

import importlib.util
from collections import Counter

import numpy as np
import pytest

import kane as kn
from kane.gallery import four_bar, pendulums, rolling_disk
from tests.peer import require

TORCH = importlib.util.find_spec("torch") is not None  # some 3 GB: `make test-torch` brings it
TOOLS = ["jax", *["torch"] * TORCH]
MODELS = {"disk": rolling_disk.system, "rods": lambda: pendulums.system(2), "closed loop": four_bar.system}


def jax64():
    jax = require("jax")
    jax.config.update("jax_enable_x64", True)
    return jax


@pytest.fixture(
    scope="module", params=["rods", *(pytest.param(m, marks=pytest.mark.slow) for m in ("disk", "closed loop"))]
)
def model(request):
    eom = kn.derive(MODELS[request.param]())
    return eom, eom.compile(not_finite="ignore"), request.param


def state(eom, seed=1):
    return np.random.default_rng(seed).uniform(0.3, 1.1, len(eom.solved.derived.state))


def close(found, expected):
    expected = np.asarray(expected)
    scale = np.abs(expected).max(initial=1.0)
    np.testing.assert_allclose(np.asarray(found), expected, rtol=1e-12, atol=1e-12 * scale)


def tool(name):
    """(function, array, Jacobian by the tool's own rules)."""
    if name == "jax":
        jax = jax64()
        return kn.exchange.to_jax, np.asarray, lambda f: jax.jit(jax.jacrev(f))
    torch = require("torch")
    return kn.exchange.to_torch, lambda v: torch.tensor(np.asarray(v)), torch.func.jacrev


@pytest.mark.parametrize("name", TOOLS)
def test_values_and_derivatives_are_those_of_machine_code(name, model):
    eom, compiled, _ = model
    to, array, jacobian = tool(name)
    x, p = state(eom), compiled.parameters()
    f = to(eom)
    close(f(0.0, array(x)), compiled.rhs(0.0, x))
    close(f(0.0, array(x), array(p)), compiled.rhs(0.0, x))
    close(jacobian(lambda v: f(0.0, v))(array(x)), compiled.jac(0.0, x))
    close(jacobian(lambda v: f(0.0, array(x), v))(array(p)), compiled.jac_parameters(0.0, x))


@pytest.mark.parametrize("name", TOOLS)
def test_further_axes_come_first(name, model):
    eom, compiled, _ = model
    to, array, _ = tool(name)
    x = np.stack([state(eom, k) for k in range(6)]).reshape(2, 3, -1)
    for routine in ("rhs", "mass_matrix", "reactions"):
        expected = getattr(compiled, routine)(0.0, x)
        found = np.asarray(to(eom, routine)(0.0, array(x)))
        assert found.shape == expected.shape
        close(found, expected)


@pytest.mark.parametrize("native", [False, True])
@pytest.mark.parametrize("name", TOOLS)
def test_parameters_by_name_may_be_traced_and_have_axes(name, native):
    """They were refused as no numbers, so that nothing was differentiated by them."""
    to, array, jacobian = tool(name)
    eom = kn.derive(pendulums.system(2))
    compiled, f, x = eom.compile(), to(eom, native=native), state(eom)
    first, last = eom.parameters[0], eom.parameters[-1].name
    found = jacobian(lambda v: f(0.0, array(x), {first: v[0], last: v[1]}))(array([1.1, 0.7]))
    close(found, compiled.jac_parameters(0.0, x, p={first: 1.1, last: 0.7})[:, [0, -1]])
    several = importlib.import_module("jax.numpy").array([0.9, 1.2]) if name == "jax" else array([0.9, 1.2])
    many = f(0.0, array(x), {first: several, last: 2.0})
    close(many, [compiled.rhs(0.0, x, p={first: v, last: 2.0}) for v in (0.9, 1.2)])


@pytest.mark.slow
def test_jax_maps_and_differentiates_twice():
    """∂(wᵀ J v)/∂x beside our own, and vmap beside a loop."""
    jax = jax64()
    eom = kn.derive(pendulums.system(3))
    compiled, f = eom.compile(), kn.exchange.to_jax(eom)
    x, v, w = (state(eom, k) for k in (1, 2, 3))
    twice = jax.grad(lambda x: jax.jvp(lambda y: f(0.0, y), (x,), (v,))[1] @ w)
    close(twice(x), compiled.hvp(0.0, x, v, w))
    rows = np.stack([x, v, w])
    close(jax.vmap(lambda y: f(0.0, y))(rows), compiled.rhs(0.0, rows))
    a = np.linspace(1.0, 2.0, 3)
    close(kn.exchange.to_jax(eom, "inverse_dynamics")(0.0, x, a=a), compiled.inverse_dynamics(0.0, x, a))


def test_parameters_by_name_and_what_is_refused():
    jax = jax64()
    eom = kn.derive(rolling_disk.system())
    f, compiled, x = kn.exchange.to_jax(eom), eom.compile(), state(kn.derive(rolling_disk.system()))
    close(f(0.0, x, {"m": 2.0}), compiled.rhs(0.0, x, {"m": 2.0}))
    with pytest.raises(
        kn.ArgumentError, match=r"Expected 10 values of x \(q1, .*\) on the last axis, got an array of shape \(9,\)"
    ):
        f(0.0, x[:9])
    with pytest.raises(kn.ArgumentError, match="4 values of p"):
        f(0.0, x, [1.0])
    with pytest.raises(kn.ArgumentError, match="Expected arguments t, x, p, r, each once"):
        f(0.0, x, y=2)
    with pytest.raises(kn.ArgumentError, match="Expected a routine among rhs, mass_matrix"):
        kn.exchange.to_jax(eom, "velocity")
    with pytest.raises(kn.ArgumentError, match="Expected Equations, got System"):
        kn.exchange.to_jax(eom.system)
    jax.config.update("jax_enable_x64", False)
    try:
        with pytest.raises(kn.ArgumentError, match="Expected JAX in double precision"):
            kn.exchange.to_jax(eom)
        single = kn.exchange.to_jax(eom, single=True)(0.0, x)
        np.testing.assert_allclose(single, compiled.rhs(0.0, x), rtol=1e-4)
    finally:
        jax.config.update("jax_enable_x64", True)


def test_a_tool_that_is_not_there(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "casadi", None)
    with pytest.raises(kn.ArgumentError, match="Expected casadi to be installed"):
        kn.exchange.to_casadi(kn.derive(rolling_disk.system()))


# ------------------------------------------------------------------------------------------------------------ CasADi


def test_casadi_has_values_and_derivatives_of_machine_code(model):
    ca = require("casadi")
    eom, compiled, _ = model
    x, p, r = state(eom), compiled.parameters(), np.zeros(len(eom.inputs))
    f = kn.exchange.to_casadi(eom)
    assert f.name_in() == ["t", "x", "p", "r"]
    close(np.asarray(f(0, x, p, r)).reshape(-1), compiled.rhs(0.0, x))
    symbols = [ca.SX.sym(name, n) for name, n in zip("txpr", (1, len(x), len(p), len(r)), strict=True)]
    for k, name in ((1, "jac"), (2, "jac_parameters")):
        slope = ca.Function("slope", symbols, [ca.jacobian(f(*symbols), symbols[k])])
        close(np.asarray(slope(0, x, p, r)), getattr(compiled, name)(0.0, x))
    close(np.asarray(kn.exchange.to_casadi(eom, "mass_matrix")(0, x, p, r)), compiled.mass_matrix(0.0, x))


def test_the_residual_is_zero_at_the_rates_of_the_motion_alone(model):
    require("casadi")
    eom, compiled, name = model
    x, p, r = state(eom), compiled.parameters(), np.zeros(len(eom.inputs))
    xdot = compiled.rhs(0.0, x)
    residual = kn.exchange.to_casadi(eom, "residual")
    assert residual.name_in() == ["t", "x", "xdot", "p", "r"]
    at = np.asarray(residual(0, x, xdot, p, r)).reshape(-1)
    scale = np.abs(np.asarray(residual(0, x, xdot + 1.0, p, r))).max()
    assert np.abs(at).max() <= 1e-12 * scale
    slope = np.column_stack([np.asarray(residual(0, x, xdot + e, p, r)).reshape(-1) - at for e in np.eye(len(x))])
    assert np.linalg.matrix_rank(slope) == len(x), name


FREE = {"OP_INPUT", "OP_OUTPUT", "OP_CONST", "OP_PARAMETER", "OP_NEG", "OP_ASSIGN"}


def test_casadi_s_graph_of_ten_rods_is_as_short_as_our_code():
    ca = require("casadi")
    names = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}
    eom = kn.derive(pendulums.system(10))
    f = kn.exchange.to_casadi(eom)
    found = Counter(names[f.instruction_id(k)] for k in range(f.n_instructions()))
    own = eom.compile().operations["rhs"]
    assert sum(n for op, n in found.items() if op not in FREE) <= own.total
