# SPDX-License-Identifier: BSD-3-Clause
"""Systems without bodies: frames and points with speeds and constraints, of which kinematics alone is asked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.symbols import Coordinate, Parameter, QuasiRate, Rate, Speed, Symbol, Symbols
from kane.model import checks
from kane.model.completed import completed
from kane.model.constraints import as_constraints
from kane.model.declarations import Declarations
from kane.model.loads import Load
from kane.model.survey import geometry, places
from kane.model.system import System
from kane.model.units import check_units
from kane.model.variables import (
    by_name,
    euler_sets,
    inputs_with_rates,
    moved,
    ordered_coordinates,
    speed_definitions,
)
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def scaffold(
    inertial: Frame,
    speeds: Mapping[Speed, Any] | str,
    of: Sequence[Frame | Point],
    holonomic: Any,
    nonholonomic: Any,
    dependent_speeds: Sequence[Speed | str],
    coordinates: Sequence[Coordinate | str] | None,
) -> System:
    """The system of frames and points; a coordinate that the definition of a speed has a rate of needs no place."""
    checks.check_inertial(inertial)
    constraints = (*as_constraints(holonomic, "configuration"), *as_constraints(nonholonomic, "motion"))
    frames, points = places(inertial, (), (placed(checks.listed("of", of)),), (), constraints)
    euler = euler_sets(frames)
    shape = list(geometry(frames, points))
    ordered = ordered_coordinates(free_symbols([*shape, *moved(speeds, constraints), *_moving(speeds)]), coordinates)
    vanishing = completed(definitions := speed_definitions(speeds, ordered, euler), ordered, euler, constraints)
    definitions |= vanishing
    watched = [c.expr for c in constraints]
    symbols = free_symbols([*shape, *definitions.values(), *watched])
    checks.check_geometry(free_symbols(shape))
    checks.check_strays(free_symbols(watched), ordered, definitions, euler)
    checks.check_names((*symbols, *definitions))
    dependent = Symbols((*by_name(dependent_speeds, definitions), *vanishing))
    checks.check_dependent("speeds", dependent, definitions, len(constraints), "dependent_speeds")
    parameters = Symbols(s for s in symbols if isinstance(s, Parameter))
    inputs = Symbols(inputs_with_rates(symbols, shape + list(definitions.values()), constraints))
    system = object.__new__(System)
    Declarations.__init__(
        system, inertial, (), definitions, {}, (), (), Symbols(()), Symbols(()), (), ordered, constraints, Symbols(()), dependent, (),
        euler, parameters, inputs, frames, points,
    )  # fmt: skip
    check_units(system, symbols)
    return system


def placed(items: Iterable[Any]) -> Load:
    """Nothing that acts at frames and points, so that what they are born from is found as it is for loads."""
    kept = list(items)
    for x in kept:
        if not isinstance(x, Frame | Point):
            raise ModelError(
                f"Expected frames and points of which motions are asked, got {cut(repr(x))}. Give a body's frame, or its mass_center."
            )
    nothing = Vector()
    return Load(
        "",
        forces=tuple((x, nothing) for x in kept if isinstance(x, Point)),
        torques=tuple((x, nothing) for x in kept if isinstance(x, Frame)),
    )


def _moving(speeds: Mapping[Speed, Any] | str) -> list[Symbol]:
    """The coordinates whose rates the definitions of speeds hold."""
    if not isinstance(speeds, Mapping):
        return []
    found: dict[Symbol, None] = {}
    for s in free_symbols(x for x in speeds.values() if hasattr(x, "op")):
        if isinstance(s, Rate) and isinstance(s.place, Coordinate):
            found[s.place] = None
        elif isinstance(s, QuasiRate) and isinstance(s.place, tuple):
            found.update((e, None) for e in s.place if isinstance(e, Coordinate))
    return list(found)
