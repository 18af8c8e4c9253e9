# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations of the gallery's flexible systems against Lagrange's equations of particles, whose places are written by hand."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from tests.oracles.flexible import Array, Matter, accelerations, along, axis, elastic, jacobian, ring, six, turn, turned

Values = Mapping[str, float]


class Made(NamedTuple):
    """Names of coordinates in the order of q, the matter, forces of q and q̇, and the places of angles Ω t after them."""

    names: tuple[str, ...]
    matter: Matter
    forces: Callable[[Array, Array], Array]
    given: tuple[int, ...] = ()


def weights(places: Callable[[Array], Array], masses: Array, g: Array) -> Any:
    """Generalized forces of gravity."""
    return lambda q: jacobian(places, q).T @ np.outer(masses, g).ravel()


def pendulum(p: Values) -> Made:
    a = axis(2)
    masses = np.append(p["rhoA"] * p["L"] * a.weights[:-1], p["m"])

    def places(q: Array) -> Array:
        own = along(a, p["L"], q[1:])
        return np.stack([own[:, 1], -own[:, 0], 0 * own[:, 0]], axis=1) @ turn(q[0]).T

    gravity = weights(places, masses, np.array([0, -p["g"], 0]))
    damping = 2 * p["zeta"] * np.sqrt(p["rhoA"] * p["L"] * p["EI"] / p["L"] ** 3) * a.waves**2

    def forces(q: Array, v: Array) -> Array:
        return gravity(q) + np.append(0.0, elastic(a, q[1:], p["EI"], p["L"]) - damping * v[1:])

    return Made(("q_pin", "v1_rod", "v2_rod"), Matter(places, masses), forces)


def slider_crank(p: Values) -> Made:
    a = axis(2, pinned=True)
    rod = p["rhoA"] * p["L"] * a.weights[:-1]
    wheel, shares = ring(p["J"], 1.0)
    masses = np.concatenate([shares, rod, [p["m"]]])

    def ends(q: Array) -> tuple[Array, Array]:
        crank = turn(q[0])
        own = p["r"] * crank[:, 0] + along(a, p["L"], q[3:]) @ (crank @ turn(q[1])).T
        return own[:-1], own[-1]

    def places(q: Array) -> Array:
        return np.concatenate([wheel @ turn(q[0]).T, ends(q)[0], [[q[2], 0, 0]]])

    def closures(q: Array) -> Array:
        return ends(q)[1][:2] - np.array([q[2], 0])

    damping = 2 * p["zeta"] * np.sqrt(p["rhoA"] * p["L"] * p["EI"] / p["L"] ** 3) * a.waves**2

    def forces(q: Array, v: Array) -> Array:
        return np.concatenate([np.zeros(3), elastic(a, q[3:], p["EI"], p["L"]) - damping * v[3:]])

    return Made(("q_crank", "q_wrist", "x", "v1_rod", "v2_rod"), Matter(places, masses, closures), forces)


def rods(mass: float, length: float) -> tuple[Array, Array]:
    """Three particles with the mass, mass centre and moment of inertia of a rod along x (Simpson's rule)."""
    return np.array([[0, 0, 0], [length / 2, 0, 0], [length, 0, 0]]), mass * np.array([1, 4, 1]) / 6


def four_bar(p: Values) -> Made:
    a = axis(2, pinned=True)
    crank, crank_masses = rods(p["m1"], p["a"])
    rocker, rocker_masses = rods(p["m3"], p["c"])
    masses = np.concatenate([crank_masses, p["rhoA"] * p["b"] * a.weights[:-1], rocker_masses])
    base = np.array([p["d"], 0, 0])

    def link(q: Array) -> Array:
        A = turn(q[0])
        return p["a"] * A[:, 0] + along(a, p["b"], q[3:]) @ (A @ turn(q[1])).T

    def places(q: Array) -> Array:
        return np.concatenate([crank @ turn(q[0]).T, link(q)[:-1], base + rocker @ turn(q[2]).T])

    def closures(q: Array) -> Array:
        return (link(q)[-1] - base - p["c"] * turn(q[2])[:, 0])[:2]

    def forces(q: Array, v: Array) -> Array:
        return np.concatenate([np.zeros(3), elastic(a, q[3:], p["EI"], p["b"])])

    names = ("q_crank", "q_coupler", "q_rocker", "v1_link", "v2_link")
    return Made(names, Matter(places, masses, closures), forces)


