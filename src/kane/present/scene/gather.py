# SPDX-License-Identifier: BSD-3-Clause
"""`scene`: all that can be drawn of a system, from its declarations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from kane import expect
from kane.equations.equations import Equations
from kane.errors import ArgumentError, ModelError
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ZERO
from kane.expr.symbols import Parameter
from kane.model.beams.beam import Beam
from kane.model.bodies import Particle
from kane.model.system import System
from kane.present.scene.default_shapes import body_items, ground_items, holding_items, of_beams
from kane.present.scene.moves import actions, center_of, load_items, movements
from kane.present.scene.records import Item, Mark, Quantities, Scene, Triad
from kane.present.scene.shapes import BodyShape, declared_item, shapes_of
from kane.space.frame import Frame, Point

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


__all__ = ["center_of", "scene", "system_of"]
