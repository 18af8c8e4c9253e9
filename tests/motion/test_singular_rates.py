# SPDX-License-Identifier: BSD-3-Clause
"""Singular kinematics at the start and on the way: the pivot, its value and the rates left open are named."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.motion import nearly_singular, pivots
from tests.peer import require

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinates("q1:4")
u = kn.speeds("u1:4")
L = kn.parameter("L", 1e-3)


def body(sequence):
    B = N.rotate_body("B", q, sequence)
    rigid = kn.RigidBody("b", frame=B, mass_center=O.at("G", 0), mass=1, inertia=kn.inertia(B, 1, 2, 2.5))
    w = B.angular_velocity(N)
    return kn.derive(kn.System(N, bodies=[rigid], speeds=dict(zip(u, map(w.dot, (B.x, B.y, B.z)), strict=True))))


def values(eom, *state):
    return dict(zip(eom.coordinates, state, strict=True)) | {p: p.default for p in eom.parameters}


@pytest.mark.parametrize(
    ("sequence", "at", "pivot"), [("zyx", np.pi / 2, "cos"), ("zxz", 0.0, "sin"), ("xyx", np.pi, "sin")]
)
def test_a_pivot_that_rounding_leaves_over(sequence, at, pivot):
    """cos(π/2) = 6e-17 in numbers: the rates are finite there, and meaningless."""
    eom = body(sequence)
    message = (
        rf"got none for q1', q3' at t = 0: the kinematics are singular at q2 = .*{pivot}\(q2\) = .*Start elsewhere"
    )
    with pytest.raises(kn.SimulationError, match=message):
        kn.simulate(eom, (0, 1), q=[0.4, at, 0.2], u=[1, 1, 1])
    run = kn.prepare(eom, (0, 1))
    assert run.in_one_call
    assert run([0.4, at + 0.7, 0.2], [1, 1, 1]).t[-1] > 0
    with pytest.raises(kn.SimulationError, match=message):
        run([0.4, at, 0.2], [1, 1, 1])


def test_one_of_many_starts_where_kinematics_are_singular():
    require("xarray")
    starts = [[0.4, 0.7, 0.2], [0.4, np.pi / 2, 0.2]]
    runs = kn.simulate_many(body("zyx"), (0, 1), q=starts, u=[1, 1, 1], samples=3, lanes=True)
    assert runs.status.values[0] != "failed"
    assert "the kinematics are singular" in runs.cause.values[1]


@pytest.mark.parametrize("near", [1e-6, 1e-3])
def test_near_a_singularity_it_still_starts(near):
    sol = kn.simulate(body("zyx"), (0, 1e-9), q=[0.4, np.pi / 2 - near, 0.2], u=[0, 0, 0])
    assert sol.status == "finished"


def test_small_parameters_are_no_singularity():
    """Y holds a length of 1 mm: what counts is its change with the configuration."""
    A = N.rotate("A", q[0], N.z)
    bob = O.at("bob", L**4 * A.x)
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", bob, 1)], speeds={u[0]: bob.velocity(N).dot(A.y)}))
    assert kn.simulate(eom, (0, 1e-13), q=[0.1], u=[1]).status == "finished"


def test_pivots_are_listed_smallest_first():
    eom = body("zyx")
    found = pivots(eom, values(eom, 0.1, 1.2, 0.4))
    assert [(str(r.pivot), r.coordinates) for r in found] == [("cos(q2)", (q[1],))]
    assert found[0].value == pytest.approx(np.cos(1.2))
    assert pivots(kn.derive(eom.system.replace(speeds="rates")), {}) == []


def test_a_motion_that_breaks_off_names_the_pivot():
    """Driven at the pitch of 90° by a speed that grows without bound, the run stops short of it."""
    eom = body("zyx")
    assert nearly_singular(eom, values(eom, 0.1, 0.2, 0.3)) == ""
    said = nearly_singular(eom, values(eom, 0.1, np.pi / 2 - 1e-6, 0.3))
    assert said == "; W of q' = W u + X divides by cos(q2) = 1e-06 there"


def test_masses_below_zero_by_the_parameters():
    m = kn.parameter("m", 1.0)
    x = kn.coordinate("x")
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("bob", O.at("P", x * N.x), m)], speeds="rates"))
    with pytest.raises(kn.SimulationError, match="mass ≥ 0 for bob, got m = -2 at the values of the parameters"):
        kn.simulate(eom, (0, 1), q=[0], u=[0], parameters={m: -2})
