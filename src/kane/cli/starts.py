# SPDX-License-Identifier: BSD-3-Clause
"""Where the systems of the gallery start when nobody says otherwise: regular states from which they move."""

from __future__ import annotations

from collections.abc import Mapping

STARTS: dict[str, Mapping[str, Mapping[str, float]]] = {
    "particle_on_spring": {"q": {"x": 0.6, "y": 0.2, "z": -0.9}, "u": {"u_x": 0.0, "u_y": 1.0, "u_z": 0.0}},
    "pendulum": {"q": {"theta": 1.0}, "u": {"u_theta": 0.0}},
    "double_pendulum": {"q": {"q1": 1.0, "q2": 2.0}, "u": {"u1": 0.0, "u2": 0.0}},
    "pendulums": {"q": {"q1": 0.5, "q2": 1.0, "q3": 1.5}, "u": {"u1": 0.0, "u2": 0.0, "u3": 0.0}},
    "pendulum_on_cart": {"q": {"x": 0.0, "theta": 1.0}, "u": {"u_x": 0.0, "u_theta": 0.0}},
    "spherical_pendulum": {"q": {"phi": 0.0, "theta": 1.0}, "u": {"u_phi": 2.0, "u_theta": 0.0}},
    "spinning_top": {"q": {"psi": 0.0, "theta": 0.5, "phi": 0.0}, "u": {"u_psi": 0.0, "u_theta": 0.0, "u_phi": 150.0}},
    "free_body": {
        "q": {"e0": 1.0, "e1": 0.0, "e2": 0.0, "e3": 0.0, "x": 0.0, "y": 0.0, "z": 0.0},
        "u": {"w1_e0": 0.01, "w2_e0": 5.0, "w3_e0": 0.02, "u_x": 0.1, "u_y": 0.0, "u_z": 0.0},
    },
    "gimbal_gyroscope": {"q": {"q1": 0.0, "q2": 0.3, "q3": 0.0}, "u": {"u1": 0.0, "u2": 0.0, "u3": 200.0}},
    "rolling_disk": {
        "q": {"q1": 0.0, "q2": 0.1, "q3": 0.0, "q4": 0.0, "q5": 0.0},
        "u": {"u1": 0.0, "u2": 2.0, "u3": 25.0, "u4": 2.0, "u5": 0.0},
    },
}
"""START of each system by name, with the speeds it has by default."""
