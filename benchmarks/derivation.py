# SPDX-License-Identifier: BSD-3-Clause
"""Derivation of the n-link pendulum on a cart against SymPy's KanesMethod, the same model in the same process.

Both sides declare the system and derive it, from cold caches: SymPy's cache is cleared and kane's node table swept before
each run. The accelerations are compared first.
"""

from __future__ import annotations

import platform

import numpy as np
import sympy as sm
from sympy.core.cache import clear_cache
from sympy.physics import mechanics as me

import kane as kn
from benchmarks.paired import Pairs, paired
from kane.expr.node import sweep
from kane.gallery.pendulums import system as chain


def sympy_pendulum_on_cart(n: int) -> me.KanesMethod:
    """The model of `chain(n, cart=True)`: uniform rods, absolute angles."""
    x, v = me.dynamicsymbols("x v")
    q = me.dynamicsymbols(f"q1:{n + 1}")
    u = me.dynamicsymbols(f"u1:{n + 1}")
    masses, lengths = sm.symbols(f"m1:{n + 1}"), sm.symbols(f"l1:{n + 1}")
    m0, g = sm.symbols("m0 g")
    N, O = me.ReferenceFrame("N"), me.Point("O")
    O.set_vel(N, 0)
    end = O.locatenew("A", x * N.x)
    end.set_vel(N, v * N.x)
    bodies: list[object] = [me.Particle("cart", end, m0)]
    loads = []
    for i in range(n):
        frame = N.orientnew(f"B{i + 1}", "Axis", [q[i], N.z])
        frame.set_ang_vel(N, u[i] * N.z)
        center = end.locatenew(f"C{i + 1}", -lengths[i] / 2 * frame.y)
        center.v2pt_theory(end, N, frame)
        inertia = me.inertia(frame, masses[i] * lengths[i] ** 2 / 12, 0, masses[i] * lengths[i] ** 2 / 12)
        bodies.append(me.RigidBody(f"R{i + 1}", center, frame, masses[i], (inertia, center)))
        loads.append((center, -masses[i] * g * N.y))
        tip = end.locatenew(f"P{i + 1}", -lengths[i] * frame.y)
        tip.v2pt_theory(end, N, frame)
        end = tip
    rates = [x.diff() - v, *(a.diff() - b for a, b in zip(q, u, strict=True))]
    method = me.KanesMethod(N, q_ind=[x, *q], u_ind=[v, *u], kd_eqs=rates)
    method.kanes_equations(bodies, loads)
    return method


def check(n: int) -> float:
    """Largest relative difference of the accelerations at a random state, all parameters at their defaults."""
    generator = np.random.default_rng(n)
    q, u = generator.uniform(-1, 1, n + 1), generator.uniform(-1, 1, n + 1)
    eom = kn.derive(chain(n, cart=True))
    ours = np.array(eom.evaluate(eom.accelerations, q=q, u=u), dtype=float)
    method = sympy_pendulum_on_cart(n)
    numbers = dict(zip([*method.q, *method.u], [*q, *u], strict=True))
    for s in method.mass_matrix.free_symbols | method.forcing.free_symbols:
        if s is not me.dynamicsymbols._t:
            numbers[s] = 9.81 if s.name == "g" else 1.0
    mass = np.array(method.mass_matrix.xreplace(numbers), dtype=float)
    forcing = np.array(method.forcing.xreplace(numbers), dtype=float).ravel()
    theirs = np.linalg.solve(mass, forcing)
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


def measure(n: int = 10, pairs: int = 15) -> Pairs:
    """Paired times of both derivations."""

    def ours() -> object:
        return kn.derive(chain(n, cart=True))

    def theirs() -> object:
        method = sympy_pendulum_on_cart(n)
        return method.mass_matrix_full, method.forcing_full

    return paired(ours, theirs, pairs, before=(sweep, clear_cache))


def main() -> None:
    """Print the table's line."""
    print(f"Python {platform.python_version()}, SymPy {sm.__version__}, kane {kn.__version__}, {platform.processor()}")
    print(f"largest relative difference of the accelerations: {check(10):.1e}")
    print("pendulum on a cart, 10 rods:", measure().line("kane", "SymPy KanesMethod"))


if __name__ == "__main__":
    main()
