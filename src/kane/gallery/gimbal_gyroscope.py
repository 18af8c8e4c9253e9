# SPDX-License-Identifier: BSD-3-Clause
"""A gyroscope in two gimbals with inertia: outer axis fixed and vertical, inner axis horizontal, rotor axis across it.

The rotor's mass centre may lie off the common centre of the axes along the rotor axis, so that gravity makes it precess. At
q2 = ±π/2 the outer and the rotor axis coincide (gimbal lock).
"""

import kane as kn
from kane.gallery import choose

TITLE = "gyroscope in gimbals"
SOURCES = (
    "Magnus, K. (1971), Kreisel: Theorie und Anwendungen, Springer.",
    "Wittenburg, J. (2008), Dynamics of Multibody Systems, 2nd ed., Springer.",
)
SPEEDS = ("rates", "spin", "inner")


def system(*, speeds: str = "rates") -> kn.System:
    """The gyroscope: q1 turns the outer gimbal, q2 the inner one, q3 the rotor.

    Speeds: the rates of the angles ("rates"), those of the gimbals with the rotor's total spin about its axis ("spin", never
    singular), or the rotor's angular velocity along the axes of the inner gimbal ("inner", singular at gimbal lock).
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1 = kn.coordinate("q1", "rad", "angle of the outer gimbal about the vertical")
    q2 = kn.coordinate("q2", "rad", "angle of the inner gimbal: elevation of the rotor axis")
    q3 = kn.coordinate("q3", "rad", "angle of the rotor")
    Az = kn.parameter("Az", 4.0e-4, "kg*m^2", "outer gimbal: moment of inertia about its axis")
    Bx = kn.parameter("Bx", 1.5e-4, "kg*m^2", "inner gimbal: moment of inertia about its axis")
    By = kn.parameter("By", 2.0e-4, "kg*m^2", "inner gimbal: moment of inertia about the rotor axis")
    Bz = kn.parameter("Bz", 2.5e-4, "kg*m^2", "inner gimbal: moment of inertia about the third axis")
    I = kn.parameter("I", 3.0e-4, "kg*m^2", "rotor: central moment of inertia across its axis")
    J = kn.parameter("J", 5.0e-4, "kg*m^2", "rotor: moment of inertia about its axis")
    m = kn.parameter("m", 0.6, "kg", "rotor: mass")
    l = kn.parameter("l", 0.01, "m", "rotor: distance of the mass centre from the centre, along the axis")
    c = kn.parameter("c", 1.0e-4, "N*m*s/rad", "damping of the gimbals' bearings")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A = N.rotate("A", q1, N.z)
    B = A.rotate("B", q2, A.x)
    C = B.rotate("C", q3, B.y)
    Cs = O.at("C*", l * B.y)
    # The gimbals are balanced: their mass centres stay at O, and their masses do not matter.
    outer = kn.RigidBody("outer gimbal", frame=A, mass_center=O, mass=0, inertia=kn.inertia(A, Az, Az, Az))
    inner = kn.RigidBody("inner gimbal", frame=B, mass_center=O, mass=0, inertia=kn.inertia(B, Bx, By, Bz))
    rotor = kn.RigidBody("rotor", frame=C, mass_center=Cs, mass=m, inertia=kn.inertia(C, I, J, I))

    w = C.angular_velocity(N)
    u1, u2, u3 = kn.speeds("u1:4", "rad/s")
    choices = {
        "spin": {u1: q1.dt, u2: q2.dt, u3: w.dot(B.y)},
        "inner": {u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z)},
    }
    return kn.System(
        N,
        bodies=[outer, inner, rotor],
        speeds=choose(choices, speeds),
        loads=[
            kn.gravity(-g * N.z),
            kn.torsional_damper(A, N, c, N.z, name="outer bearing"),
            kn.torsional_damper(B, A, c, A.x, name="inner bearing"),
        ],
        coordinates=(q1, q2, q3),
    )


def shapes(system: kn.System) -> list[kn.figures.BodyShape]:
    """Two rings and a disk on an axle, in proportion to the rotor's offset; no equation knows them."""
    outer, inner, rotor = system.rigid_bodies
    O, A, B, C = outer.mass_center, outer.frame, inner.frame, rotor.frame
    l = next(p for p in system.parameters if p.name == "l")
    axle = [O.at(f"end {k}", side * 6 * l * B.y) for k, side in enumerate((-1, 1))]
    return [
        kn.figures.shape("torus", outer, axis=A.y, radius=8 * l, tube=0.35 * l),
        kn.figures.shape("torus", inner, axis=B.z, radius=6 * l, tube=0.35 * l),
        kn.figures.shape("link", rotor, points=axle, name="axle"),
        kn.figures.shape("cylinder", rotor, axis=C.y, radius=4 * l, height=1.2 * l),
    ]
