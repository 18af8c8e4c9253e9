# SPDX-License-Identifier: BSD-3-Clause
"""A slider-crank whose slider has play in its guide: it knocks from side to side and turns, with four corners that may touch.

Of the closed loop the guide's clearance c leaves three degrees of freedom; from the third impact or so on the motion is chaotic.
"""

import kane as kn

TITLE = "slider-crank with a clearance"
SOURCES = (
    "Flores, P., Leine, R., Glocker, C. (2010), Modeling and analysis of planar rigid multibody systems with translational clearance "
    "joints based on the non-smooth dynamics approach, Multibody System Dynamics 23, 165-190; numbers as in siconos-tutorials, "
    "examples/mechanics/SliderCrank.",
)
START = {
    "q": {"theta_1": 0.0, "theta_2": 0.0, "theta_3": 0.0},
    "u": {"u_theta_1": 150.0, "u_theta_2": -75.0, "u_theta_3": -0.01},
}


def system() -> kn.System:
    """Crank, rod and slider by their angles; the slider hangs on the rod's end by its middle."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    angles = kn.coordinates("theta_1:4", "rad", "angle of crank, rod or slider")
    l_1 = kn.parameter("l_1", 0.153, "m", "length of the crank")
    l_2 = kn.parameter("l_2", 0.306, "m", "length of the rod")
    a = kn.parameter("a", 0.05, "m", "half the length of the slider")
    b = kn.parameter("b", 0.025, "m", "half the width of the slider")
    c = kn.parameter("c", 0.001, "m", "clearance on either side")
    m = [kn.parameter(f"m_{k}", x, "kg", "mass") for k, x in enumerate((0.038, 0.038, 0.076), 1)]
    J = [kn.parameter(f"J_{k}", x, "kg*m^2", "moment of inertia") for k, x in enumerate((7.4e-5, 5.9e-4, 2.7e-6), 1)]
    mu = kn.parameter("mu", 0.01, "1", "coefficient of friction")
    e = kn.parameter("e", 0.4, "1", "restitution")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A, B, C = frames = [N.rotate(name, angle, N.z) for name, angle in zip("ABC", angles, strict=True)]
    P = O.at("P", l_1 * A.x)
    Q = P.at("Q", l_2 * B.x)
    centers = [O.at("A*", l_1 / 2 * A.x), P.at("B*", l_2 / 2 * B.x), Q]
    names = ("crank", "rod", "slider")
    bodies = [
        kn.RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=kn.inertia(frame, I, I, I))
        for name, frame, center, mass, I in zip(names, frames, centers, m, J, strict=True)
    ]
    places: list[kn.joints.Contact] = []
    for name, side in (("top", 1), ("bottom", -1)):
        corners = [
            Q.fixed_in(C, f"{name} {end}", s * a * C.x + side * b * C.y) for end, s in (("rear", -1), ("front", 1))
        ]
        wall = O.at(name, side * (b + c) * N.y)
        places += kn.joints.corners_on_plane(name, corners, wall, normal=-side * N.y)
    return kn.System(
        N,
        bodies=bodies,
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        contacts=[kn.contact(place, mu, restitution=e, law="moreau") for place in places],
        coordinates=angles,
    )
