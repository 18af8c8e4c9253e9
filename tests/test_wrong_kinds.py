# SPDX-License-Identifier: BSD-3-Clause
"""A thing of another kind in each argument of what one declares with: taken where it has a meaning, else an error of the library."""

from __future__ import annotations

import contextlib
import inspect
import itertools
import math
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
Q1, Q2, Q3 = kn.coordinates("q1:4")
U1, U2 = kn.speeds("u1:3")
M = kn.parameter("m", 1.0)
A = N.rotate("A", Q1, N.z)
P = O.at("P", M * A.x)
Q = O.at("Q", Q2 * N.x + N.y)
K = P.fixed_in(A, "K", M * A.y)
I = kn.inertia(A, 1, 1, 1)
BODY = kn.RigidBody("b", frame=A, mass_center=P, mass=M, inertia=I)
PIN, NEXT, RAIL = kn.pin("J", O, N, axis=N.z), kn.pin("J2", P, A, axis=A.z), kn.slider("S", O, N, axis=N.x)
LOAD = kn.Force(P, N.x)
HELD = kn.coincident(P, Q, along=N.x)
SYSTEM = kn.System(N, bodies=[BODY, kn.Particle("p", Q, M)], speeds={U1: Q1.dt, U2: Q2.dt}, loads=[kn.gravity(-N.y)])
EOM = kn.derive(SYSTEM)
MOTION = kn.simulate(EOM, (0, 0.01), q=[0.1, 0.2], u=[0, 0], samples=3)
NORMAL = kn.reaction("R", at=P, along=N.z)
MOVED = kn.simulate(EOM, (0, 0.01), q=[0.1, 0.2], u=[0, 0], samples=2)
MOVED_ON = kn.simulate(EOM, 0.02, start=MOVED, samples=2)

