# SPDX-License-Identifier: BSD-3-Clause
"""Plane bodies on an incline with corners, spheres and stops, drawn at random; `tests.oracles.planar_contacts` has their laws."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any, NamedTuple

from hypothesis import strategies as st

import kane as kn
from tests.oracles.planar_contacts import G, Plane, Plate, Support, Touch


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


BUILDS = (
    (("corner",), "", "", "stronge"),
    (("corners",), "", "shakes", "stronge"),
    (("sphere",), "x", "", "poisson"),
    (("sphere", "pinned", "corner"), "", "shakes", "poisson"),
    (("corners", "pinned", "sphere"), "a", "", "stronge"),
    (("corner", "pinned", "none"), "x", "", "stronge"),
    (("corner", "two", "sphere"), "", "shakes", "stronge"),
    (("corners", "two", "corner"), "x", "", "poisson"),
)
"""What the first body stands on, the second one's joint and what it stands on; a stop; whether the floor moves; the law of impacts."""


@st.composite
def alike(draw: Any, builds: Any = BUILDS) -> tuple[Plane, str]:
    """A plane of one of few builds, and its law of impacts: all of a build have the same equations."""
    (first, *second), stops, support, law = draw(st.sampled_from(builds))
    plates, touches = [], []
    for i, shape in enumerate([first, *second[1:]]):
        ends = st.tuples(tenths(-5, 5), tenths(-5, 5))
        pin = (draw(ends.filter(any)), draw(ends.filter(any))) if i and second[0] == "pinned" else None
        plates.append(Plate(draw(tenths(3, 30)), draw(tenths(1, 10)), pin))
        mu = draw(tenths(0, 7))
        laws = {"kinetic": mu, "static": mu + draw(tenths(0, 3)), "restitution": draw(tenths(0, 9))}
        if shape == "sphere":
            touches.append(Touch(i, (draw(tenths(-2, 2)), draw(tenths(-2, 2))), draw(tenths(3, 6)), **laws))
        for sign in {"corner": (1,), "corners": (1, -1)}.get(shape, ()):
            touches.append(Touch(i, (sign * draw(tenths(1, 6)), draw(tenths(-6, -1))), **laws))
    if stops:
        touches.append(Touch(0, (draw(tenths(2, 9)), 0.0), stops=stops, restitution=draw(tenths(0, 9))))
    floor = None
    if support:
        along, across = ((draw(tenths(0, 2)), float(draw(st.integers(1, 12)))) for _ in range(2))
        floor = Support(along, across, draw(tenths(-5, 5)))
    return Plane(draw(tenths(-5, 5)), tuple(plates), tuple(touches), floor), law


def numbers(plane: Plane) -> Iterator[float]:
    """All numbers of a plane."""
    yield plane.slope
    if plane.support is not None:
        yield from (*plane.support.along, *plane.support.across, plane.support.belt)
    for p in plane.plates:
        yield from (p.mass, p.inertia, *(() if p.pin is None else (*p.pin[0], *p.pin[1])))
    for t in plane.touches:
        yield from (*t.place, t.radius, t.kinetic, t.static, t.restitution)


class Model(NamedTuple):
    """Equations, coordinates in the order of the oracle, and parameters in that of `numbers`."""

    eom: kn.Equations
    coordinates: tuple[kn.Coordinate, ...]
    parameters: tuple[kn.Parameter, ...]

    def values(self, plane: Plane) -> dict[Any, float]:
        return dict(zip(self.parameters, numbers(plane), strict=True))


def model(plane: Plane, law: str = "stronge") -> Model:
    """The equations of a plane, one for all of its build."""
    plates = tuple(p.pin is None for p in plane.plates)
    return _made(plates, tuple((t.body, bool(t.radius), t.stops) for t in plane.touches), bool(plane.support), law)


@cache
def _made(plates: Any, touches: Any, support: bool, law: str) -> Model:
    bodies = tuple(Plate(1.0, 1.0, None if free else ((0.1, 0.2), (0.3, -0.2))) for free in plates)
    laws = {"kinetic": 0.3, "static": 0.4, "restitution": 0.5}
    places = [(0.1 + 0.2 * k - 0.07 * k * k, -0.4 - 0.1 * k) for k in range(len(touches))]  # no two are the same
    every = tuple(
        Touch(body, place, 0.3 if round_ else 0.0, stops, **laws)
        for place, (body, round_, stops) in zip(places, touches, strict=True)
    )
    first = Plane(0.1, bodies, every, Support((0.1, 2.0), (0.1, 3.0), 0.1) if support else None)
    parameters = tuple(kn.parameter(f"p{k}", x, "") for k, x in enumerate(numbers(first)))
    eom = kn.derive(system(first, law, parameters))
    return Model(eom, tuple(sorted(eom.coordinates, key=lambda s: s.name)), parameters)


def system(plane: Plane, law: str = "stronge", given: Iterable[Any] = ()) -> kn.System:
    """The same in `kane`, with symbols for its numbers where they are given.

    Coordinates are in the order of the oracle, friction is positive along the incline.
    """
    give = iter(given or numbers(plane))
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    I = N.rotate("I", next(give), N.z)
    q = list(kn.coordinates(f"q1:{plane.width + 1}"))
    ground, surface = O, None
    if plane.support:
        (a, v), (b, w) = ((next(give), next(give)) for _ in range(2))
        ground = O.at("floor", a * kn.sin(v * kn.time) * I.x + b * kn.sin(w * kn.time) * I.y)
        surface = next(give) * I.x
    bodies, angles = [], []
    frames: list[kn.Frame] = []
    centers: list[kn.Point] = []
    k = 0
    for i, plate in enumerate(plane.plates):
        mass, moment = next(give), next(give)
        angle = q[k + 2] if plate.pin is None else q[k]
        base = I if plate.pin is None else frames[0]
        B = base.rotate(f"B{i}", angle, base.z)
        if plate.pin is None:
            C = O.at(f"C{i}", q[k] * I.x + q[k + 1] * I.y)
        else:
            H = centers[0].at(f"H{i}", next(give) * base.x + next(give) * base.y)
            C = H.at(f"C{i}", -next(give) * B.x - next(give) * B.y)
        k += 3 if plate.pin is None else 1
        bodies.append(kn.RigidBody(f"b{i}", frame=B, mass_center=C, mass=mass, inertia=kn.inertia(B, 1, 1, moment)))
        frames.append(B)
        centers.append(C)
        angles.append(angle)
    contacts = []
    for i, t in enumerate(plane.touches):
        x, y, radius, kinetic, static, restitution = (next(give) for _ in range(6))
        name, law_of = f"c{i}", {"restitution": restitution, "law": law}
        if t.stops:
            contacts.append(kn.joints.stop(name, x - (q[0] if t.stops == "x" else angles[1]), **law_of))
            continue
        B, C = frames[t.body], centers[t.body]
        options = {"normal": I.y, "along": I.x, "surface": surface}
        place = (
            kn.joints.sphere_on_plane(name, B, C.at(f"S{i}", x * B.x + y * B.y), ground, radius=radius, **options)
            if t.radius
            else kn.joints.point_on_plane(name, C.fixed_in(B, f"P{i}", x * B.x + y * B.y), ground, **options)
        )
        contacts.append(kn.contact(place, kinetic, static=static, **law_of))
    loads = [kn.gravity(-G * N.y)]
    return kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=contacts)
