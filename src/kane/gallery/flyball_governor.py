# SPDX-License-Identifier: BSD-3-Clause
"""Watt's flyball governor: a shaft that spins freely, two rods with balls hinged to its top, and a slider that they lift.

The slider hangs from the middles of the rods on two couplers: massless rods, which close two loops, or the stiff springs and
dampers that the benchmark puts in their place. Both start from the same position, with the springs unstretched.
"""

from math import pi
from typing import Literal

import kane as kn
from kane.errors import ModelError

TITLE = "flyball governor"
SOURCES = (
    "IFToMM Technical Committee for Multibody Dynamics, Library of Computational Benchmark Problems, and González, M., Dopico, D., "
    "Lugrís, U. and Cuadrado, J. (2006), A benchmarking system for MBS simulation software, Multibody System Dynamics 16, 179-190: "
    "problem A05, the stiff governor (couplers of 8e5 N/m and 4e4 N s/m). Prisms of 3000 kg/m^3: shaft and rods 1 × 0.01 × 0.01 m, "
    "slider 0.1 m; balls of 5 kg; hinges 0.05 m off the axis; start at 2π rad/s with rods 30° below level and the slider at 0.5 m.",
)
START = {
    "q": {"psi": 0.0, "alpha1": pi / 6, "alpha2": pi / 6, "s": 0.5},
    "u": {"u_psi": 2 * pi, "u_alpha1": 0.0, "u_alpha2": 0.0, "u_s": 0.0},
}


def system(*, couplers: Literal["rods", "springs"] = "rods") -> kn.System:
    """The governor on a vertical shaft; `couplers` are rigid massless "rods" or the benchmark's stiff "springs" with dampers."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    psi = kn.coordinate("psi", "rad", "angle of the shaft")
    alpha1 = kn.coordinate("alpha1", "rad", "angle of the first rod below level")
    alpha2 = kn.coordinate("alpha2", "rad", "angle of the second rod below level")
    s = kn.coordinate("s", "m", "height of the slider")
    m = kn.parameter("m", 0.3, "kg", "mass of the shaft, and of each rod")
    l = kn.parameter("l", 1.0, "m", "length of the shaft, and of each rod")
    w = kn.parameter("w", 0.01, "m", "width of their square section")
    M = kn.parameter("M", 3.0, "kg", "mass of the slider")
    a = kn.parameter("a", 0.1, "m", "edge of the slider; the hinges at the top are as far apart")
    B = kn.parameter("B", 5.0, "kg", "mass of each ball")
    L = kn.parameter("L", 0.5, "m", "length of the couplers, unstretched")
    K = kn.parameter("K", 8e5, "N/m", "stiffness of the couplers that are springs")
    C = kn.parameter("C", 4e4, "N*s/m", "damping of the couplers that are springs")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    S = N.rotate("S", psi, N.z)
    slide = O.at("S*", s * N.z)
    bodies: list[kn.RigidBody | kn.Particle] = [
        kn.RigidBody(
            "shaft", frame=S, mass_center=O.at("middle", l / 2 * N.z), mass=m, inertia=kn.solids.box(S, m, w, w, l)
        ),
        kn.RigidBody("slider", frame=S, mass_center=slide, mass=M, inertia=kn.solids.box(S, M, a, a, a)),
    ]
    pairs = []
    for k, alpha, side in ((1, alpha1, 1), (2, alpha2, -1)):
        R = S.rotate(f"R{k}", side * alpha, S.y)
        hinge = O.at(f"H{k}", l * N.z + side * a / 2 * S.x)
        middle, tip = hinge.at(f"R{k}*", side * l / 2 * R.x), hinge.at(f"ball {k}", side * l * R.x)
        bodies.append(
            kn.RigidBody(f"rod {k}", frame=R, mass_center=middle, mass=m, inertia=kn.solids.box(R, m, l, w, w))
        )
        bodies.append(kn.Particle(f"ball {k}", tip, B))
        pairs.append((middle, slide.at(f"E{k}", side * a / 2 * S.x)))
    loads: list[kn.loads.Load | kn.loads.Gravity] = [kn.gravity(-g * N.z)]
    rods: list[kn.Constraint] = []
    if couplers == "rods":
        rods = [kn.distance(p, q, L, name=f"coupler {k}") for k, (p, q) in enumerate(pairs, 1)]
    elif couplers == "springs":
        loads += [kn.linear_spring(p, q, K, L) for p, q in pairs] + [kn.linear_damper(p, q, C) for p, q in pairs]
    else:
        raise ModelError(f"Expected couplers to be 'rods' or 'springs', got {couplers!r}.")
    return kn.System(
        N, bodies=bodies, speeds="rates", loads=loads, holonomic=rods, coordinates=(psi, alpha1, alpha2, s)
    )
