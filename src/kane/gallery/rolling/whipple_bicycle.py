# SPDX-License-Identifier: BSD-3-Clause
"""The Whipple bicycle: two knife-edge wheels, a rear frame with its rider, and a front fork, on a level road; z points down.

Both wheels roll without slip and the front wheel stays on the road: four motion constraints and one configuration constraint
among eight coordinates leave three degrees of freedom: lean, steer and the turning of the rear wheel. The rear wheel is on the
road by its coordinates; the front wheel's lowest point is F^. The front wheel's two motion constraints are taken along H.x and H.y,
which shortens the equations; neither is level, so that the road's force on it is that of all three of its constraints together.
"""

import math

import kane as kn
from kane.gallery import choose

TITLE = "Whipple bicycle"
SOURCES = (
    "Meijaard, J. P., Papadopoulos, J. M., Ruina, A., Schwab, A. L. (2007), Linearized dynamics equations for the balance and steer "
    "of a bicycle: a benchmark and review, Proc. R. Soc. A 463, 1955-1982; parameters of table 1.",
)


COORDINATES = (
    ("x", "m", "rear contact, along x"),
    ("y", "m", "rear contact, along y"),
    ("psi", "rad", "yaw"),
    ("phi", "rad", "lean, to the right"),
    ("theta", "rad", "pitch of the rear frame"),
    ("delta", "rad", "steer, to the right"),
    ("theta_R", "rad", "angle of the rear wheel"),
    ("theta_F", "rad", "angle of the front wheel"),
)
START = {
    "q": {name: 0.0 for name, *_ in COORDINATES} | {"theta": kn.guess(0.0)},
    "u": {"u1": 0.5, "u4": 0.0, "u5": -4.6 / 0.3},
    "inputs": {"T_phi": 0.0, "T_delta": 0.0},
}
Frames = tuple[kn.Frame, ...]
"""N ground, Y yawed, L leaning, B rear frame, S z along the steering axis, H fork, E axes of its inertia, R and F wheels."""


def system(speeds: str = "rates") -> kn.System:
    """The bicycle.

    Fork and front wheel turn at the rates of their angles ("rates"), or at angular velocities in the ground's frame ("spins"),
    as the rear wheel does either way: with these the equations take a twentieth fewer operations.
    """
    q = x, y, _, _, theta, delta, _, theta_F = tuple(kn.coordinate(*c) for c in COORDINATES)
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
    tilt = kn.parameter("lambda", math.pi / 10, "rad", "tilt of the steering axis")
    every = N, Y, L, B, S, H, _, R, F = frames(q, tilt)
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x + y * N.y)
    four, (r_R, r_F) = bodies(every, P, tilt)
    R_hat = four[0].mass_center.fixed_in(R, "R^", r_R * L.z)
    lean = N.z.dot(H.y)
    F_hat = four[3].mass_center.fixed_in(F, "F^", r_F * (N.z - lean * H.y) / kn.sqrt(1 - lean**2))
    rear = kn.no_slip(R_hat, along=(Y.x, Y.y), name="rear wheel")
    front = kn.no_slip(F_hat, along=(H.x, H.y), name="front wheel")
    height = kn.touching(F_hat, O, normal=N.z, name="front wheel on the road")
    T_phi = kn.input("T_phi", "N*m", "lean torque on the rear frame")
    T_delta = kn.input("T_delta", "N*m", "steer torque between rear frame and fork")
    return kn.System(
        N,
        bodies=four,
        speeds=choose(definitions(every, delta, theta_F, P), speeds),
        loads=[
            kn.gravity(g * N.z),
            kn.Torque(B, T_phi * L.x, name="lean torque"),
            kn.loads.torque_pair(H, B, T_delta * S.z, name="steer torque"),
        ],
        holonomic=[height],
        nonholonomic=[*rear, *front],
        coordinates=q,
        dependent_coordinates=(theta,),
    )


def frames(q: tuple[kn.expr.Coordinate, ...], tilt: kn.Expr) -> Frames:
    """The frames by the eight coordinates."""
    _, _, psi, phi, theta, delta, theta_R, theta_F = q
    N = kn.Frame("N")
    Y = N.rotate("Y", psi, N.z)
    L = Y.rotate("L", phi, Y.x)
    B = L.rotate("B", theta, L.y)
    S = B.rotate("S", tilt, B.y)
    H = S.rotate("H", delta, S.z)
    E = H.rotate("E", -tilt, H.y)
    return N, Y, L, B, S, H, E, L.rotate("R", theta_R, L.y), H.rotate("F", theta_F, H.y)


