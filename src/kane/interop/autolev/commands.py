# SPDX-License-Identifier: BSD-3-Clause
"""The commands that define a model (orientations, velocities, loads, constraints, kinematical equations), in a table by name."""

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import Any

from kane.errors import KaneError
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Coordinate, Input, Rate, Speed, rate
from kane.interop.autolev.evaluate import FileReading, quantity
from kane.interop.autolev.functions import expression, frame_of, pair_of, point_of, solve, word
from kane.interop.autolev.grammar import Line, bare
from kane.interop.autolev.sheet import Sheet, of_euler, of_rodrigues, simple
from kane.interop.autolev.values import UNIT, FileMatrix, Unread, Vec, entries

Args = Sequence[Any]
Command = Callable[[FileReading, Args, Line], None]
_HALF = ONE / 2


# Orientation ---------------------------------------------------------------------------------------------------------


def simprot(r: FileReading, args: Args, line: Line) -> None:
    """Simprot(A, B, axis, angle)."""
    if len(args) != 4:
        raise line.refuse("Simprot(A, B, axis, angle)", f"{len(args)} arguments")
    a, b = frame_of(r, args[0], line), frame_of(r, args[1], line)
    axis = r.value(expression(args[2]), line)
    angle = r.scalar(expression(args[3]), line)
    if isinstance(axis, Vec):
        components = axis.components(b if axis.frames() == (b,) else a)
    else:
        number = r.number(expression(args[2]), line)
        if abs(number) not in (1, 2, 3):
            raise line.refuse("an axis 1, 2 or 3", number)
        components = UNIT[abs(number) - 1]
        angle = angle if number > 0 else -angle
    turn(r.sheet, a, b, components, angle, line)


def turn(s: Sheet, a: str, b: str, axis: tuple[Expr, ...], angle: Expr, line: Line) -> None:
    """Orients b in a by a simple rotation."""
    if s.connected(a, b):
        raise line.refuse(f"one orientation of {s.say(b)} in {s.say(a)}", "another one")
    s.orient(simple(a, b, axis, angle))


def dircos(r: FileReading, args: Args, line: Line) -> None:
    """Dircos(A, B, body123, q1, q2, q3) and variants; with two frames only it declares nothing."""
    if len(args) > 3:
        a, b = frame_of(r, args[0], line), frame_of(r, args[1], line)
        orient(r, a, b, word(args[2], line), [expression(x) for x in args[3:]], line)


def orient(r: FileReading, a: str, b: str, kind: str, trees: Sequence[Any], line: Line) -> None:
    """Orients b in a by a sequence of angles, Euler or Rodrigues parameters."""
    angles = [r.scalar(x, line) for x in trees]
    if kind in ("euler", "quaternion"):
        if len(angles) != 4 or not all(isinstance(x, Coordinate) for x in angles):
            raise line.refuse("four variables with primes as Euler parameters", f"{len(angles)} expressions")
        e = tuple(x for x in angles if isinstance(x, Coordinate))
        r.sheet.orient(of_euler(a, b, e if kind == "euler" else (*e[1:], e[0])))
        return
    if kind == "rodrigues" and len(angles) == 3:
        r.sheet.orient(of_rodrigues(a, b, tuple(angles)))
        return
    axes = kind[-3:].translate(str.maketrans("xyz", "123"))
    if kind[:-3] not in ("body", "space") or not set(axes) <= set("123") or len(angles) != 3:
        raise line.refuse("Euler, Rodrigues, or body or space with three axes, and as many angles", kind)
    steps = list(zip(axes, angles, strict=True))
    steps = steps if kind.startswith("body") else steps[::-1]
    base = a
    for k, (axis, angle) in enumerate(steps):
        name = b if k == 2 else f"{b}~{k + 1}"
        r.sheet.shown.setdefault(name, f"{r.sheet.say(b)}~{k + 1}")
        turn(r.sheet, base, name, UNIT[int(axis) - 1], angle, line)
        base = name


def angvel(r: FileReading, args: Args, line: Line) -> None:
    """Angvel(A, B): the angular velocity of B in A, from orientations."""
    a, b = frame_of(r, args[0], line), frame_of(r, args[1], line)
    r.sheet.spins[b, a] = r.sheet.spin(b, a)


