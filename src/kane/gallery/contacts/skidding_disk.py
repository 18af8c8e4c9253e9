# SPDX-License-Identifier: BSD-3-Clause
"""The disk of the worked example on a plane with friction: it slides, rolls once its slip has died out, and may slip again.

The coordinates keep it on the plane, so that its normal force is brought into evidence and given.
"""

import kane as kn
from kane.gallery.rolling.rolling_disk import model

TITLE = "disk that slides, then rolls"
SOURCES = (
    "Yoo, H. H. (2004), tutorial on Kane's method, spring conference on noise and vibration, Gyeongju.",
    "Neimark, J. I., Fufaev, N. A. (1972), Dynamics of Nonholonomic Systems, AMS.",
)
START = {
    "q": {"q1": 0.0, "q2": 0.1, "q3": 0.0, "q4": 0.0, "q5": 0.0},
    "u": {"u1": 0.0, "u2": 2.0, "u3": 25.0, "u4": 2.0, "u5": 0.0},
}


def system() -> kn.System:
    """The sliding disk with a contact in the place of its friction."""
    disk = model()
    place = kn.joints.point_on_plane("ground", disk.Ch, disk.O, normal=disk.N.z)
    return kn.System(
        disk.N,
        bodies=[disk.disk],
        speeds=dict(disk.system.speeds),
        loads=[kn.gravity(-disk.g * disk.N.z)],
        contacts=[kn.contact(place, disk.mu, normal=disk.normal)],
        coordinates=disk.q,
    )
