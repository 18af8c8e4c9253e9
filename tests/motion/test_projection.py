# SPDX-License-Identifier: BSD-3-Clause
"""Back onto the constraints by the least change in the mass metric."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kane as kn
from kane.motion import ConstraintProjection, KernelConstraints, Slot, constraint_projection
from tests.dynamics.constraints.test_branches import EIGHT, closed
from tests.numeric.kkt import kkt
from tests.systems.four_bar import BAR, EOM, N, O, state


def project(eom, x):
    nothing = np.zeros(0)
    return constraint_projection(eom.numeric()).project(
        0.0, x, nothing, nothing, np.zeros((len(eom.b), len(eom.speeds)))
    )


def perturbed(size):
    found = state()
    x = np.array([*found["q"].values(), *found["u"].values()])
    return x + size * np.sin(np.arange(1, len(x) + 1))


def test_projection_closes_the_constraints():
    x, numbers = project(EOM, perturbed(1e-4))
    assert np.abs(numbers.f).max() < 1e-13
    assert np.abs(numbers.a @ x[3:] + numbers.b).max() < 1e-13


def test_projection_is_the_least_change():
    """To first order in what is missed: of q by one KKT step, of u exactly."""
    x = perturbed(1e-5)
    before = constraint_projection(EOM.numeric()).numbers(0.0, x, np.zeros(0), np.zeros(0))
    kept, after = project(EOM, x)
    np.testing.assert_allclose(kept[:3] - x[:3], kkt(before.m, before.a, -before.f), atol=1e-9)
    np.testing.assert_allclose(kept[3:] - x[3:], kkt(after.m, after.a, -(after.a @ x[3:])), atol=1e-13)


def test_a_state_on_the_constraints_stays():
    x = perturbed(0.0)
    kept, _ = project(EOM, x)
    np.testing.assert_allclose(kept, x, atol=1e-13)


def test_euler_parameters_are_divided_by_their_length():
    e = kn.coordinates("e0:4")
    B = N.rotate_euler_parameters("B", e)
    body = kn.RigidBody("b", frame=B, mass_center=O.at("b*", 0), mass=1, inertia=kn.inertia(B, 0.1, 0.2, 0.3))
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates"))
    x = np.array([0.8, 0.2, -0.4, 0.5, 1, 2, 3])
    kept, _ = project(eom, x)
    np.testing.assert_allclose(kept[:4], x[:4] / np.linalg.norm(x[:4]), atol=1e-15)
    np.testing.assert_array_equal(kept[4:], x[4:])


def test_without_constraints_there_is_nothing_to_keep():
    assert constraint_projection(kn.derive(BAR.system(holonomic=())).numeric()) is None


def test_projection_onto_another_branch_is_told():
    """A little off a third turn, where a slider's equations hold too, they close to that."""
    _, system = closed("slider")
    eom = kn.derive(system)
    for turn, told in (
        (EIGHT[0], ""),
        (EIGHT[3], "'G' with its frame turned by 180°"),
        (EIGHT[6], "'G' with its frame turned by 120°"),
    ):
        e = np.roll(Rotation.from_matrix(turn).as_quat(), 1)
        x = np.array([*(e + 1e-3 * np.sin(range(4))), 0, 0, 0, *[0.0] * 6])
        _, numbers = project(eom, x)
        assert np.abs(numbers.f).max() < 1e-12
        assert constraint_projection(eom.numeric()).turned(numbers) == told


@pytest.mark.slow
@pytest.mark.parametrize("method", ["DOP853", "gauss16", "dop853"])
@pytest.mark.parametrize(("turned", "status"), [(3, "finished"), (10**9, "stopped")])
def test_a_step_onto_another_branch_is_halved_and_named_where_none_is_short_enough(monkeypatch, turned, status, method):
    _, system = closed("slider")
    eom, seen = kn.derive(system), []

    def told(self, numbers):
        seen.append(numbers)
        return "'G' with its frame turned by 120°" if len(seen) <= turned else ""

    monkeypatch.setattr(ConstraintProjection, "turned", told)
    # so that a kernel asks: all dependent speeds are poor to it, and it knows no others
    monkeypatch.setattr(KernelConstraints, "begin", lambda self, s: s.__setitem__(Slot.QUIET, 1e-300))
    monkeypatch.setattr(KernelConstraints, "choose_among", lambda self: None)
    start = kn.assemble(eom, q={q: kn.guess(v) for q, v in zip(eom.coordinates, (0, 0, 0, 1, 0, 0, 0), strict=True)})
    sol = kn.simulate(eom, (0, 1), q=start.q, u=start.u, method=method)
    assert sol.status == status
    if status == "stopped":
        assert "the closures are on another branch beyond t = " in sol.message
        assert sol.message.endswith("'G' with its frame turned by 120°")
