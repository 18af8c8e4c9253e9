# SPDX-License-Identifier: BSD-3-Clause
"""A four-bar linkage whose coupler bends."""

from typing import Any

import kane as kn

TITLE = "four-bar linkage with a flexible coupler"
SOURCES = (
    "Turcic, D. A. and Midha, A. (1984), Dynamic analysis of elastic mechanism systems, J. Dynamic Systems, Measurement, and "
    "Control 106(4), 243-260.",
)
START = {
    "q": {"q_crank": 1.0, "q_coupler": kn.guess(-0.6), "q_rocker": kn.guess(1.5), "v1_link": 0.0, "v2_link": 0.0},
    "u": {"u_crank": 8.0, "u_v1_link": 0.0, "u_v2_link": 0.0},
}


def system(*, modes: int = 2, form: str = "linearized") -> kn.System:
    """Crank and rocker are rigid; the coupler's frame follows its two pins."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    a = kn.parameter("a", 0.1, "m", "length of the crank")
    b = kn.parameter("b", 0.28, "m", "length of the coupler")
    c = kn.parameter("c", 0.27, "m", "length of the rocker")
    d = kn.parameter("d", 0.25, "m", "length of the base")
    m1 = kn.parameter("m1", 0.3, "kg", "mass of the crank")
    m3 = kn.parameter("m3", 0.2, "kg", "mass of the rocker")
    crank = kn.pin("crank", O, N, axis=N.z)
    A = crank.frame
    joint = kn.pin("coupler", crank.point.at("A", a * A.x), A, axis=A.z)
    B = joint.frame
    link = kn.Beam(
        "link", joint.point, frame=B, axis=B.x, length=b, mass_per_length=kn.parameter("rhoA", 0.22, "kg/m", "mass per length"),
        EI=kn.parameter("EI", 2.5, "N*m^2", "bending stiffness"), modes=modes, support="pinned", form=form,
    )  # fmt: skip
    rocker = kn.pin("rocker", O.at("G", d * N.x), N, axis=N.z)
    C = rocker.frame
    end = rocker.point.at("B", c * C.x)
    bodies: list[Any] = [
        kn.RigidBody(
            "crank",
            frame=A,
            mass_center=crank.point.at("A*", a / 2 * A.x),
            mass=m1,
            inertia=kn.solids.rod(A, m1, a, A.x),
        ),
        link,
        kn.RigidBody(
            "rocker",
            frame=C,
            mass_center=rocker.point.at("C*", c / 2 * C.x),
            mass=m3,
            inertia=kn.solids.rod(C, m3, c, C.x),
        ),
    ]
    closing = kn.coincident(link.point_at(1), end, along=(N.x, N.y), name="B")
    return kn.System(
        N,
        bodies=bodies,
        joints=[crank, joint, rocker],
        holonomic=closing,
        dependent_coordinates=("q_coupler", "q_rocker"),
        dependent_speeds=("u_coupler", "u_rocker"),
    )
