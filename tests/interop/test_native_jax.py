# SPDX-License-Identifier: BSD-3-Clause
"""Machine code that XLA calls, beside the same operations as JAX's own: values, axes, derivatives of both modes and orders."""

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums, rolling_disk
from tests.interop.test_autodiff import close, jax64, state


@pytest.fixture(scope="module", params=["rods", pytest.param("disk", marks=pytest.mark.slow)])
def both(request):
    jax = jax64()
    eom = kn.derive(pendulums.system(2) if request.param == "rods" else rolling_disk.system())
    return jax, eom, kn.exchange.to_jax(eom, native=True), jax.jit(kn.exchange.to_jax(eom))


def test_values_with_axes_that_broadcast_in_any_order(both):
    jax, eom, native, traced = both
    x = np.stack([state(eom, k) for k in range(3)])
    p = eom.compile().parameters() * np.array([[1.0], [1.1]])
    close(jax.jit(native)(0.2, x[0]), traced(0.2, x[0]))
    t = np.arange(2.0)
    close(native(t, x[:, None], p), traced(t, x[:, None], p))

    def nested(f):
        return jax.jit(jax.vmap(jax.vmap(lambda x, p: f(0.2, x, p), (0, None)), (None, 0)))(x, p)

    close(nested(native), nested(traced))
    assert native(0.2, x[:0]).shape == x[:0].shape


def test_derivatives_in_both_modes_under_maps_and_once_more(both):
    jax, eom, native, traced = both
    x, p = state(eom), eom.compile().parameters()
    for mode in (jax.jacfwd, jax.jacrev):
        found, expected = (jax.jit(mode(f, argnums=(0, 1, 2)))(0.2, x, p) for f in (native, traced))
        for one, other in zip(found, expected, strict=True):
            close(one, other)
    rows = np.stack([x, 1.1 * x])

    def grad_of_map(f):
        return jax.jit(jax.grad(lambda rows: jax.vmap(lambda y: f(0.2, y)[-1] ** 2)(rows).sum()))(rows)

    close(grad_of_map(native), grad_of_map(traced))
    close(*(jax.jit(jax.hessian(lambda y, f=f: f(0.2, y)[-1]))(x) for f in (native, traced)))


@pytest.mark.slow
def test_a_motion_is_differentiated_through_its_steps():
    jax = jax64()
    eom = kn.derive(pendulums.system(4))
    x = state(eom)

    def end(f):
        return jax.jit(jax.grad(lambda x: jax.lax.scan(lambda y, _: (y + 1e-2 * f(0.0, y), 0), x, None, 50)[0].sum()))

    close(end(kn.exchange.to_jax(eom, native=True))(x), end(kn.exchange.to_jax(eom))(x))
    for name in ("mass_matrix", "reactions"):  # without compiled derivatives, and without results
        found, expected = (jax.jacfwd(kn.exchange.to_jax(eom, name, native=n), 1)(0.0, x) for n in (True, False))
        close(found, expected)


def test_single_precision_is_refused():
    jax, eom = jax64(), kn.derive(pendulums.system(2))
    jax.config.update("jax_enable_x64", False)
    try:
        with pytest.raises(kn.ArgumentError, match="Expected JAX in double precision"):
            kn.exchange.to_jax(eom, single=True, native=True)
    finally:
        jax.config.update("jax_enable_x64", True)
