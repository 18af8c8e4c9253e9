# SPDX-License-Identifier: BSD-3-Clause
"""Random plane systems with contacts: each mode against Newton and Euler, and what no motion may do.

On supports at rest energy never grows, on moving ones it changes by their work and by friction; N ≥ 0, |F| ≤ μ_s N, no body is within
another, and what sticks does not move.
"""

from __future__ import annotations

from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.integrate import simpson, trapezoid

import kane as kn
from tests.examples import examples
from tests.oracles.planar_contacts import Plane, Plate, Support, Touch, floor, poses, rows, solved
from tests.systems.planar_contacts import alike, model, planes, system

Array = Any
TIGHT = {"rtol": 1e-10, "atol": 1e-11}


class Held(NamedTuple):
    """Gaps of the contacts that are closed, rows over u of these gaps and of the slips that are none, and what they have besides."""

    gaps: Array
    rows: Array
    rest: Array


def held_rows(plane: Plane, q: Array, modes: list[str], t: float = 0.0) -> Held:
    z, dz = poses(plane, q)
    gaps, found, rest = list[float](), list[Array](), list[float]()
    for touch, mode in zip(plane.touches, modes, strict=True):
        row = rows(plane, touch, z, 0 * z, t)
        if mode != "separated":
            gaps.append(row.gap)
            found.append(row.j[0] @ dz)
            rest.append(row.rest[0])
        if mode == "stick" and not touch.stops:
            found.append(row.j[1] @ dz)
            rest.append(row.rest[1])
    return Held(np.array(gaps), np.array(found).reshape(len(found), plane.width), np.array(rest))


def admitted(
    plane: Plane, modes: list[str], rng: np.random.Generator, t: float = 0.0, redundant: bool = False
) -> tuple[Array, Array] | None:
    """A random state whose gaps are closed, with speeds that the mode has; None where there is none near.

    With `redundant` rows that are held may depend on each other.
    """
    q, u = rng.uniform(-0.6, 0.6, plane.width), rng.normal(size=plane.width)
    closed = ["straight" if m != "separated" else m for m in modes]
    if closed.count("separated") == len(closed):
        return q, u
    for _ in range(60):
        gaps, only, _ = held_rows(plane, q, closed, t)
        if np.abs(gaps).max() < 1e-14:
            break
        step = np.linalg.pinv(only, rcond=1e-9) @ gaps
        q = q - step / max(1.0, np.abs(step).max())
    gaps, held, rest = held_rows(plane, q, modes, t)
    sizes = np.linalg.svd(held, compute_uv=False)
    full = len(held) <= plane.width and sizes[-1] > 1e-2 * sizes[0]
    clear = (sizes > 1e-2 * sizes[0]) | (sizes < 1e-11 * sizes[0])
    if np.abs(gaps).max() > 1e-12 or not (full or (redundant and clear.all())):
        return None
    u = u - np.linalg.pinv(held, rcond=1e-10) @ (held @ u + rest)
    return q, np.where(np.abs(u) < 1e-13, 0.0, u)


def drawn_modes(plane: Plane, data: st.DataObject) -> list[str]:
    """A mode for each contact; the second corner of a body that sticks is held with the first."""
    modes = list[str]()
    for i, touch in enumerate(plane.touches):
        if touch.stops or touch.static == 0:
            modes.append(data.draw(st.sampled_from(["separated", "stick"])))
            continue
        modes.append(data.draw(st.sampled_from(["separated", "stick", "straight"])))
        twin = i and plane.touches[i - 1].body == touch.body and modes[i - 1] == "stick"
        if twin and modes[i] == "stick":
            modes[i] = "held"
    return modes