def kindiffs(r: FileReading, args: Args, line: Line) -> None:
    """KinDiffs(A, B, kind, q1, …): rates of angles or Euler parameters from the angular velocity."""
    a, b, kind = frame_of(r, args[0], line), frame_of(r, args[1], line), word(args[2], line)
    q = [r.scalar(expression(x), line) for x in args[3:]]
    if kind.startswith("poisson"):
        by_elements(r, b, a, [q[k::3] for k in range(3)], line)
    else:
        kinematics(r.sheet, a, b, kind, q, line)


def kinematics(s: Sheet, a: str, b: str, kind: str, q: Sequence[Expr], line: Line) -> None:
    """The kinematical equations of an orientation, from its angular velocity."""
    known = s.components(s.spin(b, a), b)
    if kind in ("euler", "quaternion"):
        x, y, z, w = q if kind == "euler" else (*q[1:], q[0])
        p, m, n = known
        rates = (w * p + y * n - z * m, w * m + z * p - x * n, w * n + x * m - y * p, -(x * p + y * m + z * n))
        for e, value in zip((x, y, z, w), rates, strict=True):
            s.kinematic[rate(_coordinate(e, line))] = value * _HALF
        return
    rows = s.components(s.turning(b, a), b)
    equations = [mine - given for mine, given in zip(rows, known, strict=True)]
    unknown = [rate(_coordinate(x, line)) for x in q]
    s.kinematic |= dict(zip(unknown, solve(s, equations, unknown, line), strict=True))


def by_elements(r: FileReading, b: str, a: str, rows: Sequence[Sequence[Expr]], line: Line) -> None:
    """Poisson's equations for the nine b_i · a_j: b is turned by additional Euler parameters, of which the elements are functions."""
    s, spin = r.sheet, r.sheet.spin(b, a)
    if [len(row) for row in rows] != [3, 3, 3]:
        raise line.refuse("nine elements of a rotation matrix", sum(map(len, rows)))
    if not s.connected(a, b):
        e = tuple(Coordinate.declare(f"{s.say(b)}_e{k}", None, "", "") for k in range(1, 5))
        s.symbols |= {x.name.lower(): x for x in e}
        s.orient(of_euler(a, b, e))
        s.spins[b, a] = spin
        kinematics(s, a, b, "euler", e, line)
        s.remarks.say(
            "changed", f"{s.say(b)} is oriented by Euler parameters; the elements of its matrix follow", line.where
        )
    for told, element in zip(chain(*rows), chain(*s.cosines(b, a)), strict=True):
        name = _coordinate(told, line).name.lower()
        s.late[told] = s.values[name] = element
        s.symbols.pop(name, None)


def _coordinate(e: Expr, line: Line) -> Coordinate:
    if not isinstance(e, Coordinate):
        raise line.refuse("a variable declared with a prime", e)
    return e


# Velocities ----------------------------------------------------------------------------------------------------------


def _velocity(*, moving: bool) -> Command:
    """V2pts(A, B, P, Q): the velocity in A of Q, where P and Q are fixed on B; V1pt(A, B, P, Q): that of Q, which moves in B."""

    def call(r: FileReading, args: Args, line: Line) -> None:
        s, a, b = r.sheet, frame_of(r, args[0], line), frame_of(r, args[1], line)
        p, q = point_of(r, args[2], line), point_of(r, args[3], line)
        own = (s.velocities.get((q, b)) or s.dt(s.position(p, q), b)) if moving else Vec()
        s.velocities[q, a] = s.carried(a, b, p, q) + own

    return call


def _nothing(r: FileReading, args: Args, line: Line) -> None:
    """Ignored: accelerations are derivatives of velocities."""


# Loads ---------------------------------------------------------------------------------------------------------------


def gravity(r: FileReading, args: Args, line: Line) -> None:
    """Gravity(g*N3>), optionally with the bodies and particles on which it acts."""
    names = tuple(word(x, line) for x in args[1:])
    for name in names:
        if name not in r.sheet.bodies and name not in r.sheet.particles:
            raise line.refuse("a body or particle under gravity", name)
    r.sheet.gravities.append((r.vector(expression(args[0]), line), names))


