# SPDX-License-Identifier: BSD-3-Clause
"""u̇ multiplied out: its terms add up to it along motions."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.cli import model_of
from kane.gallery import GALLERY
from kane.present import multiplied_out

SHORT = ("pendulum", "spherical_pendulum", "spinning_top", "particle_on_spring")


def difference(name: str) -> float | None:
    """How far the terms of u̇ are from it, beside the largest of them; None where they are not shown."""
    model = model_of(name)
    eom = kn.derive(model.system)
    found = multiplied_out(eom)
    if found is None:
        return None
    sol = kn.simulate(eom, (0.0, 0.2), samples=11, **model.start)
    far = 0.0
    for u, whole in zip(eom.speeds, eom.accelerations, strict=True):
        values = np.array([np.broadcast_to(v, sol.t.shape) for v in sol[[whole, *(c.term for c in found[u])]]])
        far = max(far, np.abs(values[0] - values[1:].sum(axis=0)).max() / max(np.abs(values).max(), 1e-300))
    return far


@pytest.mark.parametrize("name", SHORT)
def test_the_terms_of_an_acceleration_add_up(name: str) -> None:
    assert difference(name) <= 1e-12


@pytest.mark.slow
def test_the_terms_of_the_gallery_add_up() -> None:
    found = {name: difference(name) for name in GALLERY if name not in SHORT and model_of(name).start}
    assert {name: far for name, far in found.items() if far is not None and far > 1e-12} == {}


def test_a_force_and_what_a_speed_brings() -> None:
    """θ̈ = φ̇² sin θ cos θ − g sin θ / l of a spherical pendulum, the second by gravity."""
    eom = kn.derive(model_of("spherical_pendulum").system)
    told = {c.source: str(c.term) for c in multiplied_out(eom)[eom.speeds[1]]}
    assert told == {"gravity": "-g*sin(theta)/l", "bob": "u_phi^2*cos(theta)*sin(theta)"}


def test_what_is_long_or_held_is_not_multiplied_out() -> None:
    assert multiplied_out(kn.derive(model_of("double_pendulum").system)) is None
    assert multiplied_out(kn.derive(model_of("four_bar").system)) is None
