# SPDX-License-Identifier: BSD-3-Clause
"""A disk that slides and rolls on a horizontal plane with sliding friction: the article's worked example.

Five coordinates, five speeds, and the normal force brought into evidence, since sliding friction needs it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import kane as kn

TITLE = "disk that slides on a plane with friction"
SOURCES = (
    "Yoo, H. H. (2004), tutorial on Kane's method, spring conference on noise and vibration, Gyeongju; eqs. (11) to (32). "
    "Misprinted there: csc q2 and sec q2 in (11), (13), (14), which must be cos q2 and sin q2; brackets in (21); a^C for a^C* "
    "in (24); the hat on the friction point's velocity in (26) and (29).",
)


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """The disk's frames, points, symbols and system."""

    system: kn.System
    N: kn.Frame
    Y: kn.Frame
    B: kn.Frame
    C: kn.Frame
    O: kn.Point
    P: kn.Point
    Cs: kn.Point
    Ch: kn.Point
    normal: kn.expr.Reaction
    slip: kn.Vector
    disk: kn.RigidBody
    rolling: tuple[kn.Constraint, ...]
    q: tuple[kn.expr.Coordinate, ...]
    u: tuple[kn.expr.Speed, ...]
    m: kn.expr.Parameter
    R: kn.expr.Parameter
    g: kn.expr.Parameter
    mu: kn.expr.Parameter


Inertia = Callable[[kn.Frame, kn.Expr, kn.Expr], kn.Dyadic]


def model(
    inertia: Inertia | None = None,
    *,
    speeds: Literal["components", "rates"] = "components",
    contact: Literal["sliding", "rolling"] = "sliding",
) -> Model:
    """The disk; `inertia(C, m, R)` gives another central inertia, which must be that of a body of revolution about C.z.

    The speeds u1, u2, u3 are the components of the angular velocity along B's axes, or, with "rates", u = q̇ throughout. With
    `contact="rolling"` two motion constraints take the place of friction, and their forces are brought into evidence.
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1 = kn.coordinate("q1", "rad", "yaw")
    q2 = kn.coordinate("q2", "rad", "lean")
    q3 = kn.coordinate("q3", "rad", "spin")
    q4 = kn.coordinate("q4", "m", "contact, along x")
    q5 = kn.coordinate("q5", "m", "contact, along y")
    u1, u2, u3 = kn.speeds("u1:4", "rad/s")
    u4, u5 = kn.speeds("u4:6", "m/s")
    m = kn.parameter("m", 1.2, "kg", "mass of the disk")
    R = kn.parameter("R", 0.3, "m", "radius")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
    mu = kn.parameter("mu_k", 0.25, "1", "coefficient of sliding friction")

    Y = N.rotate("Y", q1, N.z)
    B = Y.rotate("B", kn.pi / 2 - q2, Y.x)
    C = B.rotate("C", q3, B.z)
    P = O.at("P", q4 * N.x + q5 * N.y)
    Cs = P.at("C*", R * B.y)
    Ch = Cs.fixed_in(C, "C^", -R * B.y)
    dyadic = kn.solids.thin_disk(C, m, R, axis=C.z) if inertia is None else inertia(C, m, R)
    disk = kn.RigidBody("disk", frame=C, mass_center=Cs, mass=m, inertia=dyadic)

    w = C.angular_velocity(N)
    definitions = {u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z), u4: q4.dt, u5: q5.dt}
    if speeds == "rates":
        definitions = {u1: q1.dt, u2: q2.dt, u3: q3.dt, u4: q4.dt, u5: q5.dt}
    normal = kn.reaction("N_z", at=P, along=N.z)
    slip = Ch.velocity(N).reject(N.z)
    rolling = kn.rolling(Ch, normal=N.z) if contact == "rolling" else ()
    friction = [] if rolling else [kn.friction(Ch, normal, mu, name="friction")]
    held = [kn.reaction(name, constraint=c) for name, c in zip(("F_x", "F_y"), rolling, strict=False)]
    q, u = (q1, q2, q3, q4, q5), (u1, u2, u3, u4, u5)
    system = kn.System(
        N,
        bodies=[disk],
        reactions=[normal, *held],
        speeds=definitions,
        loads=[kn.gravity(-g * N.z), *friction],
        nonholonomic=rolling,
        dependent_speeds=(u4, u5) if rolling else (),
        coordinates=q,
    )
    return Model(system, N, Y, B, C, O, P, Cs, Ch, normal, slip, disk, rolling, q, u, m, R, g, mu)


def system() -> kn.System:
    """The sliding disk."""
    return model().system
