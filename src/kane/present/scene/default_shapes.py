# SPDX-License-Identifier: BSD-3-Clause
"""Default shapes of bodies: the solids of their inertias, links between their points, round edges, guides of sliders.

A point belongs to a body if a chain of offsets that are constant in the body's frame leads to it from the mass centre.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate
from kane.model.beams.beam import Beam
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint, cut_of
from kane.model.solids import Inertia
from kane.model.system import System
from kane.numeric.sampling import SEEDS, sample
from kane.numeric.scale import DECLARED
from kane.present.scene.records import Item, Quantities, distinct
from kane.present.scene.shapes import along, ellipsoid_item, solid_item
from kane.space.frame import Frame, Point, frames_of
from kane.space.vector import Vector

_STATIONS = 16
"""Segments of a beam's axis in drawings."""


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """A body that rolls on its edge: a sphere without an axis, a disk with one."""

    center: Point
    radius: Vector
    axis: Vector | None


def family(system: System) -> dict[Point, list[Point]]:
    """The children of each point, without points of beams."""
    children: dict[Point, list[Point]] = {}
    within = of_beams(system)
    for p in system.points:
        if p.parent is not None and not p.name.startswith(within):
            children.setdefault(p.parent, []).append(p)
    return children


def of_beams(system: System) -> tuple[str, ...]:
    """Prefixes of the names of points of beams."""
    return tuple(f"{b.name} " for b in system.bodies if isinstance(b, Beam))


def attached(body: RigidBody, children: dict[Point, list[Point]]) -> list[Point]:
    """The points of a body, its mass centre first."""
    seen, todo = {body.mass_center: None}, [body.mass_center]
    while todo:
        p = todo.pop()
        near = [(q, q.offset) for q in children.get(p, ())]
        if p.parent is not None:
            near.append((p.parent, p.offset))
        for q, step in near:
            if q not in seen and _rides(step, body.frame) and q.body in (None, body.frame):
                seen[q] = None
                if q.body is None:
                    todo.append(q)
    return list(seen)


def _rides(step: Vector, frame: Frame) -> bool:
    return all(f is frame for f in frames_of(step)) and is_constant_in_time(step.scalars())


def rounds(system: System) -> dict[Frame, Round]:
    """Bodies that roll on an edge, by their frames."""
    centers = {b.frame: b.mass_center for b in system.rigid_bodies}
    result: dict[Frame, Round] = {}
    for particle, normal in touching(system):
        frame, center = particle.body, particle.parent
        if frame is None or center is None or frame in result or particle.offset.is_zero:
            continue
        if center in centers.values() and center is not centers.get(frame) and frame not in centers:
            continue
        edge = _round(frame, center, particle.offset, normal)
        if edge is not None:
            result[frame] = edge
    return result


def touching(system: System) -> Iterator[tuple[Point, Vector]]:
    """Particles in contact with planes or other bodies, with the normals."""
    for law in system.contacts:
        if law.place is not None:
            yield law.place.particle, law.place.normal
    up = upward(system)
    for c in system.constraints:
        if c.kind == "motion" and c.forces and (c.normal is not None or c.forces[0][0].body is not None):
            yield c.forces[0][0], c.normal or up
    for load in system.loads:
        pressed = [cut for r in (load.slip.presses if load.slip else ()) if (cut := cut_of(r)) is not None]
        if pressed and load.forces:
            yield load.forces[0][0], pressed[0].along


def upward(system: System) -> Vector:
    """The direction opposite to gravity, or the third axis of the inertial frame without gravity."""
    for g in system.gravities:
        return -g.acceleration.normalized()
    return system.inertial.z


def _round(frame: Frame, center: Point, reach: Vector, normal: Vector) -> Round | None:
    """A sphere if the vector to the contact is along the normal, a disk if it stays normal to an axis of the body; else None."""
    if is_constant_in_time(reach.components(frame)):
        return None
    size, along_normal = reach.dot(reach), reach.dot(normal)
    across = [reach.dot(e) for e in (frame.x, frame.y, frame.z)]
    tests = [sample([size, along_normal, *across], seed, spread=1.0) for seed in SEEDS]
    if any(abs(row[0] - tests[0][0]) > DECLARED * tests[0][0] for row in tests):
        return None
    if all(abs(row[1] ** 2 - row[0]) <= DECLARED * row[0] for row in tests):
        return Round(center, reach, None)
    for k, e in enumerate((frame.x, frame.y, frame.z)):
        if all(abs(row[2 + k]) <= DECLARED * row[0] ** 0.5 for row in tests):
            return Round(center, reach, e)
    return None


