# SPDX-License-Identifier: BSD-3-Clause
"""An object of every public class, for tests of what all have in common."""

from __future__ import annotations

from functools import cache

import kane as kn
from kane.gallery import pendulum, rolling_disk

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
x, y, a = kn.coordinate("x", "m"), kn.coordinate("y", "m"), kn.coordinate("a", "rad")
v, w = kn.speed("v", "m/s"), kn.speed("w", "rad/s")
m, k, c = kn.parameter("m", 2.0, "kg"), kn.parameter("k", 50.0, "N/m"), kn.parameter("c", 0.5, "N*s/m")
F = kn.input("F", "N")
z = kn.state("z")
P = O.at("P", x * N.x)
A = N.rotate("A", a, N.z)
PUSH = kn.Force(P, F * N.x)
INERTIA = kn.inertia(A, 1, 2, 3)


@cache
def things() -> tuple[object, ...]:
    """One of each, and of some more."""
    plate = kn.RigidBody("plate", frame=A, mass_center=P, mass=m, inertia=INERTIA)
    loads = [PUSH, kn.gravity(-9.81 * N.y), kn.linear_spring(P, O, stiffness=k), kn.linear_damper(P, O, c)]
    system = kn.System(
        N, bodies=[plate], speeds={v: x.dt, w: a.dt}, loads=loads, events=[kn.Event("stop", x, threshold=9.0)], states={z: v}
    )  # fmt: skip
    eom = kn.derive(system)
    sol = kn.simulate(eom, (0, 0.1), q=[0.1, 0.0], u=[0.0, 0.0], inputs={F: 1.0}, samples=3)
    swing = kn.derive(pendulum.system())
    rest = {"q": [0.0], "u": [0.0]}
    linear = kn.linearize(swing, **rest)
    held = kn.derive(rolling_disk.system())
    R = O.at("R", x * N.x + y * N.y)
    rail = kn.derive(
        kn.System(N, bodies=[kn.Particle("bead", R, m)], speeds="rates", nonholonomic=[kn.no_slip(R, O, along=N.y)])
    )
    beam = kn.Beam("beam", O, frame=N, axis=N.x, length=1.0, mass_per_length=1.0, EI=1.0, modes=2)
    contact = kn.disk_on_plane("c", A, O.at("Q", x * N.x + N.y), O, axis=A.z, radius=1, normal=N.y)
    speeds = kn.compare_speeds(system, {"rates": {v: x.dt, w: a.dt}})
    moved = kn.motions(N, {v: x.dt, w: a.dt}, of=(A, P))
    line = kn.continuation(swing, swing.parameters[0], [1.0, 1.1], **rest)
    forces = kn.force_system(PUSH)
    undamped = kn.linearize(swing, parameters={"c": 0}, **rest)
    point = kn.trim(swing, **rest)
    return (
        x, x.dt, v, m, F, z, kn.time, kn.pi, x + 1, held.reactions[0], kn.auxiliary_speed("ua", at=P, along=N.z),
        kn.Matrix([[x, 1]]), kn.table([0, 1, 2], [0, 1, 4]), kn.count_operations([x * k]),
        N, A, O, P, N.x, INERTIA, kn.Rotation.identity(), kn.pin("hinge", O, N, axis=N.x),
        plate, kn.Particle("mass", P, m), kn.principal(INERTIA), beam, kn.mode_shapes("polynomials", 2),
        *loads, kn.Torque(A, N.z), forces, forces.wrench(O), *rail.system.nonholonomic, contact, system.events[0],
        moved, system, eom, eom.reaction(A), kn.Noncontributing(PUSH, "why"), eom.compile(), eom.jacobian(), eom.compile().rhs,
        kn.Settings(),
        kn.assemble(swing, q=[0.0], u=[0.0]), kn.guess(1.0), kn.signal([0, 1, 2], [0, 1, 0]), sol, sol.accuracy(),
        kn.prepare(swing, (0, 0.1)),
        linear, kn.linearizer(swing), kn.linearize_symbolic(swing, dict.fromkeys(swing.state, 0)), linear.second_order(),
        linear.modes[0], kn.normal_modes(undamped), kn.impact(eom, P, N.x, restitution=0.5, q=[0, 0], u=[-1, 0]),
        kn.constraint_forces(rail, q=[0.0, 0.0], u=[0.0, 0.0]), point, line, kn.Crossing(1.0, 1j, point, (0, 1), True),
        kn.inverse(swing, [s.dt for s in swing.speeds]), speeds, *speeds.sets, kn.compare_methods(system, ["kane"]),
        eom.by("kane"), kn.Check("mass", 0.0, 1.0),
    )  # fmt: skip
