# SPDX-License-Identifier: BSD-3-Clause
"""A four-bar linkage in the plane: crank, coupler, rocker."""

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
G = 9.81
LENGTHS = (0.4, 1.0, 0.8)


class FourBar:
    """Crank, coupler, rocker in the plane N.x N.y; a fixed link of 1.1."""

    def __init__(self):
        self.q = kn.coordinates("q1:4")
        self.frames, self.bodies, point = [], [], O.at("pivot", 0)
        self.pivot = point
        for name, q, length in zip("ABC", self.q, LENGTHS, strict=True):
            frame = N.rotate(name, q, N.z)
            center = point.at(f"{name}*", length / 2 * frame.x)
            inertia = kn.inertia(frame, 0.01, 0.1, 0.1)
            self.bodies.append(kn.RigidBody(name, frame=frame, mass_center=center, mass=1, inertia=inertia))
            self.frames.append(frame)
            point = point.at(f"end {name}", length * frame.x)
        self.tip, self.anchor = point, O.at("anchor", 1.1 * N.x)
        self.close = kn.coincident(self.tip, self.anchor, along=(N.x, N.y), name="close")

    def system(self, **more):
        more = {"holonomic": self.close, "speeds": "rates", **more}
        return kn.System(N, bodies=self.bodies, loads=[kn.gravity(-G * N.y)], **more)

    def derive(self, **more):
        return kn.derive(self.system(**more))


BAR = FourBar()
EOM = BAR.derive()


def state(eom=EOM):
    q1, q2, q3 = BAR.q
    found = kn.assemble(eom, q={q1: 1.2, q2: kn.guess(-0.2), q3: kn.guess(-1.5)}, u={eom.speeds[0]: 3.0})
    return {"q": found.q, "u": found.u}
