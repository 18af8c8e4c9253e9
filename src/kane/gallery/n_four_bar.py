# SPDX-License-Identifier: BSD-3-Clause
"""N four-bar linkages side by side: N + 1 links that stand on the ground, and N couplers from top to top.

All links are equally long, so that the mechanism is a row of parallelograms. Where they lie along the ground, the constraints lose
rank by N and the linkages could go on as parallelograms or crossed; the motion is that of the parallelograms.
"""

import kane as kn
from kane.errors import ModelError

TITLE = "N four-bar linkages"
SOURCES = (
    "IFToMM Technical Committee for Multibody Dynamics, Library of Computational Benchmark Problems, and González, M., Dopico, D., "
    "Lugrís, U. and Cuadrado, J. (2006), A benchmarking system for MBS simulation software, Multibody System Dynamics 16, 179-190: "
    "problem A02, links of 1 m and 1 kg, gravity 9.81 N/kg, the first top starting at 1 m/s, upright (the library has 40 windows).",
    "Bayo, E. and Avello, A. (1994), Singularity-free augmented Lagrangian algorithms for constrained multibody dynamics, Nonlinear "
    "Dynamics 5, 209-231 (two windows).",
)
START = {
    "q": {"q0": 0.0, "q1": 0.0, "q2": 0.0, "p1": 0.0, "p2": 0.0},
    "u": {"u_q0": -1.0, "u_q1": -1.0, "u_q2": -1.0, "u_p1": 0.0, "u_p2": 0.0},
}


def system(n: int = 2) -> kn.System:
    """`n` windows: q0 to qn turn the links from upright, p1 to pn the couplers from level.

    Each coupler hangs on the top of the link before it, and is held to the next top by two configuration constraints.
    """
    if n < 1:
        raise ModelError(f"Expected at least one window, got {n}.")
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    m = kn.parameter("m", 1.0, "kg", "mass of each link")
    l = kn.parameter("l", 1.0, "m", "length of each link")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    bodies: list[kn.RigidBody] = []
    tops: list[kn.Point] = []
    closing: list[kn.Constraint] = []
    q = [kn.coordinate(f"q{k}", "rad", f"angle of link {k} from upright") for k in range(n + 1)]
    p = [kn.coordinate(f"p{k}", "rad", f"angle of coupler {k} from level") for k in range(1, n + 1)]
    for k in range(n + 1):
        A = N.rotate(f"A{k}", q[k], N.z)
        foot = O.at(f"A_{k}", k * l * N.x)
        tops.append(foot.at(f"B_{k}", l * A.y))
        center = foot.at(f"A{k}*", l / 2 * A.y)
        bodies.append(
            kn.RigidBody(f"link {k}", frame=A, mass_center=center, mass=m, inertia=kn.solids.rod(A, m, l, A.y))
        )
    for k in range(1, n + 1):
        C = N.rotate(f"C{k}", p[k - 1], N.z)
        center, end = tops[k - 1].at(f"C{k}*", l / 2 * C.x), tops[k - 1].at(f"end {k}", l * C.x)
        bodies.append(
            kn.RigidBody(f"coupler {k}", frame=C, mass_center=center, mass=m, inertia=kn.solids.rod(C, m, l, C.x))
        )
        closing += kn.coincident(end, tops[k], along=(N.x, N.y), name=f"pin {k}")
    return kn.System(
        N,
        bodies=bodies,
        speeds={kn.speed(f"u_{x.name}", "rad/s"): x.dt for x in (*q, *p)},
        loads=[kn.gravity(-g * N.y)],
        holonomic=closing,
        coordinates=(*q, *p),
    )
