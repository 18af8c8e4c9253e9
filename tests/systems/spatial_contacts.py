# SPDX-License-Identifier: BSD-3-Clause
"""Bodies in space on an incline with points, spheres, disks and tori; `tests.oracles.spatial_contacts` has their laws.

Numbers are parameters, so that all scenes with the same joints and shapes have the same equations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

import kane as kn
from tests.oracles.spatial_contacts import STEP, G, Scene, Solid, Touch, motions, posed, rows, touching
from tests.systems.planar_contacts import tenths

BUILDS = (
    ("point",),
    ("points",),
    ("sphere",),
    ("disk",),
    ("torus",),
    ("point", "free", "sphere"),
    ("sphere", "free", "above"),
    ("ball on the ground", "point"),
    ("sphere", "pin", "point"),
    ("torus", "pin", "disk"),
    ("point", "ball", "sphere"),
)
"""What touches of the first body, the second one's joint, and what touches of it: "above" is a sphere on the first body."""
STANDING = (("sphere",), ("points",), ("feet",), ("box",), ("points", "free", "above"), ("feet", "pin", "point"))
"""The same of bodies that stand on two to four points: three feet, or the corners of a box."""


Array = Any


CORNERS = ((1, 1), (1, -1), (-1, 1), (-1, -1))


class Model(NamedTuple):
    """Equations, coordinates in the order of the oracle, and parameters in that of `numbers`; speeds are in both in one order."""

    eom: kn.Equations
    coordinates: tuple[kn.Coordinate, ...]
    parameters: tuple[kn.Parameter, ...]

    def values(self, scene: Scene) -> dict[Any, float]:
        return dict(zip(self.parameters, numbers(scene), strict=True))


def numbers(scene: Scene) -> Iterator[float]:
    """All numbers of a scene."""
    yield from scene.tilt
    for s in scene.solids:
        yield s.mass
        yield from s.inertia
        yield from () if s.joint == "free" else (*s.there, *s.here)
    for t in scene.touches:
        yield from (*t.place, t.radius, t.crown, t.above, t.kinetic, t.static)


def triples(low: int = -4, high: int = 4) -> st.SearchStrategy[tuple[float, ...]]:
    return st.tuples(*[tenths(low, high)] * 3)


@st.composite
def solids(draw: Any, joint: str = "free", to: int = -1) -> Solid:
    """A body whose moments of inertia have products."""
    a, b, c = (draw(tenths(2, 8)) for _ in range(3))
    xy, yz, zx = (draw(tenths(-3, 3)) / 5 for _ in range(3))
    there, here = ((0.0,) * 3, (0.0,) * 3) if joint == "free" else (draw(triples()), draw(triples(1, 4)))
    return Solid(draw(tenths(5, 30)), (b + c, c + a, a + b, xy, yz, zx), joint, to, there, here)


@st.composite
def touches(draw: Any, body: int, shape: str) -> Touch:
    """A contact of a body."""
    mu = draw(tenths(0, 8))
    law = {"kinetic": mu, "static": mu + draw(tenths(1, 3))}
    if shape == "above":
        return Touch(body, "sphere", draw(triples(-2, 2)), draw(tenths(2, 5)), on=0, above=draw(tenths(1, 3)), **law)
    if shape == "point":
        return Touch(body, shape, (draw(tenths(-4, 4)), draw(tenths(-4, 4)), draw(tenths(-6, -2))), **law)
    crown = draw(tenths(1, 2)) if shape == "torus" else 0.0
    return Touch(body, shape, draw(triples(-2, 2)), draw(tenths(3, 6)), crown, **law)


@st.composite
def scenes(draw: Any, builds: tuple[tuple[str, ...], ...] = BUILDS) -> Scene:
    """One or two bodies."""
    build = draw(st.sampled_from(builds))
    tilt, speeds = (draw(tenths(-5, 5)), draw(tenths(-5, 5))), draw(st.sampled_from(["rates", "bodies"]))
    if build[0] == "ball on the ground":
        return Scene(tilt, (draw(solids("ball")),), (draw(touches(0, build[1])),), speeds)
    bodies = [draw(solids())]
    found = list[Touch]()
    for x, y in {"points": ((1, 0), (-1, 0)), "feet": ((1, 0), (-1, 1), (-1, -1)), "box": CORNERS}.get(build[0], ()):
        own = draw(touches(0, "point"))
        z = found[0].place[2] if build[0] == "box" and found else own.place[2]
        place = (
            (x * 0.3, y * 0.4, z) if build[0] == "box" else (0.3 * x + own.place[0] / 4, 0.4 * y + own.place[1] / 4, z)
        )
        found.append(replace(own, place=place))
    if not found:
        found.append(draw(touches(0, build[0])))
    if len(build) > 1:
        bodies.append(draw(solids(build[1], 0 if build[1] != "free" else -1)))
        found.append(draw(touches(1, build[2])))
    return Scene(tilt, tuple(bodies), tuple(found), speeds)


def build_of(scene: Scene) -> Any:
    """What scenes with the same equations have in common."""
    return (
        scene.speeds,
        tuple((s.joint, s.to) for s in scene.solids),
        tuple((t.body, t.shape, t.on) for t in scene.touches),
    )


def model(scene: Scene) -> Model:
    """The equations of a scene."""
    return made(build_of(scene))


