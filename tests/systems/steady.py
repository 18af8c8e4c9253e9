# SPDX-License-Identifier: BSD-3-Clause
"""Systems that are linearized and trimmed in the tests."""

import kane as kn


def rolling_disk() -> kn.Equations:
    """The thin uniform disk that rolls without slip: q1 yaw, q2 lean, q3 spin, q4, q5 the contact's trace."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2, q3, q4, q5 = kn.coordinates("q1:6")
    u1, u2, u3, u4, u5 = kn.speeds("u1:6")
    m, R, g = kn.parameter("m", 1.2), kn.parameter("R", 0.3), kn.parameter("g", 9.81)
    Y = N.rotate("Y", q1, N.z)
    B = Y.rotate("B", kn.pi / 2 - q2, Y.x)
    C = B.rotate("C", q3, B.z)
    P = O.at("P", q4 * N.x + q5 * N.y)
    Cs = P.at("C*", R * B.y)
    disk = kn.RigidBody("disk", frame=C, mass_center=Cs, mass=m, inertia=kn.thin_disk(C, m, R, axis=C.z))
    w = C.angular_velocity(N)
    roll = kn.rolling(Cs.fixed_in(C, "C^", -R * B.y), normal=N.z)
    normal = kn.reaction("N_z", at=P, along=N.z)
    side = kn.reaction("F_x", constraint=roll[0])
    speeds = {u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z), u4: q4.dt, u5: q5.dt}
    return kn.derive(
        kn.System(
            N, bodies=[disk], speeds=speeds, loads=[kn.gravity(-g * N.z)], nonholonomic=roll, reactions=[normal, side]
        )
    )


def four_bar() -> kn.Equations:
    """A four-bar linkage with a motor; the pin that closes it is a pair of configuration constraints."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinates("q1:4")
    m, g = kn.parameter("m", 1.0), kn.parameter("g", 9.81)
    tau = kn.input("tau")
    bodies, frames, at = [], [], O.at("O1", 0)
    for name, angle, length in zip("ABC", q, (0.4, 1.0, 0.8), strict=True):
        frame = N.rotate(name, angle, N.z)
        middle = at.at(f"{name}*", length / 2 * frame.x)
        bodies.append(
            kn.RigidBody(name, frame=frame, mass_center=middle, mass=m, inertia=kn.rod(frame, m, length, axis=frame.x))
        )
        frames.append(frame)
        at = at.at(f"P{name}", length * frame.x)
    close = kn.coincident(at, O.at("G", 1.1 * N.x), along=(N.x, N.y), name="pin")
    return kn.derive(
        kn.System(
            N,
            bodies=bodies,
            speeds="rates",
            loads=[kn.gravity(-g * N.y), kn.Torque(frames[0], tau * N.z)],
            holonomic=close,
            reactions=[kn.reaction("G_x", constraint=close[0]), kn.reaction("G_y", constraint=close[1])],
        )
    )


def double_pendulum() -> kn.Equations:
    """Two rods with a motor at each pin; the second speed is the sum of the rates."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2 = kn.coordinates("q1:3")
    u1, u2 = kn.speeds("u1:3")
    g, k = kn.parameter("g", 9.81), kn.parameter("k", 0.3)
    s1, s2 = kn.input("s1"), kn.input("s2")
    A = N.rotate("A", q1, N.z)
    B = A.rotate("B", q2, A.z)
    P = O.at("P", -1.0 * A.y)
    bodies = [
        kn.RigidBody("a", frame=A, mass_center=O.at("A*", -0.5 * A.y), mass=1.0, inertia=kn.rod(A, 1.0, 1.0, axis=A.y)),
        kn.RigidBody("b", frame=B, mass_center=P.at("B*", -0.4 * B.y), mass=0.7, inertia=kn.rod(B, 0.7, 0.8, axis=B.y)),
    ]
    loads = [
        kn.gravity(-g * N.y),
        kn.Torque(A, s1 * N.z),
        kn.torque_pair(B, A, (s2 - k * q2.dt * kn.cos(q1)) * N.z),
    ]
    return kn.derive(kn.System(N, bodies=bodies, speeds={u1: q1.dt, u2: q1.dt + q2.dt}, loads=loads))


def sleigh() -> kn.Equations:
    """The Chaplygin sleigh: a runner that does not slip sideways, the mass centre ahead of it."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, psi = kn.coordinate("x"), kn.coordinate("y"), kn.coordinate("psi")
    m, a = kn.parameter("m", 2.0), kn.parameter("a", 0.4)
    drag = kn.parameter("c", 0.2, "N*s/m")
    S = N.rotate("S", psi, N.z)
    P = O.at("P", x * N.x + y * N.y)
    G = P.at("G", a * S.x)
    v, w, side = kn.speed("v"), kn.speed("w"), kn.speed("s")
    velocity = P.velocity(N)
    push = kn.input("F", "N")
    return kn.derive(
        kn.System(
            N,
            bodies=[kn.RigidBody("sleigh", frame=S, mass_center=G, mass=m, inertia=kn.inertia(S, 0.2, 0.2, 0.3))],
            speeds={v: velocity.dot(S.x), w: psi.dt, side: velocity.dot(S.y)},
            loads=[kn.Force(P, (push - drag * velocity.dot(S.x)) * S.x)],
            nonholonomic=[kn.motion_constraint("runner", velocity.dot(S.y))],
            dependent_speeds=(side,),
        )
    )


