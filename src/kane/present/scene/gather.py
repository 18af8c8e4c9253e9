# SPDX-License-Identifier: BSD-3-Clause
"""`scene`: all that can be drawn of a system, from its declarations: items, effects of coordinates, loads at their points.

A coordinate in the angle of a frame is a rotation about its axis, shown at the frame's first point; one in the offset of a point is a
displacement along the path of the point as the coordinate grows from zero, with the following coordinates still zero.
"""

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

from kane import expect
from kane.equations.equations import Equations
from kane.errors import ArgumentError, ModelError
from kane.expr.build import sub
from kane.expr.differentiation import diff
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.symbols import Coordinate, Parameter, Rate, Speed
from kane.expr.visit import substituted
from kane.model.beams.beam import Beam
from kane.model.bodies import Particle
from kane.model.constraints import cut_of
from kane.model.loads import Load
from kane.model.system import System
from kane.numeric.sampling import SEEDS, sample
from kane.numeric.scale import DECLARED
from kane.present.scene.default_shapes import body_items, ground_items, holding_items, of_beams
from kane.present.scene.records import Action, Item, Mark, Movement, Quantities, Scene, Triad
from kane.present.scene.shapes import BodyShape, declared_item, shapes_of
from kane.space.frame import Frame, Point, frames_of
from kane.space.rotation import UNITS, Orientation
from kane.space.vector import Vector
from kane.write.arrange import to_text

_WAYS = 8
"""Segments of a curved path."""
_CONTACTS = 6
"""Largest number of contacts for which forces are shown."""
_SHORT = 16
"""Largest number of letters of a load's expression in a label; a longer one is replaced by its name."""


def movements(system: System, into: Quantities) -> Iterator[Movement]:
    """A movement for each coordinate, or for several that move together."""
    left = dict.fromkeys(system.coordinates)
    for beam in (b for b in system.bodies if isinstance(b, Beam)):
        own = [q for q in beam.coordinates if q in left]
        for q in own:
            del left[q]
        if own:
            yield _deflection(beam, own, into)
    for group in system.euler_parameters:
        own = [q for q in group.coordinates if q in left]
        for q in own:
            del left[q]
        frame = next(f for f in system.frames if f.orientation is not None and f.orientation.quasi is group.quasi)
        at = into.position(center_of(system, frame))
        yield Movement("attitude", tuple(q.name for q in own), (at,), frame=frame.name, axis=into.direction(frame.z))
    for q in left:
        yield _turn(system, q, into) or _shift(system, q, into) or Movement("none", (q.name,))


def _deflection(beam: Beam, own: list[Coordinate], into: Quantities) -> Movement:
    axis = beam.deformation.axis
    places = []
    for xi in (1.0, 0.5):
        places += [into.position(beam.root, axis * (beam.length * xi)), into.position(beam.point_at(xi))]
    return Movement("deflection", tuple(q.name for q in own), tuple(places), frame=beam.name)


def _turn(system: System, q: Coordinate, into: Quantities) -> Movement | None:
    frame = turned_by(system, q)
    if frame is None:
        return None
    o = frame.orientation
    assert o is not None
    assert o.angle is not None
    assert isinstance(o.base, Frame)
    axis = Vector(((o.base, UNITS[o.axis] if o.axis is not None else o.direction or UNITS[0]),))
    center = center_of(system, frame)
    return Movement(
        "turn", (q.name,), (into.position(center),), into.direction(axis), into.direction(_hand(system, frame, center, axis, o)),
        into.scalar(sub(o.angle, substituted(o.angle, {q: ZERO}))), frame.name,
    )  # fmt: skip


def turned_by(system: System, q: Coordinate) -> Frame | None:
    """The frame whose angle is the coordinate, or contains it with the fewest others."""
    found: list[tuple[int, int, Frame]] = []
    for k, f in enumerate(system.frames):
        angle = f.orientation.angle if f.orientation is not None else None
        if angle is None:
            continue
        moving = {s for s in free_symbols([angle]) if isinstance(s, Coordinate)}
        if q in moving and is_constant_in_time([diff(angle, q)]):
            found.append((len(moving), k, f))
    return min(found, key=lambda x: x[:2])[2] if found else None


def center_of(system: System, frame: Frame) -> Point:
    """The point at which a frame's rotation is shown: its joint, its first point, its body's mass centre, or that of a child."""
    for j in system.joints:
        if j.frame is frame:
            return j.point
    built = [p for p in system.points if p.parent is not None and frame in frames_of(p.offset)]
    bodies = [b for b in system.rigid_bodies if b.frame is frame]
    for p in built:
        if p.body is None and is_constant_in_time(p.offset.scalars()) and p.parent is not None:
            return p.parent
    if bodies:
        return bodies[0].mass_center
    if built and built[0].parent is not None:
        return built[0].parent
    for f in system.frames:
        if f.orientation is not None and f.orientation.base is frame:
            return center_of(system, f)
    return system.points[0].root()


