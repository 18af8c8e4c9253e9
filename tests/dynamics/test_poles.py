# SPDX-License-Identifier: BSD-3-Clause
"""Speeds whose W has a pole where the motion has none: a sled and a cart at it, beside it and elsewhere."""

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.dynamics import derived, without_poles
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


@pytest.mark.slow
@pytest.mark.parametrize("name", GALLERY)
def test_true_poles_are_left_alone(name):
    """Gimbals and the like: there the coordinates themselves are singular."""
    eom = kn.derive(load(name).system())
    assert eom.solved.twin is None
    embedding = eom.embedding
    assert without_poles(derived(eom.system), embedding.partition if embedding else None) is None


@pytest.mark.slow
@pytest.mark.parametrize("yaw", [0.0, np.pi / 2, np.pi / 2 - 1e-8])
def test_a_motion_turns_through_the_poles(yaw):
    """The sled turns by 15.6 rad: yaw = ω t + 3 t²/2, speed = v + 3 t."""
    eom = kn.derive(sled())
    sol = kn.simulate(eom, (0, 3), q=[0, 0, yaw], u={"u1": 0.7, "u2": 1.1}, rtol=1e-10, atol=1e-10)
    assert sol.status == "finished"
    assert sol.energy_check.relative < 1e-12
    end = yaw + 0.7 * 3 + 1.5 * 9
    ends = [sol[name][-1] for name in ("yaw", "u1", "u2", "u3")]
    np.testing.assert_allclose(ends, [end, 9.7, 10.1, 10.1 * np.sin(end)], rtol=1e-9, atol=1e-8)


def test_a_start_at_a_pole_is_assembled():
    eom = kn.derive(sled())
    got = kn.assemble(eom, q=[0, 0, np.pi / 2], rates={"yaw": 1.0, "y": 2.0})
    assert list(got.u.values()) == pytest.approx([1, 2, 2])
    assert got.residual < 1e-15


def cart() -> kn.System:
    """A cart on two wheels and a slider, with y' and the spins among its speeds."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, yaw, left, right = kn.coordinates("x y yaw left right")
    A = N.rotate("A", yaw, N.z)
    C = O.at("C", x * N.x + y * N.y)
    G = C.at("G", 0.2 * A.x)
    body = kn.RigidBody("body", frame=A, mass_center=G, mass=5.0, inertia=kn.inertia(A, 0.4, 0.4, 0.4))
    spin, run, climb, s1, s2 = kn.speeds("spin run climb s1 s2")
    v = C.velocity(N)
    wheels, rolling = [], [kn.motion_constraint("no slip across", v.dot(A.y))]
    for name, angle, side in (("left", left, 0.3), ("right", right, -0.3)):
        hub = C.at(name, side * A.y)
        frame = A.rotate(name, angle, A.y)
        wheels.append(
            kn.RigidBody(name, frame=frame, mass_center=hub, mass=0.5, inertia=kn.inertia(frame, 0.01, 0.02, 0.01))
        )
        rolling.append(kn.motion_constraint(f"rolling {name}", hub.velocity(N).dot(A.x) - 0.2 * angle.dt))
    speeds = {spin: yaw.dt, run: v.dot(A.x), climb: y.dt, s1: left.dt, s2: right.dt}
    loads = [kn.Force(G, 2 * N.x + N.y), kn.Torque(A, 0.3 * N.z)]
    return kn.System(N, bodies=[body, *wheels], speeds=speeds, nonholonomic=rolling, loads=loads)


def expected_accelerations(yaw: float, spin: float, run: float) -> list[float]:
    """spin', run': Newton and Euler of the whole cart, mass centre 0.2 · 5/6 before C, wheels as added inertia."""
    m, wheel, own = 6.0, 2 * 0.02 / 0.2**2, 5 * 0.2  # Σ m, what the spins add along, Σ m x of the mass centre
    J = 0.4 + 5 * 0.2**2 + 2 * (0.01 + 0.5 * 0.3**2) + 2 * 0.02 * 0.3**2 / 0.2**2
    along, across = 2 * np.cos(yaw) + np.sin(yaw), np.cos(yaw) - 2 * np.sin(yaw)
    run_dot = (along + own * spin**2) / (m + wheel)
    spin_dot = (0.3 + 0.2 * across - own * run * spin) / J
    return [spin_dot, run_dot]


@pytest.mark.slow
@pytest.mark.parametrize("yaw", NEAR)
def test_a_cart_is_regular_at_every_heading(yaw):
    eom = kn.derive(cart())
    spin, run = 0.7, -1.3
    wheels = [(run - 0.3 * spin) / 0.2, (run + 0.3 * spin) / 0.2]
    q, u = {"x": 0, "y": 0, "yaw": yaw, "left": 1, "right": 2}, dict(
        zip(("spin", "run", "climb", "s1", "s2"), (spin, run, run * np.sin(yaw), *wheels), strict=True)
    )  # fmt: skip
    spin_dot, run_dot = expected_accelerations(yaw, spin, run)
    climb_dot = run_dot * np.sin(yaw) + run * spin * np.cos(yaw)
    wanted = [spin_dot, run_dot, climb_dot, (run_dot - 0.3 * spin_dot) / 0.2, (run_dot + 0.3 * spin_dot) / 0.2]
    np.testing.assert_allclose(eom.evaluate(list(eom.accelerations), q=q, u=u), wanted, atol=1e-11)
    state = np.array([{**q, **u}[s.name] for s in (*eom.coordinates, *eom.speeds)])
    rates = eom.compile().rhs(0.0, state)
    np.testing.assert_allclose(rates, [run * np.cos(yaw), u["climb"], spin, *wheels, *wanted], atol=1e-11)


def test_constraints_that_hold_nothing_leave_no_choice():
    """Two names of one particle: no speed depends on the others, and there is nothing to choose at a pole."""
    system = sled()
    body = system["sled"]
    one, two = (body.mass_center.fixed_in(body.frame, name, 0.2 * body.frame.x) for name in ("K", "K0"))
    with pytest.warns(kn.KaneWarning, match="contact"):
        eom = kn.derive(system.replace(nonholonomic=kn.no_slip(one, two, along=body.frame.y, name="contact")))
    assert eom.dependent_speeds == ()