CALLS: list[tuple[Any, tuple[Any, ...], dict[str, Any]]] = [
    (kn.Frame, ("B",), {}),
    (kn.Point, ("O2",), {"fixed_in": N}),
    (O.at, ("P9", N.x), {}),
    (P.fixed_in, (A, "P8", N.x), {}),
    (P.position, (O,), {}),
    (P.velocity, (N,), {}),
    (P.acceleration, (N,), {}),
    (N.rotate, ("B", Q1, N.z), {}),
    (N.rotate_body, ("B", (Q1, Q2, Q3), "xyz"), {}),
    (N.rotate_space, ("B", (Q1, Q2, Q3), "xyz"), {}),
    (A.angular_velocity, (N,), {}),
    (A.angular_acceleration, (N,), {}),
    (P.velocity, (A, O), {}),
    (P.acceleration, (A, O), {}),
    (A.simple_rotation, (N,), {}),
    (A.x.diff, (Q1, N), {}),
    (A.dcm, (N,), {}),
    (N.x.dot, (N.y,), {}),
    (N.x.cross, (N.y,), {}),
    (N.x.outer, (N.y,), {}),
    (N.x.express, (N,), {}),
    (N.x.components, (N,), {}),
    (N.x.dt, (N,), {}),
    (N.x.reject, (N.y,), {}),
    (I.dot, (N.x,), {}),
    (I.express, (N,), {}),
    (kn.RigidBody, ("b",), {"frame": A, "mass_center": P, "mass": M, "inertia": I}),
    (kn.Particle, ("p", P, M), {}),
    (kn.inertia, (A, 1, 1, 1), {}),
    (kn.rod, (A, M, M, A.x), {}),
    (kn.box, (A, M, 1, 1, 1), {}),
    (kn.solid_sphere, (A, M, 1), {}),
    (kn.ellipsoid, (A, M, 1, 2, 3), {}),
    (kn.torus, (A, M, 2, 1, A.z), {}),
    (kn.frustum, (A, M, 2, 1, 3, A.z), {}),
    (kn.half_cylinder, (A, M, 1, 2, A.z, A.x), {}),
    (kn.hemisphere, (A, M, 1, A.z), {}),
    (kn.rectangular_plate, (A, M, 1, 2), {}),
    (kn.right_triangle, (A, M, 1, 2), {}),
    (kn.triangular_plate, (A, M, A.x, A.y), {}),
    (kn.circular_sector, (A, M, 1, 1, A.z, A.x), {}),
    (kn.circular_arc, (A, M, 1, 1, A.z, A.x), {}),
    (kn.parallel_axis, (I, M, N.x), {}),
    (kn.central_inertia, (I, M, N.x), {}),
    (kn.mass_center, ([BODY], O), {}),
    (kn.inertia_about, ([BODY], O), {}),
    (kn.inertia_matrix, ([BODY], O, A), {}),
    (kn.inertia_vector, ([BODY], O, A.x), {}),
    (kn.moment_of_inertia, ([BODY], O, A.x), {}),
    (kn.product_of_inertia, ([BODY], O, A.x, A.y), {}),
    (kn.radius_of_gyration, ([BODY], O, A.x), {}),
    (kn.composite, ("c", [BODY], A), {"without": ()}),
    (kn.principal, (I, A), {"values": {}}),
    (kn.Force, (P, N.x), {}),
    (kn.Torque, (A, N.x), {}),
    (kn.gravity, (-N.y,), {}),
    (kn.linear_spring, (P, Q, M, 1), {}),
    (kn.linear_damper, (P, Q, M), {}),
    (kn.torsional_spring, (A, N, Q1, M, N.z, 0), {}),
    (kn.torsional_damper, (A, N, M, N.z), {}),
    (kn.gravitation, (BODY, kn.Particle("far", Q, M), 1), {}),
    (kn.gravity_moment, (BODY, N.x, 1), {}),
    (kn.buoyancy, (P, M, 1, -N.y), {}),
    (kn.linear_drag, (P, M), {"medium": N.x}),
    (kn.quadratic_drag, (P, M), {"medium": N.x}),
    (kn.line_load, (A, P, A.x, N.y), {"degree": 1}),
    (kn.pressure_on_rectangle, (A, P, A.x, A.y, M), {"degree": 1}),
    (kn.pressure_on_disk, (A, P, A.z, 1, M), {"degree": 1, "across": A.x}),
    (kn.force_system, ([LOAD],), {"bodies": ()}),
    (kn.force_system(LOAD).moment, (O,), {}),
    (kn.force_system(LOAD).wrench, (O,), {}),
    (kn.force_system(LOAD).is_equivalent, (kn.force_system(LOAD),), {}),
    (kn.action_reaction, (P, Q, N.x), {}),
    (kn.torque_pair, (A, N, N.z), {}),
    (kn.friction, (K, NORMAL, 0.3), {}),
    (kn.coincident, (P, Q), {"along": N.x}),
    (kn.distance, (P, Q, 1), {}),
    (kn.perpendicular, (A.x, N.x), {}),
    (kn.parallel, (A.x, N.x), {"across": (N.y, N.z)}),
    (kn.no_slip, (K, Q), {"along": N.x}),
    (kn.touching, (K, O), {"normal": N.y}),
    (kn.rolling, (K, Q), {"normal": N.y, "along": N.x}),
    (kn.configuration_constraint, ("c", Q1), {}),
    (kn.motion_constraint, ("c", Q1.dt), {}),
    (kn.pin, ("j", O, N), {"axis": N.z, "child": "c", "coordinates": "x", "speeds": "v"}),
    (kn.slider, ("j", O, N), {"axis": N.z}),
    (kn.universal, ("j", O, N), {"axes": (N.x, N.y)}),
    (kn.planar, ("j", O, N), {"normal": N.z}),
    (kn.ball, ("j", O, N), {"coordinates": "a b c d"}),
    (kn.free, ("j", O, N), {}),
    (kn.screw, ("j", O, N), {"axis": N.z, "pitch": 1}),
    (kn.close_pin, ("g", O, N, P, A), {"axis": N.z}),
    (kn.close_ball, ("g", O, N, P, A), {}),
    (kn.sphere_on_plane, ("c", A, Q, O), {"radius": 1, "normal": N.y}),
    (kn.disk_on_plane, ("c", A, Q, O), {"axis": A.z, "radius": 1, "normal": N.y}),
    (kn.contact, (kn.joints.sphere_on_plane("c", A, Q, O, radius=1, normal=N.x), 0.3), {"restitution": 0.5, "name": "c"}),
    (kn.joints.torus_on_plane, ("c", A, Q, O), {"axis": A.z, "radius": 1, "crown": 0.1, "normal": N.y}),
    (kn.joints.sphere_on_sphere, ("c", A, Q, N, O), {"radius": 1, "other_radius": 1, "inside": False, "pole": N.z}),
    (kn.joints.sphere_on_cylinder, ("c", A, Q, N, O), {"axis": N.z, "radius": 1, "cylinder_radius": 1, "inside": False}),
    (kn.joints.capsule_on_plane, ("c", A, [Q, P], O), {"radius": 1, "normal": N.y}),
    (kn.joints.corners_on_plane, ("c", [K], O), {"normal": N.y, "along": N.x, "surface": N.x}),
    (kn.joints.point_on_plane, ("c", K, O), {"normal": N.y, "along": N.x, "surface": N.x}),
    (kn.joints.rope, ("c", [O, Q], 2), {"restitution": 0, "law": "newton"}),
    (kn.joints.stop, ("c", Q1), {"restitution": 0, "law": "newton"}),
    (kn.joints.stiction, (PIN, 1), {"static": 2, "viscous": 0, "name": "c"}),
    (kn.joints.clutch, ("c", A, N, N.z, 1), {"static": 2, "viscous": 0}),
    (kn.joints.stribeck, (0.3, 0.4, 0.1), {}),
    (kn.joints.weld, ("j", O, N), {"child": "c"}),
    (kn.loads.dry_friction, (PIN, 1), {"threshold": 1e-3, "name": "c"}),
    (kn.gear_pair, ("g", PIN, NEXT), {"teeth": (1, 2)}),
    (kn.bevel_pair, ("g", PIN, kn.pin("J3", O, N, axis=N.x)), {"teeth": (1, 2), "radius": 1, "apex": O, "phase": 0}),
    (kn.worm_pair, ("g", PIN, kn.pin("J4", O.at("J4", 2 * N.y), N, axis=N.x)), {"teeth": (40, 2), "radius": 1, "phase": 0}),
    (kn.rack_and_pinion, ("g", PIN, RAIL), {"radius": 1}),
    (kn.reaction, ("R",), {"at": P, "along": N.z}),
    (kn.auxiliary_speed, ("ua",), {"at": P, "along": N.z}),
    (kn.Event, ("e", Q1), {"threshold": 0.5, "direction": -1, "terminal": False, "message": "m", "then": {U1: -U1}}),
    (
        kn.System,
        (N,),
        {"bodies": [BODY], "speeds": {U1: Q1.dt}, "loads": [LOAD], "coordinates": (Q1,)}
        | dict.fromkeys(("holonomic", "nonholonomic", "joints", "reactions", "events", "auxiliary_speeds"), ())
        | dict.fromkeys(("dependent_speeds", "dependent_coordinates"), ()) | {"states": {kn.state("a"): U1}},
    ),
    (kn.motions, (N, {U1: Q1.dt}), {"of": (A,), "holonomic": (), "nonholonomic": (), "dependent_speeds": (), "coordinates": (Q1,)}),
    (kn.motions(N, {U1: Q1.dt, U2: Q2.dt}).velocity, (P, A, O), {}),
    (kn.motions(N, {U1: Q1.dt, U2: Q2.dt}).angular_velocity, (A, N), {}),
    (kn.derive, (SYSTEM,), {"near": {}}),
    (kn.simulate, (EOM, (0, 0.01)), {"q": [0.1, 0.2], "u": [0, 0], "parameters": {}, "inputs": {}, "samples": 2, "states": {}}),
    (kn.simulate, (EOM, 0.02), {"start": MOVED, "method": "auto", "rtol": 1e-9, "atol": 1e-9, "max_step": 0.01, "breakpoints": ()}),
    (MOVED.__add__, (MOVED_ON,), {}),
    (kn.assemble, (EOM,), {"q": [0.1, 0.2], "u": [0, 0], "parameters": {}}),
    (kn.evaluate, (Q1, {Q1: 1.0}), {}),
    (kn.substitute, (Q1, {Q1: M}), {}),
    (kn.diff, (Q1**2, Q1), {}),
    (kn.affine, (Q1, [Q1]), {}),
    (kn.coordinate, ("a", "m", "d"), {}),
    (kn.parameter, ("a", 1.0, "m", "d"), {}),
    (kn.speed, ("a", "m/s"), {}),
    (kn.coordinates, ("a b", "m"), {}),
    (kn.input, ("F", "N"), {}),
    (kn.state, ("a", 0.0, "N", "d"), {}),
    (kn.where, (kn.less(Q1, 1), Q1, 1), {}),
    (kn.mode_shapes, ("clamped-free", 2), {}),
    (kn.tapered, (M, lambda xi: 1 - 0.5 * xi), {}),
    (kn.sin, (Q1,), {}),
    (kn.unit_of, (Q1,), {}),
    (kn.gradient, (Q1**2, [Q1]), {}),
    (kn.jacobian, ([Q1**2], [Q1]), {}),
    (kn.time_derivative, (Q1**2,), {}),
    (kn.taylor, (Q1**2, {Q1: 0}, 2), {}),
    (kn.solve_linear, (kn.Matrix([[2, 1], [1, 3]]), [1, 2]), {}),
    (kn.free_symbols, ([Q1],), {}),
    (kn.count_operations, ([Q1],), {}),
    (kn.to_text, (Q1,), {}),
    (kn.to_latex, (Q1,), {}),
    (kn.Matrix, ([[1, 2]],), {}),
    (kn.Rational, (1, 2), {}),
    (kn.max, (Q1, 2), {}),
    (kn.table, ([0, 1], [0, 1]), {"kind": "linear", "name": "t", "unit": "N", "of": "m"}),
    (kn.signal, ([0, 1, 2], [0, 1, 0]), {}),
    (kn.sampled, (lambda t, x: 0.0,), {"period": 0.1}),
    (kn.guess, (1.0,), {}),
    (kn.Rotation.from_angles, ("zxz", (1, 2, 3)), {}),
    (kn.Rotation.from_axis_angle, ((1, 0, 0), 1.0), {}),
    (kn.Rotation.from_euler_parameters, ((1, 0, 0, 0),), {}),
    (kn.small_rotation, ((Q1, Q2, Q3),), {}),
    (kn.Load.from_potential, (Q1**2, "V"), {}),
    (kn.compare_methods, (SYSTEM,), {"methods": ["kane"]}),
    (kn.compare_speeds, (SYSTEM, {}), {}),
    (EOM.by, ("lagrange",), {}),
    (EOM.contributions, ("u1",), {}),
    (EOM.mass_contributions, ("u1", "u2"), {}),
    (EOM.steady_conditions, ({Q1: 0},), {}),
    (EOM.time_derivative, (Q1,), {}),
    (EOM.unit, (Q1,), {}),
    (EOM.evaluate, (Q1,), {"q": [0.1, 0.2], "u": [0, 0], "parameters": {}, "inputs": {}, "t": 0.0}),
    (EOM.operational_mobility, (P,), {"along": [N.x]}),
    (EOM.jacobian, ("time",), {}),
    (EOM.speeds_from_rates, ([0.1, 0.2], [0, 0]), {"parameters": {}, "t": 0}),
    (EOM.find_potential, (["gravity"],), {}),
    (EOM.generalized_impulses, ([(P, N.x)],), {}),
    (EOM.angular_momentum, (O,), {}),
    (MOTION.__getitem__, (Q1,), {}),
    (kn.plot, (MOTION, Q1), {}),
]  # fmt: skip
ANALYSES: list[tuple[Any, tuple[Any, ...], dict[str, Any]]] = [
    (kn.impact, (EOM, P, N.x), {"restitution": 0.5, "q": [0.1, 0.2], "u": [1, 1]}),
    (kn.trim, (EOM,), {"q": [0.1, 0.2], "u": [0, 0]}),
    (kn.equilibrium, (EOM,), {"q": [0.1, 0.2]}),
    (kn.linearize, (EOM,), {"q": [0.1, 0.2], "u": [0, 0]}),
    (kn.linearizer, (EOM,), {}),
    (kn.linearize_symbolic, (EOM, {Q1: 0}), {}),
    (kn.continuation, (EOM, "m", [1, 2]), {"q": [0.1, 0.2], "u": [0, 0]}),
    (kn.inverse, (EOM, ["u1'", "u2'"]), {}),
    (kn.constraint_forces, (EOM,), {"q": [0.1, 0.2], "u": [0, 0]}),
    (kn.report, (EOM, "never.html"), {"solution": 1}),
]
"""What may end in an error of the library as it stands."""
WRONG = (A, P, M, Q2, 1, None, "x", BODY, A.x, [1, 2], PIN, LOAD, HELD, I)
ODD: tuple[Any, ...] = (
    -1.0, 0, math.nan, math.inf, 1 + 2j, True, np.float16(0.5), np.int8(1), np.array(1.0), np.array([1.0, 2.0]), np.array(Q1), 10**400,
    "", b"x", [], {}, {1}, [[]], Decimal("0.1"), Fraction(1, 3), 0 * N.x, 2 * N.x,
)  # fmt: skip
"""Numbers of other kinds, or out of range, and things that are empty."""


