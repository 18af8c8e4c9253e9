# SPDX-License-Identifier: BSD-3-Clause
"""Bevel and worm gears: ratios, reflected inertia, tooth forces, and the differential."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.model.joints.kinds import rigid

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def spinner(name, frame, point, inertia):
    return rigid(name, frame, point, 1, kn.inertia(frame, inertia, inertia, inertia))


def numbers(eom, exprs, **state):
    return np.array([float(x) for x in eom.evaluate(list(exprs), **state)])


@pytest.mark.parametrize("angle", [kn.pi / 2, kn.pi / 3, 2 * kn.pi / 3])
def test_bevel_gears_on_the_ground(angle):
    """(J_a + (z_a/z_b)² J_b) α = T, θ_b = −(z_a/z_b)(θ_a − φ); the teeth push across both axes."""
    tilted = N.rotate("M", angle, N.y)
    a, b = kn.pin("a", O, N, axis=N.z), kn.pin("b", O, N, axis=tilted.z)
    mesh = kn.bevel_pair("mesh", a, b, teeth=(20, 40), radius=kn.parameter("r", 0.1, "m"), phase=0.2)
    assert mesh.kind == "configuration"
    bodies = [spinner("A", a.frame, a.point, 0.03), spinner("B", b.frame, b.point, 0.5)]
    system = kn.System(N, bodies=bodies, joints=[a, b], loads=[kn.Torque(a.frame, 5 * N.z)], holonomic=mesh)
    eom = kn.derive(system)
    state = kn.assemble(eom, q={a.coordinates[0]: 0.7}, u={"u_a": 2.0})
    at = {"q": state.q, "u": state.u}
    assert state.q[b.coordinates[0]] == pytest.approx(-0.5 * (0.7 - 0.2), abs=1e-12)
    alpha = 5 / (0.03 + 0.25 * 0.5)
    np.testing.assert_allclose(numbers(eom, eom.accelerations, **at), [alpha, -alpha / 2], rtol=1e-12)
    force = numbers(eom, eom.reaction("mesh").force.components(N), **at)
    np.testing.assert_allclose(force, [0, (0.03 * alpha - 5) / 0.1, 0], atol=1e-11)


def test_a_differential():
    """Side gears turn by the mean of their speeds with the carrier: ω₁ + ω₂ = 2 ω_C; torques are shared equally."""
    carrier = kn.pin("carrier", O, N, axis=N.z)
    C = carrier.frame
    left, right = kn.pin("left", O, N, axis=N.z), kn.pin("right", O, N, axis=N.z)
    planet = kn.pin("planet", O.at("p", 0.05 * C.x), C, axis=C.x)
    meshes = [
        kn.bevel_pair(f"{side.name} mesh", (planet.frame, planet.point), (side.frame, side.point), teeth=(1, 1), radius=0.05,
                      apex=O, axes=(C.x, axis))
        for side, axis in ((left, C.z), (right, -C.z))
    ]  # fmt: skip
    assert {m.kind for m in meshes} == {"motion"}
    J = 0.02
    bodies = [spinner(j.name, j.frame, j.point, J) for j in (left, right, carrier)]
    bodies.append(spinner("planet", planet.frame, planet.point, 1e-3))
    eom = kn.derive(
        kn.System(
            N, bodies=bodies, joints=[carrier, left, right, planet], nonholonomic=meshes, loads=[kn.Torque(C, 3 * N.z)]
        )
    )
    state = kn.assemble(eom, q=dict.fromkeys(eom.coordinates, 0.0), u={"u_left": 1.0, "u_right": 4.0})
    speeds = {u.name: float(v) for u, v in state.u.items()}
    assert speeds["u_left"] + speeds["u_right"] == pytest.approx(2 * speeds["u_carrier"])
    assert abs(speeds["u_planet"]) == pytest.approx(1.5)
    found = dict(zip(eom.speeds, numbers(eom, eom.accelerations, q=state.q, u=state.u), strict=True))
    names = {u.name: v for u, v in found.items()}
    assert names["u_left"] == pytest.approx(names["u_right"])
    assert names["u_carrier"] == pytest.approx(names["u_left"])


@pytest.mark.parametrize("hand", ["right", "left"])
@pytest.mark.parametrize("side", [1, -1])
def test_worm_gears_on_the_ground(hand, side):
    """θ_wheel/θ_worm = ∓ threads/teeth; the worm's torque is rise times its thrust, without friction."""
    r = 0.2
    wheel = kn.pin("wheel", O, N, axis=N.z)
    worm = kn.pin("worm", O.at("W", side * 0.25 * N.y + 0.03 * N.x), N, axis=N.x)
    mesh = kn.worm_pair("mesh", wheel, worm, teeth=(40, 2), radius=r, hand=hand, phase=0.3)
    assert mesh.kind == "configuration"
    bodies = [spinner("G", wheel.frame, wheel.point, 0.6), spinner("W", worm.frame, worm.point, 0.002)]
    loads = [kn.Torque(worm.frame, 0.5 * N.x)]
    eom = kn.derive(kn.System(N, bodies=bodies, joints=[wheel, worm], loads=loads, holonomic=mesh))
    state = kn.assemble(eom, q={worm.coordinates[0]: 1.5}, u={"u_worm": 2.0})
    # n_w × n_g = x × z = −y: a worm above the wheel (+y) is on the side −1 of it
    ratio = (2 / 40) * (1 if hand == "right" else -1) * side
    assert state.q[wheel.coordinates[0]] == pytest.approx(ratio * 1.2, abs=1e-12)
    at = {"q": state.q, "u": state.u}
    alpha = 0.5 / (0.002 + ratio**2 * 0.6)
    np.testing.assert_allclose(numbers(eom, eom.accelerations, **at), [ratio * alpha, alpha], rtol=1e-11)
    force = numbers(eom, eom.reaction("mesh").force.components(N), **at)  # on the wheel
    assert -side * 0.2 * force[0] == pytest.approx(0.6 * ratio * alpha, rel=1e-10)
    rise, arm = 0.2 * 2 / 40, 0.05
    assert abs(force[2] / force[0]) == pytest.approx(rise / arm, rel=1e-10)
    assert force[1] == pytest.approx(0, abs=1e-10)


