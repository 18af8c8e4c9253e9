# SPDX-License-Identifier: BSD-3-Clause
"""The pendulum of rods by SymPy's KanesMethod and PyDy's code, Cython or SymPy's lambdify: called from Python only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import sympy as sm
from pydy.codegen.ode_function_generators import generate_ode_function
from sympy.physics import mechanics as me

from benchmarks.native import Array


def chain(n: int, generator: str = "cython") -> tuple[tuple[str, ...], Any]:
    """The names of the parameters and PyDy's function (x, t, p) → ẋ of n uniform rods, u = q̇."""
    q, u = me.dynamicsymbols(f"q1:{n + 1}"), me.dynamicsymbols(f"u1:{n + 1}")
    masses, lengths, g = sm.symbols(f"m1:{n + 1}"), sm.symbols(f"l1:{n + 1}"), sm.Symbol("g")
    N, end = me.ReferenceFrame("N"), me.Point("O")
    end.set_vel(N, 0)
    bodies, loads = [], []
    for i in range(n):
        frame = N.orientnew(f"B{i + 1}", "Axis", [q[i], N.z])
        frame.set_ang_vel(N, u[i] * N.z)
        center = end.locatenew(f"C{i + 1}", -lengths[i] / 2 * frame.y)
        center.v2pt_theory(end, N, frame)
        across = masses[i] * lengths[i] ** 2 / 12
        bodies.append(
            me.RigidBody(f"R{i + 1}", center, frame, masses[i], (me.inertia(frame, across, 0, across), center))
        )
        loads.append((center, -masses[i] * g * N.y))
        tip = end.locatenew(f"P{i + 1}", -lengths[i] * frame.y)
        tip.v2pt_theory(end, N, frame)
        end = tip
    method = me.KanesMethod(N, q_ind=q, u_ind=u, kd_eqs=[a.diff() - b for a, b in zip(q, u, strict=True)])
    method.kanes_equations(bodies, loads)
    constants = [*masses, *lengths, g]
    function = generate_ode_function(
        method.forcing,
        q,
        u,
        constants,
        mass_matrix=method.mass_matrix,
        coordinate_derivatives=sm.Matrix(u),
        generator=generator,
        constants_arg_type="array",
    )
    return tuple(s.name for s in constants), function


def call(
    n: int, x: Array, values: Mapping[str, float], generator: str = "cython"
) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """The function and its arguments."""
    names, function = chain(n, generator)
    return function, (x, 0.0, np.array([values[name] for name in names]))
