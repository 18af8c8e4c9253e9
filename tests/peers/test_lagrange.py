# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations of the gallery's systems by Lagrange's equations, derived by SymPy from energies written out by hand.

Nothing of kane enters: positions in scalar form are differentiated by SymPy, angular velocities are those of the textbooks.
Dampers enter through Rayleigh's dissipation function D, as −∂D/∂q̇.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

import kane as kn
from tests.gallery.cases import CASES, Case, case_of, equations, random_states
from tests.oracles.compare import tolerance

t = dynamicsymbols._t
g = sp.Symbol("g", positive=True)
Vector = Sequence[Any]


@dataclass(frozen=True, eq=False)
class Energies:
    """Coordinates by kane's names, kinetic and potential energy, and Rayleigh's dissipation function."""

    q: Mapping[str, Any]
    kinetic: Any
    potential: Any
    dissipation: Any = 0


def symbols(names: str) -> tuple[Any, ...]:
    return tuple(sp.Symbol(n, positive=True) for n in names.split())


def coordinates(names: str) -> dict[str, Any]:
    return {n: dynamicsymbols(n) for n in names.split()}


def moving(m: Any, place: Vector) -> Any:
    """m |v|²/2 of a particle at a place (x, y, …)."""
    return m * sum(x.diff(t) ** 2 for x in place) / 2


def particle_on_a_spring(dimensions: int) -> Energies:
    m, k, l0, c = symbols("m k l0 c")
    q = coordinates("x y z" if dimensions == 3 else "x y")
    place = list(q.values())
    length = sp.sqrt(sum(x**2 for x in place))
    return Energies(q, moving(m, place), m * g * place[-1] + k * (length - l0) ** 2 / 2, c * length.diff(t) ** 2 / 2)


def chain(n: int, *, relative: bool = False, cart: bool = False, bobs: bool = False) -> Energies:
    q = coordinates(" ".join([*(["x"] if cart else []), *(f"q{i}" for i in range(1, n + 1))]))
    m, l = symbols(" ".join(f"m{i}" for i in range(1, n + 1))), symbols(" ".join(f"l{i}" for i in range(1, n + 1)))
    angles = [q[f"q{i}"] for i in range(1, n + 1)]
    if relative:
        angles = [sum(angles[: i + 1]) for i in range(n)]
    x, y = q.get("x", sp.Integer(0)), sp.Integer(0)
    kinetic, potential = (moving(sp.Symbol("m0", positive=True), (x,)) if cart else 0), 0
    for i, angle in enumerate(angles):
        dx, dy = l[i] * sp.sin(angle), -l[i] * sp.cos(angle)
        share = 1 if bobs else sp.Rational(1, 2)
        center = (x + share * dx, y + share * dy)
        kinetic += moving(m[i], center)
        if not bobs:
            kinetic += m[i] * l[i] ** 2 / 24 * angle.diff(t) ** 2
        potential += m[i] * g * center[1]
        x, y = x + dx, y + dy
    return Energies(q, kinetic, potential)


def pendulum() -> Energies:
    m, l, I, c = symbols("m l I c")
    q = coordinates("theta")
    v = q["theta"].diff(t)
    return Energies(q, (I + m * l**2) * v**2 / 2, -m * g * l * sp.cos(q["theta"]), c * v**2 / 2)


def pendulum_on_a_cart() -> Energies:
    M, m, l, I, c = symbols("M m l I c")
    q = coordinates("x theta")
    x, th = q.values()
    kinetic = moving(M, (x,)) + moving(m, (x + l * sp.sin(th), -l * sp.cos(th))) + I * th.diff(t) ** 2 / 2
    return Energies(q, kinetic, -m * g * l * sp.cos(th), c * x.diff(t) ** 2 / 2)


def spherical_pendulum() -> Energies:
    m, l = symbols("m l")
    q = coordinates("phi theta")
    phi, th = q.values()
    place = (l * sp.sin(th) * sp.cos(phi), l * sp.sin(th) * sp.sin(phi), -l * sp.cos(th))
    return Energies(q, moving(m, place), m * g * place[2])


def top() -> Energies:
    m, l, I, J = symbols("m l I J")
    q = coordinates("psi theta phi")
    psi, th, phi = q.values()
    across = th.diff(t) ** 2 + (psi.diff(t) * sp.sin(th)) ** 2
    spin = phi.diff(t) + psi.diff(t) * sp.cos(th)
    return Energies(q, ((I + m * l**2) * across + J * spin**2) / 2, m * g * l * sp.cos(th))


