# SPDX-License-Identifier: BSD-3-Clause
"""Bodies on wheels and blades that do not slip; which speeds are dependent is named, or left to be chosen."""

from collections.abc import Sequence

import numpy as np

import kane as kn


def named(system: kn.System, dependent: Sequence[str]) -> kn.System:
    """The system with dependent speeds by name, none to have them chosen."""
    return system.replace(dependent_speeds=tuple(u for u in system.speeds if u.name in dependent))


def disk(dependent: Sequence[str] = (), *, plane: float = 0.0) -> kn.System:
    """A thin disk whose contact has the coordinates x, y and the speeds v_x, v_y; ω along the axes of the leaning frame.

    The plane is inclined by `plane` (rad).
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    psi, theta, phi, x, y = kn.coordinates("psi theta phi x y")
    w1, w2, w3, v_x, v_y = kn.speeds("w1 w2 w3 v_x v_y")
    m, R, g = kn.parameter("m", 1.2), kn.parameter("R", 0.3), kn.parameter("g", 9.81)
    Y = N.rotate("Y", psi, N.z)
    B = Y.rotate("B", theta, Y.x)
    C = B.rotate("C", phi, B.y)
    P = O.at("P", x * N.x + y * N.y)
    center = P.at("C*", R * B.z)
    contact = center.fixed_in(C, "C^", -R * B.z)
    w = C.angular_velocity(N)
    return named(
        kn.System(
            N,
            bodies=[kn.RigidBody("disk", frame=C, mass_center=center, mass=m, inertia=kn.thin_disk(C, m, R, axis=C.y))],
            speeds={w1: w.dot(B.x), w2: w.dot(B.y), w3: w.dot(B.z), v_x: x.dt, v_y: y.dt},
            loads=[kn.gravity(g * (np.sin(plane) * N.x - np.cos(plane) * N.z))],
            nonholonomic=kn.rolling(contact, normal=N.z),
        ),
        dependent,
    )


def free_disk(dependent: Sequence[str] = ()) -> kn.System:
    """A thin disk on a free joint, held to the plane and rolling by `kn.disk_on_plane`."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    m, R, g = kn.parameter("m", 1.2), kn.parameter("R", 0.3), kn.parameter("g", 9.81)
    wheel = kn.free("wheel", O, N, child="W")
    W = wheel.frame
    edge = kn.disk_on_plane("edge", W, wheel.point, O, axis=W.z, radius=R, normal=N.z)
    body = kn.RigidBody("disk", frame=W, mass_center=wheel.point, mass=m, inertia=kn.thin_disk(W, m, R, axis=W.z))
    loads = [kn.gravity(-g * N.z)]
    return named(
        kn.System(N, bodies=[body], joints=[wheel], loads=loads, holonomic=edge.height, nonholonomic=edge.rolling),
        dependent,
    )


def segway(dependent: Sequence[str] = (), *, redundant: bool = False) -> kn.System:
    """A leaning body on two wheels: speeds along and across its heading, turning, leaning and of the wheels."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, psi, theta, phi1, phi2 = kn.coordinates("x y psi theta phi1 phi2")
    v, s, turn, lean, w1, w2 = kn.speeds("v s turn lean w1 w2")
    R, b, h, g = (kn.parameter(n, x) for n, x in {"R": 0.2, "b": 0.3, "h": 0.9, "g": 9.81}.items())
    A = N.rotate("A", psi, N.z)
    B = A.rotate("B", theta, A.y)
    P = O.at("P", x * N.x + y * N.y + R * N.z)
    G = P.at("G", h * B.z)
    bodies = [kn.RigidBody("body", frame=B, mass_center=G, mass=70, inertia=kn.inertia(B, 8, 7, 2))]
    contacts: list[kn.Constraint] = []
    for name, angle, side in (("left", phi1, b), ("right", phi2, -b)):
        hub, W = P.at(name, side * A.y), A.rotate(name, angle, A.y)
        bodies.append(kn.RigidBody(name, frame=W, mass_center=hub, mass=3, inertia=kn.inertia(W, 0.03, 0.06, 0.03)))
        edge = kn.disk_on_plane(name, W, hub, O, axis=W.y, radius=R, normal=N.z, along=A.x)
        contacts += edge.rolling if redundant or not contacts else edge.rolling[:1]
    at = P.velocity(N)
    speeds = {v: at.dot(A.x), s: at.dot(A.y), turn: psi.dt, lean: theta.dt, w1: phi1.dt, w2: phi2.dt}
    return named(
        kn.System(N, bodies=bodies, speeds=speeds, loads=[kn.gravity(-g * N.z)], nonholonomic=contacts), dependent
    )


def vehicle(rng: np.random.Generator) -> kn.System:
    """A plate in the plane on one to three blades, wheels or castors at random places, its speeds along random frames."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, psi = kn.coordinates("x y psi")
    v1, v2, w = kn.speeds("v1 v2 w")
    A = N.rotate("A", psi, N.z)
    P = O.at("P", x * N.x + y * N.y)
    first, second = ((N, N), (A, A), (A, N))[int(rng.integers(3))]  # of the last W has a pole where A.x and N.y are one
    at = P.velocity(N)
    speeds = {v1: at.dot(first.x), v2: at.dot(second.y), w: psi.dt}
    G = P.at("G", float(rng.normal()) * A.x)
    bodies = [kn.RigidBody("plate", frame=A, mass_center=G, mass=3.0, inertia=kn.inertia(A, 0.2, 0.3, 0.4))]
    held: list[kn.Constraint] = []
    for k in range(int(rng.integers(1, 4))):
        hub = P.at(f"H{k}", float(rng.normal()) * A.x + float(rng.normal()) * A.y)
        S = A.rotate(f"S{k}", float(rng.uniform(0, np.pi)), A.z)
        kind = int(rng.integers(3))
        if kind == 2 or len(held) > 1:  # a castor, steered
            (steer,), (rate,) = kn.coordinates(f"steer{k}"), kn.speeds(f"s{k}")
            S = A.rotate(f"T{k}", steer, A.z)
            speeds[rate] = steer.dt
            bodies.append(
                kn.RigidBody(f"fork{k}", frame=S, mass_center=hub, mass=0.3, inertia=kn.inertia(S, 0.1, 0.1, 0.1))
            )
        if kind:  # a wheel
            (spin,), (rate,) = kn.coordinates(f"spin{k}"), kn.speeds(f"u{k}")
            speeds[rate] = spin.dt
            W = S.rotate(f"W{k}", spin, S.y)
            bodies.append(
                kn.RigidBody(f"wheel{k}", frame=W, mass_center=hub, mass=0.5, inertia=kn.inertia(W, 0.02, 0.04, 0.02))
            )
            held.append(kn.motion_constraint(f"rolling {k}", hub.velocity(N).dot(S.x) - 0.2 * spin.dt))
        if kind == 0 or rng.integers(2):
            held.append(kn.motion_constraint(f"across {k}", hub.velocity(N).dot(S.y)))
    return kn.System(N, bodies=bodies, speeds=speeds, nonholonomic=held, loads=[kn.Force(G, 2 * A.x + N.y)])