@pytest.mark.grows
@examples(0.25, least=10)
@given(st.one_of(planes(), alike().map(itemgetter(0))), st.data())
def test_a_modes_equations_are_those_of_newton_and_euler(plane: Plane, data: st.DataObject) -> None:
    """At 100 states of each mode by the full profile."""
    modes = drawn_modes(plane, data)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    oracle, times = frictionless(plane, modes), rng.uniform(0, 3, settings().max_examples // 2)
    states = [(t, *state) for t in times if (state := admitted(plane, oracle, rng, float(t))) is not None]
    assume(states)
    whole = system(plane)
    eom = kn.derive(whole.in_modes({f"c{i}": m for i, m in enumerate(modes)}))
    along = rng.choice([-1.0, 1.0], (len(states), len(modes)))
    at = dict(zip((kn.time, *eom.coordinates, *eom.speeds), np.array([np.hstack(s) for s in states]).T, strict=True))
    for c, d in zip(whole.contacts, along.T, strict=True):
        at |= dict(zip(c.direction, [d], strict=False))
    values = kn.evaluate([*eom.solved.accelerations, *eom.solved.reactions], at)
    columns = np.array([np.broadcast_to(x, len(states)) for x in values], dtype=float).T
    for (t, q, u), sense, found in zip(states, along, columns, strict=True):
        beside_newton(plane, eom, modes, found, solved(plane, q, u, oracle, sense, t))


def beside_newton(plane: Plane, eom: kn.Equations, modes: list[str], values: Array, expected: Any) -> None:
    """Accelerations, and all forces that are multipliers, of one state."""
    wanted, normal, tangential = expected
    contacts, count = eom.system.contacts, len(eom.speeds)
    size = max(1.0, np.abs(wanted).max(), np.abs(normal).max(initial=0))
    names = {c.normal_force.name: n for c, n in zip(contacts, normal, strict=True) if c.normal_force is not None}
    np.testing.assert_allclose(values[:count], wanted, rtol=0, atol=1e-9 * size)
    held = dict(zip([r.name for r in eom.reactions], values[count:], strict=True))
    for name, value in held.items():
        if name in names:
            assert value == pytest.approx(names[name], abs=1e-9 * size)
    twins = {i - 1 for i, m in enumerate(modes) if m == "held"}
    for i, (c, mode) in enumerate(zip(contacts, modes, strict=True)):
        if mode == "stick" and c.friction_forces:
            total = tangential[i] + (tangential[i + 1] if i in twins else 0)
            assert held[c.friction_forces[0].name] == pytest.approx(total, abs=1e-9 * size)


def frictionless(plane: Plane, modes: list[str]) -> list[str]:
    """The modes for the oracle: a contact without friction that is closed has no row of slip."""
    return ["straight" if m == "stick" and not t.static else m for t, m in zip(plane.touches, modes, strict=True)]


def started(plane: Plane, eom: kn.Equations, rng: np.random.Generator) -> tuple[Array, Array]:
    """A start with all gaps open."""
    q, u = rng.uniform(-0.4, 0.4, plane.width), rng.normal(size=plane.width)
    k = 0
    for plate in plane.plates:
        if plate.pin is None:
            q[k + 1] += 1.0
            k += 3
        else:
            k += 1
    z, dz = poses(plane, q)
    gaps = [rows(plane, t, z, dz @ u)[0] for t in plane.touches]
    floor = [g for g, t in zip(gaps, plane.touches, strict=True) if not t.stops]
    down = min(floor, default=0.5) - 0.05
    k = 0
    for plate in plane.plates:
        if plate.pin is None:
            q[k + 1] -= down
            k += 3
        else:
            k += 1
    assume(all(g > 0 for g, t in zip(gaps, plane.touches, strict=True) if t.stops))
    return q, u


POINT = {"kinetic": 0.2, "static": 0.5, "restitution": 0.4}
PRESSED_DOWN = Plane(
    0.4,
    (Plate(1.8, 0.2), Plate(0.3, 1.0)),
    (
        Touch(0, (0.1, -0.5), **POINT),
        Touch(0, (-0.5, -0.6), **POINT),
        Touch(1, (0.5, -0.4), static=0.1, restitution=0.7),
        Touch(0, (0.7, 0.0), stops="x"),
    ),
)
"""Two corners come to rest at one instant; a gap that has opened is moved below zero by the other, which closes."""
RESTS_IN_A_CORNER = Plane(
    -0.5,
    (Plate(0.9, 0.1), Plate(1.3, 0.4, ((-0.4, 0.3), (-0.4, 0.3)))),
    (
        Touch(0, (0.2, -0.1), restitution=0.3),
        Touch(0, (-0.4, -0.1), restitution=0.3),
        Touch(1, (0.1, -0.2), 0.4, kinetic=0.1, static=0.1, restitution=0.1),
        Touch(0, (0.5, 0.0), stops="a", restitution=0.5),
    ),
)
"""A corner whose rebounds are not followed any more presses the stop down, which has just opened."""

LEAVES_A_STOP = Plane(
    -0.1,
    (Plate(1.1, 0.2),),
    (
        Touch(0, (0.0, -0.1), 0.3, kinetic=0.7, static=1.0, restitution=0.7),
        Touch(0, (0.9, 0.0), stops="x", restitution=0.9),
    ),
)
"""A sphere that begins to roll leaves a stop at that instant, without speed."""
ROUGH = {"kinetic": 0.7, "static": 0.7, "restitution": 0.4}
SLIPS_ON_BOTH = Plane(
    0.4,
    (Plate(1.5, 0.5), Plate(0.9, 0.3, ((0.2, 0.5), (0.0, -0.4)))),
    (
        Touch(0, (0.6, -0.4), **ROUGH),
        Touch(0, (-0.4, -0.5), **ROUGH),
        Touch(1, (0.1, 0.0), 0.4, kinetic=0.5, static=0.7, restitution=0.6),
        Touch(0, (0.4, 0.0), stops="a", restitution=0.7),
    ),
)
"""Two corners that stick by one row begin to slip together."""

SLIGHT = {"kinetic": 0.1, "static": 0.2, "restitution": 0.1}
LIFTS_OFF = Plane(
    0.1,
    (Plate(1.0, 0.1),),
    (Touch(0, (0.6, -0.1), **SLIGHT), Touch(0, (-0.5, -0.6), **SLIGHT)),
    Support((0.1, 12.0), (0.1, 10.0)),
)
"""The forces of both corners fall to zero at one instant, and the floor leaves the body."""
STANDS = {"kinetic": 0.4, "static": 0.4, "restitution": 0.1}
BESIDE_ONE_THAT_STANDS = Plane(
    0.1,
    (Plate(2.9, 0.1), Plate(1.3, 0.8)),
    (
        Touch(0, (0.5, -0.4), **STANDS),
        Touch(0, (-0.1, -0.6), **STANDS),
        Touch(1, (0.1, -0.4), kinetic=0.3, static=0.6, restitution=0.5),
        Touch(0, (0.6, 0.0), stops="x", restitution=0.6),
    ),
)
"""Speeds of what sticks become ever smaller, to where their squares are no numbers any more, and another body hits."""


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Expected a quantity of the event:kane.KaneWarning")  # a stop that nothing presses
@pytest.mark.filterwarnings("ignore:Expected one mode of the contacts:kane.KaneWarning")
@examples(1.5)
@example((LIFTS_OFF, "stronge"), 183961)
@example((BESIDE_ONE_THAT_STANDS, "poisson"), 24369)
@example((PRESSED_DOWN, "poisson"), 224)
@example((RESTS_IN_A_CORNER, "stronge"), 24)
@example((LEAVES_A_STOP, "poisson"), 2827)
@example((SLIPS_ON_BOTH, "stronge"), 5)
@given(alike(), st.integers(0, 2**32))
def test_what_no_motion_may_do(drawn: tuple[Plane, str], seed: int) -> None:
    plane, law = drawn
    own = model(plane, law)
    q, u = started(plane, own.eom, np.random.default_rng(seed))
    start = {"q": dict(zip(own.coordinates, q, strict=True)), "u": u, "parameters": own.values(plane)}
    sol = kn.simulate(own.eom, (0, 1.5), **start, **TIGHT)
    assert sol.status == "finished" or "with uniquely determined forces between rigid bodies" in sol.message, (
        sol.message
    )
    size = np.abs(sol.energy).max() + sum(p.mass for p in plane.plates)
    if plane.support is None:
        assert np.diff(sol.energy).max() < 1e-8 * size
    supports_work(plane, sol, size)
    for c, touch in zip(own.eom.system.contacts, plane.touches, strict=True):
        modes, gap = sol.modes[c.name], sol[c.gap.expr]
        closed = modes != "separated"
        assert gap.min() > -1e-10
        assert np.abs(gap[closed]).max(initial=0) < 1e-10
        n = sol[c.normal_force]
        assert n.min() > -1e-9 * size
        assert not n[~closed].any()
        if c.slips:
            f, slip = np.abs(sol[c.friction_forces[0]]), sol[c.slips[0].expr]
            assert (f <= touch.static * n * (1 + 1e-9) + 1e-9 * size).all()
            assert np.abs(slip[modes == "stick"]).max(initial=0) < 1e-10


def supports_work(plane: Plane, sol: kn.Solution, size: float) -> None:
    """ΔE is the work of N and F on what they move; impacts take energy, seen from the floor."""
    moves = np.array([floor(plane, t)[1] for t in sol.t])
    moves[:, 1] += plane.support.belt if plane.support else 0.0
    power = np.zeros(len(sol))
    for c, touch in zip(sol.equations.system.contacts, plane.touches, strict=True):
        if not touch.stops:
            slip = sol[c.slips[0].expr] if c.slips else 0.0
            power += sol[c.normal_force] * moves[:, 0] + sol[c.friction_forces[0]] * (moves[:, 1] + slip)
    phases = np.split(np.arange(len(sol)), np.flatnonzero(np.diff(sol.phase)) + 1)
    masses = np.array([x for p in plane.plates for x in (p.mass, p.mass, 0.0)])
    for at, after in zip(phases, [*phases[1:], None], strict=True):
        done = simpson(power[at], sol.t[at]) if len(at) > 1 else 0.0
        unsure = (
            abs(done - trapezoid(power[at], sol.t[at])) if len(at) > 4 else abs(done)
        )  # more than Simpson's rule leaves
        change = sol.energy[at[-1]] - sol.energy[at[0]]
        assert change == pytest.approx(done, abs=1e-6 * size + unsure)
        assert sol.work[at[-1]] - sol.work[at[0]] == pytest.approx(change, abs=1e-8 * size)
        if after is not None:
            last, first = at[-1], after[0]
            _, dz = poses(plane, sol.q[first])
            given = (masses * (dz @ (sol.u[first] - sol.u[last]))).reshape(-1, 3).sum(axis=0)
            gained = sol.energy[first] - sol.energy[last] - given[:2] @ moves[first, ::-1]
            assert gained < 1e-9 * size
    assert sol.energy_check.drift < 1e-7 * size
