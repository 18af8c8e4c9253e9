# SPDX-License-Identifier: BSD-3-Clause
"""The disk of the worked example, rolling without slip: two motion constraints leave three degrees of freedom.

Normal force and friction are the forces that hold the contact; all three are brought into evidence. A thin uniform disk that
rolls upright with v² > g R/3 is stable.
"""

import kane as kn
from kane.gallery.rolling.rolling_disk import model

TITLE = "disk that rolls without slip"
SOURCES = (
    "Yoo, H. H. (2004), tutorial on Kane's method, spring conference on noise and vibration, Gyeongju.",
    "Neimark, J. I., Fufaev, N. A. (1972), Dynamics of Nonholonomic Systems, AMS.",
)
START = {"q": {"q1": 0.0, "q2": 0.1, "q3": 0.0, "q4": 0.0, "q5": 0.0}, "u": {"u1": 0.0, "u2": 0.5, "u3": 6.0}}


def system() -> kn.System:
    """The rolling disk."""
    return model(contact="rolling").system
