# SPDX-License-Identifier: BSD-3-Clause
"""A free body by velocities of its mass centre: the numbers of the classical route, for random bodies, speeds and loads."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.dynamics import by_mass_centre, classical
from kane.gallery import load, rolling_disk
from tests.examples import examples


def free_body(seed: int) -> kn.System:
    """A body carried by a point that is not its mass centre, with two or three coordinates of that point, in a resisting wind."""
    rng = np.random.default_rng(seed)
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    axes = [N.x, N.y, N.z]
    count, first = int(rng.integers(1, 4)), int(rng.integers(3))
    places = kn.coordinates(f"x1:{count + 1}", "m")
    frame, angles = N, kn.coordinates(f"a1:{int(rng.integers(1, 4)) + 1}", "rad")
    for k, a in enumerate(angles):
        frame = frame.rotate(f"B{k}", a + 0.3 * k, getattr(frame, "xyz"[(first + k) % 3]))
    P = O.at("P", sum((x * n for x, n in zip(places, axes, strict=False)), start=0 * N.x))
    r = kn.parameters("r1:4", 0.3, "m")
    C = P.at("C", r[0] * frame.x + r[1] * frame.y + r[2] * frame.z)
    inertia = kn.inertia(frame, *kn.parameters("I1:4", 0.2, "kg*m^2"))
    body = kn.RigidBody("body", frame=frame, mass_center=C, mass=kn.parameter("m", 1.5, "kg"), inertia=inertia)
    tip = C.at("T", -2 * r[1] * frame.z + r[0] * frame.x)
    drag = kn.Force(
        tip, -kn.parameter("c", 0.4, "kg/s") * (tip.velocity(N) - kn.parameter("v", 3.0, "m/s") * N.x), name="drag"
    )
    w = frame.angular_velocity(N)
    along = [w.dot(frame.x), w.dot(frame.y), w.dot(frame.z)]
    own = along if len(angles) == 3 and rng.random() < 0.5 else [a.dt for a in angles]
    speeds = kn.speeds(f"u1:{len(own) + count + 1}")
    definitions = dict(zip(speeds, [*own, *(x.dt for x in places)], strict=True))
    return kn.System(N, bodies=[body], speeds=definitions, loads=[kn.gravity(-9.81 * N.z), drag])


def agree(system: kn.System, rng: np.random.Generator) -> bool:
    """Whether there is such a route, which then gives what the classical one does."""
    eom = kn.derive(system)
    found = by_mass_centre(eom.derived)
    if found is None:
        return False
    usual = classical(eom.derived, None)
    _, solved = found
    for _ in range(3):
        q = {x: rng.uniform(0.2, 1.2) for x in eom.coordinates}
        u = {x: rng.normal() for x in eom.speeds}
        wanted, given = (
            np.array(eom.evaluate([*s.accelerations, *s.reactions], q=q, u=u), dtype=float) for s in (usual, solved)
        )
        assert np.abs(given - wanted).max() <= 1e-10 * np.abs(wanted).max()
    return True


@pytest.mark.slow
@examples(0.5, 15)
@given(st.integers(0, 2**32 - 1))
def test_random_free_bodies(seed):
    assert agree(free_body(seed), np.random.default_rng(seed))


def test_the_sliding_disk_whose_friction_holds_its_normal_force(rng):
    assert agree(load("rolling_disk").system(), rng)
    eom = kn.derive(load("rolling_disk").system())
    assert eom.solved.route == "mass centre"
    assert eom.operations.total <= 107


@pytest.mark.parametrize("speeds", ["components", "rates"])
def test_either_choice_of_speeds(speeds, rng):
    assert agree(rolling_disk.model(speeds=speeds).system, rng)


def test_speeds_of_the_mass_centre_itself_leave_nothing_to_do():
    system = load("free_body").system()
    assert by_mass_centre(kn.derive(system).derived) is None