def force(r: FileReading, args: Args, line: Line) -> None:
    """Force(P, F>), Force(P/Q, F>): F on Q, −F on P."""
    _loads(r, args, line, r.sheet.points, r.sheet.forces, "point")


def torque(r: FileReading, args: Args, line: Line) -> None:
    """Torque(A, T>), Torque(A/B, T>): T on B, −T on A."""
    _loads(r, args, line, r.sheet.frames, r.sheet.torques, "frame")


def _loads(r: FileReading, args: Args, line: Line, known: Any, loads: list[tuple[str, Vec, Line]], what: str) -> None:
    if len(args) != 2:
        raise line.refuse(f"a {what} or a pair of them, and a vector", f"{len(args)} arguments")
    first, second = pair_of(args[0], line)
    vector = r.vector(expression(args[1]), line)
    for name in (first, second) if second else (first,):
        if name not in known:
            raise line.refuse(f"the name of a {what}", name)
    if second:
        r.sheet.act(loads, first, second, vector.times(-ONE), line)
    else:
        loads.append((first, vector, line))


# Constraints and equations -------------------------------------------------------------------------------------------


def constrain(r: FileReading, args: Args, line: Line) -> None:
    """Constrain(Dependent[u3, u4]), Constrain(Auxiliary[u5]), or both in one command."""
    for arg in args:
        element = bare(arg)
        if element.data != "element":
            raise line.refuse("Dependent[…] or Auxiliary[…] in Constrain", "another expression")
        name = str(element.children[0]).lower()
        unknown = [r.scalar(x.children[0], line) for x in element.children[1].children]
        hold(r, name, unknown, line, auxiliary=name.startswith("aux"))


def hold(r: FileReading, name: str, unknown: Sequence[Expr], line: Line, *, auxiliary: bool = False) -> None:
    """Makes the named equations motion constraints, with these dependent speeds; auxiliary speeds are recorded instead."""
    table = r.sheet.values.get(name)
    if not isinstance(table, FileMatrix):
        raise line.refuse(f"equations {name}[…] before they are constraints", "none")
    held: Any = [u.place if isinstance(u, Rate) else u for u in unknown]
    speeds = [u for u in unknown if isinstance(u, Speed)]
    if auxiliary:
        r.sheet.auxiliary += [u for u in held if isinstance(u, Speed)]
        return
    for e in table.flat():
        if not isinstance(e, Expr):
            raise line.refuse("scalars as constraints", "another value")
        if e is not ZERO:
            r.sheet.constraints.append((e, line))
    r.sheet.dependent += speeds


def solved(r: FileReading, args: Args, line: Line) -> None:
    """Solve(equations, unknowns): rates as unknowns give kinematical equations, speeds constraints; accelerations are ignored."""
    tree = args[0].children[0]
    if r.sheet.formed:
        closed(r, args, line)
    value = r.value(tree, line)
    if isinstance(value, Unread):
        return
    scalars = [e for e in entries(value) if isinstance(e, Expr)]
    unknown = [x for a in args[1:] for x in entries(r.value(expression(a), line)) if isinstance(x, Expr)]
    if any(isinstance(u, Rate) and isinstance(u.place, Speed) for u in unknown):
        r.sheet.remarks.say("ignored", "equations solved for accelerations, which follow from the model", line.where)
        return
    if any(isinstance(u, Speed) for u in unknown):
        r.sheet.constraints += [(e, line) for e in scalars]
        r.sheet.dependent += [u for u in unknown if isinstance(u, Speed)]
        return
    try:
        answers = solve(r.sheet, scalars, unknown, line)
    except KaneError as error:
        if not r.sheet.formed and any(isinstance(u, Rate) for u in unknown):
            raise
        r.sheet.remarks.say("ignored", f"equations that are not solved here: {error}", line.where)
        return
    for u, answer in zip(unknown, answers, strict=True):
        _known(r.sheet, u, answer)


