# SPDX-License-Identifier: BSD-3-Clause
"""Declarations of frames, bodies, points, constants and variables; the kind of a variable is inferred from the whole file.

A variable whose derivative is assigned somewhere is a coordinate (or a further state), one with a prime whose derivative is not
assigned a generalized speed, one with two primes a coordinate whose rate is a generalized speed unless it is assigned.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from kane.expr.node import Expr, constant_value
from kane.expr.symbols import Coordinate, Input, Parameter, Speed, Symbol, rate
from kane.interop.autolev.evaluate import FileReading, quantity
from kane.interop.autolev.grammar import Line, names_of, tokens
from kane.interop.autolev.sheet import Sheet

_PLACING = re.compile(r"(?i)simprot|dircos|[pr]_\w+>\s*=|\w+\.(rotate|setrotationmatrix\s*\(|translate|setposition)")
FORMING = {
    "fr", "frstar", "getdynamicskane", "getdynamics", "getstaticskane", "geteffectiveforce", "getgeneralizedeffectiveforce",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Statement:
    """A parsed statement; `keyword` is that of a declaration, else ""."""

    keyword: str
    tree: Any
    line: Line


@dataclass(slots=True)
class Outlook:
    """Names by their use in the whole file: assigned derivatives and values, equations of motion, positions and orientations."""

    rated: set[str] = field(default_factory=set)
    assigned: set[str] = field(default_factory=set)
    equations: set[str] = field(default_factory=set)
    placing: set[str] = field(default_factory=set)
    solved: set[str] = field(default_factory=set)
    chosen: set[str] = field(default_factory=set)

    def prescribed(self, low: str) -> bool:
        """Whether a variable is prescribed: the file lists its generalized speeds, without its rate, and no equation determines it."""
        return bool(self.chosen) and low not in self.chosen | self.solved | self.rated


def outlook(statements: Sequence[Statement]) -> Outlook:
    """The outlook, from a pass over all statements before the first is executed."""
    seen = Outlook()
    for s in statements:
        if _PLACING.match(s.line.text):
            seen.placing |= set(_words(s.tree))
        if s.tree.data == "statement":
            target = s.tree.children[0]
            names = [] if s.tree.children[1] is None else list(_words(target))
            if s.tree.children[1] is None:
                _called(seen, target)
            elif len(names) == 1:
                _note(seen, names[0])
                seen.equations.update(names if FORMING & set(_words(s.tree.children[2])) else ())
        elif s.tree.data == "declaration":
            for item in s.tree.children:
                if item is not None and item.children[5] is not None:
                    _note(seen, str(item.children[0]).lower())
    return seen


def _note(seen: Outlook, name: str) -> None:
    (seen.rated if name.endswith("'") else seen.assigned).add(name.rstrip("'"))


def _called(seen: Outlook, tree: Any) -> None:
    """Records the derivatives that KinDiffs, Solve and SetDt assign, except those solved from equations of motion."""
    words = _words(tree)
    if words and words[0].startswith("setgeneralizedspeed"):
        seen.chosen |= {w.rstrip("'") for w in words[1:]}
    if not words or words[0] not in ("kindiffs", "solve", "solvedt", "constrain"):
        if "setrotationmatrixode" in words:
            seen.rated |= set(words)
        return
    if words[0] == "kindiffs":
        seen.rated |= set(words[1:])
        return
    seen.solved |= {w.rstrip("'") for w in words[1:]}
    if words[0] == "solve" and not (seen.equations | FORMING) & set(words[1:]):
        seen.rated |= {w.rstrip("'") for w in words if w.endswith("'")}


def _words(tree: Any) -> list[str]:
    """All names in a tree, in order, in lower case."""
    return [str(token).lower() for token in tokens(tree)]


# Declarations by keyword ---------------------------------------------------------------------------------------------

Declare = Callable[[Sheet, Outlook, str, int, Line], None]


def _frame(s: Sheet, o: Outlook, name: str, primes: int, line: Line) -> None:
    low = name.lower()
    s.frames[low] = s.shown[low] = name
    for point in (f"{name}o", f"{name}cm") if s.genesis else (f"{name}O",):
        s.points[point.lower()] = s.shown[point.lower()] = point
        s.fixed[point.lower()] = low


def _newtonian(s: Sheet, o: Outlook, name: str, primes: int, line: Line) -> None:
    if s.inertial:
        raise line.refuse("one Newtonian frame", f"{s.say(s.inertial)} and {name}")
    _frame(s, o, name, primes, line)
    s.inertial = name.lower()


def _body(s: Sheet, o: Outlook, name: str, primes: int, line: Line) -> None:
    _frame(s, o, name, primes, line)
    s.bodies[name.lower()] = f"{name.lower()}{'cm' if s.genesis else 'o'}"


def _point(s: Sheet, o: Outlook, name: str, primes: int, line: Line) -> None:
    s.points[name.lower()] = name
    s.shown.setdefault(name.lower(), name)


def _particle(s: Sheet, o: Outlook, name: str, primes: int, line: Line) -> None:
    _point(s, o, name, primes, line)
    s.particles[name.lower()] = name


def _constant(s: Sheet, o: Outlook, name: str, primes: int, line: Line) -> None:
    _enter(s, name, Parameter.declare(name, None, "", ""), primes)


def _specified(s: Sheet, o: Outlook, name: str, primes: int, line: Line) -> None:
    _enter(s, name, Input.declare(name, None, "", ""), primes)
    s.given.add(name.lower())


def _variable(s: Sheet, o: Outlook, name: str, primes: int, line: Line) -> None:
    low = name.lower()
    symbol: Symbol
    if not primes or low in o.assigned or o.prescribed(low):
        symbol = Input.declare(name, None, "", "")
        if primes and low not in o.assigned:
            s.given.add(low)
            s.prescribed.append(name)
    elif primes == 1 and low not in o.rated | o.placing:
        symbol = Speed.declare(name, None, "", "")
    else:
        symbol = Coordinate.declare(name, None, "", "")
        if low not in o.rated:
            s.kinematic[rate(symbol)] = Speed.declare(f"{name}p", None, "", "")
    _enter(s, name, symbol, primes)


def _enter(s: Sheet, name: str, symbol: Symbol, primes: int) -> None:
    low = name.lower()
    s.symbols[low], s.primes[low] = symbol, primes
    s.shown.setdefault(low, name)
    s.values.pop(low, None)


_TABLE: dict[str, tuple[Declare, str]] = {
    "newtonian": (_newtonian, "newtonian newtonianframe"),
    "frame": (_frame, "frame frames rigidframe rigidframes"),
    "body": (_body, "body bodies rigidbody rigidbodies"),
    "particle": (_particle, "particle particles"),
    "point": (_point, "point points"),
    "constant": (_constant, "constant constants"),
    "specified": (_specified, "specified specifieds"),
    "variable": (_variable, "variable variables motionvariable motionvariables"),
    "imaginary": (lambda *_: None, "imaginary"),
}
DECLARED: dict[str, Declare] = {w: declare for declare, words in _TABLE.values() for w in words.split()}
"""The function that executes the declaration of each keyword."""

Assign = Callable[[str, Any, str, Line], None]


def declare(r: FileReading, seen: Outlook, statement: Statement, assign: Assign) -> None:
    """Executes a declaration; values beside names are defaults of constants, or assignments."""
    line = statement.line
    for item in statement.tree.children:
        if item is None:
            continue
        parts = item.children
        for name, primes in names_of(parts, r.number, line):
            DECLARED[statement.keyword](r.sheet, seen, name, primes, line)
            if parts[3] is not None:
                r.sheet.fixed[name.lower()] = str(parts[3]).lower()
            if parts[5] is not None:
                _initial(r, name, primes, parts, line, assign)


def _initial(r: FileReading, name: str, primes: int, parts: Sequence[Any], line: Line, assign: Assign) -> None:
    value = quantity(r, parts[5], parts[6], line)
    number = constant_value(value) if isinstance(value, Expr) else None
    if number is not None and isinstance(r.sheet.symbols.get(name.lower()), Parameter):
        r.sheet.symbols[name.lower()] = Parameter.declare(name, float(number), "", "")
    else:
        assign(name + "'" * primes, value, "=", line)


def words_of(trees: Iterable[Any]) -> set[str]:
    """The names in several trees."""
    return {w for tree in trees for w in _words(tree)}