def _hand(system: System, frame: Frame, center: Point, axis: Vector, o: Orientation) -> Vector:
    """A vector that shows a rotation: to a point of the frame, perpendicular to the axis, or else an axis of the frame."""
    for p in system.points:
        own = dict(p.offset.parts).get(frame)
        if p.parent is center and own is not None and p.body is None:
            way = Vector(((frame, own),)).reject(axis)
            if any(abs(x) > DECLARED for x in sample(list(way.components(frame)), SEEDS[0])):
                return way
    k = o.axis if o.axis is not None else next((i for i, x in enumerate(o.direction or UNITS[2]) if x is not ZERO), 2)
    return (frame.x, frame.y, frame.z)[(k + 1) % 3].reject(axis)


def _shift(system: System, q: Coordinate, into: Quantities) -> Movement | None:
    for p in system.points:
        if q not in set(free_symbols(p.offset.scalars())) or p.parent is None:
            continue
        later: dict[Expr, Expr] = dict.fromkeys(_behind(system, p, q), ZERO)
        way = p.offset.map(_moving)
        rates = [diff(substituted(x, later), q) for x in way.scalars()]
        straight = q not in set(free_symbols(rates))
        shares = [ZERO, ONE] if straight else [as_expr(k) / _WAYS for k in range(_WAYS + 1)]
        start = into.place(p.parent)
        steps = [way.map(partial(substituted, replacements={**later, q: q * share})) for share in shares]
        return Movement("shift", (q.name,), tuple(into.at(start + step) for step in steps), frame=p.name)
    return None


def _moving(e: Expr) -> Expr:
    """A measure number that depends on coordinates; zero for others."""
    return e if any(isinstance(s, Coordinate) for s in free_symbols([e])) else ZERO


def _behind(system: System, p: Point, q: Coordinate) -> list[Expr]:
    """The coordinates of a point's offset that follow `q` and rotate no frame."""
    among = set(free_symbols(p.offset.scalars()))
    own = [s for s in system.coordinates if s in among]
    place = next(k for k, s in enumerate(own) if s is q)
    return [s for s in own[place + 1 :] if turned_by(system, s) is None]


# Loads ---------------------------------------------------------------------------------------------------------------


def load_items(system: System, into: Quantities) -> Iterator[Item]:
    """Springs and dampers between points."""
    for load in system.loads:
        kind = between(load)
        if kind in ("spring", "damper"):
            yield Item(kind, load.name, "load", points=tuple(into.position(p) for p, _ in load.forces))


def between(load: Load) -> str:
    """The kind of a load between two points: a spring has a potential, a damper depends on rates; "" for others."""
    if len(load.forces) != 2 or load.torques or load.slip is not None or load.scalar is not None:
        return ""
    (p, v), (_, w) = load.forces
    if any(x is not ZERO for x in (v + w).components(p.root().frame)):
        return ""
    if load.potential is not None:
        return "spring"
    return "damper" if any(isinstance(s, Rate | Speed) for s in free_symbols(v.scalars())) else ""


def actions(system: System, into: Quantities) -> Iterator[Action]:
    """Gravity, forces and torques, and reactions if they are few."""
    parts = [part for b in system.bodies for part in b.parts()]
    for g in system.gravities:
        at = into.position(parts[0].mass_center)
        size = _factor(g.acceleration)
        yield Action("gravity", g.name, to_text(size) if size is not None else "g", at, into.direction(g.acceleration))
    brought = {id(x) for b in system.bodies if isinstance(b, Beam) for x in b.own_loads}
    for load in system.loads:
        if id(load) in brought or between(load) in ("spring", "damper") or load.scalar is not None:
            continue
        if load.forces:
            p, v = load.forces[0]
            yield Action("force", load.name, _label(load, v), into.position(p), into.direction(v))
        elif load.torques and load.potential is None:
            f, v = load.torques[0]
            yield Action("torque", load.name, _label(load, v), into.position(center_of(system, f)), into.direction(v))
    for r in system.reactions:
        cut = cut_of(r)
        if cut is not None and len(system.reactions) < 4 and isinstance(cut.at, Point):
            yield Action("force", r.name, r.name, into.position(cut.at), into.direction(cut.along))
    yield from _touching(system, into)


def _touching(system: System, into: Quantities) -> Iterator[Action]:
    """Normal and friction forces of contacts if these are few, on the first body of each."""
    for law in system.contacts if len(system.contacts) <= _CONTACTS else ():
        normal = law.normal_force
        cut = None if normal is None else cut_of(normal)
        if normal is not None and law.gap is not None and law.gap.forces:
            p, v = law.gap.forces[0]
            yield Action("contact", law.name, "N", into.position(p), into.direction(normal * v))
        elif cut is not None and isinstance(cut.at, Point):
            yield Action("contact", law.name, "N", into.position(cut.at), into.direction(normal * cut.along))
        pushed = [(f, slip.forces[0]) for f, slip in zip(law.friction_forces, law.slips, strict=True) if slip.forces]
        if pushed:
            (_, (p, _)), *_ = pushed
            friction = sum((f * v for f, (_, v) in pushed), start=Vector())
            yield Action("contact", law.name, "F", into.position(p), into.direction(friction))