def solved_with_rates(r: FileReading, args: Args, line: Line) -> None:
    """SolveDt(equations, unknowns): as Solve; equations solved for coordinates become configuration constraints."""
    value = r.value(args[0].children[0], line)
    placed = [x for a in args[1:] for x in entries(r.value(expression(a), line)) if isinstance(x, Coordinate)]
    equations = entries(value)
    scalars = [e for e in equations if isinstance(e, Expr)]
    if not placed or len(scalars) != len(equations) or r.sheet.formed:
        solved(r, args, line)
        return
    rates = [r.sheet.rate(q) for q in placed]
    r.sheet.constraints += [(r.sheet.rate(e), line) for e in scalars]
    r.sheet.dependent += [u for u in rates if isinstance(u, Speed)]


def closed(r: FileReading, args: Args, line: Line) -> None:
    """ODE([Dynamics; Constraint] = 0, q'', F): derivatives of equations in speeds become constraints, and F their forces.

    Equations of motion are ignored, because they follow from the model.
    """
    s, found = r.sheet, False
    for e in _parts(r, args[0].children[0] if args else None, line):
        told = e
        while told in s.before and any(_is_acceleration(x) for x in free_symbols([told])):
            told = s.before[told]
        symbols = set(free_symbols([told]))
        if told is not e and any(isinstance(x, Speed) for x in symbols) and not any(map(_is_acceleration, symbols)):
            found = True
            if all(told is not law for law, _ in s.constraints):
                s.constraints.append((told, line))
    for a in args[1:]:
        for x in entries(r.value(expression(a), line)):
            if isinstance(x, Input) and (found or s.constraints):
                s.sought.setdefault(x.name, line)


def _parts(r: FileReading, tree: Any, line: Line) -> Iterator[Expr]:
    """The scalars in blocks of equations, without outputs."""
    tree = bare(tree)
    if tree is None:
        return
    blocks = [x for row in tree.children for x in row.children] if tree.data == "matrix" else [tree]
    for block in blocks:
        yield from (x for x in entries(r.value(block, line)) if isinstance(x, Expr))


def _is_acceleration(x: Expr) -> bool:
    return isinstance(x, Rate) and isinstance(x.place, Speed)


def _known(s: Sheet, unknown: Expr, answer: Expr) -> None:
    if isinstance(unknown, Rate):
        s.kinematic[unknown] = answer
        for key, value in s.kinematic.items():
            if unknown in set(free_symbols([value])):
                s.kinematic[key] = s.by_speeds(value)
    elif not isinstance(unknown, Speed | Coordinate):
        s.late[unknown] = answer


def start_by(r: FileReading, args: Args, line: Line) -> None:
    """SolveSetInput(equations = 0, x = 1): initial guesses; the start is assembled when a motion is simulated."""
    for a in args[1:]:
        name = word(a.children[0], line) if a.data == "named" else ""
        value = quantity(r, a.children[2], a.children[3], line) if name else None
        if isinstance(value, Expr) and (name in r.sheet.symbols or name.rstrip("'") in r.sheet.symbols):
            r.sheet.inputs[name] = value
    r.sheet.remarks.say("ignored", "equations of a start: assembly finds it when a motion is asked for", line.where)


def kane(r: FileReading, args: Args, line: Line) -> None:
    """Kane(F1, F2): the unknown forces to bring into evidence."""
    r.sheet.unknown += [word(a, line) for a in args]


COMMANDS: dict[str, Command] = {
    "simprot": simprot, "dircos": dircos, "angvel": angvel, "kindiffs": kindiffs,
    "v2pts": _velocity(moving=False), **dict.fromkeys(("v1pt", "v1pts"), _velocity(moving=True)),
    **dict.fromkeys(("a2pts", "a1pt", "a1pts", "angacc", "alf"), _nothing),
    "gravity": gravity, "force": force, "torque": torque,
    "constrain": constrain, "solve": solved, "ode": closed, "solvedt": solved_with_rates,
    **dict.fromkeys(("solvesetinput", "solvesetinputdt"), start_by), "kane": kane,
}  # fmt: skip
"""The implementation of each command."""