def free_body(*, torsion: float = 0.0) -> kn.Equations:
    """A free body oriented by Euler parameters, its inertia 1, 2, 3; a spring pulls a point off its centre to the origin."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    e = kn.coordinates("e0:4")
    x, y, z = (kn.coordinate(n) for n in "xyz")
    B = N.rotate_euler_parameters("B", e)
    G = O.at("G", x * N.x + y * N.y + z * N.z)
    A = G.at("A", 0.5 * B.x + 0.2 * B.z)
    w = B.angular_velocity(N)
    speeds = dict(zip(kn.speeds("w1:4"), (w.dot(a) for a in (B.x, B.y, B.z)), strict=True))
    speeds |= dict(zip(kn.speeds("v1:4"), (c.dt for c in (x, y, z)), strict=True))
    torque = kn.input("T")
    loads = [kn.Torque(B, torque * B.x)]
    if torsion:
        loads += [kn.Force(A, -torsion * A.position(O)), kn.Force(G, -2 * torsion * G.position(O))]
    return kn.derive(
        kn.System(
            N,
            bodies=[kn.RigidBody("body", frame=B, mass_center=G, mass=1.5, inertia=kn.inertia(B, 1.0, 2.0, 3.0))],
            speeds=speeds,
            loads=loads,
        )
    )


def cart() -> kn.Equations:
    """A pendulum (a particle) on a cart that a force pushes; q1 the cart, q2 the angle from hanging."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2 = kn.coordinate("q1"), kn.coordinate("q2")
    M, m, l, g = (kn.parameter(n, v) for n, v in (("M", 2.0), ("m", 0.5), ("l", 0.7), ("g", 9.81)))
    F = kn.input("F", "N")
    A = N.rotate("A", q2, N.z)
    C = O.at("C", q1 * N.x)
    P = C.at("P", -l * A.y)
    bodies = [kn.Particle("cart", C, M), kn.Particle("bob", P, m)]
    rail = kn.reaction("R_y", at=C, along=N.y)
    loads = [kn.gravity(-g * N.y), kn.Force(C, F * N.x)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, reactions=[rail]))


def moved_guide() -> kn.Equations:
    """Two links whose end runs along a guide that an input moves: the input and its derivatives are in the constraint."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2 = kn.coordinates("q1:3")
    s = kn.input("s")
    A, B = N.rotate("A", q1, N.z), N.rotate("B", q2, N.z)
    P = O.at("P", 1.0 * A.x)
    Q = P.at("Q", 2.0 * B.x)
    guide = kn.coincident(Q, O.at("G", s * N.y), along=N.y, name="guide")
    bodies = [kn.Particle("p", P, 1.0), kn.Particle("q", Q, 0.5)]
    force = kn.reaction("G_y", constraint=guide[0])
    loads = [kn.gravity(-9.81 * N.y)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, holonomic=guide, reactions=[force]))


def driven_pendulum() -> kn.Equations:
    """m l² q̈ = τ − m g l sin q − b q̇ with m g l = 10."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    (q,) = kn.coordinates("q1:2", "rad")
    tau, b = kn.input("tau", "N*m"), kn.parameter("b", 0.5, "N*m*s/rad")
    A = N.rotate("A", q, N.z)
    P = O.at("P", -1.0 * A.y)
    loads = [kn.gravity(-10.0 * N.y), kn.Torque(A, (tau - b * q.dt) * N.z)]
    body = kn.RigidBody("b", frame=A, mass_center=P, mass=1.0, inertia=kn.inertia(A, 0, 0, 0.0))
    return kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=loads))
