# SPDX-License-Identifier: BSD-3-Clause
"""Never silently wrong: model files with one slip each, and what `kane check` says of them.

`BAD` has a row for each slip in `bad.SLIPS`: what the message must say, in the user's own names, with what came and the cure, and
the line of the file it points at. `COVERED` maps the mistakes that must be named to the rows and, for those that arise only
when running, to tests at the interface.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import kane as kn
from kane.cli import LINES
from tests.cli import bad
from tests.cli.command import from_json, kane, line, written

TESTS = Path(__file__).resolve().parents[1]


class Bad(NamedTuple):
    """Exit code, category as `--json` names it ("Warning" for what can be computed), words of the message, text of the line."""

    code: int
    kind: str
    words: tuple[str, ...]
    at: str = ""


def error(kind: str, *words: str, at: str = "kn.System(") -> Bad:
    return Bad(1, kind, words, at)


def warning(*words: str, at: str = "") -> Bad:
    return Bad(0, "Warning", words, at)


BAD: dict[str, Bad] = {
    # the speeds
    "speed_nonlinear": error("SpeedsError", "definition of u2 to be linear in the rates", "got q'^2", "Take a rate such as q.dt"),
    "speed_forgot_dt": error("SpeedsError", "definition of u2 to contain a rate, got q.", "Write q.dt for the rate of q"),
    "speed_of_another": error("SpeedsError", "every rate in some speed's definition, got none with q'", "Define a speed for each"),
    "speeds_too_few": error("SpeedsError", "independent rates, 2: x', q'; got 1: u1", "Define 1 more"),
    "speeds_too_many": error("SpeedsError", "independent rates, 2: x', q'; got 3: u1, u2, u3", "Leave 1 of them out"),
    "speeds_dependent": error("SpeedsError", "combination of u2, u3 that vanishes", "u3 = 2*(", "Define one of them differently"),
    "speeds_as_list": error("SpeedsError", "speeds= to be a dict", "got [x', q']", "{u1: q1.dt, u2: q2.dt}"),
    "singular_start": error(
        "SimulationError", "got none for q1', q3' at t = 0", "singular at q2 = 1.5708", "divides by cos(q2) = 6.12e-17",
        "Start elsewhere", at="START ="),
    # symbols
    "coordinate_unused": error("ModelError", "coordinates= to list those", "(x, q), got y, which nothing uses", "Leave it out"),
    "coordinate_left_out": error("ModelError", "list each of x, q once, got x. Add q."),
    "two_symbols_of_one_name": error(
        "ModelError", "one symbol of the name 'L'", "kn.parameter('L', 0.8", "kn.parameter('L', 0.9", "Declare it once"),
    "name_in_two_roles": error(
        "ModelError", "one symbol of the name 'u1'", "kn.parameter('u1', 30.0", "kn.speed('u1'", "or rename one"),
    "symbol_in_two_roles": error("SpeedsError", "keys of speeds=, got q (Coordinate)", "Declare a kn.speed"),
    "speed_in_position": error("ModelError", "positions and orientations in coordinates", "got u2 (Speed)", "Declare a kn.coordinate"),
    "coordinates_not_unpacked": error(
        "ExpressionError", "got tuple: (q,)", "unpack it", "kn.coordinate(…)", at='N.rotate("B", q, N.z)'),
    "too_few_names": error("UserError", "ValueError: not enough values to unpack (expected 3, got 2)", at='kn.coordinates("q1:3"'),
    "input_in_position": error(
        "ValueMissingError", "the input lift with its derivatives", "got a bare function", "lift: (f, f', f'')", "kn.signal(t, y)",
        at="START = "),
    "compare_if": error("ExpressionError", "`<` on x cannot be decided", "kn.where(kn.less(a, b), x, y)", at="if x < 0:"),
    "compare_equal": error("ExpressionError", "`==` on x' cannot be decided", "Use `a is b`", at="x.dt == 0"),
    "compare_truth": error("ExpressionError", "`if` on x cannot be decided", "kn.where(", at="N.x if x else"),
    "math_sin": error("ExpressionError", "Expected a number, got the expression q", "kn.sin for math.sin", at="math.sin(q)"),
    "unit_misfit": error("UnitError", "Expected a force (N)", "'spring' on A", "k [N*m/rad]", "Correct the expression, or the unit"),
    # space
    "axis_not_unit": error("SpaceError", "got N.y + N.z of length 1.41421", "Use axis.normalized()", at="N.rotate("),
    "axis_zero": error("SpaceError", "unit vector as axis, got the zero vector", "such as N.z", at="N.rotate("),
    "angular_velocity_contradicts": error(
        "SpaceError", "angular velocity of B in N", "q' B.z, got -q' N.z", "Correct its sign", "leave it out", at="N.rotate("),
    "point_on_particle": error(
        "SpaceError", "geometric point to build valve on, got contact, a particle of C", "Build valve on G", at="contact.at("),
    "point_at_number": error("SpaceError", "Expected a Vector (or 0) as the position of A from O, got x", "x*N.x", at='O.at("A", x)'),
    "vector_plus_number": error("SpaceError", "got the scalar 0.1", "Give it a direction, such as 0.1*B.x", at="B.y - 0.1"),
    # bodies
    "inertia_not_symmetric": error(
        "ModelError", "symmetric inertia for rod, got Ixy = 0.01 and Iyx = 0", "Write kn.inertia(B, Ixx", at="kn.RigidBody("),
    "inertia_triangle": warning(
        "moments of inertia for rod", "got 0.01, 0.01, 0.03: no body has them", "Check them and the signs", at="kn.RigidBody("),
    "inertia_negative": error(
        "ModelError", "moments of inertia ≥ 0 for rod, got -0.05", "larger by m r², not smaller", at="kn.RigidBody("),
    "inertia_number": error("ModelError", "inertia dyadic for rod", "got Expr (m*L^2/12)", "kn.rod", at="kn.RigidBody("),
    "mass_negative": error("ModelError", "mass ≥ 0 for bob, got -0.5", "Check its sign", at='kn.Particle("bob"'),
    "mass_negative_default": error("ModelError", "mass ≥ 0 for bob, got m2 = -0.5", "or the default", at='kn.Particle("bob"'),
    "mass_negative_start": error("SimulationError", "mass ≥ 0 for bob, got m2 = -0.7 at the values", "Correct them", at="START ="),
    "mass_singular": error("ModelError", "zero row of the mass matrix for u2 = q'", "a mass or inertia", "leave out its coordinate"),
    "mass_singular_rod": error("ModelError", "mass matrix for u1 = q3' - q1'*sin(q2)", "a rod has none about its axis"),
    "two_bodies_of_one_name": error("ModelError", "bodies of different names, got cart more than once", "rename one"),
    "body_not_listed": error("SpeedsError", "definition of u2", "got q', but no frame or point", "Is a body missing from bodies=?"),
    "bodies_not_a_list": error("ModelError", "bodies= to be a list, got RigidBody('rod'", "Write bodies=[…] around it"),
    # loads
    "force_of_another_system": error(
        "ModelError", "got wall, whose root wall is fixed in M, the root of another system", "Use a point of this one"),
    "force_on_frame": error("ModelError", "force on a Point, got Frame('B'", "such as its mass centre", "kn.Torque", at="kn.Force(B"),
    "force_on_body": error("ModelError", "force on a Point, got RigidBody('rod'", "kn.Force(G, …)", at="kn.Force(rod"),
    "torque_on_body": error("ModelError", "torque on a Frame, got RigidBody('rod'", "kn.Torque(B, …)", at="kn.Torque(rod"),
    "force_tuple": error("ModelError", "force as a Vector, got (0, -0.1, 0)", "x*B.x + y*B.y + z*B.z", at="kn.Force(G"),
    "gravity_number": error("ModelError", "as a Vector, got 9.81", "Give it a direction, downwards: -g*N.z", at="kn.gravity("),
    "loads_not_a_list": error("ModelError", "loads= to be a list, got Gravity(", "Write loads=[…] around it"),
    "load_of_acceleration": error("ModelError", "got x'', which is not known before", "as mass or inertia"),
    # reactions
    "reaction_free_direction": error(
        "ReactionError", "reaction Fn along a direction", "got N.x at P, along which it moves freely with u1", "to that motion"),
    "reaction_nonlinear": error("ReactionError", "linear in the reactions", "got Fn^2 in 'friction'", "such as -mu*N_z"),
    "reaction_not_listed": error("ReactionError", "reaction Fn is used in a load but not listed", "System(reactions=[…])"),
    "reaction_not_unit": error("ReactionError", "got 2 N.y of length 2", "Use along.normalized()", at="kn.reaction("),
    # the start
    "start_nan": error("SimulationError", "finite start value for x, got nan", "Give a finite number", at="START ="),
    "start_infinite_parameter": error("SimulationError", "finite value for k, got inf", "Give a finite number", at="START ="),
    "default_infinite": error("ExpressionError", "finite number in an expression, got inf", "leave the term out", at='float("inf")'),
    "start_text": error("SimulationError", "number as the start value for x, got '10 cm'", "plain number", at="START ="),
    "start_degrees": warning("angle q = 30 rad, 4.77 turns", "math.radians(30)"),
    "rotate_degrees": warning("frame T is turned by 30 rad, 4.77 turns", "math.radians(30)"),
    "gravity_twice": warning("2 loads of gravity", "their sum is applied", "List one"),
    "load_twice": error("ModelError", "each load once in loads=, got Load('spring') more than once", "List it once"),
    "spring_pushes": warning("load 'spring' pushes away: at START it increases", "by up to 30 per unit", "sign of the force"),
    "damper_feeds": warning("load 'brake' adds energy to the motion", "positive power at START", "A damper dissipates energy"),
    "damper_negative": error("ModelError", "damping coefficient at or above zero, got c = -0.02", "Check its sign", at="brake"),
    "start_unknown": error("ModelError", "name of a coordinate (x, q) in START['q'], got 'q1'", "Did you mean q?", at="START ="),
    "start_length": error("ModelError", "START['q']", "dict {name: value}, got [0.1, 0.5, 0.0]", "each value by name", at="START ="),
    "start_incomplete": warning("START is incomplete", "needs --q q=…"),
    "parameter_missing": warning("No default for k", "--parameter NAME=VALUE"),
    "parameter_unknown": error(
        "ModelError", "name of a parameter (L, m1, m2, k, g)", "got 'm'", "Did you mean m2 or m1?", at="START ="),
    "span_reversed": error("ModelError", "SPAN", "to end after it begins, got (10, 0)", "Swap its times", at="SPAN ="),
    "euler_parameters_not_unit": error(
        "SimulationError", "Euler parameters (e0, e1, e2, e3)", "got length 1.0198039", "Divide them by this length", at="START ="),
    # the file
    "no_system": error("ModelError", "function system()", "got only cart_with_pendulum()", "Define one that returns", at=""),
    "no_return": error("ModelError", "to return a kn.System, got None", "end it with `return kn.System(…)`", at=""),
    "python_error": error("UserError", "in system", "ZeroDivisionError: division by zero", at="(1 / 0)"),
}  # fmt: skip

RUNNING = {
    "singular_motion": (1, "stdout", ("singular kinematics (cos(q2) = 0) at t = 0.199625", "W of q' = W u + X divides by cos(q2)",
                                      "another sequence of angles, Euler parameters", "From 0 s", "21 samples")),
    "singular_start": (1, "stderr", ("singular at q2 = 1.5708", "divides by cos(q2) = 6.12e-17")),
    "parameter_missing": (2, "stderr", ("Expected a start value of every quantity", "add --parameter k=…")),
    "start_incomplete": (2, "stderr", ("Expected a start value of every quantity", "add --q q=…")),
    "start_nan": (1, "stderr", ("finite start value for x, got nan",)),
    "mass_negative_start": (1, "stderr", ("mass ≥ 0 for bob, got m2 = -0.7",)),
    "span_reversed": (1, "stderr", ("to end after it begins, got (10, 0)",)),
    "speed_nonlinear": (1, "stderr", ("linear in the rates", "got q'^2")),
}  # fmt: skip
"""What `kane simulate` leaves with and says."""

COVERED: dict[str, tuple[str, ...]] = {
    "a speed definition nonlinear in q̇": ("speed_nonlinear", "kinematics/test_speeds.py::test_what_speeds_must_not_be"),
    "too few speeds": ("speeds_too_few",),
    "too many speeds": ("speeds_too_many", "kinematics/test_speeds.py::test_too_many_speeds"),
    "dependent speed definitions": ("speeds_dependent", "kinematics/test_speeds.py::test_structurally_dependent_definitions"),
    "Y singular only at the given start": ("singular_start", "motion/test_singular_rates.py::test_a_pivot_that_rounding_leaves_over"),
    "a coordinate that nothing uses": ("coordinate_unused", "body_not_listed"),
    "a force on a point of another system": ("force_of_another_system", "model/test_system.py::test_errors"),
    "two symbols of one name in a System": ("two_symbols_of_one_name", "two_bodies_of_one_name"),
    "a symbol used in two roles": ("symbol_in_two_roles", "name_in_two_roles", "speed_in_position"),
    "an angular velocity that contradicts the orientation": (
        "angular_velocity_contradicts", "space/test_angular_velocity.py::test_what_contradicts_the_orientation"),
    "a non-unit axis": ("axis_not_unit", "reaction_not_unit"),
    "a zero axis": ("axis_zero",),
    "inertia not symmetric": ("inertia_not_symmetric", "model/test_plausible.py::test_inertias_that_no_body_has"),
    "inertia breaking the triangle inequality": (
        "inertia_triangle", "inertia_negative", "model/test_plausible.py::test_a_thin_disk_meets_the_inequality_with_equality"),
    "negative mass as a number": (
        "mass_negative", "mass_negative_default", "mass_negative_start", "model/test_plausible.py::test_masses"),
    "singular mass matrix": ("mass_singular", "mass_singular_rod", "dynamics/test_checks.py::test_two_coordinates_that_do_the_same"),
    "a unit that does not fit": ("unit_misfit",),
    "a reaction along a free direction": ("reaction_free_direction", "dynamics/test_reactions.py::test_along_a_free_direction"),
    "a reaction entering nonlinearly": ("reaction_nonlinear", "dynamics/test_reactions.py::test_two_reactions_multiplied"),
    "an input in a position without derivatives": ("input_in_position",),
    "a point built on a fixed_in leaf": ("point_on_particle",),
    "missing or unknown parameter": ("parameter_missing", "parameter_unknown", "motion/test_run.py::test_errors"),
    "wrong state length": (
        "start_length", "motion/test_run.py::test_errors", "program/native/test_handle.py::test_shapes_and_types"),
    "NaN or infinity": (
        "start_nan", "start_infinite_parameter", "default_infinite", "program/native/test_handle.py::test_values_that_are_not_finite"),
    "comparing expressions": (
        "compare_equal", "compare_if", "compare_truth", "expr/test_node.py::test_truth_values_are_refused_with_the_cure"),
    "tolerances ≤ 0": ("motion/test_start.py::test_span_and_tolerance",),
    "reversed time span": ("span_reversed", "motion/test_start.py::test_span_and_tolerance"),
    "a motion that reaches a singularity of W": (
        "singular_motion", "motion/test_run.py::test_euler_angles_through_gimbal_lock",
        "motion/test_singular_rates.py::test_a_motion_that_breaks_off_names_the_pivot"),
    "a model file without system()": ("no_system", "no_return"),
    "a Python error inside a model file": ("python_error", "too_few_names"),
    # what students do most often
    "a rate without .dt": ("speed_forgot_dt",),
    "speeds in a list": ("speeds_as_list",),
    "one thing where a list is due": ("bodies_not_a_list", "loads_not_a_list", "coordinates_not_unpacked"),
    "a load on a body or frame": ("force_on_body", "force_on_frame", "torque_on_body"),
    "a vector without axes": ("force_tuple", "gravity_number", "vector_plus_number", "point_at_number", "inertia_number"),
    "degrees": ("start_degrees", "rotate_degrees"),
    "a spring or damper of the wrong sign": ("spring_pushes", "damper_feeds", "damper_negative"),
    "a load that acts twice": ("gravity_twice", "load_twice"),
    "math.sin": ("math_sin",),
    "a rate without a speed": ("speed_of_another", "coordinate_left_out"),
    "a load that depends on an acceleration": ("load_of_acceleration",),
    "a reaction that is not listed": ("reaction_not_listed",),
    "a start that does not fit": ("start_text", "start_unknown", "start_incomplete", "euler_parameters_not_unit"),
}  # fmt: skip
"""Each mistake that must be named, by the files in `bad` and the tests that make it."""


@pytest.fixture(scope="module")
def file_of(tmp_path_factory):
    """The model file of a name, in a folder of their own."""
    folder = tmp_path_factory.mktemp("bad")
    return lambda name: bad.written(name, folder)


def line_of(name: str) -> str:
    """“line N” of the one line of the file that holds the row's text."""
    (number,) = [n for n, t in enumerate(bad.source(name).splitlines(), 1) if BAD[name].at in t]
    return f"line {number}"


