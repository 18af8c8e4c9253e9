# SPDX-License-Identifier: BSD-3-Clause
"""dE/dt = P, load by load and with prescribed motion; kinetic energy is half of u M u where nothing is prescribed."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.paths import derivative

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinates("q1:5")
g = kn.parameter("g", 9.81)


def model(drive):
    """A turntable, driven or free, a skew link on it, and a slider along the link."""
    A = N.rotate("A", q[0] if drive is None else q[0] + drive, N.z)
    hub = O.at("hub", 0.5 * A.x if drive is None else 0.5 * A.x + drive * N.y)
    B = A.rotate("B", q[1], (A.x + A.z).normalized())
    link = hub.at("link", 0.3 * B.y)
    slider = hub.at("slider", q[2] * B.y + q[3] * B.z)
    bodies = [
        kn.RigidBody("table", frame=A, mass_center=hub, mass=2, inertia=kn.inertia(A, 1, 1, 2)),
        kn.RigidBody(
            "link", frame=B, mass_center=link, mass=1, inertia=kn.inertia(B, 0.2, 0.15, 0.2, 0.03, 0.02, 0.01)
        ),
        kn.Particle("slider", slider, 0.5),
    ]
    return A, B, hub, slider, bodies


def loads_of(name, A, B, hub, slider):
    s = slider
    return {
        "nothing": [],
        "gravity": [kn.gravity(-g * N.z)],
        "gravity that turns with the table": [kn.gravity(-g * A.x)],
        "gravity that varies": [kn.gravity(-g * kn.sin(kn.time) * N.z)],
        "springs": [kn.linear_spring(s, hub, 30, 0.2), kn.linear_spring(s, O, 5), kn.torsional_spring(
            B, A, q[1], 3, (A.x + A.z).normalized(), rest=0.1)],
        "a spring whose stiffness varies": [kn.linear_spring(s, hub, 30 * (2 + kn.sin(kn.time)), 0.2)],
        "a spring whose length varies": [kn.linear_spring(s, hub, 30, 0.2 + 0.1 * kn.sin(kn.time))],
        "dampers": [kn.linear_damper(s, hub, 2), kn.torsional_damper(B, A, 0.3, (A.x + A.z).normalized())],
        "drag and a motor": [kn.Force(s, -0.4 * s.velocity(N)), kn.torque_pair(B, A, 2 * kn.cos(kn.time) * A.y)],
        "a particle's force": [kn.Force(hub.fixed_in(B, "tip", q[2] * B.y), N.x - 2 * N.z)],
        "an input": [kn.Force(s, kn.input("T") * B.x)],
    }[name]  # fmt: skip


LOADS = ["nothing", "gravity", "gravity that turns with the table", "gravity that varies", "springs",
         "a spring whose stiffness varies", "a spring whose length varies", "dampers", "drag and a motor",
         "a particle's force", "an input"]  # fmt: skip
DRIVES = {"free": None, "driven": kn.sin(2 * kn.time) / 3, "driven steadily": 1.5 * kn.time}
STATE = {"q": [0.4, -0.3, 0.9, 0.2], "u": [0.8, -1.1, 0.5, 0.3], "t": 0.7}


def derive(load, drive, speeds="rates"):
    A, B, hub, slider, bodies = model(DRIVES[drive])
    loads = loads_of(load, A, B, hub, slider)
    eom = kn.derive(kn.System(N, bodies=bodies, speeds=speeds, loads=loads, coordinates=q))
    return eom, STATE | ({"inputs": {"T": 0.4}} if eom.inputs else {})


@pytest.mark.slow
@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("load", LOADS)
@pytest.mark.filterwarnings("ignore:Expected gravity .* along a fixed direction")
def test_power_is_the_rate_of_the_energy(load, drive):
    eom, state = derive(load, drive)
    rate, power = (float(x) for x in eom.evaluate([eom.time_derivative(eom.energy), eom.power], **state))
    assert rate == pytest.approx(power, rel=1e-11, abs=1e-12)
    # the exact derivative against differences along the motion, over which u̇ changes q and u
    q_dot = np.array(eom.evaluate(list(eom.rates), **state))
    u_dot = np.array(eom.evaluate(list(eom.accelerations), **state))

    def energy(s):
        moved = {"q": np.array(STATE["q"]) + s * q_dot, "u": np.array(STATE["u"]) + s * u_dot, "t": 0.7 + s}
        return float(eom.evaluate(eom.energy, **(state | moved)))

    assert derivative(energy) == pytest.approx(rate, rel=1e-7, abs=1e-8)


def test_conservative_loads_alone_have_no_power():
    for load in ("nothing", "gravity", "springs"):
        eom, _ = derive(load, "free")
        assert str(eom.power) == "0"


@pytest.mark.parametrize("drive", ["free", "driven"])
def test_kinetic_energy(drive):
    """½ uᵀ M u, and with prescribed motion the sum over the bodies in NumPy."""
    eom, state = derive("gravity", drive)
    M, u = eom.evaluate(eom.mass_matrix, **state), np.array(STATE["u"])
    found = float(eom.evaluate(eom.kinetic_energy, **state))
    total = 0.0
    for b in eom.system.bodies:
        v = np.array(eom.evaluate(eom.velocities[b.mass_center].components(N), **state))
        total += float(kn.evaluate(b.mass, {})) * v @ v / 2
        if isinstance(b, kn.RigidBody):
            w = np.array(eom.evaluate(eom.angular_velocities[b.frame].components(b.frame), **state))
            total += w @ kn.evaluate(b.inertia.components(b.frame), {}) @ w / 2
    assert found == pytest.approx(total)
    if drive == "free":
        assert found == pytest.approx(u @ M @ u / 2)
    else:
        assert found != pytest.approx(u @ M @ u / 2, rel=1e-2)


def test_power_of_a_driven_pivot_is_force_times_speed():
    """A bob on a rod whose pivot goes up and down: P = F ẏ with the reaction that drives it."""
    lift = 0.3 * kn.sin(4 * kn.time)
    pivot = O.at("pivot", lift * N.y)
    A = N.rotate("A", q[0], N.z)
    bob = kn.Particle("bob", pivot.at("bob", -1 * A.y), 2)
    force = kn.reaction("F", at=pivot, along=N.y)
    eom = kn.derive(kn.System(N, bodies=[bob], speeds="rates", loads=[kn.gravity(-g * N.y)], reactions=[force]))
    state = {"q": [0.8], "u": [1.3], "t": 0.2}
    P, F = (float(x) for x in eom.evaluate([eom.power, force], **state))
    assert pytest.approx(F * 1.2 * np.cos(0.8)) == P
    assert abs(P) > 1


def test_energy_does_not_depend_on_the_speeds():
    u = kn.speeds("u1:5")
    A, B, hub, slider, bodies = model(DRIVES["driven"])
    w, v = B.angular_velocity(N), slider.velocity(N)
    definitions = {u[0]: w.dot(B.x), u[1]: w.dot(B.y), u[2]: v.dot(B.y), u[3]: v.dot(B.z)}
    loads = loads_of("dampers", A, B, hub, slider)
    one, state = derive("dampers", "driven")
    two = kn.derive(kn.System(N, bodies=bodies, speeds=definitions, loads=loads, coordinates=q))
    values = dict(zip(q, STATE["q"], strict=True)) | {kn.time: 0.7}
    values |= {x.dt: r for x, r in zip(q, STATE["u"], strict=True)}
    other = state | {"u": [float(x) for x in kn.evaluate(list(definitions.values()), values)]}
    for name in ("kinetic_energy", "potential_energy", "power"):
        first, second = getattr(one, name), getattr(two, name)
        assert float(two.evaluate(second, **other)) == pytest.approx(float(one.evaluate(first, **state)))
