# SPDX-License-Identifier: BSD-3-Clause
"""Andrews' squeezing mechanism: seven bodies in a plane, driven by a constant torque, in three loops that meet at one pin.

Crank K1 turns about O with K2 at its end; K3 turns about B against a spring fixed at C; K5 with K4 at its end, and K7 with K6 at
its end, turn about A. The free ends of K2, K3, K4 and K6 are pinned together: six configuration constraints for seven angles.
"""

import kane as kn

TITLE = "Andrews' squeezing mechanism"
SOURCES = (
    "Lioen, W. M. and de Swart, J. J. B. (1998), Test Set for Initial Value Problem Solvers, CWI, continued by Mazzia, F. and "
    "Magherini, C. (2008), release 2.4, University of Bari: problem andrews, with parameters, start and the solution at 0.03 s.",
    "Hairer, E. and Wanner, G. (1996), Solving Ordinary Differential Equations II, 2nd ed., Springer, sec. VII.7.",
    "Schiehlen, W. (ed.) (1990), Multibody Systems Handbook, Springer.",
)
START = {
    "q": {
        "beta": -0.0617138900142764496358948458001,
        "theta": 0.0,
        "gamma": 0.455279819163070380255912382449,
        "phi": 0.222668390165885884674473185609,
        "delta": 0.487364979543842550225598953530,
        "Omega": -0.222668390165885884674473185609,
        "epsilon": 1.23054744454982119249735015568,
    },
    "u": {f"u_{x}": 0.0 for x in ("beta", "theta", "gamma", "phi", "delta", "Omega", "epsilon")},
}
SPAN = (0.0, 0.03)

_LENGTHS = {
    "d": (0.028, "K2: length"),
    "da": (0.0115, "K2: mass centre from the crank's end"),
    "e": (0.02, "K4: length"),
    "ea": (0.01421, "K4: mass centre from the common pin"),
    "rr": (0.007, "K1: length"),
    "ra": (0.00092, "K1: mass centre from O"),
    "ss": (0.035, "K3: length"),
    "sa": (0.01874, "K3: mass centre from B, along"),
    "sb": (0.01043, "K3: mass centre from B, across"),
    "sc": (0.018, "K3: spring from B, along"),
    "sd": (0.02, "K3: spring from B, across"),
    "ta": (0.02308, "K5: mass centre from A, along"),
    "tb": (0.00916, "K5: mass centre from A, across"),
    "u": (0.04, "K7: length"),
    "ua": (0.01228, "K7: mass centre from A, along"),
    "ub": (0.00449, "K7: mass centre from A, across"),
    "zf": (0.02, "K6: length"),
    "zt": (0.04, "K5: length"),
    "fa": (0.01421, "K6: mass centre from the common pin"),
    "xa": (-0.06934, "A, along x"),
    "ya": (-0.00227, "A, along y"),
    "xb": (-0.03635, "B, along x"),
    "yb": (0.03273, "B, along y"),
    "xc": (0.014, "C, along x"),
    "yc": (0.072, "C, along y"),
    "l0": (0.07785, "free length of the spring"),
}
_MASSES = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)
_INERTIAS = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)


def system() -> kn.System:
    """The mechanism in a horizontal plane; phi turns K4 in K5, theta K2 in K1 and Omega K6 in K7."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    angles = [kn.coordinate(name, "rad") for name in START["q"]]
    beta, theta, gamma, phi, delta, Omega, epsilon = angles
    r = {name: kn.parameter(name, value, "m", what) for name, (value, what) in _LENGTHS.items()}
    c0 = kn.parameter("c0", 4530.0, "N/m", "stiffness of the spring")
    mom = kn.parameter("mom", 0.033, "N*m", "torque on the crank")
    m = [kn.parameter(f"m{k}", value, "kg", f"K{k}: mass") for k, value in enumerate(_MASSES, 1)]
    i = [kn.parameter(f"i{k}", v, "kg*m^2", f"K{k}: central moment of inertia") for k, v in enumerate(_INERTIAS, 1)]

    A = O.at("A", r["xa"] * N.x + r["ya"] * N.y)
    B = O.at("B", r["xb"] * N.x + r["yb"] * N.y)
    C = O.at("C", r["xc"] * N.x + r["yc"] * N.y)
    K1, K3 = N.rotate("K1", beta, N.z), N.rotate("K3", gamma, N.z)
    K5, K7 = N.rotate("K5", delta, N.z), N.rotate("K7", epsilon, N.z)
    K2, K4, K6 = K1.rotate("K2", theta, N.z), K5.rotate("K4", phi, N.z), K7.rotate("K6", Omega, N.z)
    crank_end = O.at("end of K1", r["rr"] * K1.x)
    end_5, end_7 = A.at("end of K5", r["zt"] * K5.x), A.at("end of K7", -r["u"] * K7.y)
    centers = (
        O.at("K1*", r["ra"] * K1.x),
        crank_end.at("K2*", -r["da"] * K2.x),
        B.at("K3*", -r["sa"] * K3.y + r["sb"] * K3.x),
        end_5.at("K4*", (r["ea"] - r["e"]) * K4.y),
        A.at("K5*", r["ta"] * K5.x - r["tb"] * K5.y),
        end_7.at("K6*", (r["zf"] - r["fa"]) * K6.x),
        A.at("K7*", -r["ua"] * K7.y + r["ub"] * K7.x),
    )
    bodies = [
        kn.RigidBody(K.name, frame=K, mass_center=center, mass=mass, inertia=kn.inertia(K, moment, moment, moment))
        for K, center, mass, moment in zip((K1, K2, K3, K4, K5, K6, K7), centers, m, i, strict=True)
    ]
    pin = crank_end.at("pin of K2", -r["d"] * K2.x)
    others = (
        B.at("pin of K3", -r["ss"] * K3.y),
        end_5.at("pin of K4", -r["e"] * K4.y),
        end_7.at("pin of K6", r["zf"] * K6.x),
    )
    spring = B.at("D", r["sd"] * K3.x - r["sc"] * K3.y)
    return kn.System(
        N,
        bodies=bodies,
        speeds="rates",
        loads=[kn.Torque(K1, mom * N.z, name="drive"), kn.linear_spring(spring, C, c0, r["l0"], name="spring")],
        holonomic=[kn.coincident(pin, other, along=(N.x, N.y)) for other in others],
        coordinates=angles,
    )
