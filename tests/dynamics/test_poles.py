# SPDX-License-Identifier: BSD-3-Clause
"""Speeds whose W has a pole where the motion has none: sleds and carts at it, beside it and elsewhere."""

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.dynamics.constraints.poles import without_poles
from kane.dynamics.derived import derived
from kane.gallery import GALLERY, load

NEAR = (0.3, 2.5, np.pi / 2, np.pi / 2 - 1e-8, np.pi / 2 + 1e-12, -np.pi / 2, 0.0, 1e-8, np.pi)


def sled(**options: Any) -> kn.System:
    """A sled on its runner, u1 = yaw', u2 = v·a_x, u3 = y': W has a pole at yaw = π/2."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, yaw = kn.coordinates("x y yaw")
    A = N.rotate("A", yaw, N.z)
    C = O.at("C", x * N.x + y * N.y)
    m, J = kn.parameter("m", 2.0), kn.parameter("J", 0.3)
    body = kn.RigidBody("sled", frame=A, mass_center=C, mass=m, inertia=kn.inertia(A, J, J, J))
    u1, u2, u3 = kn.speeds("u1 u2 u3")
    v = C.velocity(N)
    speeds = {u1: yaw.dt, u2: v.dot(A.x), u3: y.dt}
    across = kn.motion_constraint("no slip across", v.dot(A.y))
    loads = [kn.Force(C, 6 * A.x + 0.5 * A.y), kn.Torque(A, 0.9 * N.z)]
    chosen = {k: [{"u2": u2, "u3": u3}[name] for name in names] for k, names in options.items()}
    return kn.System(N, bodies=[body], speeds=speeds, nonholonomic=[across], loads=loads, **chosen)


def truth(yaw: float, spin: float, speed: float) -> dict[str, float]:
    """Rates, accelerations, what holds the sled and its energy: v' = 3 along, a force of m v ω − 0.5 across."""
    c, s = np.cos(yaw), np.sin(yaw)
    return {
        "x": speed * c, "y": speed * s, "yaw": spin,
        "u1": 3.0, "u2": 3.0, "u3": 3.0 * s + speed * c * spin,
        "force": 2 * speed * spin - 0.5, "energy": speed**2 + 0.15 * spin**2, "power": 6 * speed + 0.9 * spin,
    }  # fmt: skip


@pytest.mark.parametrize("options", [{}, {"dependent_speeds": ["u3"]}])
@pytest.mark.parametrize("yaw", NEAR)
def test_a_sled_is_regular_at_every_heading(options, yaw):
    eom = kn.derive(sled(**options))
    spin, speed = 0.7, 1.1
    expected = truth(yaw, spin, speed)
    q, u = {"x": 0.1, "y": 0.2, "yaw": yaw}, {"u1": spin, "u2": speed, "u3": speed * np.sin(yaw)}
    rates = [expected[s.name] for s in (*eom.coordinates, *eom.speeds)]
    np.testing.assert_allclose(eom.evaluate(list(eom.right_hand_side), q=q, u=u), rates, atol=1e-12)
    state = [{**q, **u}[s.name] for s in (*eom.coordinates, *eom.speeds)]
    np.testing.assert_allclose(eom.compile().rhs(0.0, np.array(state)), rates, atol=1e-12)
    asked = [*eom.multipliers.values(), eom.energy, eom.power]
    wanted = [expected[name] for name in ("force", "energy", "power")]
    np.testing.assert_allclose(eom.evaluate(asked, q=q, u=u), wanted, atol=1e-12)


def test_equations_without_the_pole_are_short():
    eom = kn.derive(sled())
    assert [str(u) for u in eom.dependent_speeds] == ["u3"]
    assert str(eom.accelerations[1]) == "6/m"
    assert eom.operations.total == 10


@pytest.mark.parametrize("name", GALLERY)
def test_true_poles_are_left_alone(name):
    """Gimbals and the like: there the coordinates themselves are singular."""
    eom = kn.derive(load(name).system())
    assert eom.solved.route == "classical"
    embedding = eom.embedding
    assert without_poles(derived(eom.system), embedding.partition if embedding else None) is None