def gyroscope() -> Energies:
    Az, Bx, By, Bz, I, J, m, l, c = symbols("Az Bx By Bz I J m l c")
    q = coordinates("q1 q2 q3")
    q1, q2, _ = q.values()
    w1, w2, w3 = (x.diff(t) for x in q.values())
    inner = Bx * w2**2 + (By * sp.sin(q2) ** 2 + Bz * sp.cos(q2) ** 2) * w1**2
    rotor = I * (w2**2 + (w1 * sp.cos(q2)) ** 2) + J * (w3 + w1 * sp.sin(q2)) ** 2
    place = (-l * sp.cos(q2) * sp.sin(q1), l * sp.cos(q2) * sp.cos(q1), l * sp.sin(q2))
    kinetic = (Az * w1**2 + inner + rotor) / 2 + moving(m, place)
    return Energies(q, kinetic, m * g * place[2], c * (w1**2 + w2**2) / 2)


ROUTES: dict[str, Callable[[], Energies]] = {
    "particle on a spring in space": lambda: particle_on_a_spring(3),
    "particle on a spring in a plane": lambda: particle_on_a_spring(2),
    "pendulum": pendulum,
    "double pendulum of rods": lambda: chain(2),
    "double pendulum of particles": lambda: chain(2, bobs=True),
    "three links, absolute angles": lambda: chain(3),
    "three links, relative angles": lambda: chain(3, relative=True),
    "three links on a cart": lambda: chain(3, relative=True, cart=True),
    "pendulum on a cart": pendulum_on_a_cart,
    "spherical pendulum": spherical_pendulum,
    "top": top,
    "gyroscope": gyroscope,
}
ALL = [
    pytest.param(n, s, id=f"{n}, {s}", marks=[pytest.mark.slow] if k % 2 else [])
    for k, (n, s) in enumerate((n, s) for n in ROUTES for s in case_of(n).speeds)
]


@cache
def lagrange(name: str) -> Callable[..., Any]:
    """(M, forcing) of Lagrange's equations as a function of q, q' and the parameters in the order of their names."""
    energies = ROUTES[name]()
    q = list(energies.q.values())
    rates = [x.diff(t) for x in q]
    method = LagrangesMethod(energies.kinetic - energies.potential, q)
    method.form_lagranges_equations()
    lost = sp.Matrix([sp.diff(energies.dissipation, v) for v in rates])
    forcing = method.forcing - lost
    plain = {**{v: sp.Symbol(f"v{i}") for i, v in enumerate(rates)}, **{x: sp.Symbol(f"x{i}") for i, x in enumerate(q)}}
    parts = [m.xreplace({v: plain[v] for v in rates}).xreplace(plain) for m in (method.mass_matrix, forcing)]
    left = {s.name: s for m in parts for s in m.free_symbols if s not in set(plain.values())}
    ordered = sorted(left)
    inputs = [[plain[x] for x in q], [plain[v] for v in rates], [left[n] for n in ordered]]
    run = sp.lambdify(inputs, parts, cse=True)

    def solved(case: Case, q_values: Any, rate_values: Any) -> tuple[Any, float]:
        defaults = {p.name: p.default for p in case.build(case.speeds[0]).parameters}
        M, f = run(q_values, rate_values, [float(defaults[n] or 0) for n in ordered])
        return np.linalg.solve(M, f)[:, 0], float(np.linalg.cond(M))

    return solved


@pytest.mark.slow
@pytest.mark.parametrize(("name", "speeds"), ALL)
def test_accelerations(name: str, speeds: str) -> None:
    case = case_of(name)
    eom, states = equations(case, speeds), random_states(case, 20, seed=5)
    found = states.evaluate(eom, [eom.time_derivative(r) for r in eom.rates])
    place = {q.name: i for i, q in enumerate(eom.coordinates)}
    order = [place[n] for n in ROUTES[name]().q]
    Y = states.matrix(eom, eom.Y)
    for k in range(states.count):
        q = [float(v[k]) for v in states.q.values()]
        rates = [float(v[k]) for v in states.rates.values()]
        expected, condition = lagrange(name)(case, [q[i] for i in order], [rates[i] for i in order])
        off = np.abs(found[order, k] - expected).max() / max(1.0, np.abs(expected).max())
        limit = tolerance(1e-9, condition * float(np.linalg.cond(Y[k])))
        assert off <= limit, f"state {k}: off by {off:.1e}, limit {limit:.1e}"


def test_every_system_with_generalized_coordinates_is_here() -> None:
    """All but Euler parameters (against Euler's equations in the literature) and sliding friction (Newton–Euler)."""
    left = {c.name for c in CASES} - set(ROUTES)
    assert left == {"free body", "free body that falls", "sliding disk"}


def test_parameters_are_the_same() -> None:
    for name, route in ROUTES.items():
        e = route()
        own = {s.name for s in (e.kinetic - e.potential + e.dissipation).free_symbols} - {"t"}
        eom: kn.Equations = equations(case_of(name), "rates")
        assert own == {p.name for p in eom.parameters}, name
