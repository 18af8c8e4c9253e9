# SPDX-License-Identifier: BSD-3-Clause
"""Model files with one slip each: sound models of the folder `models`, each edited in one or two places."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

MODELS = Path(__file__).with_name("models")


class Slip(NamedTuple):
    """The sound model, what is wrong with the edited one, and the edits: text that stands once in it, and what takes its place."""

    model: str
    what: str
    edits: list[tuple[str, str]]


SLIPS = {
    "speed_nonlinear": Slip("cart", "A speed defined with the square of a rate.", [("q.dt", "q.dt**2")]),
    "speed_forgot_dt": Slip("cart", "A speed defined by the coordinate, not its rate.", [("q.dt", "q")]),
    "speed_of_another": Slip("cart", "A rate without a speed.", [("x.dt, u2: q.dt", "x.dt")]),
    "speeds_too_few": Slip("cart", "Two coordinates, one speed that holds both rates.", [("x.dt, u2:", "x.dt + L *")]),
    "speeds_too_many": Slip(
        "cart",
        "Two coordinates, three speeds.",
        [("m1 =", 'u3 = kn.speed("u3", "m/s")\n    m1 ='), ("q.dt", "q.dt, u3: P.velocity(N).dot(N.x)")],
    ),
    "speeds_dependent": Slip(
        "gyro", "Two speeds that are the same but for a factor.", [("w.dot(B.z", "2 * w.dot(B.y")]
    ),
    "speeds_as_list": Slip(
        "cart", "Speeds given as a list of definitions.", [("{u1: x.dt, u2: q.dt}", "[x.dt, q.dt]")]
    ),
    "singular_start": Slip(
        "gyro",
        "Angles whose kinematics are singular where the motion starts, and only there.",
        [("0.3", "1.5707963267948966")],
    ),
    "coordinate_unused": Slip(
        "cart",
        "A coordinate listed that no point or frame depends on.",
        [
            ("u1 =", 'y = kn.coordinate("y", "m", "height of the cart")\n    u1 ='),
            ("    )", "        coordinates=(x, q, y),\n    )"),
        ],
    ),
    "coordinate_left_out": Slip(
        "cart", "An order of the coordinates that leaves one out.", [("    )", "        coordinates=(x,),\n    )")]
    ),
    "two_symbols_of_one_name": Slip(
        "cart",
        "The length of the rod declared twice, with different defaults.",
        [
            ("cart =", 'length = kn.parameter("L", 0.9, "m", "length of the rod")\n    cart ='),
            ("kn.Force(A", "kn.Force(P, -k * (L - length) * B.y), kn.Force(A"),
        ],
    ),
    "name_in_two_roles": Slip(
        "cart", "A parameter that has the name of a speed.", [('kn.parameter("k', 'kn.parameter("u1')]
    ),
    "symbol_in_two_roles": Slip("cart", "A coordinate used as a generalized speed.", [("x.dt, u2", "x.dt, q")]),
    "speed_in_position": Slip("cart", "A speed where a coordinate is meant.", [(", x * N.x", ", x * N.x + u2 * N.y")]),
    "coordinates_not_unpacked": Slip(
        "rod", "The plural kn.coordinates gives a tuple.", [("kn.coordinate", "kn.coordinates")]
    ),
    "too_few_names": Slip("gyro", 'Three names for two coordinates: "q1:3" ends before q3.', [("q1:4", "q1:3")]),
    "input_in_position": Slip(
        "cart",
        "A driven support: an input in a position, without its derivatives.",
        [
            ("import kane as kn", "import math\n\nimport kane as kn"),
            (
                'A = O.at("A", x * N.x',
                'lift = kn.input("lift", "m", "height of the rail")\n    A = O.at("A", x * N.x + lift * N.y',
            ),
            ("0.0}", '0.0}, "inputs": {"lift": math.sin}'),
        ],
    ),
    "compare_if": Slip(
        "cart",
        "A spring that only pushes, by `if` on a coordinate.",
        [
            ("cart =", "force = -k * x * N.x\n    if x < 0:\n        force = 0 * N.x\n    cart ="),
            ("-k * x * N.x", "force"),
        ],
    ),
    "compare_equal": Slip(
        "cart",
        "A force switched by `==` on an expression.",
        [("cart =", "force = 0 * N.x if x.dt == 0 else -k * x * N.x\n    cart ="), ("-k * x * N.x", "force")],
    ),
    "compare_truth": Slip(
        "cart",
        "A force switched by the truth value of an expression.",
        [("cart =", "force = -k * x * N.x if x else 0 * N.x\n    cart ="), ("-k * x * N.x", "force")],
    ),
    "math_sin": Slip(
        "rod",
        "math.sin of a coordinate.",
        [
            ("import kane as kn", "import math\n\nimport kane as kn"),
            ("kn.gravity(-g * N.y", "kn.Torque(B, -m * g * L / 2 * math.sin(q) * N.z"),
        ],
    ),
    "unit_misfit": Slip("cart", "A spring whose stiffness is that of a torsion spring.", [("N/m", "N*m/rad")]),
    "axis_not_unit": Slip("rod", "An axis of length √2.", [("N.z", "N.y + N.z")]),
    "axis_zero": Slip("rod", "An axis without a direction.", [("N.z", "N.z.cross(N.z)")]),
    "angular_velocity_contradicts": Slip(
        "rod", "An angular velocity of the wrong sign beside the angle.", [("N.z", "N.z, angular_velocity=-q.dt * N.z")]
    ),
    "point_on_particle": Slip(
        "wheel",
        "A point built on the particle in contact.",
        [
            ("wheel =", 'valve = contact.at("valve", R / 2 * C.x)\n    wheel ='),
            ("loads=[", "loads=[kn.Force(valve, -g * N.y), "),
        ],
    ),
    "point_at_number": Slip("cart", "A position given as a scalar.", [(", x * N.x", ", x")]),
    "vector_plus_number": Slip("cart", "A scalar added to a vector.", [("B.y", "B.y - 0.1")]),
    "inertia_not_symmetric": Slip(
        "rod",
        "An inertia matrix with one product of inertia left out.",
        [
            ("rod =", "inertia = kn.Dyadic.of(B, [[0.03, 0.01, 0], [0, 0.02, 0], [0, 0, 0.04]])\n    rod ="),
            ("kn.rod(B, m, L, axis=B.y)", "inertia"),
        ],
    ),
    "inertia_triangle": Slip(
        "rod", "An inertia that no body has.", [("kn.rod(B, m, L, axis=B.y", "kn.inertia(B, 0.01, 0.01, 0.03")]
    ),
    "inertia_negative": Slip(
        "rod",
        "A central moment of inertia below zero, from the theorem of parallel axes with the wrong sign.",
        [
            ("rod =", "I = m * L**2 / 12 - m * (L / 2) ** 2\n    rod ="),
            ("kn.rod(B, m, L, axis=B.y)", "kn.inertia(B, I, I, I)"),
        ],
    ),
    "inertia_number": Slip(
        "rod", "A moment of inertia where the dyadic is due.", [("kn.rod(B, m, L, axis=B.y)", "m * L**2 / 12")]
    ),
    "mass_negative": Slip("cart", "A mass below zero.", [("P, m2", "P, -0.5")]),
    "mass_negative_default": Slip("cart", "A mass whose default is below zero.", [(", 0.5", ", -0.5")]),
    "mass_negative_start": Slip(
        "cart", "A mass below zero among the start values.", [("0.0}", '0.0}, "parameters": {"m2": -0.7}')]
    ),
    "mass_singular": Slip(
        "cart", "A massless coordinate: the bob has no mass, so nothing moves with the angle.", [("P, m2", "P, 0")]
    ),
    "mass_singular_rod": Slip(
        "gyro",
        "A rod turns about its own axis, about which it has no inertia.",
        [("kn.inertia(B, I1, I2, I3", "kn.rod(B, m, 2 * a, axis=B.x")],
    ),
    "two_bodies_of_one_name": Slip("cart", "Two bodies of one name.", [('"bob', '"cart')]),
    "body_not_listed": Slip("cart", "The bob is declared, but not among the bodies.", [("cart, bob", "cart")]),
    "bodies_not_a_list": Slip("rod", "One body, not in a list.", [("[rod]", "rod")]),
    "force_of_another_system": Slip(
        "cart",
        "A force on a point of another inertial frame.",
        [
            ("cart =", 'M = kn.Frame("M")\n    wall = kn.Point("wall", fixed_in=M)\n    cart ='),
            ('N.x, name="spring"', "N.x), kn.Force(wall, k * x * M.x"),
        ],
    ),
    "force_on_frame": Slip("rod", "A force on a frame.", [("N.y)", "N.y), kn.Force(B, -0.1 * N.x)")]),
    "force_on_body": Slip("rod", "A force on a body.", [("N.y)", "N.y), kn.Force(rod, -0.1 * N.x)")]),
    "torque_on_body": Slip("rod", "A torque on a body.", [("N.y)", "N.y), kn.Torque(rod, -0.1 * N.z)")]),
    "force_tuple": Slip(
        "rod",
        "A force as a tuple of measure numbers along the body's axes.",
        [("N.y)", "N.y), kn.Force(G, (0, -0.1, 0))")],
    ),
    "gravity_number": Slip("rod", "Gravity without a direction.", [("-g * N.y", "9.81")]),
    "loads_not_a_list": Slip("rod", "One load, not in a list.", [("[kn.gravity(-g * N.y)]", "kn.gravity(-g * N.y)")]),
    "load_of_acceleration": Slip("cart", "A load that depends on an acceleration.", [("* x", "* x.dt.dt")]),
    "reaction_free_direction": Slip(
        "wheel", "A reaction along the direction in which the wheel moves.", [("along=N.y", "along=N.x")]
    ),
    "reaction_nonlinear": Slip(
        "wheel", "Friction that grows with the square of the normal force.", [("* normal", "* normal**2")]
    ),
    "reaction_not_listed": Slip(
        "wheel", "A reaction that a load uses, not listed.", [("        reactions=[normal],\n", "")]
    ),
    "reaction_not_unit": Slip(
        "wheel", "A reaction along a vector that is no unit vector.", [("along=N.y", "along=2 * N.y")]
    ),
    "start_nan": Slip("cart", "A start value that is not a number.", [("0.1", 'float("nan")')]),
    "start_infinite_parameter": Slip(
        "cart", "A parameter of infinite value at the start.", [("0.0}", '0.0}, "parameters": {"k": float("inf")}')]
    ),
    "default_infinite": Slip("cart", "A default that is infinite.", [("0.8", 'float("inf")')]),
    "start_text": Slip("cart", "A start value as text.", [("0.1", '"10 cm"')]),
    "start_degrees": Slip("rod", "The start angle in degrees.", [(": 0.5", ": 30")]),
    "rotate_degrees": Slip(
        "rod",
        "A tilted frame, by an angle in degrees.",
        [('B = N.rotate("B", q, N.z', 'T = N.rotate("T", 30, N.x)\n    B = T.rotate("B", q, T.z')],
    ),
    "gravity_twice": Slip("cart", "Gravity listed twice.", [("kn.Force", "kn.gravity(-g * N.y), kn.Force")]),
    "load_twice": Slip(
        "cart",
        "The spring listed twice, under two names of Python.",
        [
            (
                "return kn.System(",
                'spring = kn.Force(A, -k * x * N.x, name="spring")\n    right_spring = spring\n    return kn.System(',
            ),
            ('kn.Force(A, -k * x * N.x, name="spring")', "spring, right_spring"),
        ],
    ),
    "spring_pushes": Slip("cart", "A spring that pushes the cart away.", [("-k * x", "k * x")]),
    "damper_feeds": Slip(
        "rod",
        "A damper written by hand, with the wrong sign.",
        [
            ("g =", 'c = kn.parameter("c", 0.02, "N*m*s/rad")\n    g ='),
            ("N.y)", 'N.y), kn.Torque(B, c * B.angular_velocity(N), name="brake")'),
        ],
    ),
    "damper_negative": Slip(
        "rod",
        "A damper whose coefficient has the wrong sign.",
        [
            ("g =", 'c = kn.parameter("c", -0.02, "N*m*s/rad")\n    g ='),
            ("N.y)", 'N.y), kn.torsional_damper(B, N, c, N.z, name="brake")'),
        ],
    ),
    "start_unknown": Slip("cart", "A start value for a coordinate of another name.", [(' "q', ' "q1')]),
    "start_length": Slip(
        "cart", "The start as a list with one value too many.", [('{"x": 0.1, "q": 0.5}', "[0.1, 0.5, 0.0]")]
    ),
    "start_incomplete": Slip("cart", "A start without the angle.", [('0.1, "q": 0.5', "0.1")]),
    "parameter_missing": Slip(
        "cart", "A parameter without a default or a value.", [('30.0, "N/m", ', 'unit="N/m", description=')]
    ),
    "parameter_unknown": Slip(
        "cart", "A value for a parameter that the system does not have.", [("0.0}", '0.0}, "parameters": {"m": 0.7}')]
    ),
    "span_reversed": Slip(
        "cart",
        "A time span that ends before it begins.",
        [
            (
                'START = {"q": {"x": 0.1, "q": 0.5}, "u": {"u1": 0.0, "u2": 0.0}}',
                'START = {"q": {"x": 0.1, "q": 0.5}, "u": {"u1": 0.0, "u2": 0.0}}\nSPAN = (10, 0)',
            )
        ],
    ),
    "euler_parameters_not_unit": Slip(
        "gyro",
        "Euler parameters that are not of unit length.",
        [
            ('q1, q2, q3 = kn.coordinates("q1:4", "rad", "yaw, pitch, roll', 'e = kn.coordinates("e0:4'),
            ('N.rotate_body("B", (q1, q2, q3), "zyx"', 'N.rotate_euler_parameters("B", e'),
            ('q1": 0.0, "q2": 0.3, "q3', 'e0": 1.0, "e1": 0.2, "e2": 0.0, "e3'),
        ],
    ),
    "no_system": Slip("cart", "A model file without system().", [("system", "cart_with_pendulum")]),
    "no_return": Slip("cart", "A system() that does not return what it makes.", [("return kn.System", "kn.System")]),
    "python_error": Slip(
        "cart", "A mistake of Python: a number divided by zero on the way.", [("B.y", "(1 / 0) * B.y")]
    ),
    "singular_motion": Slip(
        "gyro",
        "Angles whose kinematics become singular on the way: the pitch passes 90°.",
        [('20.0, "u2": 0.0', '0.0, "u2": 5.0')],
    ),
}


@cache
def source(name: str) -> str:
    """The text of the model file with that slip."""
    slip = SLIPS[name]
    sound = (MODELS / f"{slip.model}.py").read_text(encoding="utf-8")
    rest = sound.partition("\n")[2]
    first = rest.partition("\n")[0]
    cuts = [(sound.index(old), old, new) for old, new in (*slip.edits, (first, f'"""{slip.what}"""'))]
    text = sound
    for at, old, new in sorted(cuts, reverse=True):
        assert sound.count(old) == 1, f"{name}: {old!r} stands {sound.count(old)} times in {slip.model}.py"
        text = text[:at] + new + text[at + len(old) :]
    return text


def written(name: str, folder: Path) -> Path:
    """The model file with that slip, in a folder."""
    path = folder / f"{name}.py"
    path.write_text(source(name), encoding="utf-8")
    return path
