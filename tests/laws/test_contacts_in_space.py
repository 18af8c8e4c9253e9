# SPDX-License-Identifier: BSD-3-Clause
"""Random bodies in space with contacts: each mode's accelerations and forces against Newton and Euler."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples
from tests.oracles.spatial_contacts import Scene, motions, posed, rates, rows, solved
from tests.systems.spatial_contacts import admitted, build_of, made, model, scenes

Array = Any
MODES = ("separated", "stick", "straight", "slip")


@cache
def in_modes(build: Any, modes: tuple[str, ...]) -> kn.Equations:
    """The equations of a mode, one for all scenes of a build."""
    system = made(build).eom.system
    return kn.derive(system.in_modes({f"c{i}": m for i, m in enumerate(modes)}))


def slips(scene: Scene, q: Array, u: Array) -> Array:
    """The directions of slip of all contacts (k × 2)."""
    v = motions(scene, q) @ u
    slip = rows(scene, posed(scene, q), v).contacts[:, 1:] @ v
    return slip / np.linalg.norm(slip, axis=1, keepdims=True)


def drawn_modes(scene: Scene, data: st.DataObject) -> tuple[str, ...]:
    """A mode for each contact whose forces are determined: a body held at a point has no three rows, two points have no six."""
    modes = list[str]()
    for i, touch in enumerate(scene.touches):
        first = i and scene.touches[i - 1].body == touch.body and modes[i - 1] == "stick"
        held = first or (scene.solids[touch.body].joint == "ball" and scene.solids[touch.body].to < 0)
        modes.append(data.draw(st.sampled_from([m for m in MODES if m != "stick" or not held])))
    return tuple(modes)


@pytest.mark.grows
@examples(0.25, least=10)
@given(scenes(), st.data())
def test_a_modes_equations_are_those_of_newton_and_euler(scene: Scene, data: st.DataObject) -> None:
    """At 100 states of each mode by the full profile."""
    modes = drawn_modes(scene, data)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    eom, own = in_modes(build_of(scene), modes), model(scene)
    found = (admitted(scene, modes, rng) for _ in range(max(3, settings().max_examples // 2)))
    states = [state for state in found if state is not None]
    assume(states)
    angles = rng.uniform(-np.pi, np.pi, (len(states), len(modes)))
    straight = np.stack([np.cos(angles), np.sin(angles)], axis=2)
    every = np.array([np.hstack([q, u, rates(scene, q, u)]) for q, u in states])
    at = own.values(scene) | dict(zip((*own.coordinates, *eom.speeds), every.T, strict=False))
    at |= dict(zip([x.dt for x in own.coordinates], every.T[-len(own.coordinates) :], strict=True))
    for c, d in zip(eom.system.contacts, np.moveaxis(straight, 0, 2), strict=True):
        at |= dict(zip(c.direction, d, strict=True))
    values = dict(zip(range(len(eom.speeds)), kn.evaluate(list(eom.solved.accelerations), at), strict=True))
    values |= dict(zip((r.name for r in eom.reactions), kn.evaluate(list(eom.solved.reactions), at), strict=True))
    for c, mode in zip(eom.system.contacts, modes, strict=True):
        if mode in ("straight", "slip"):
            laws = c.sliding_friction(kn.ContactMode[mode.upper()])
            forces = kn.evaluate([*laws.values()], at | {c.normal_force: values[c.normal_force.name]})
            values |= dict(zip((f.name for f in laws), forces, strict=True))
    columns = np.array([np.broadcast_to(x, len(states)) for x in values.values()], dtype=float).T
    for (q, u), way, numbers in zip(states, straight, columns, strict=True):
        along = np.where(np.array(modes)[:, None] == "slip", slips(scene, q, u), way)
        beside(eom, modes, dict(zip(values, numbers, strict=True)), solved(scene, q, u, modes, along))


def beside(eom: kn.Equations, modes: tuple[str, ...], values: dict[Any, float], wanted: Any) -> None:
    """Accelerations, by number, and N and F, by name, of one state."""
    size = max(1.0, np.abs(wanted.accelerations).max(), np.abs(wanted.normal).max(), np.abs(wanted.friction).max())
    told = dict[Any, float](enumerate(wanted.accelerations))
    for c, mode, n, f in zip(eom.system.contacts, modes, wanted.normal, wanted.friction, strict=True):
        if mode != "separated":
            told |= {c.normal_force.name: n} | {x.name: y for x, y in zip(c.friction_forces, f, strict=True)}
    assert values.keys() == told.keys()
    np.testing.assert_allclose([values[name] for name in told], list(told.values()), rtol=0, atol=1e-9 * size)