def bodies(
    frames: Frames, P: kn.Point, tilt: kn.Expr
) -> tuple[tuple[kn.RigidBody, ...], tuple[kn.expr.Parameter, ...]]:
    """The four bodies – rear wheel, rear frame, fork, front wheel – above the rear contact P, and the wheels' radii."""
    w = kn.parameter("w", 1.02, "m", "wheel base")
    c = kn.parameter("c", 0.08, "m", "trail")
    r_R, r_F = (
        kn.parameter(f"r_{n}", v, "m", f"{s} wheel: radius") for n, v, s in (("R", 0.3, "rear"), ("F", 0.35, "front"))
    )
    m_R, I_R, J_R = _wheel("R", "rear", 2.0, 0.0603, 0.12)
    m_F, I_F, J_F = _wheel("F", "front", 3.0, 0.1405, 0.28)
    x_B, z_B, m_B, inertia_B = _frame("B", "rear frame and rider", 0.3, -0.9, 85.0, (9.2, 11.0, 2.8, 2.4))
    x_H, z_H, m_H, inertia_H = _frame("H", "fork and handlebar", 0.9, -0.7, 4.0, (0.05892, 0.06, 0.00708, -0.00756))

    def along(dx: kn.Expr, dz: kn.Expr) -> tuple[kn.Expr, kn.Expr]:
        """Measure numbers along S.x and S.z of dx B.x + dz B.z."""
        return kn.cos(tilt) * dx - kn.sin(tilt) * dz, kn.sin(tilt) * dx + kn.cos(tilt) * dz

    _, _, L, B, S, H, E, R, F = frames
    reach = along(w + c, r_R)[0]  # from the rear axle square to the steering axis
    front_x, front_z = along(w, r_R - r_F)
    fork_x, fork_z = along(x_H, z_H + r_R)
    Rs = P.at("R*", -r_R * L.z)
    Bs = Rs.at("B*", x_B * B.x + (z_B + r_R) * B.z)
    A = Rs.at("A", reach * S.x)
    Hs = A.at("H*", (fork_x - reach) * H.x + fork_z * H.z)
    Fs = A.at("F*", (front_x - reach) * H.x + front_z * H.z)
    return (
        kn.RigidBody("rear wheel", frame=R, mass_center=Rs, mass=m_R, inertia=kn.inertia(L, I_R, J_R, I_R)),
        kn.RigidBody("rear frame", frame=B, mass_center=Bs, mass=m_B, inertia=kn.inertia(B, *inertia_B)),
        kn.RigidBody("fork", frame=H, mass_center=Hs, mass=m_H, inertia=kn.inertia(E, *inertia_H)),
        kn.RigidBody("front wheel", frame=F, mass_center=Fs, mass=m_F, inertia=kn.inertia(H, I_F, J_F, I_F)),
    ), (r_R, r_F)


def definitions(
    frames: Frames, delta: kn.expr.Coordinate, theta_F: kn.expr.Coordinate, P: kn.Point
) -> dict[str, dict[kn.expr.Speed, kn.Expr]]:
    """The speeds u by name of the choice."""
    N, Y, L, B, S, H, _, R, F = frames
    u = (*kn.speeds("u1:7", "rad/s"), *kn.speeds("u7:9", "m/s"))
    spin, contact = B.angular_velocity(N), P.velocity(N)
    rates = {
        u[0]: spin.dot(L.x),
        u[1]: spin.dot(L.y),
        u[2]: spin.dot(L.z),
        u[3]: delta.dt,
        u[4]: R.angular_velocity(N).dot(L.y),
        u[5]: theta_F.dt,
        u[6]: contact.dot(Y.x),
        u[7]: contact.dot(Y.y),
    }
    spins = {u[3]: H.angular_velocity(N).dot(S.z), u[5]: F.angular_velocity(N).dot(H.y)}
    return {"rates": rates, "spins": rates | spins}


def _wheel(letter: str, words: str, mass: float, across: float, about: float) -> tuple[kn.expr.Parameter, ...]:
    return (
        kn.parameter(f"m_{letter}", mass, "kg", f"{words} wheel: mass"),
        kn.parameter(f"I_{letter}xx", across, "kg*m^2", f"{words} wheel: moment of inertia across its axle"),
        kn.parameter(f"I_{letter}yy", about, "kg*m^2", f"{words} wheel: moment of inertia about its axle"),
    )


def _frame(
    letter: str, words: str, x: float, z: float, mass: float, inertia: tuple[float, float, float, float]
) -> tuple[kn.expr.Parameter, kn.expr.Parameter, kn.expr.Parameter, tuple[kn.expr.Parameter | int, ...]]:
    """Place and mass, and the six numbers of the inertia: Ixx, Iyy, Izz, Ixy, Iyz, Izx."""
    xx, yy, zz, xz = (
        kn.parameter(f"I_{letter}{k}", value, "kg*m^2", f"{words}: {kind} of inertia")
        for k, value, kind in zip(("xx", "yy", "zz", "xz"), inertia, (*["moment"] * 3, "product"), strict=True)
    )
    return (
        kn.parameter(f"x_{letter}", x, "m", f"{words}: mass centre ahead of the rear contact"),
        kn.parameter(f"z_{letter}", z, "m", f"{words}: mass centre below the road"),
        kn.parameter(f"m_{letter}", mass, "kg", f"{words}: mass"),
        (xx, yy, zz, 0, 0, xz),
    )