def spacecraft(p: Values) -> Made:
    a = axis(2)
    hub, hub_masses = ring(p["J"] / p["m"], p["m"])
    wheel, wheel_masses = ring(p["Jw"] / 1e-3, 1e-3)
    boom = np.append(p["rhoA"] * p["L"] * a.weights[:-1], p["m_t"])
    masses = np.concatenate([hub_masses * (1 - 1e-3 / p["m"]), wheel_masses, boom, boom])
    hub *= (1 - 1e-3 / p["m"]) ** -0.5
    out = np.array([p["R"], 0, 0])

    def places(q: Array) -> Array:
        A = turn(q[2])
        right = out + along(a, p["L"], q[4:6])
        left = -out + along(a, p["L"], q[6:8]) * np.array([-1, 1, 1])
        own = np.concatenate([hub @ A.T, wheel @ (A @ turn(q[3])).T, right @ A.T, left @ A.T])
        return own + np.array([q[0], q[1], 0 * q[0]])

    def forces(q: Array, v: Array) -> Array:
        bent = [elastic(a, q[4:6], p["EI"], p["L"]), elastic(a, q[6:8], p["EI"], p["L"])]
        return np.concatenate([np.zeros(3), [p["T_w"]], *bent])

    names = ("x_hub", "y_hub", "q_hub", "q_wheel", "v1_right", "v2_right", "v1_left", "v2_left")
    return Made(names, Matter(places, masses), forces)


def blade(p: Values) -> Made:
    a = axis(2)
    masses = p["rhoA"] * p["L"] * a.weights[:-1]

    def places(q: Array) -> Array:
        A = turn(q[5])
        B = A @ turn(-q[0], about=1) @ turn(q[1])
        return p["e"] * A[:, 0] + along(a, p["L"], q[2:3], q[3:5])[:-1] @ B.T

    def forces(q: Array, v: Array) -> Array:
        own = elastic(a, q[2:3], p["EI_c"], p["L"]), elastic(a, q[3:5], p["EI_f"], p["L"])
        return np.concatenate([[0.0, -p["c"] * v[1]], *own, [0.0]])

    names = ("q_flap", "q_lag", "v1_blade", "w1_blade", "w2_blade")
    return Made(names, Matter(places, masses), forces, (5,))


def arm(p: Values) -> Made:
    a = axis(2)
    link = p["rhoA"] * p["L"] * a.weights[:-1]
    masses = np.concatenate([link, [p["m_h"]], link, [p["m_p"]]])

    def places(q: Array) -> Array:
        A = turn(q[0])
        upper = along(a, p["L"], q[2:4]) @ A.T
        E = A @ turn(a.tip_slopes @ q[2:4] / p["L"])
        lower = upper[-1] + along(a, p["L"], q[4:6]) @ (E @ turn(q[1])).T
        return np.concatenate([upper, lower])

    def forces(q: Array, v: Array) -> Array:
        bent = [elastic(a, q[k : k + 2], p["EI"], p["L"]) for k in (2, 4)]
        return np.concatenate([np.zeros(2), *bent])

    names = ("q_1", "q_2", "v1_upper", "v2_upper", "v1_lower", "v2_lower")
    return Made(names, Matter(places, masses), forces)


SYSTEMS: dict[str, Callable[[Values], Made]] = {
    "flexible_pendulum": pendulum,
    "flexible_slider_crank": slider_crank,
    "flexible_four_bar": four_bar,
    "flexible_spacecraft": spacecraft,
    "flap_lag_blade": blade,
    "flexible_arm": arm,
}


DEFORMED = re.compile(r"(u_)?[vw]\d_")
"""Names of the coordinates and speeds of deflections."""


def defaults(eom: kn.Equations) -> dict[str, float]:
    return {p.name: float(p.default or 0.0) for p in eom.parameters}


def state_of(name: str, eom: kn.Equations, rng: np.random.Generator) -> dict[str, Any]:
    """The start, with some deflections and other rates; on the closures, if there are any."""
    start = load(name).START
    length = defaults(eom).get("L", 0.3)
    q = {k: x if isinstance(x, kn.Guess) else x + 0.01 * rng.standard_normal() for k, x in start["q"].items()}
    q |= {k: 0.01 * length * rng.standard_normal() for k in q if DEFORMED.match(k)}
    u = {k: x + 0.5 * rng.standard_normal() for k, x in start["u"].items()}
    if not eom.system.holonomic:
        return {"q": q, "u": u}
    at = kn.assemble(eom, q=q, u=u)
    return {"q": at.q, "u": at.u}


