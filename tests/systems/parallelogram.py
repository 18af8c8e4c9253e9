# SPDX-License-Identifier: BSD-3-Clause
"""A parallelogram of three links: laid flat its constraints lose a row."""

import kane as kn
from tests.systems.four_bar import N, O


class Parallelogram:
    """Laid flat it may open either way."""

    q = kn.coordinates("q1:4")

    bodies: tuple[kn.RigidBody, ...] = ()
    point = O.at("pivot", 0)
    for name, q_, length in zip("ABC", q, (1.0, 2.0, 1.0), strict=True):
        frame = N.rotate(name, q_, N.z)
        center = point.at(f"{name}*", length / 2 * frame.x)
        inertia = kn.inertia(frame, 0.1, 0.1, 0.1)
        bodies = (*bodies, kn.RigidBody(name, frame=frame, mass_center=center, mass=1, inertia=inertia))
        point = point.at(f"end {name}", length * frame.x)

    def closed(self):
        return kn.coincident(self.point, O.at("anchor", 2 * N.x), along=(N.x, N.y), name="close")

    def derive(self, close=None, **more):
        close = self.closed() if close is None else close
        return kn.derive(kn.System(N, bodies=self.bodies, speeds="rates", holonomic=close, **more))
