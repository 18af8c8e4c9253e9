# SPDX-License-Identifier: BSD-3-Clause
"""Random bodies in space with contacts: each mode's accelerations and forces against Newton and Euler."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
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
@examples(1.0)
@given(scenes(), st.data())
def test_a_modes_equations_are_those_of_newton_and_euler(scene: Scene, data: st.DataObject) -> None:
    modes = drawn_modes(scene, data)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    eom = in_modes(build_of(scene), modes)
    states = [state for state in (admitted(scene, modes, rng) for _ in range(3)) if state is not None]
    for q, u in states:
        beside(scene, eom, modes, q, u, rng)


def beside(
    scene: Scene, eom: kn.Equations, modes: tuple[str, ...], q: Array, u: Array, rng: np.random.Generator
) -> None:
    """Accelerations, N and F of one state."""
    angles = rng.uniform(-np.pi, np.pi, len(modes))
    straight = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    along = np.where(np.array(modes)[:, None] == "slip", slips(scene, q, u), straight)
    own = model(scene)
    at = dict(zip(own.coordinates, q, strict=True)) | dict(zip(eom.speeds, u, strict=True)) | own.values(scene)
    at |= {x.dt: rate for x, rate in zip(own.coordinates, rates(scene, q, u), strict=True)}
    for c, d in zip(eom.system.contacts, straight, strict=True):
        at |= dict(zip(c.direction, d, strict=True))
    wanted = solved(scene, q, u, modes, along)
    values = np.array(kn.evaluate([*eom.solved.accelerations, *eom.solved.reactions], at), dtype=float)
    count = len(eom.speeds)
    size = max(1.0, np.abs(wanted.accelerations).max(), np.abs(wanted.normal).max(), np.abs(wanted.friction).max())
    np.testing.assert_allclose(values[:count], wanted.accelerations, rtol=0, atol=1e-9 * size)
    held = dict(zip([r.name for r in eom.reactions], values[count:], strict=True))
    told = dict[str, float]()
    for c, mode, n, f in zip(eom.system.contacts, modes, wanted.normal, wanted.friction, strict=True):
        told |= {c.normal_force.name: n} if mode != "separated" else {}
        told |= {x.name: y for x, y in zip(c.friction_forces, f, strict=True)} if mode == "stick" else {}
        if mode in ("straight", "slip"):
            laws = kn.evaluate(c.sliding_friction(kn.ContactMode[mode.upper()]).values(), at | {c.normal_force: n})
            np.testing.assert_allclose(laws, f, rtol=0, atol=1e-9 * size)
    assert held.keys() == told.keys()
    for name, value in held.items():
        assert value == pytest.approx(told[name], abs=1e-9 * size)