@pytest.mark.slow
@pytest.mark.parametrize("name", SYSTEMS)
def test_accelerations(name: str, rng: np.random.Generator) -> None:
    """q̈ of the nonlinear form, closures and prescribed spins as they are; stations and particles have the same integrals."""
    eom = kn.derive(load(name).system(form="nonlinear"))
    p = defaults(eom)
    made = SYSTEMS[name](p)
    state = state_of(name, eom, rng)
    names = [q.name for q in eom.coordinates]
    order = [names.index(n) for n in made.names]
    count = len(names)
    values = eom.evaluate([*eom.coordinates, *eom.rates, *(eom.time_derivative(r) for r in eom.rates)], **state)
    q, v, found = (np.array(values[k * count : (k + 1) * count])[order] for k in range(3))
    spins = [p["Omega"] for _ in made.given]
    q, v = np.append(q, [0.0] * len(spins)), np.append(v, spins)
    expected = accelerations(made.matter, q, v, made.forces(q, v), made.given)[:count]
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-8 * np.abs(expected).max())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["flexible_pendulum", "flexible_spacecraft", "flap_lag_blade", "flexible_arm"])
def test_the_linearized_form_lacks_terms_of_second_order(name: str, rng: np.random.Generator) -> None:
    """Its accelerations differ from those by four times less when a small deformation and its rates are halved."""
    forms = [kn.derive(load(name).system(form=form)) for form in ("linearized", "nonlinear")]
    state = state_of(name, forms[0], rng)
    differences = []
    for size in (1e-4, 5e-5):
        now = {
            kind: {n: x * (size if DEFORMED.match(n) else 1.0) for n, x in row.items()} for kind, row in state.items()
        }
        a, b = (np.array(e.evaluate([e.time_derivative(u) for u in e.speeds], **now)) for e in forms)
        differences.append((a - b) / np.abs(b).max())
    whole, half = differences
    counts = np.abs(whole) > 0.1 * np.abs(whole).max()
    assert np.abs(whole).max() > 1e-12
    np.testing.assert_allclose(whole[counts] / half[counts], 4, rtol=0.25)


@pytest.mark.slow
def test_the_satellite(rng: np.random.Generator) -> None:
    """ω̇, the hub's acceleration and the rest: turns from the attitude by a vector have ω and ω̇ as its rates where it is zero."""
    eom = kn.derive(load("flexible_satellite").system(form="nonlinear"))
    p = defaults(eom)
    state = state_of("flexible_satellite", eom, rng)
    euler = rng.standard_normal(4)
    euler /= np.linalg.norm(euler)
    state["q"] |= dict(zip(("e0_hub", "e1_hub", "e2_hub", "e3_hub"), euler, strict=True))
    names = [u.name for u in eom.speeds]
    values = dict(zip(names, eom.evaluate([eom.time_derivative(u) for u in eom.speeds], **state), strict=True))
    e0, e = euler[0], euler[1:]
    cross = np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    attitude = (e0**2 - e @ e) * np.eye(3) + 2 * np.outer(e, e) + 2 * e0 * cross

    a = axis(1)
    light = 1e-3
    hub, hub_masses = six(np.array([p["J1"], p["J2"], p["J3"]]), p["m"] - 3 * light)
    wheels = [ring(p["Jw"] / light, light, axis=k) for k in range(3)]
    boom = np.append(p["rhoA"] * p["L"] * a.weights[:-1], p["m_t"])
    masses = np.concatenate([hub_masses, *(m for _, m in wheels), boom, boom])
    out = np.array([p["R"], 0, 0])

    def places(q: Array) -> Array:
        A = attitude @ turned(q[:3])
        right = out + along(a, p["L"], q[9:10], q[10:11])
        left = -out + along(a, p["L"], q[11:12], q[12:13]) * np.array([-1, 1, -1])
        spun = [w @ (A @ turn(q[6 + k], about=k)).T for k, (w, _) in enumerate(wheels)]
        return np.concatenate([hub @ A.T, *spun, right @ A.T, left @ A.T]) + q[3:6]

    bent = ("v1_right", "w1_right", "v1_left", "w1_left")
    spins = ("wheel_x", "wheel_y", "wheel_z")
    turning, moving = [f"w_{k}_hub" for k in "xyz"], [f"v_{k}_hub" for k in "xyz"]
    w, v = (np.array([state["u"][n] for n in row]) for row in (turning, moving))
    u = {n: state["u"][f"u_{n}"] for n in (*spins, *bent)}
    q = np.concatenate([np.zeros(3), np.zeros(3), [state["q"][f"q_{n}"] for n in spins], [state["q"][n] for n in bent]])
    rates = np.concatenate([w, attitude @ v, list(u.values())])
    forces = np.concatenate([np.zeros(6), [p[f"T_{k}"] for k in "xyz"], elastic_of(a, q[9:], p)])
    expected = accelerations(Matter(places, masses), q, rates, forces)
    found = np.array([values[n] for n in turning])
    hub_found = attitude @ (np.array([values[n] for n in moving]) + np.cross(w, v))
    rest = np.array([values[f"u_{n}"] for n in u])
    np.testing.assert_allclose(
        np.concatenate([found, hub_found, rest]), expected, rtol=1e-7, atol=1e-8 * np.abs(expected).max()
    )


def elastic_of(a: Any, q: Array, p: Values) -> Array:
    return np.concatenate([elastic(a, q[k : k + 1], p["EI"], p["L"]) for k in range(len(q))])
