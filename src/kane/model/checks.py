# SPDX-License-Identifier: BSD-3-Clause
"""Local checks of a system's declarations: what can be said before anything is derived."""

from collections.abc import Iterable, Mapping
from typing import Any

from kane import expect
from kane.errors import ModelError, ReactionError, cut
from kane.expr.node import Expr
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    QuasiRate,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbol,
    declared,
    input_of,
)
from kane.model.bodies import Body, Particle, RigidBody
from kane.model.constraints import Constraint
from kane.model.declarations import Event
from kane.model.joints.joint import Joint
from kane.model.loads import Gravity, Load
from kane.model.reactions import constraint_of, cut_of
from kane.model.variables import EulerParameters
from kane.space.frame import Frame


def listed(what: str, items: Any) -> tuple[Any, ...]:
    """What stands in a list."""
    return expect.items(items, f"{what}= to be a list", f"Write {what}=[…] around it.")


def check_listed(what: str, items: Iterable[Any], kind: type, made_by: str) -> None:
    """Items of one kind."""
    expect.instances(items, kind, f"{what}= made by {made_by}")


def check_inertial(frame: Any) -> None:
    """A root frame."""
    if not isinstance(frame, Frame) or frame.parent is not None:
        raise ModelError(
            f'Expected a root frame as the inertial frame, got {cut(repr(frame))}. Make one with kn.Frame("N") and give it first.'
        )


def check_loads(loads: Iterable[Any]) -> None:
    """Loads and gravity."""
    expect.instances(
        loads,
        (Load, Gravity),
        "loads from kn.Force, kn.Torque, kn.gravity, kn.linear_spring, …",
        "Say where it acts: kn.Force(point, vector), kn.Torque(frame, vector).",
    )


def check_bodies(bodies: tuple[Body, ...]) -> None:
    """At least one body, no two of one name."""
    if not bodies:
        raise ModelError("Expected at least one body, got none: nothing has mass.")
    for b in bodies:
        if not isinstance(b, RigidBody | Particle) and not isinstance(b, Body):
            raise ModelError(
                f"Expected bodies from kn.RigidBody or kn.Particle, got {cut(repr(b))}. A point or frame has no mass: "
                "make a body of it."
            )
    twice = _repeated([b.name for b in bodies])
    if twice:
        raise ModelError(
            f"Expected bodies of different names, got {', '.join(twice)} more than once. Results are read by name: rename one, or "
            "list it once."
        )


def check_events(events: Iterable[Any]) -> None:
    """Events, no two of one name: a motion names those that it met."""
    _check_named("events", events, Event, "kn.Event(name, quantity)")


def check_joints(joints: Iterable[Any]) -> None:
    """Joints, no two of one name."""
    _check_named("joints", joints, Joint, "kn.pin, kn.slider, …")


def _check_named(what: str, items: Iterable[Any], kind: type, made_by: str) -> None:
    check_listed(what, items, kind, made_by)
    expect.different((item.name for item in items), f"{what} of different names")


def _repeated(names: list[str]) -> list[str]:
    return sorted({n for n in names if names.count(n) > 1})


def check_names(symbols: Iterable[Symbol]) -> None:
    """No two symbols of one name."""
    first: dict[str, Symbol] = {}
    for s in symbols:
        if isinstance(s, Rate):
            continue
        other = first.setdefault(s.name, s)
        if other is not s:
            raise ModelError(
                f"Expected one symbol of the name {s.name!r}, got two with different declarations: {declared(other)} and "
                f"{declared(s)}. Declare it once and use it in both places, or rename one."
            )


def check_geometry(symbols: Iterable[Symbol]) -> None:
    """Positions and orientations are functions of coordinates, parameters and time."""
    for s in symbols:
        if isinstance(s, Speed | AuxiliarySpeed | Reaction | Rate | QuasiRate) and input_of(s) is None:
            raise ModelError(
                f"Expected positions and orientations in coordinates, parameters, inputs and kn.time, got {s} ({type(s).__name__}): "
                "a motion is described by coordinates, whose rates the speeds= define. Declare a kn.coordinate for it."
            )