def body_items(system: System, into: Quantities, declared: set[str]) -> Iterator[Item]:
    """The shapes of all bodies without declared ones."""
    children, edges = family(system), rounds(system)
    for body in system.bodies:
        if body.name in declared:
            continue
        if isinstance(body, Beam):
            yield beam_item(body, into)
        elif isinstance(body, RigidBody):
            yield from _rigid(system, body, into, children, edges.get(body.frame))
        elif isinstance(body, Particle):
            yield _particle(system, body, into)
        else:
            for part in body.parts():
                yield Item("particle", part.name, "body", into.position(part.mass_center))


def beam_item(beam: Beam, into: Quantities) -> Item:
    """A beam by points of its deformed axis."""
    stations = [k / _STATIONS for k in range(_STATIONS + 1)]
    places = [into.position(beam.point_at(xi)) for xi in stations]
    return Item("beam", beam.name, "body", places[0], None, tuple(places))


def _rigid(
    system: System, body: RigidBody, into: Quantities, children: dict[Point, list[Point]], edge: Round | None
) -> Iterator[Item]:
    solid = solid_item(body, into)
    own = attached(body, children)
    if edge is not None and (solid is None or solid.kind == "ellipsoid"):
        yield _edge_item(body, edge, into)
        return
    corners = [p for p in own if p.body is body.frame]
    if solid is not None:
        yield solid
        for p in own[1:] if solid.kind != "rod" else ():  # thin lines to points away from the centre
            if p.body is None:
                yield Item("arm", body.name, "body", points=(into.position(body.mass_center), into.position(p)))
        return
    if corners and not edge:
        yield _mirrored(body, corners, into)
        return
    places = distinct(into.position(p) for p in own)
    if len(places) > 1:
        yield Item("link", body.name, "body", places[0], points=places)
    if len(places) < 3:
        yield ellipsoid_item(body, into)


def _edge_item(body: RigidBody, edge: Round, into: Quantities) -> Item:
    sizes = {"radius": into.scalar(edge.radius.magnitude())}
    at = into.position(edge.center)
    if edge.axis is None:
        return Item("sphere", body.name, "body", at, into.frame(body.frame), (), sizes)
    return Item("disk", body.name, "body", at, along(into, body.frame, edge.axis), (), sizes)


def _mirrored(body: RigidBody, corners: list[Point], into: Quantities) -> Item:
    """The convex hull of the corners in contact, and of their mirror images with respect to the mass centre."""
    center = into.place(body.mass_center)
    steps = [into.place(p) - center for p in corners]
    places = distinct(into.at(center + v * sign) for sign in (1, -1) for v in steps)
    return Item("hull", body.name, "body", into.position(body.mass_center), points=places)


def _particle(system: System, body: Particle, into: Quantities) -> Item:
    """A ball, or a block if the particle is guided along a straight line."""
    p = body.point
    at = into.position(p)
    carriers = {b.frame for b in system.rigid_bodies}
    for law in system.contacts:
        place = law.place
        if place is not None and place.particle.body in carriers and place.particle.parent is p:
            continue  # the body around the particle is in contact, not the particle
        for touch in (place.particle, place.ground) if place is not None else ():
            if touch is not None and touch is not p and touch.parent is p and not touch.offset.is_zero and touch.body:
                sizes = {"radius": into.scalar(touch.offset.magnitude())}
                if (place is not None and place.normal.cross(touch.offset).is_zero) or law.slips or law.gap:
                    return Item("sphere", body.name, "body", at, into.frame(into.inertial), (), sizes)
        if place is not None and (place.particle is p or place.particle.parent is p):
            kind = "block" if law.restitution is ZERO else "ball"
            return Item(kind, body.name, "body", at, direction=into.direction(place.normal))
    guide = _guided(system, p, into)
    if guide is not None:
        return Item("slider", body.name, "body", at, direction=into.direction(guide))
    return Item("particle", body.name, "body", at)