def name_of(call: Any) -> str:
    return str(getattr(call[0], "__qualname__", call[0]))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::kane.KaneWarning")
@pytest.mark.parametrize("call", CALLS, ids=name_of)
def test_another_kind_is_named(call):
    make, args, named = call
    make(*args, **named)
    _tried_with_all(make, args, named)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::kane.KaneWarning")
@pytest.mark.parametrize("call", ANALYSES, ids=name_of)
def test_analyses_name_another_kind(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _tried_with_all(*call)


@pytest.mark.parametrize(
    "made", [MOTION, EOM.jacobian(), kn.compare_methods(SYSTEM, ["kane"]), kn.compare_speeds(SYSTEM, {}), SYSTEM]
)
def test_loops_over_what_has_subscripts_end(made):
    with contextlib.suppress(kn.KaneError):
        assert len(list(itertools.islice(made, 100))) < 100
    with contextlib.suppress(kn.KaneError):
        assert ("nothing of the kind" in made) is False


def test_samples_are_no_subscripts_of_a_motion():
    for place in (0, -1, 1.5, slice(2)):
        with pytest.raises(kn.ArgumentError, match="the rows of sol"):
            MOTION[place]
    assert MOTION["q1"].shape == MOTION[kn.Rational(1)].shape == (3,)


def test_systems_of_equations_are_square():
    for a, b in (([[2, 1, 1], [1, 3, 1]], [1, 2]), ([[2, 1], [1, 3]], [1, 2, 3]), ([[2, 1], [1, 3]], [1])):
        with pytest.raises(kn.ExpressionError, match="square matrix and as many right-hand sides"):
            kn.solve_linear(kn.Matrix(a), b)
    assert kn.evaluate(kn.solve_linear([[2, 1], [1, 3]], [1, 2]), {}) == pytest.approx([0.2, 0.6])


def _tried_with_all(make: Any, args: Any, named: Any) -> None:
    for wrong in WRONG + ODD:
        for k in range(len(args)):
            _tried(make, (*args[:k], wrong, *args[k + 1 :]), named)
        for k in named:
            _tried(make, args, {**named, k: wrong})


def _tried(make: Any, args: tuple[Any, ...], named: dict[str, Any]) -> None:
    with contextlib.suppress(kn.KaneError):
        make(*args, **named)


def test_every_function_that_declares_is_tried():
    tried = {getattr(call[0], "__name__", "") for call in CALLS}
    declare = {
        n
        for n, made in vars(kn).items()
        if n in kn.__all__ and inspect.isfunction(made) and made.__module__.startswith("kane.model")
    }
    alike = {n for n in declare if n.startswith("close_")} | {
        "thin_disk", "ring", "spherical_shell", "solid_cylinder", "cylindrical_shell", "solid_cone", "cylindrical", "weld",
        "dry_friction",
    }  # fmt: skip
    assert declare <= tried | alike