def check_no_accelerations(symbols: Iterable[Symbol]) -> None:
    """Loads do not depend on accelerations."""
    for s in symbols:
        if isinstance(s, Rate) and not isinstance(s.place, Coordinate | StateVariable) and input_of(s) is None:
            raise ModelError(
                f"Expected loads in coordinates, rates, speeds, parameters, inputs and time, got {s}, which is not known before the "
                "equations are solved. Model a load that depends on an acceleration as mass or inertia."
            )


def check_strays(
    symbols: Iterable[Symbol],
    coordinates: tuple[Coordinate, ...],
    speeds: Mapping[Speed, Expr],
    euler: tuple[EulerParameters, ...],
) -> None:
    """Loads and events use the system's own symbols."""
    own: set[Symbol] = {*coordinates, *speeds, *(w for s in euler for w in s.quasi)}
    for s in symbols:
        origin: Any = s
        while isinstance(origin, Rate):
            origin = origin.place
        if isinstance(origin, Coordinate | Speed | QuasiRate) and origin not in own:
            raise ModelError(
                f"Expected loads, masses and events in symbols of the system, got {s}: no frame or point depends on it and it is not "
                "among the keys of speeds=. Use the system's own symbol, or a kn.parameter or kn.input for what is given."
            )


def check_reactions(
    symbols: Iterable[Symbol], reactions: tuple[Reaction, ...], auxiliary: tuple[AuxiliarySpeed, ...]
) -> None:
    """Each reaction in a load is listed; explicit auxiliary speeds and bare reactions are equally many."""
    listed = dict.fromkeys(reactions)
    if len(listed) < len(reactions):
        raise ReactionError("Expected each reaction once in reactions=, got one twice.")
    for s in symbols:
        if isinstance(s, Reaction) and s not in listed:
            raise ReactionError(f"The reaction {s} is used in a load but not listed: add it to System(reactions=[…]).")
    bare = [r for r in reactions if cut_of(r) is None and constraint_of(r) is None]
    if len(bare) != len(auxiliary):
        raise ReactionError(
            f"Expected as many explicit auxiliary speeds as reactions without a place, got {len(auxiliary)} and {len(bare)} "
            f"({', '.join(map(str, bare)) or 'none'}). Give the reaction a place: kn.reaction(name, at=point, along=direction)."
        )


def check_constraints(constraints: tuple[Constraint, ...], reactions: tuple[Reaction, ...]) -> None:
    """No two constraints of one name; every constraint whose multiplier is a reaction is the system's."""
    names = [c.name for c in constraints]
    expect.different(names, "constraints of different names", "Say name=… for each.")
    for r in reactions:
        c = constraint_of(r)
        if c is not None and c not in constraints:
            raise ReactionError(
                f"Expected the constraint of the reaction {r} among the system's ({', '.join(names) or 'none'}), got {c.name!r}. List "
                "it in holonomic= or nonholonomic=."
            )


def check_all_dependent(
    coordinates: tuple[Any, ...],
    ordered: Iterable[Any],
    speeds: tuple[Any, ...],
    definitions: Mapping[Any, Any],
    constraints: Iterable[Constraint],
) -> None:
    """No more dependent coordinates and speeds than constraints give, each the system's own."""
    kinds = [c.kind for c in constraints]
    check_dependent("coordinates", coordinates, ordered, kinds.count("configuration"), "dependent_coordinates")
    check_dependent("speeds", speeds, definitions, len(kinds), "dependent_speeds")


def check_dependent(what: str, dependent: tuple[Any, ...], own: Iterable[Any], most: int, argument: str) -> None:
    """Dependent coordinates or speeds are the system's own, each once, and as many as the constraints can fix."""
    names = ", ".join(map(str, dependent))
    strangers = [str(s) for s in dependent if s not in set(own)]
    if strangers or len(set(dependent)) < len(dependent):
        raise ModelError(f"Expected {argument}= to list {what} of the system, each once, got {names}.")
    if len(dependent) > most:
        raise ModelError(
            f"Expected at most {most} dependent {what}, one a constraint, got {len(dependent)} in {argument}=: {names}. Leave it "
            "out to have them chosen."
        )
