# SPDX-License-Identifier: BSD-3-Clause
"""Quantities outside of their range, and arguments of the wrong kind, are refused where they are declared."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
HINGE = kn.pin("hinge", O, N, axis=N.z)
A = HINGE.frame
P = HINGE.point.at("P", A.x)
RACK = kn.slider("rack", O, N, axis=N.x)
CROSSED = kn.pin("crossed", O, N, axis=N.x)
PLACE = kn.joints.point_on_plane("corner", P, O, normal=N.y)
PUSH = kn.reaction("push", at=P, along=A.y)

LOAD = kn.Force(P, kn.input("F") * N.x, name="load")
EOM = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], joints=[HINGE], loads=[LOAD]))

MASS = {"mass": 2.0}
R, H = {"radius": 0.3}, {"height": 0.7}
SOLIDS: dict[str, dict[str, Any]] = {
    "rod": {"length": 0.4, "axis": A.x},
    "thin_disk": {**R, "axis": A.x},
    "ring": {**R, "axis": A.x},
    "solid_sphere": R,
    "spherical_shell": R,
    "solid_cylinder": {**R, **H, "axis": A.x},
    "cylindrical_shell": {**R, **H, "axis": A.x},
    "solid_cone": {**R, **H, "axis": A.x},
    "torus": {**R, "tube": 0.1, "axis": A.x},
    "frustum": {"base": 0.3, "top": 0.2, **H, "axis": A.x},
    "hemisphere": {**R, "axis": A.x},
    "half_cylinder": {**R, **H, "axis": A.x, "towards": A.y},
    "circular_sector": {**R, "half_angle": 1.0, "normal": A.x, "towards": A.y},
    "circular_arc": {**R, "half_angle": 1.0, "normal": A.x, "towards": A.y},
    "box": {"a": 0.1, "b": 0.2, "c": 0.3},
    "ellipsoid": {"a": 0.1, "b": 0.2, "c": 0.3},
    "rectangular_plate": {"a": 0.1, "b": 0.2},
    "right_triangle": {"a": 0.1, "b": 0.2},
    "triangular_plate": {"p": A.x, "q": A.y},
}


def solid(kind: str, **changed: Any) -> kn.Dyadic:
    made: kn.Dyadic = getattr(kn.solids, kind)(A, **{**MASS, **SOLIDS[kind], **changed})
    return made


SHAPED = ("height", "half_angle")
NUMBERS = [
    (kind, name) for kind, args in SOLIDS.items() for name, x in {**MASS, **args}.items() if isinstance(x, float)
]


@pytest.mark.parametrize(("kind", "name"), NUMBERS)
def test_solids_refuse_sizes_that_no_solid_has(kind: str, name: str) -> None:
    words = name.replace("_", " ")
    solid(kind, **{name: kn.parameter("x")})
    with pytest.raises(kn.ModelError, match=f"{words} of the .* zero, got -0.5"):
        solid(kind, **{name: -0.5})
    with pytest.raises(kn.ModelError, match=f"{words} of the .* zero, got x = -2"):
        solid(kind, **{name: kn.parameter("x", -2.0)})
    with pytest.raises(kn.ExpressionError):
        solid(kind, **{name: math.nan})


@pytest.mark.parametrize("kind", [k for k, args in SOLIDS.items() if any(isinstance(x, float) for x in args.values())])
def test_a_solid_without_extent_is_a_point(kind: str) -> None:
    sizes = {name: 0.0 for name, x in SOLIDS[kind].items() if isinstance(x, float) and name != "half_angle"}
    if kind == "frustum":  # whose moments are 0/0
        with pytest.raises(kn.ModelError, match=r"sum of the radii of the frustum above zero, got 0"):
            solid(kind, **sizes)
    else:
        assert str(solid(kind, **sizes)) == "0"


@pytest.mark.parametrize("kind", [k for k, args in SOLIDS.items() if "axis" in args])
def test_a_solid_of_revolution_needs_its_axis(kind: str) -> None:
    with pytest.raises(kn.ModelError, match="unit vector"):
        solid(kind, axis=None)


@pytest.mark.parametrize("kind", ["circular_sector", "circular_arc"])
@pytest.mark.parametrize("half", [180.0, math.pi * (1 + 1e-9), kn.parameter("alpha", 4.0)])
def test_a_sector_is_not_more_than_a_disk(kind: str, half: Any) -> None:
    with pytest.raises(kn.ModelError, match=r"π less the half angle .* in rad"):
        solid(kind, half_angle=half)


def test_shapes_that_overlap_or_are_flat() -> None:
    with pytest.raises(kn.ModelError, match="radius of the torus less that of its tube"):
        solid("torus", tube=0.31)
    with pytest.raises(kn.ModelError, match="edges of a triangle in different directions"):
        solid("triangular_plate", q=2 * A.x)


SIGNS = {
    "stiffness": lambda x: kn.linear_spring(O, P, x),
    "damping": lambda x: kn.linear_damper(O, P, x),
    "stiffness of torsion": lambda x: kn.torsional_spring(A, N, HINGE.coordinates[0], x, N.z),
    "damping of torsion": lambda x: kn.torsional_damper(A, N, x, N.z),
    "drag": lambda x: kn.loads.linear_drag(P, x),
    "quadratic drag": lambda x: kn.loads.quadratic_drag(P, x),
    "density": lambda x: kn.loads.buoyancy(P, x, 1, -N.y),
    "volume": lambda x: kn.loads.buoyancy(P, 1, x, -N.y),
    "gravitation": lambda x: kn.loads.gravitation(kn.Particle("a", O, 1), kn.Particle("b", P, 1), x),
    "radius under pressure": lambda x: kn.loads.pressure_on_disk(A, P, A.z, x, 1),
    "pinion": lambda x: kn.joints.rack_and_pinion("g", HINGE, RACK, radius=x),
    "bevel": lambda x: kn.joints.bevel_pair("g", HINGE, CROSSED, teeth=(10, 20), radius=x),
    "sphere": lambda x: kn.joints.sphere_on_sphere("s", A, P, N, O, radius=x, other_radius=2),
    "rod between points": lambda x: kn.distance(O, P, x),
    "mass of a particle": lambda x: kn.Particle("a", P, x),
    "friction": lambda x: kn.friction(P, PUSH, x, along=N.z),
    "size of a shape": lambda x: kn.figures.shape("sphere", of=kn.Particle("s", P, 1), radius=x),
    "Stribeck": lambda x: kn.joints.stribeck(x, x, 0.1),
}  # fmt: skip


@pytest.mark.parametrize("what", SIGNS)
def test_coefficients_of_the_wrong_sign(what: str) -> None:
    make = SIGNS[what]
    make(0.5)
    make(kn.parameter("c"))
    for wrong in (-0.5, kn.parameter("c", -0.5)):
        with pytest.raises(kn.ModelError, match=r"Expected .*(zero|≥ 0).*, got .*-0.5.*\.$"):
            make(wrong)


NAMED = {
    "body": lambda x: kn.RigidBody(x, frame=A, mass_center=P, mass=1, inertia=kn.inertia(A, 1, 1, 1)),
    "particle": lambda x: kn.Particle(x, P, 1),
    "force": lambda x: kn.Force(P, N.x, x),
    "gravity": lambda x: kn.gravity(-N.y, x),
    "spring": lambda x: kn.linear_spring(O, P, 1, name=x),
    "damper": lambda x: kn.linear_damper(O, P, 1, x),
    "drag": lambda x: kn.loads.linear_drag(P, 1, name=x),
    "potential": lambda x: kn.loads.Load.from_potential(HINGE.coordinates[0], x),
    "distance": lambda x: kn.distance(O, P, 1, name=x),
    "coincident": lambda x: kn.coincident(O, P, N.x, name=x),
    "constraint": lambda x: kn.configuration_constraint(x, HINGE.coordinates[0]),
    "motion": lambda x: kn.motion_constraint(x, HINGE.coordinates[0].dt),
    "corners": lambda x: kn.joints.corners_on_plane(x, [P], O, normal=N.y),
    "contact": lambda x: kn.contact(PLACE, name=x),
}  # fmt: skip


@pytest.mark.parametrize("what", NAMED)
@pytest.mark.parametrize("wrong", [1, ["a"], b"a", N], ids=lambda x: type(x).__name__)
def test_a_name_is_a_text(what: str, wrong: Any) -> None:
    with pytest.raises(kn.ModelError, match="Expected a text"):
        NAMED[what](wrong)


LISTS = {
    "bodies": lambda x: kn.System(N, bodies=x, speeds="rates"),
    "loads": lambda x: kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds="rates", loads=x),
    "masses": lambda x: kn.solids.mass_center(x, O),
    "forces": lambda x: kn.loads.force_system(x),
    "directions": lambda x: kn.coincident(O, P, x),
    "slip": lambda x: kn.no_slip(P, along=x),
    "corners": lambda x: kn.joints.corners_on_plane("c", x, O, normal=N.y),
    "orientation": lambda x: kn.ball("b", O, N, orientation=x),
    "coordinates": lambda x: kn.pin("p", O, N, axis=N.z, coordinates=x),
    "names": lambda x: kn.coordinates(x),
    "matrix": lambda x: kn.Matrix(x),
    "roots": lambda x: kn.jacobian(x, [HINGE.coordinates[0]]),
    "table": lambda x: kn.table(x, x),
}  # fmt: skip


@pytest.mark.parametrize("what", LISTS)
@pytest.mark.parametrize("wrong", [np.array(1.0), b"ab", 10**400, ...], ids=["0-d", "bytes", "huge", "ellipsis"])
def test_what_is_no_list(what: str, wrong: Any) -> None:
    with pytest.raises(kn.KaneError, match="Expected "):
        LISTS[what](wrong)


def test_texts_are_no_numbers() -> None:
    texts: Any = ["0", "1"]
    with pytest.raises(kn.ExpressionError, match="numbers as the points of a table"):
        kn.table(texts, [0, 1])
    with pytest.raises(kn.SimulationError, match="a time span"):
        kn.simulate(EOM, texts, q=0, u=0, inputs={"F": 0})


def test_an_input_without_a_value_is_named() -> None:
    with pytest.raises(kn.SimulationError, match="load is undefined here, as F is nan"):
        kn.simulate(EOM, (0, 1), q=0, u=0, inputs={"F": lambda t: math.nan})


@pytest.mark.parametrize("empty", [[], "", ()])
def test_a_constraint_has_a_direction(empty: Any) -> None:
    with pytest.raises(kn.ModelError, match="unit vector"):
        kn.coincident(O, P, empty)


@pytest.mark.parametrize(
    ("kind", "name", "value", "message"),
    [
        ("solid_cone", "height", -0.1, "the height of the solid cone 'body' at or above zero, got size = -0.1"),
        ("torus", "tube", 0.4, "the radius of the torus less that of its tube 'body' .*got 0.3 - size = -0.1"),
        ("circular_arc", "half_angle", 4.0, r"π less the half angle of the circular arc 'body' .*got .* = -0.858"),
        ("rod", "length", -0.1, "the length of the rod 'body' at or above zero, got size = -0.1"),
    ],
)  # fmt: skip
def test_sizes_at_values_of_parameters(kind: str, name: str, value: float, message: str) -> None:
    inertia = solid(kind, **{name: kn.parameter("size", 0.1)})
    body = kn.RigidBody("body", frame=A, mass_center=P, mass=1, inertia=inertia)
    eom = kn.derive(kn.System(N, bodies=[body], joints=[HINGE]))
    kn.simulate(eom, (0, 0.1), q=0, u=0, parameters={"size": 0.15})
    with pytest.raises(kn.SimulationError, match=f"Expected {message}.* at the values of the parameters"):
        kn.simulate(eom, (0, 0.1), q=0, u=0, parameters={"size": value})


def test_friction_at_values_of_parameters() -> None:
    mu, size = kn.parameter("mu", 0.3), kn.parameter("size", 0.1)
    block = O.at("B", kn.coordinate("x") * N.x).at("block", 0)
    weight = kn.reaction("weight", at=block, along=N.y)
    slides = {"bodies": [kn.Particle("b", block, 1)], "speeds": "rates", "reactions": [weight]}
    brake = kn.loads.dry_friction(HINGE, size)
    for system, given in (
        (kn.System(N, **slides, loads=[kn.gravity(-9.81 * N.y), kn.friction(block, weight, mu)]), mu),
        (kn.System(N, bodies=[kn.Particle("p", P, 1)], joints=[HINGE], loads=[brake]), size),
    ):
        eom = kn.derive(system)
        kn.simulate(eom, (0, 0.01), q=0, u=[1], parameters={given: 0.2})
        with pytest.raises(kn.SimulationError, match=f"a size ≥ 0 of .*friction.*, got {given} = -0.2"):
            kn.simulate(eom, (0, 0.01), q=0, u=[1], parameters={given: -0.2})
