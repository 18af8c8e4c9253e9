# SPDX-License-Identifier: BSD-3-Clause
"""The woodpecker toy: a bird on a spring at a sleeve that climbs down a pole, jammed in the meantime by its own friction.

The sleeve has an upper and a lower edge that may touch the pole, the bird its beak; angles are small, so that heights are linear in
them: M q̈ + K q = f with q = (y, φ_M, φ_S). It falls by 19.45 mm in 0.14598 s.
"""

import kane as kn

TITLE = "woodpecker toy"
SOURCES = (
    "Glocker, C., Studer, C. (2005), Formulation and preparation for numerical evaluation of linear complementarity systems in "
    "dynamics, Multibody System Dynamics 13, 447-463; numbers as in siconos-tutorials, examples/mechanics/Woodpecker.",
    "Leine, R. I., Glocker, C., van Campen, D. H. (2003), Nonlinear dynamics and modeling of various wooden toys with impact and "
    "friction, J. Vibration and Control 9, 25-78.",
)
START = {
    "q": {"y": 0.0, "phi_M": -(0.0031 - 0.0025) / 0.0058, "phi_S": -0.2788},
    "u": {"u_y": -0.3411, "u_phi_M": 0.0, "u_phi_S": -7.4583},
}


def system() -> kn.System:
    """Sleeve and bird by height and two angles; the normals point to the sleeve."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    y = kn.coordinate("y", "m", "height of the sleeve")
    phi_M = kn.coordinate("phi_M", "rad", "angle of the sleeve")
    phi_S = kn.coordinate("phi_S", "rad", "angle of the bird")
    r_O = kn.parameter("r_O", 0.0025, "m", "radius of the pole")
    r_M = kn.parameter("r_M", 0.0031, "m", "inner radius of the sleeve")
    h_M = kn.parameter("h_M", 0.0058, "m", "half the height of the sleeve")
    l_M = kn.parameter("l_M", 0.010, "m", "from the sleeve's middle to the spring")
    l_G = kn.parameter("l_G", 0.015, "m", "from the spring to the bird's mass centre")
    h_S = kn.parameter("h_S", 0.02, "m", "beak: height above the bird's mass centre")
    l_S = kn.parameter("l_S", 0.0201, "m", "beak: from the bird's mass centre towards the pole")
    m_M = kn.parameter("m_M", 0.0003, "kg", "sleeve: mass")
    m_S = kn.parameter("m_S", 0.0045, "kg", "bird: mass")
    J_M = kn.parameter("J_M", 5e-9, "kg*m^2", "sleeve: central moment of inertia")
    J_S = kn.parameter("J_S", 7e-7, "kg*m^2", "bird: central moment of inertia")
    c = kn.parameter("c", 0.0056, "N*m/rad", "stiffness of the spring")
    mu = kn.parameter("mu", 0.3, "1", "coefficient of friction")
    e = kn.parameter("e", 0.5, "1", "restitution of the beak")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    M, S = N.rotate("M", phi_M, N.z), N.rotate("S", phi_S, N.z)
    sleeve, bird = O.at("M*", y * N.y), O.at("S*", (y + l_M * phi_M + l_G * phi_S) * N.y)
    lean, room = h_M * phi_M, r_M - r_O
    at_beak = (l_M + l_G - l_S - r_O - h_S * phi_S, y + l_M * phi_M + (l_G - l_S) * phi_S)
    edge = y + r_M * phi_M
    places = {"beak": (at_beak, e), "lower": ((room + lean, edge), 0), "upper": ((room - lean, edge), 0)}
    return kn.System(
        N,
        bodies=[
            kn.RigidBody("sleeve", frame=M, mass_center=sleeve, mass=m_M, inertia=kn.inertia(M, J_M, J_M, J_M)),
            kn.RigidBody("bird", frame=S, mass_center=bird, mass=m_S, inertia=kn.inertia(S, J_S, J_S, J_S)),
        ],
        speeds="rates",
        loads=[kn.gravity(-g * N.y), kn.torque_pair(S, M, -c * (phi_S - phi_M) * N.z, name="spring")],
        contacts=[
            kn.contact(
                kn.joints.point_on_plane(name, O.at(name, a * N.x + b * N.y), O, normal=N.x),
                mu,
                restitution=restitution,
                law="moreau",
            )
            for name, ((a, b), restitution) in places.items()
        ],
        coordinates=(y, phi_M, phi_S),
    )


def shapes(system: kn.System) -> list[kn.figures.BodyShape]:
    """The pole, the sleeve around it, and the bird beside it on its spring."""
    sleeve, bird = system.rigid_bodies
    N, pole = system.inertial, sleeve.mass_center.root()
    r_O, r_M, h_M, l_M, l_G = (
        next(p for p in system.parameters if p.name == name) for name in ("r_O", "r_M", "h_M", "l_M", "l_G")
    )
    middle = bird.mass_center.at("middle of the bird", (l_M + l_G) * N.x)
    return [
        kn.figures.shape("box", frame=N, at=pole, a=2 * r_O, b=4 * (l_M + l_G), c=2 * r_O, name="pole"),
        kn.figures.shape("box", sleeve, a=2.6 * r_M, b=2 * h_M, c=2.6 * r_M),
        kn.figures.shape("link", bird, points=[sleeve.mass_center, middle], name="spring's arm"),
        kn.figures.shape("ellipsoid", bird, at=middle, a=0.4 * l_G, b=0.8 * l_G, c=0.4 * l_G),
    ]
