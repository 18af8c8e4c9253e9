# SPDX-License-Identifier: BSD-3-Clause
"""A planar arm of two flexible links with a mass at its tip."""

from typing import Any

import kane as kn

TITLE = "two-link flexible arm with a tip mass"
SOURCES = (
    "De Luca, A. and Siciliano, B. (1991), Closed-form dynamic model of planar multilink lightweight robots, IEEE Trans. Systems, "
    "Man, and Cybernetics 21(4), 826-839.",
)
START = {
    "q": {"q_1": 0.3, "q_2": -0.5, "v1_upper": 0.0, "v2_upper": 0.0, "v1_lower": 0.0, "v2_lower": 0.0},
    "u": {"u_1": 1.0, "u_2": -2.0, "u_v1_upper": 0.0, "u_v2_upper": 0.0, "u_v1_lower": 0.0, "u_v2_lower": 0.0},
}


def system(*, modes: int = 2, form: str = "linearized") -> kn.System:
    """The links are clamped to motors at the shoulder and at the elbow, which stands on the tip of the first."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    T1 = kn.parameter("T1", 0.0, "N*m", "torque at the shoulder")
    T2 = kn.parameter("T2", 0.0, "N*m", "torque at the elbow")
    mh = kn.parameter("m_h", 1.0, "kg", "mass of the elbow's motor")
    mp = kn.parameter("m_p", 0.1, "kg", "mass at the tip")
    length = kn.parameter("L", 0.5, "m", "length of each link")
    share = kn.parameter("rhoA", 1.0, "kg/m", "mass per length")
    stiff = kn.parameter("EI", 10.0, "N*m^2", "bending stiffness")
    shoulder = kn.pin("1", O, N, axis=N.z)
    A = shoulder.frame

    def link(name: str, joint: kn.joints.Joint) -> kn.Beam:
        frame = joint.frame
        return kn.Beam(
            name,
            joint.point,
            frame=frame,
            axis=frame.x,
            length=length,
            mass_per_length=share,
            EI=stiff,
            modes=modes,
            form=form,
        )

    upper = link("upper", shoulder)
    E = upper.frame_at(1)
    elbow = kn.pin("2", upper.point_at(1), E, axis=E.z)
    lower = link("lower", elbow)
    bodies: list[Any] = [
        upper,
        kn.Particle("motor", upper.point_at(1), mh),
        lower,
        kn.Particle("load", lower.point_at(1), mp),
    ]
    loads = [kn.Torque(A, T1 * N.z, name="shoulder"), kn.loads.torque_pair(elbow.frame, E, T2 * N.z, name="elbow")]
    return kn.System(N, bodies=bodies, joints=[shoulder, elbow], loads=loads)