def _label(load: Load, v: Vector) -> str:
    """The expression of a force if it is short, else its name."""
    size = _factor(v)
    text = "" if size is None else to_text(size)
    return text if text and len(text) <= _SHORT and not any(c in text for c in "+/(") else load.name


def _factor(v: Vector) -> Expr | None:
    """The only nonzero measure number of a vector, without its sign; None if there are several."""
    numbers = [x for _, triple in v.parts for x in triple if x is not ZERO]
    if len(numbers) != 1:
        return None
    e = numbers[0]
    return -e if to_text(e).startswith("-") else e


_MANY = 3
"""Number of bodies beyond which only the axes of the inertial frame are shown."""


def scene(system: System | Equations, shapes: Iterable[BodyShape] = ()) -> Scene:
    """The geometry of a system as data: bodies with their shapes, coordinates, frames, points and loads, and their poses.

    Parameters
    ----------
    system : a System, or its Equations
    shapes : shapes of bodies and surroundings, from `kn.figures.shape`; shapes of other bodies are derived from inertias, points,
        joints and contacts

    Raises
    ------
    ArgumentError
        if `system` is neither a System nor Equations
    ModelError
        if a shape belongs to a body of another system
    """
    model = system_of(system)
    told = shapes_of(shapes)
    for s in told:
        if s.of is not None and all(s.of is not b for b in model.bodies):
            raise ModelError(f"Expected shapes of bodies of the system, got one of {s.of.name}.")
    into = Quantities(model.inertial)
    items = tuple(_items(model, told, into))
    moves, acts = tuple(movements(model, into)), tuple(actions(model, into))
    marks, triads, lengths = tuple(_marks(model, into)), tuple(_triads(model, into)), tuple(_lengths(model, into))
    return Scene(model, items, moves, acts, marks, triads, lengths, *into.tables())


def system_of(given: Any) -> System:
    """The system, given as such or by its equations."""
    if isinstance(given, Equations):
        return given.system
    return expect.instance(given, System, "a kn.System or its Equations to draw", error=ArgumentError)


def _items(system: System, told: tuple[BodyShape, ...], into: Quantities) -> Iterator[Item]:
    yield from ground_items(system, into)
    yield from (declared_item(s, into) for s in told)
    yield from body_items(system, into, {s.of.name for s in told if s.of is not None})
    yield from holding_items(system, into)
    yield from load_items(system, into)


def _marks(system: System, into: Quantities) -> Iterator[Mark]:
    """Points named by the user, the first of those at one position."""
    within, seen = of_beams(system), set[int]()
    for p in system.points:
        at = into.position(p)
        own = not p.name.endswith((" point", " ground", " particle")) and not p.name.startswith("end of ")
        if at not in seen and own and not p.name.startswith(within):
            seen.add(at)
            yield Mark(p.name, at, is_constant_in_time(into.place(p).components(into.inertial)))


def _triads(system: System, into: Quantities) -> Iterator[Triad]:
    """The axes of the inertial frame, and of bodies if they are few; for a body that spins about its axis, those without the spin."""
    origin = system.points[0].root() if system.points else None
    if origin is None:
        return
    yield Triad(system.inertial.name, into.frame(system.inertial), into.position(origin), True)
    shown: dict[Frame, Point] = {}
    bodies = [b for b in system.rigid_bodies if b.frame is not system.inertial]
    for b in bodies:
        shown.setdefault(_despun(system, b.frame), b.mass_center)
    for beam in system.bodies:
        if isinstance(beam, Beam):
            shown.setdefault(beam.frame, beam.root)
    for particle in system.bodies:  # for a particle on a massless rod, the frame of the rod
        if isinstance(particle, Particle):
            turned = [f for f, _ in particle.point.offset.parts if isinstance(f, Frame) and f is not system.inertial]
            shown.update({f: particle.point for f in turned[:1] if f not in shown})
    if len(shown) <= _MANY:
        for f, at in shown.items():
            if f is not system.inertial:
                yield Triad(f.name, into.frame(f), into.position(at))


def _despun(system: System, frame: Frame) -> Frame:
    """The frame in which a body spins, if speeds are written along its axes instead of the body's."""
    o = frame.orientation
    used = {f for f in system.frames if any(f in dict(p.offset.parts) for p in system.points)}
    if o is not None and o.axis is not None and isinstance(o.base, Frame) and frame not in used and o.base in used:
        return o.base
    return frame


def _lengths(system: System, into: Quantities) -> Iterator[tuple[str, int, int]]:
    """Distances between points equal to one parameter, once each: its name, the indices of both points."""
    seen: set[str] = set()
    for p in system.points:
        numbers = [x for x in p.offset.scalars() if x is not ZERO]
        numbers = [x.args[0] if len(x.args) == 1 and x.op.name == "neg" else x for x in numbers]
        if len(numbers) == 1 and isinstance(numbers[0], Parameter) and p.parent is not None:
            name = numbers[0].name
            if name not in seen:
                seen.add(name)
                yield name, into.position(p.parent), into.position(p)