@pytest.mark.slow
@pytest.mark.parametrize("name", BAD)
def test_check(name, file_of):
    row, file = BAD[name], file_of(name)
    ran = kane("check", file, code=row.code)
    told = ran.stdout[ran.stdout.index("\nWarnings") :].strip() if row.code == 0 else ran.stderr
    for words in row.words:
        assert words in line(told)
    assert len(told.splitlines()) <= LINES
    assert "kane/cli" not in told
    assert "src/kane" not in told
    assert ("Traceback" in told) is (row.kind == "UserError")
    if row.at:
        assert f"{name}.py" in told
        assert line_of(name) in told


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in BAD if BAD[n].code])
def test_category(name, file_of):
    found = from_json("check", file_of(name), code=1)
    assert not found["ok"]
    assert found["error"]["type"] == BAD[name].kind
    assert all(words in line(found["error"]["message"]) for words in BAD[name].words)


@pytest.mark.parametrize("name", [n for n in BAD if not BAD[n].code])
def test_doubts_are_no_errors(name, file_of):
    found = from_json("check", file_of(name))
    assert found["ok"]
    assert any(all(words in text for words in BAD[name].words) for text in found["warnings"])


@pytest.mark.parametrize("name", RUNNING)
def test_simulate(name, file_of):
    code, stream, parts = RUNNING[name]
    told = line(getattr(kane("simulate", file_of(name), code=code), stream))
    assert all(part in told for part in parts)