@cache
def made(build: Any) -> Model:
    speeds, joints, places = build
    parameters: list[kn.Parameter] = []

    def number(default: float = 0.0) -> kn.Parameter:
        parameters.append(kn.parameter(f"p{len(parameters)}", default, ""))
        return parameters[-1]

    def along(F: kn.Frame) -> Any:
        x, y, z = (number((len(parameters) ** 2 * k % 31 - 15) / 40) for k in (3, 5, 7))  # no two places are the same
        return x * F.x + y * F.y + z * F.z

    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    I = N.rotate("J", number(), N.x)
    I = I.rotate("I", number(), I.y)
    frames, centers, bodies, q, told = list[kn.Frame](), list[kn.Point](), list[Any](), list[Any](), dict[Any, Any]()
    for i, (joint, to) in enumerate(joints):
        mass, (xx, yy, zz), (xy, yz, zx) = number(1.0), (number(1.0) for _ in range(3)), (number() for _ in range(3))
        base, origin = (I, O) if to < 0 else (frames[to], centers[to])
        place = list(kn.coordinates(f"x{i} y{i} z{i}")) if joint == "free" else []
        angles = [kn.coordinate(f"a{i}")] if joint == "pin" else list(kn.coordinates(f"a{i} b{i} c{i}"))
        B = base.rotate(f"B{i}", angles[0], base.z) if joint == "pin" else base.rotate_body(f"B{i}", angles, "123")
        if joint == "free":
            C = O.at(f"C{i}", place[0] * I.x + place[1] * I.y + place[2] * I.z)
        else:
            C = origin.at(f"H{i}", along(base)).at(f"C{i}", -along(B))
        w = B.angular_velocity(base)
        turns = [a.dt for a in angles] if speeds == "rates" or joint == "pin" else [w.dot(x) for x in (B.x, B.y, B.z)]
        definitions = [*(x.dt for x in place), *turns]
        q += [*place, *angles]
        names = [f"u{i}{k}" for k in range(len(definitions))]
        told |= dict(zip(kn.speeds(names), definitions, strict=True))
        inertia = kn.inertia(B, xx, yy, zz, xy, yz, zx)
        bodies.append(kn.RigidBody(f"b{i}", frame=B, mass_center=C, mass=mass, inertia=inertia))
        frames.append(B)
        centers.append(C)
    contacts = [_contact(f"c{i}", t, frames, centers, (I, O), number, along) for i, t in enumerate(places)]
    loads = [kn.gravity(-G * N.z)]
    system = kn.System(N, bodies=bodies, speeds=told, loads=loads, contacts=contacts)
    return Model(kn.derive(system), tuple(q), tuple(parameters))


def _contact(
    name: str, touch: Any, frames: list[kn.Frame], centers: list[kn.Point], ground: Any, number: Any, along: Any
) -> kn.ContactLaw:
    body, shape, on = touch
    B, C = frames[body], centers[body]
    offset, radius, crown, above = along(B), number(0.5), number(0.1), number(0.1)
    E, O = (frames[on], centers[on]) if on >= 0 else ground
    plane = O.at(f"{name} plane", above * E.z) if on >= 0 else O
    kinetic, static = number(), number()
    place: Any = C.fixed_in(B, f"{name} place", offset) if shape == "point" else C.at(f"{name} place", offset)
    options = {"normal": E.z, "along": E.x}
    if shape == "point":
        where = kn.joints.point_on_plane(name, place, plane, **options)
    elif shape == "sphere":
        where = kn.joints.sphere_on_plane(name, B, place, plane, radius=radius, **options)
    elif shape == "disk":
        where = kn.joints.disk_on_plane(name, B, place, plane, axis=B.x, radius=radius, **options)
    else:
        where = kn.joints.torus_on_plane(name, B, place, plane, axis=B.x, radius=radius, crown=crown, **options)
    return kn.contact(where, kinetic, static=static)


def admitted(
    scene: Scene, modes: Sequence[str], rng: np.random.Generator, redundant: bool = False
) -> tuple[Array, Array] | None:
    """A random state whose gaps are closed, with speeds that the modes have; None where there is none near.

    With `redundant` rows that are held may depend on each other.
    """
    q, u = rng.uniform(-0.6, 0.6, scene.width), rng.normal(size=scene.width)
    closed = [t for t, mode in zip(scene.touches, modes, strict=True) if mode != "separated"]
    unit = 1j * STEP * np.eye(scene.width)
    for _ in range(40 if closed else 0):
        gaps = np.array([touching(scene, t, posed(scene, q))[0] for t in closed])
        if np.abs(gaps).max() < 1e-14:
            break
        slopes = np.array([[touching(scene, t, posed(scene, q + d))[0].imag / STEP for d in unit] for t in closed])
        step = np.linalg.lstsq(slopes, gaps, rcond=1e-9)[0]
        q = q - step / max(1.0, np.abs(step).max())
    at = posed(scene, q)
    if any(abs(touching(scene, t, at)[0]) > 1e-13 for t in closed) or _flat(scene, at):
        return None
    of, b = rows(scene, at, np.zeros(6 * len(scene.solids))), motions(scene, q)
    counts = [{"separated": 0, "stick": 3}.get(mode, 1) for mode in modes]
    held = np.concatenate([np.zeros((0, len(b))), *(j[:n] for j, n in zip(of.contacts, counts, strict=True))]) @ b
    if not len(held):
        return q, u
    sizes = np.linalg.svd(held, compute_uv=False)
    full = len(held) <= scene.width and sizes[-1] > 1e-2 * sizes[0]
    clear = (sizes > 1e-2 * sizes[0]) | (sizes < 1e-11 * sizes[0])
    if not (full or (redundant and clear.all())):
        return None
    u = u - np.linalg.pinv(held, rcond=1e-10) @ (held @ u)
    return q, np.where(np.abs(u) < 1e-13, 0.0, u)


def _flat(scene: Scene, at: Any) -> bool:
    """Whether a wheel all but lies."""
    return any(t.shape in ("disk", "torus") and abs(at.R[t.body][2, 0]) > 0.95 for t in scene.touches)