def _guided(system: System, p: Point, into: Quantities) -> Vector | None:
    """The direction of a particle whose one coordinate displaces it along a straight line that is not vertical; None for others."""
    moving = [s for s in free_symbols(_chain(p)) if isinstance(s, Coordinate)]
    if len(moving) != 1:
        return None
    inertial = system.inertial
    way = into.place(p).diff(moving[0], inertial)
    if any(isinstance(s, Coordinate) for s in free_symbols(way.components(inertial))):
        return None
    fall = sum((g.acceleration for g in system.gravities), start=Vector())
    if fall.is_zero:
        return way
    sideways = sample(way.cross(fall).components(inertial), SEEDS[0])
    return None if all(abs(x) <= DECLARED for x in sideways) else way


def _chain(p: Point) -> list[Expr]:
    steps = [q.offset for q in p.ancestry()]
    return [x for v in steps for x in (*v.scalars(), *(y for f in frames_of(v) for y in _scalars(f)))]


def holding_items(system: System, into: Quantities) -> Iterator[Item]:
    """Massless rods of constraints, ropes of contacts, and rods to particles in rotating frames."""
    for c in system.constraints:
        if c.kind == "configuration" and _is_rod(c):
            yield Item("bar", c.name, "constraint", points=tuple(into.position(p) for p, _ in c.forces))
        elif c.kind == "configuration" and len(c.forces) == 2:
            yield Item("pin", c.name, "constraint", into.position(c.forces[0][0]))
        elif c.kind == "motion" and c.normal is None and c.forces and not c.torques and c.forces[0][0].body is None:
            p, e = c.forces[0]
            yield Item("wheel", c.name, "constraint", into.position(p), direction=into.direction(e))
    for law in system.contacts:
        if law.place is None and law.gap is not None and len(law.gap.forces) > 1:
            yield Item("rope", law.name, "constraint", points=tuple(into.position(p) for p, _ in law.gap.forces))
    yield from _rods(system, into)


def _is_rod(c: Constraint) -> bool:
    """Whether a constraint keeps two points at a distance: its force is along the line between them."""
    if len(c.forces) != 2:
        return False
    (p, v), (q, _) = c.forces
    across = v.cross(p.position(q)).components(p.root().frame)
    return all(abs(x) <= DECLARED for x in sample(across, SEEDS[0]))


def _rods(system: System, into: Quantities) -> Iterator[Item]:
    """Rods from a point to one at a constant offset in a rotating frame, unless a body connects them."""
    frames, within = {b.frame for b in system.rigid_bodies}, of_beams(system)
    covered = {edge.center for edge in rounds(system).values()} | {
        b.mass_center for b in system.rigid_bodies if isinstance(b.inertia, Inertia) and b.inertia.shape.kind != "rod"
    }
    for p in system.points:
        turning = [f for f in frames_of(p.offset) if any(isinstance(s, Coordinate) for s in free_symbols(_scalars(f)))]
        fixed = is_constant_in_time(p.offset.scalars())
        carried = p.body is None and not any(f in frames for f in frames_of(p.offset))
        if (
            turning
            and fixed
            and carried
            and not p.name.startswith(within)
            and p.parent is not None
            and p not in covered
        ):
            yield Item("bar", p.name, "constraint", points=(into.position(p.parent), into.position(p)))


def _scalars(frame: Frame) -> list[Expr]:
    return [x for f in frame.lineage if f.orientation is not None for x in f.orientation.scalars()]


def ground_items(system: System, into: Quantities) -> Iterator[Item]:
    """The planes on which bodies roll and slide, once each."""
    seen: set[tuple[object, ...]] = set()
    gaps = {law.place.particle: law.place.height.expr for law in system.contacts if law.place is not None and law.gap}
    for particle, normal in touching(system):
        home, level = frames_of(normal), normal.components(system.inertial)
        if len(home) != 1 or not is_constant_in_time(normal.scalars()):
            continue
        at = into.place(particle) - normal * gaps.get(particle, ZERO)
        levels = [sample([normal.dot(at)], seed)[0] for seed in SEEDS[:2]]
        if particle in gaps and abs(levels[0] - levels[1]) > DECLARED * max(map(abs, levels)):
            continue  # the plane is a face of a moving body
        key = (home, level, normal.dot(at) if particle in gaps else None)
        if key not in seen:
            seen.add(key)
            yield Item("plane", particle.name, "ground", into.at(at), direction=into.direction(normal))
