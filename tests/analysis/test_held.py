# SPDX-License-Identifier: BSD-3-Clause
"""States assembled where A or A_n is not finite: at false poles, where dependent speeds do not follow, at singular coordinates."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.analysis import assembly, velocity_constraints_at
from kane.gallery import sphere_on_turntable, whipple_bicycle
from tests.dynamics.test_poles import sled
from tests.systems.turning_disk import disk

EPS = np.finfo(float).eps


@pytest.mark.parametrize("yaw", [0.4, np.pi / 2, np.pi / 2 - 1e-8])
@pytest.mark.parametrize("dependent", [["u3"], ["u2"]])
def test_a_sled_at_the_pole_of_its_speeds(yaw, dependent):
    eom = kn.derive(sled(dependent_speeds=dependent))
    q, speed = {"x": 0.1, "y": 0.2, "yaw": yaw}, 1.1
    wanted = [0.7, speed, speed * np.sin(yaw)]
    by_speeds = kn.assemble(eom, q=q, u={"u1": 0.7, "u2": speed})
    rates = {"x": speed * np.cos(yaw), "y": speed * np.sin(yaw), "yaw": 0.7}
    by_rates = kn.assemble(eom, q=q, rates=rates)
    for state in (by_speeds, by_rates):
        np.testing.assert_allclose(list(state.u.values()), wanted, atol=1e-12)
    with pytest.raises(kn.SimulationError, match="miss no slip across"):
        kn.assemble(eom, q=q, u={"u1": 0.7, "u2": 1.0, "u3": np.sin(yaw) + 0.1})


@pytest.mark.parametrize("dependent", [(), (1, 3), (1, 4), (2, 3), (2, 4), (3, 4)])
def test_an_upright_disk_with_any_dependent_speeds(dependent):
    """Upright the rolling does not hold the speed of its yaw, and its contact's speeds along the disk's axes vanish in turn."""
    eom = kn.derive(disk(dependent))
    for spin in (0.0, 0.2, np.pi / 2, 2.2):
        q = dict(zip(("yaw", "lean", "spin", "x", "y"), (0.3, 0.0, spin, 0.0, 0.0), strict=True))
        state = kn.assemble(eom, q=q, rates={"yaw": 0.1, "lean": 0.2, "spin": 5.0})
        rates = {"x": -1.5 * np.cos(0.3), "y": -1.5 * np.sin(0.3), "yaw": 0.1, "lean": 0.2, "spin": 5.0}
        np.testing.assert_allclose(list(state.u.values()), list(eom.speeds_from_rates(q, rates).values()), atol=1e-12)


def test_in_rates_of_euler_parameters_is_what_is_held_in_speeds(monkeypatch):
    eom = kn.derive(sphere_on_turntable.system())
    e = [0.8, 0.2, -0.4, np.sqrt(1 - 0.84)]
    own = [q for s in eom.system.euler_parameters for q in s.coordinates]
    at = dict.fromkeys(eom.coordinates, 0.3) | dict(zip(own, e, strict=True)) | {kn.time: 0.4}
    plain = [velocity_constraints_at(eom, at, by_rates) for by_rates in (False, True)]
    monkeypatch.setattr(assembly, "_plain", lambda eom, a, b: False)
    by_speeds, by_rates = (velocity_constraints_at(eom, at, by_rates) for by_rates in (False, True))
    for one, other in (
        (by_rates.to_speeds, plain[1].to_speeds),
        (by_rates.rows, plain[1].rows),
        (by_rates.rest, plain[1].rest),
    ):
        np.testing.assert_allclose(one, other, atol=100 * EPS * np.abs(other).max())
    u = np.linalg.lstsq(plain[0].rows, -plain[0].rest, rcond=None)[0]
    terms = np.abs(by_speeds.rows) @ np.abs(u) + np.abs(by_speeds.rest)
    np.testing.assert_array_less(np.abs(by_speeds.rows @ u + by_speeds.rest), 100 * EPS * terms.max())
    assert np.linalg.matrix_rank(by_speeds.rows) == np.linalg.matrix_rank(plain[0].rows)


def test_a_bicycle_laid_flat_is_named():
    """Where the front wheel lies flat its lowest point is nowhere in particular."""
    eom = kn.derive(whipple_bicycle.system())
    flat = dict.fromkeys((q.name for q in eom.coordinates), 0.0) | {"phi": -np.pi / 2}
    with pytest.raises(
        kn.SimulationError, match=r"finite, got infinity or NaN of 'front wheel on the road' at phi = -1\.5708"
    ):
        kn.assemble(eom, q=flat, u={"u1": 0.0})
    for free in (("phi",), ("phi", "theta")):
        state = kn.assemble(eom, q={k: kn.guess(x) if k in free else x for k, x in flat.items()}, u=None)
        np.testing.assert_allclose(eom.evaluate([c.expr for c in eom.system.holonomic], q=state.q), 0, atol=1e-12)
    told = "finite, got infinity or NaN of 'front wheel on the road'|is largest in 'front wheel on the road', which is not finite"
    with pytest.raises(kn.SimulationError, match=told):
        kn.assemble(eom, q=flat | {"theta": kn.guess(0.0)}, u=None)
