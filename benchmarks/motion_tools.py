# SPDX-License-Identifier: BSD-3-Clause
"""Chains of rods for 10 s by several tools: the motion alone, to be timed, and the states at samples, whose energy tells the error.

Each tool makes its functions once, for any start and tolerance. kane, heyoka and diffrax compile the equations to machine code;
SciPy's solver is Python that calls compiled right-hand sides, CasADi's is SUNDIALS in C that calls its interpreter.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from math import cos, sin
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.peers import recursion
from benchmarks.stepping import GRAVITY, SAMPLES, SPAN, Heyoka, Kane

Array = Any
Run = Callable[[], object]


class SciPy:
    """DOP853 of SciPy with a right-hand side f(t, x)."""

    def __init__(self, rate: Callable[[float, Array], Array]) -> None:
        self.rate = rate

    def solved(self, q: Array, tolerance: float, times: Array | None) -> Any:
        """The motion, with the states at times."""
        x = np.append(q, 0 * q)
        return solve_ivp(self.rate, (0.0, SPAN), x, method="DOP853", t_eval=times, rtol=tolerance, atol=tolerance)

    def sampled(self, q: Array, tolerance: float) -> Array:
        """The states at the samples."""
        return self.solved(q, tolerance, SAMPLES).y.T

    def timed(self, q: Array, tolerance: float) -> Run:
        """The motion alone."""
        end = np.array([SPAN])
        return lambda: self.solved(q, tolerance, end)


def by_numba(n: int) -> SciPy:
    """The recursion as loops over arrays, compiled by Numba."""
    return SciPy(importlib.import_module("numba").njit(loops))


def loops(t: float, x: Array) -> Array:
    """(q̇, u̇) of rods of mass and length 1: `peers/recursion.py` in arrays, which Numba compiles."""
    n = len(x) // 2
    rods, out = np.empty((n, 6)), np.empty(2 * n)
    xx = xy = yy = bx = by = 0.0
    for i in range(n - 1, -1, -1):
        s, c, squared = sin(x[i]), cos(x[i]), x[n + i] * x[n + i]
        ax, ay = xx * c + xy * s, xy * c + yy * s
        hx, hy = 0.5 * c + ax, 0.5 * s + ay
        rx, ry = bx - squared * (xx * s - xy * c), by - squared * (xy * s - yy * c)
        k = c * rx + s * ry + 0.5 * GRAVITY * s
        d = 1 / 3 + c * ax + s * ay
        tx, ty = hx / d, hy / d
        xx, xy, yy = xx + 1 - tx * hx, xy - tx * hy, yy + 1 - ty * hy
        bx, by = rx - 0.5 * squared * s - tx * k, ry + 0.5 * squared * c + GRAVITY - ty * k
        rods[i, 0], rods[i, 1], rods[i, 2], rods[i, 3], rods[i, 4], rods[i, 5] = s, c, squared, tx, ty, k / d
    ax = ay = 0.0
    for i in range(n):
        s, c, squared = rods[i, 0], rods[i, 1], rods[i, 2]
        alpha = -(rods[i, 3] * ax + rods[i, 4] * ay + rods[i, 5])
        ax, ay = ax + c * alpha - s * squared, ay + s * alpha + c * squared
        out[i], out[n + i] = x[n + i], alpha
    return out


def by_pydy(n: int) -> SciPy:
    """SymPy's equations in PyDy's Cython."""
    from benchmarks.peers.pydy_cython import chain

    names, function = chain(n)
    p = np.array([GRAVITY if name == "g" else 1.0 for name in names])
    return SciPy(lambda t, x: function(x, t, p).copy())  # it writes to one array, which the solver keeps


class Sundials:
    """CVODES through CasADi, with the recursion."""

    def __init__(self, n: int) -> None:
        import casadi as ca

        self.ca, x = ca, ca.SX.sym("x", 2 * n)
        parts = ca.vertsplit(x)
        found = recursion.accelerations(parts[:n], parts[n:], [1.0] * n, [1.0] * n, GRAVITY, ca.sin, ca.cos)
        self.dae = {"x": x, "ode": ca.vertcat(x[n:], *found)}
        self.made: dict[tuple[float, int], Any] = {}

    def integrator(self, tolerance: float, times: Array) -> Any:
        """One a tolerance and set of times."""
        key = tolerance, len(times)
        if key not in self.made:
            options = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**7}
            self.made[key] = self.ca.integrator("motion", "cvodes", self.dae, 0.0, list(times), options)
        return self.made[key]

    def sampled(self, q: Array, tolerance: float) -> Array:
        """The states at the samples."""
        found = self.integrator(tolerance, SAMPLES[1:])(x0=np.append(q, 0 * q))["xf"]
        return np.vstack([np.append(q, 0 * q), np.asarray(found).T])

    def timed(self, q: Array, tolerance: float) -> Run:
        """The motion alone."""
        run, x = self.integrator(tolerance, np.array([SPAN])), np.append(q, 0 * q)
        return lambda: run(x0=x)


class Diffrax:
    """Dopri8 of diffrax, compiled by JAX in double precision."""

    def __init__(self, n: int) -> None:
        jax, self.diffrax = importlib.import_module("jax"), importlib.import_module("diffrax")
        jax.config.update("jax_enable_x64", True)
        jnp = importlib.import_module("jax.numpy")

        def rate(t: Any, x: Any, args: Any) -> Any:
            own = [x[i] for i in range(2 * n)]
            found = recursion.accelerations(own[:n], own[n:], [1.0] * n, [1.0] * n, GRAVITY, jnp.sin, jnp.cos)
            return jnp.stack([*own[n:], *found])

        def solve(x: Any, tolerance: Any, times: Any) -> Any:
            d = self.diffrax
            control = d.PIDController(rtol=tolerance, atol=tolerance)
            save = d.SaveAt(ts=times)
            term = d.ODETerm(rate)
            return d.diffeqsolve(
                term, d.Dopri8(), 0.0, SPAN, 1e-3, x, stepsize_controller=control, saveat=save, max_steps=10**6
            ).ys

        self.solve, self.array = jax.jit(solve), jnp.asarray

    def sampled(self, q: Array, tolerance: float) -> Array:
        """The states at the samples."""
        return np.asarray(self.solve(self.array(np.append(q, 0 * q)), tolerance, self.array(SAMPLES)))

    def timed(self, q: Array, tolerance: float) -> Run:
        """The motion alone."""
        x, end = self.array(np.append(q, 0 * q)), self.array([SPAN])
        return lambda: self.solve(x, tolerance, end).block_until_ready()


TOOLS: Mapping[str, Callable[[int], Any]] = {
    "kane, gauss16": lambda n: Kane(n, "gauss16"),
    "kane, tsitpap8": lambda n: Kane(n, "tsitpap8"),
    "kane, dop853": lambda n: Kane(n, "dop853"),
    "heyoka, Taylor": Heyoka,
    "SciPy DOP853, Numba": by_numba,
    "SciPy DOP853, PyDy": by_pydy,
    "SUNDIALS CVODES, CasADi": Sundials,
    "diffrax, Dopri8": Diffrax,
}
"""By what the page calls them."""