def test_a_right_handed_screw_pulls_its_nut_back():
    """Turned about +x, a right-handed thread that is held moves what it meshes with along −x."""
    wheel = kn.pin("wheel", O, N, axis=N.z)
    worm = kn.pin("worm", O.at("W", -0.25 * N.y), N, axis=N.x)
    mesh = kn.worm_pair("mesh", wheel, worm, teeth=(40, 2), radius=0.2)
    (at, direction), _ = mesh.forces
    rates = {wheel.coordinates[0].dt: 0.0, worm.coordinates[0].dt: 1.0}
    wheel_rate = -float(kn.evaluate(kn.time_derivative(mesh.expr), rates)) / float(
        kn.evaluate(kn.time_derivative(mesh.expr), {wheel.coordinates[0].dt: 1.0, worm.coordinates[0].dt: 0.0})
    )
    v = at.velocity(N).dot(N.x)
    values = {
        wheel.coordinates[0].dt: wheel_rate,
        wheel.coordinates[0]: 0.0,
        worm.coordinates[0]: 0.0,
        worm.coordinates[0].dt: 1.0,
    }
    assert float(kn.evaluate(v, values)) == pytest.approx(-0.2 * 2 / 40)
    assert direction is not None


def test_errors():
    a, b = kn.pin("a", O, N, axis=N.z), kn.pin("b", O, N, axis=N.x)
    with pytest.raises(kn.ModelError, match=r"kn\.gear_pair"):
        kn.bevel_pair("m", a, kn.pin("c", O, N, axis=N.z), teeth=(1, 2), radius=1)
    with pytest.raises(kn.ModelError, match="off the line"):
        kn.bevel_pair("m", a, kn.pin("c", O.at("C", N.y), N, axis=N.x), teeth=(1, 2), radius=1)
    with pytest.raises(kn.ModelError, match="positive numbers"):
        kn.bevel_pair("m", a, b, teeth=(1, -2), radius=1)
    with pytest.raises(kn.ModelError, match="teeth="):
        kn.bevel_pair("m", a, b, teeth=3, radius=1)
    with pytest.raises(kn.ModelError, match="axes="):
        kn.bevel_pair("m", (a.frame, O), b, teeth=(1, 2), radius=1)
    with pytest.raises(kn.ModelError, match="right angles"):
        kn.worm_pair("m", a, b, teeth=(40, 1), radius=1)
    with pytest.raises(kn.ModelError, match="hand="):
        kn.worm_pair("m", a, b, teeth=(40, 1), radius=1, hand="up")
    c = kn.pin("c", O.at("C", N.y), N, axis=N.x)
    with pytest.raises(kn.ModelError, match="below the distance"):
        kn.worm_pair("m", a, c, teeth=(40, 1), radius=1.2)
