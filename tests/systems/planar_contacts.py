# SPDX-License-Identifier: BSD-3-Clause
"""Plane bodies on an incline with corners, spheres and stops, drawn at random; `tests.oracles.planar_contacts` has their laws."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

import kane as kn
from tests.oracles.planar_contacts import G, Plane, Plate, Touch


def tenths(low: int, high: int) -> st.SearchStrategy[float]:
    return st.integers(low, high).map(lambda k: k / 10)


@st.composite
def planes(draw: Any) -> Plane:
    """One or two bodies, free or pinned, each with one or two corners or a sphere, and perhaps a stop."""
    kind = draw(st.sampled_from(["one", "pinned", "two"]))
    plates, touches = [], []
    for i in range(1 if kind == "one" else 2):
        pin = None
        if kind == "pinned" and i == 1:
            ends = st.tuples(tenths(-5, 5), tenths(-5, 5))
            pin = (draw(ends), draw(ends.filter(lambda r: r != (0, 0))))
        plates.append(Plate(draw(tenths(3, 30)), draw(tenths(1, 10)), pin))
        mu = draw(tenths(0, 7))
        law = {"kinetic": mu, "static": mu + draw(tenths(0, 3)), "restitution": draw(tenths(0, 9))}
        shape = draw(st.sampled_from(["corner", "corners", "sphere"] if i == 0 else ["corner", "sphere", "none"]))
        if shape == "sphere":
            touches.append(Touch(i, (draw(tenths(-2, 2)), draw(tenths(-2, 2))), draw(tenths(3, 6)), **law))
        for sign in {"corner": (1,), "corners": (1, -1)}.get(shape, ()):
            touches.append(Touch(i, (sign * draw(tenths(1, 6)), draw(tenths(-6, -1))), **law))
    stops = draw(st.sampled_from(["", "x", "a"] if kind == "pinned" else ["", "x"]))
    if stops:
        touches.append(Touch(0, (draw(tenths(2, 9)), 0.0), stops=stops, restitution=draw(tenths(0, 9))))
    return Plane(draw(tenths(-5, 5)), tuple(plates), tuple(touches))


def system(plane: Plane, law: str = "stronge") -> kn.System:
    """The same in `kane`; coordinates in the order of the oracle, friction positive along the incline."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    I = N.rotate("I", plane.slope, N.z)
    q = list(kn.coordinates(f"q1:{plane.width + 1}"))
    bodies, angles = [], []
    frames: list[kn.Frame] = []
    centers: list[kn.Point] = []
    k = 0
    for i, plate in enumerate(plane.plates):
        angle = q[k + 2] if plate.pin is None else q[k]
        base = I if plate.pin is None else frames[0]
        B = base.rotate(f"B{i}", angle, base.z)
        if plate.pin is None:
            C = O.at(f"C{i}", q[k] * I.x + q[k + 1] * I.y)
        else:
            (a, b), (c, d) = plate.pin
            C = centers[0].at(f"H{i}", a * base.x + b * base.y).at(f"C{i}", -c * B.x - d * B.y)
        k += 3 if plate.pin is None else 1
        inertia = kn.inertia(B, 1, 1, plate.inertia)
        bodies.append(kn.RigidBody(f"b{i}", frame=B, mass_center=C, mass=plate.mass, inertia=inertia))
        frames.append(B)
        centers.append(C)
        angles.append(angle)
    contacts = []
    for i, t in enumerate(plane.touches):
        name, law_of = f"c{i}", {"restitution": t.restitution, "law": law}
        if t.stops:
            contacts.append(kn.joints.stop(name, t.place[0] - (q[0] if t.stops == "x" else angles[1]), **law_of))
            continue
        B, C = frames[t.body], centers[t.body]
        offset = t.place[0] * B.x + t.place[1] * B.y
        place = (
            kn.joints.sphere_on_plane(name, B, C.at(f"S{i}", offset), O, radius=t.radius, normal=I.y, along=I.x)
            if t.radius
            else kn.joints.point_on_plane(name, C.fixed_in(B, f"P{i}", offset), O, normal=I.y, along=I.x)
        )
        contacts.append(kn.contact(place, t.kinetic, static=t.static, **law_of))
    loads = [kn.gravity(-G * N.y)]
    return kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=contacts)
