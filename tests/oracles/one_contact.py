# SPDX-License-Identifier: BSD-3-Clause
"""Motions with one contact closed at a time, without kane: from event to event by SciPy, impacts by Newton's law with Coulomb's cone.

M(q) u̇ = h(q, u) + Jᵀ λ. A contact has a gap, rows J (2 × n) of constant places, its normal first, μ and e.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

Array = Any
EXACT: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}


class Touch(NamedTuple):
    """A contact: its gap and rows by q, μ and e."""

    name: str
    gap: Callable[[Array], float]
    rows: Callable[[Array], Array]
    mu: float
    e: float


class Model(NamedTuple):
    """M(q), h(q, u) and contacts."""

    mass: Callable[[Array], Array]
    forces: Callable[[Array, Array], Array]
    touches: tuple[Touch, ...]


class Happened(NamedTuple):
    """An event, with the state after it."""

    t: float
    name: str
    q: Array
    u: Array


def impact(model: Model, i: int, q: Array, u: Array) -> Array:
    """u⁺ with v_n⁺ = −e v_n⁻, and v_t⁺ = 0 or friction against v_t⁺."""
    touch, j = model.touches[i], model.touches[i].rows(q)
    back = np.linalg.solve(model.mass(q), j.T)
    w, v = j @ back, j @ u
    wanted = np.array([-(1 + touch.e) * v[0], -v[1]])
    p = np.linalg.solve(w, wanted)
    if abs(p[1]) > touch.mu * p[0]:
        (p,) = (
            x
            for s in (-1.0, 1.0)
            for x in [wanted[0] / (w[0, 0] - touch.mu * s * w[0, 1]) * np.array([1, -touch.mu * s])]
            if s * (v + w @ x)[1] > 0
        )
    return u + back @ p


def accelerated(model: Model, mode: tuple[int, float] | None, q: Array, u: Array) -> tuple[Array, Array]:
    """u̇ and (N, F) where a contact (i, s) slips along s = ±1, or sticks with s = 0; None is open."""
    m, h = model.mass(q), model.forces(q, u)
    if mode is None:
        return np.linalg.solve(m, h), np.zeros(2)
    i, s = mode
    touch, j = model.touches[i], model.touches[i].rows(q)
    free, back = np.linalg.solve(m, h), np.linalg.solve(m, j.T)
    if s:
        along = np.array([1, -touch.mu * s])
        force = along * (-(j[0] @ free) / (j[0] @ back @ along))
    else:
        force = -np.linalg.solve(j @ back, j @ free)
    return free + back @ force, force


def begins(model: Model, i: int, q: Array, u: Array, push: float = 0.0) -> tuple[int, float] | None:
    """What a closed contact does: it slips by its speed, else by `push`, else it sticks if it can; None where it does not press."""
    touch = model.touches[i]
    slip = touch.rows(q)[1] @ u
    s = float(np.sign(slip)) if abs(slip) > 1e-12 else push
    if not s:
        _, (normal, friction) = accelerated(model, (i, 0.0), q, u)
        s = 0.0 if abs(friction) <= touch.mu * normal else -float(np.sign(friction))
    return (i, s) if accelerated(model, (i, s), q, u)[1][0] > 0 else None


def motion(
    model: Model, q: Array, u: Array, end: float, mode: tuple[int, float] | None, most: int, step: float
) -> list[Happened]:
    """The events up to the end, or so many."""
    n, t, found = len(q), 0.0, list[Happened]()

    def watched(mode: tuple[int, float] | None) -> tuple[Any, list[str]]:
        def of_force(place: int, mu: float) -> Callable[..., float]:
            def value(_: float, z: Array) -> float:
                normal, friction = accelerated(model, mode, z[:n], z[n:])[1]
                return float([normal, mu * normal - abs(friction)][place])

            return value

        open_ = [k for k in range(len(model.touches)) if mode is None or k != mode[0]]
        events: Any = [lambda _, z, k=k: model.touches[k].gap(z[:n]) for k in open_]
        names = [f"{model.touches[k].name} closes" for k in open_]
        if mode is not None:
            i, s = mode
            name, mu = model.touches[i].name, model.touches[i].mu
            events.append(of_force(0, mu))
            names.append(f"{name} opens")
            events.append((lambda _, z: s * (model.touches[i].rows(z[:n])[1] @ z[n:])) if s else of_force(1, mu))
            names.append(f"{name} sticks" if s else f"{name} slips")
        for x in events:
            x.terminal, x.direction = True, -1
        return events, names

    while t < end and len(found) < most:
        events, names = watched(mode)

        def rates(_: float, z: Array, mode: tuple[int, float] | None = mode) -> Array:
            return np.concatenate([z[n:], accelerated(model, mode, z[:n], z[n:])[0]])

        run: Any = solve_ivp(rates, (t, end), np.concatenate([q, u]), events=events, max_step=step, **EXACT)
        t, q, u = float(run.t[-1]), run.y[:n, -1], run.y[n:, -1]
        if run.status != 1:
            break
        which = next(k for k, times in enumerate(run.t_events) if len(times))
        name, _, kind = names[which].rpartition(" ")
        i = next(k for k, touch in enumerate(model.touches) if touch.name == name)
        if kind == "closes":
            u = impact(model, i, q, u)
            mode = None if model.touches[i].e else begins(model, i, q, u)
        elif kind == "opens":
            mode = None
        elif kind == "slips":
            mode = begins(model, i, q, u, push=-float(np.sign(accelerated(model, mode, q, u)[1][1])))
        else:
            mode = begins(model, i, q, u)
        found.append(Happened(t, names[which], q, u))
    return found