def test_a_motion_keeps_what_it_has(tmp_path, file_of):
    table = tmp_path / "motion.csv"
    kane("simulate", file_of("singular_motion"), "--csv", table, code=1)
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    assert head.startswith("t,q1,q2,q3,u1")
    last = [float(x) for x in rows[-1].split(",")]
    assert last[0] == pytest.approx(0.199625, abs=1e-6)
    assert last[2] == pytest.approx(1.5707963, abs=1e-6)
    assert kane("check", file_of("singular_motion")).stdout.count("Warnings") == 0  # its start is sound


@pytest.mark.slow
@pytest.mark.parametrize("name", ["speed_nonlinear", "singular_start"])
def test_in_a_process_of_its_own(name, file_of):
    code = "import sys; sys.argv[0] = 'kane'; from kane.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code, "check", str(file_of(name))],
        cwd=file_of(name).parent, env=dict(os.environ), capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (1, "")
    assert all(words in line(done.stderr) for words in BAD[name].words)
    assert f"in {name}.py, {line_of(name)}: " in done.stderr


def test_numpy_functions_know_expressions():
    """np.sin in place of math.sin is no mistake."""
    q = kn.coordinate("q")
    assert np.sin(q) is kn.sin(q)


@pytest.mark.parametrize(
    ("name", "slip", "right"),
    [
        ("python_error", " * (1 / 0)", ""),
        ("axis_zero", "N.z.cross(N.z)", "N.z"),
        ("reaction_nonlinear", "normal**2", "normal"),
        ("singular_start", "1.5707963267948966", "0.3"),
        ("math_sin", "math.sin(q)", "kn.sin(q)"),
        ("gravity_number", "9.81)]", "g * N.y)]"),  # upwards: which way is up is the user's to choose
    ],
)
def test_the_slip_alone_is_wrong(name, slip, right, tmp_path):
    text = bad.source(name)
    assert text.count(slip) == 1
    said = kane("check", written(tmp_path, text.replace(slip, right))).stdout
    assert "No error found" in said
    assert "Warnings" not in said


@pytest.mark.parametrize("model", sorted(p.stem for p in bad.MODELS.glob("*.py")))
def test_the_models_that_are_edited_are_sound(model):
    said = kane("check", bad.MODELS / f"{model}.py").stdout
    assert "No error found" in said
    assert "Warnings" not in said


def test_every_slip_has_a_row_and_every_row_a_slip():
    assert bad.SLIPS.keys() == BAD.keys() | RUNNING.keys()
    assert bad.SLIPS.keys() == {n for names in COVERED.values() for n in names if "::" not in n}


def test_every_test_named_is_there():
    for name in (n for names in COVERED.values() for n in names if "::" in n):
        file, function = name.split("::")
        tree = ast.walk(ast.parse((TESTS / file).read_text(encoding="utf-8")))
        assert function in {n.name for n in tree if isinstance(n, ast.FunctionDef)}, name
