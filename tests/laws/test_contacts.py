# SPDX-License-Identifier: BSD-3-Clause
"""Random plane systems with contacts: each mode against Newton and Euler, and what no motion may do.

On supports at rest energy never grows; N ≥ 0, |F| ≤ μ_s N, no body is within another, and what sticks does not move.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples
from tests.oracles.planar_contacts import Plane, poses, rows, solved
from tests.systems.planar_contacts import planes, system

Array = Any
TIGHT = {"rtol": 1e-10, "atol": 1e-11}


def held_rows(plane: Plane, q: Array, u: Array, modes: list[str]) -> tuple[Array, Array]:
    """Gaps of the contacts that are closed, and the rows over u of these gaps and of the slips that are none."""
    z, dz = poses(plane, q)
    gaps, found = list[float](), list[Array]()
    for touch, mode in zip(plane.touches, modes, strict=True):
        gap, j, _ = rows(plane, touch, z, dz @ u)
        if mode != "separated":
            gaps.append(gap)
            found.append(j[0] @ dz)
        if mode == "stick" and not touch.stops:
            found.append(j[1] @ dz)
    return np.array(gaps), np.array(found).reshape(len(found), plane.width)


def admitted(plane: Plane, modes: list[str], rng: np.random.Generator) -> tuple[Array, Array]:
    """A random state whose gaps are closed, with speeds that the mode has."""
    q, u = rng.uniform(-0.6, 0.6, plane.width), rng.normal(size=plane.width)
    for _ in range(60):
        gaps, _ = held_rows(plane, q, u, modes)
        _, only = held_rows(plane, q, u, ["straight" if m != "separated" else m for m in modes])
        if not len(gaps):
            return q, u
        if np.abs(gaps).max() < 1e-14:
            break
        step = np.linalg.pinv(only, rcond=1e-9) @ gaps
        q = q - step / max(1.0, np.abs(step).max())
    assume(np.abs(gaps).max() < 1e-12)
    _, held = held_rows(plane, q, u, modes)
    sizes = np.linalg.svd(held, compute_uv=False)
    assume(len(held) <= plane.width and sizes[-1] > 1e-2 * sizes[0])
    return q, u - np.linalg.pinv(held) @ (held @ u)


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
@examples(1.0)
@given(st.data())
def test_a_modes_equations_are_those_of_newton_and_euler(data: st.DataObject) -> None:
    plane = data.draw(planes())
    modes = drawn_modes(plane, data)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    q, u = admitted(plane, frictionless(plane, modes), rng)
    whole = system(plane)
    eom = kn.derive(whole.in_modes({f"c{i}": m for i, m in enumerate(modes)}))
    along = [float(rng.choice([-1, 1])) for _ in modes]
    at = dict(zip(eom.coordinates, q, strict=True)) | dict(zip(eom.speeds, u, strict=True))
    for c, d in zip(whole.contacts, along, strict=True):
        at |= dict(zip(c.direction, [d], strict=False))
    wanted, normal, tangential = solved(plane, q, u, frictionless(plane, modes), along)
    values = np.array(kn.evaluate([*eom.solved.accelerations, *eom.solved.reactions], at), dtype=float)
    size = max(1.0, np.abs(wanted).max(), np.abs(normal).max(initial=0))
    names = {c.normal_force.name: n for c, n in zip(whole.contacts, normal, strict=True)}
    count = len(eom.speeds)
    np.testing.assert_allclose(values[:count], wanted, rtol=0, atol=1e-9 * size)
    held = dict(zip([r.name for r in eom.reactions], values[count:], strict=True))
    for name, value in held.items():
        if name in names:
            assert value == pytest.approx(names[name], abs=1e-9 * size)
    twins = {i - 1 for i, m in enumerate(modes) if m == "held"}
    for i, (c, mode) in enumerate(zip(whole.contacts, modes, strict=True)):
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


@pytest.mark.slow
@examples(0.5)
@given(planes(), st.integers(0, 2**32), st.sampled_from(["stronge", "poisson"]))
def test_what_no_motion_may_do(plane: Plane, seed: int, law: str) -> None:
    eom = kn.derive(system(plane, law))
    q, u = started(plane, eom, np.random.default_rng(seed))
    sol = kn.simulate(eom, (0, 1.5), q=q, u=u, **TIGHT)
    assert sol.status == "finished", sol.message
    size = np.abs(sol.energy).max() + sum(p.mass for p in plane.plates)
    assert np.diff(sol.energy).max() < 1e-8 * size
    for c in eom.system.contacts:
        modes, gap = sol.modes[c.name], sol[c.gap.expr]
        closed = modes != "separated"
        assert gap.min() > -1e-10
        assert np.abs(gap[closed]).max(initial=0) < 1e-10
        n = sol[c.normal_force]
        assert n.min() > -1e-9 * size
        assert not n[~closed].any()
        if c.slips:
            f, slip = np.abs(sol[c.friction_forces[0]]), sol[c.slips[0].expr]
            mus = float(kn.evaluate(c.static, {}))
            assert (f <= mus * n * (1 + 1e-9) + 1e-9 * size).all()
            assert np.abs(slip[modes == "stick"]).max(initial=0) < 1e-10
