# SPDX-License-Identifier: BSD-3-Clause
"""The state of a file being read: names, orientations, positions, velocities, loads and constraints; and its vector algebra."""

import re
from collections import deque
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import reduce
from typing import TypeVar

import numpy as np

from kane.errors import ModelError
from kane.expr.differentiation import time_derivative
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.operators import cos, sin, sqrt
from kane.expr.symbols import Coordinate, Parameter, Speed, Symbol
from kane.expr.visit import substituted
from kane.interop.autolev.grammar import Line
from kane.interop.autolev.values import UNIT, Dyad, Rows, Value, Vec, along, dot, gathered, product, transposed
from kane.interop.imported import Remarks
from kane.space.attitude_formulas import cosines_of

Pair = tuple[str, str]
K = TypeVar("K", bound=Hashable)
X = TypeVar("X")


@dataclass(frozen=True, slots=True, eq=False)
class FileTurn:
    """The orientation of a frame in its parent: simple rotation, Euler parameters (scalar last), Rodrigues parameters, or a matrix."""

    parent: str
    child: str
    cosines: Rows
    axis: tuple[Expr, ...] | None = None
    angle: Expr = ZERO
    euler: tuple[Coordinate, ...] = ()
    rodrigues: tuple[Expr, ...] = ()


@dataclass(slots=True)
class Sheet:
    """The definitions that a file has made so far; keys are names in lower case."""

    remarks: Remarks
    genesis: bool = False
    inertial: str = ""
    degrees: bool = True
    units: tuple[float, float, float] = (1.0, 1.0, 1.0)
    formed: bool = False
    shown: dict[str, str] = field(default_factory=dict)
    frames: dict[str, str] = field(default_factory=dict)
    bodies: dict[str, str] = field(default_factory=dict)
    particles: dict[str, str] = field(default_factory=dict)
    points: dict[str, str] = field(default_factory=dict)
    fixed: dict[str, str] = field(default_factory=dict)
    symbols: dict[str, Symbol] = field(default_factory=dict)
    primes: dict[str, int] = field(default_factory=dict)
    values: dict[str, Value] = field(default_factory=dict)
    kinematic: dict[Expr, Expr] = field(default_factory=dict)
    late: dict[Expr, Expr] = field(default_factory=dict)
    inputs: dict[str, Expr] = field(default_factory=dict)
    turns: dict[Pair, FileTurn] = field(default_factory=dict)
    spins: dict[Pair, Vec] = field(default_factory=dict)
    positions: dict[Pair, Vec] = field(default_factory=dict)
    velocities: dict[Pair, Vec] = field(default_factory=dict)
    accelerations: dict[Pair, tuple[Vec, Line]] = field(default_factory=dict)
    masses: dict[str, Expr] = field(default_factory=dict)
    inertias: dict[str, tuple[Dyad, str, Line]] = field(default_factory=dict)
    gravities: list[tuple[Vec, tuple[str, ...]]] = field(default_factory=list)
    forces: list[tuple[str, Vec, Line]] = field(default_factory=list)
    torques: list[tuple[str, Vec, Line]] = field(default_factory=list)
    constraints: list[tuple[Expr, Line]] = field(default_factory=list)
    dependent: list[Speed] = field(default_factory=list)
    auxiliary: list[Speed] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)
    given: set[str] = field(default_factory=set)
    prescribed: list[str] = field(default_factory=list)
    outputs: dict[Expr, tuple[str, Line]] = field(default_factory=dict)
    before: dict[Expr, Expr] = field(default_factory=dict)
    sought: dict[str, Line] = field(default_factory=dict)
    _paths: dict[Pair, Rows] = field(default_factory=dict)

    # Scalars ---------------------------------------------------------------------------------------------------------

    def parameter(self, name: str, default: float | None = None) -> Parameter:
        """A constant, declared on first use if necessary."""
        symbol = self.symbols.get(name.lower())
        if not isinstance(symbol, Parameter):
            symbol = Parameter.declare(name, default, "", "")
            self.symbols[name.lower()] = symbol
        return symbol

    def rate(self, e: Expr) -> Expr:
        """The time derivative, in which the kinematical equations defined so far replace rates of coordinates."""
        result = self.by_speeds(time_derivative(e))
        self.before[result] = e  # an equation in accelerations may be the derivative of one in speeds
        return result

    def by_speeds(self, e: Expr) -> Expr:
        """An expression in which kinematical equations replace rates."""
        return substituted(e, self.kinematic) if self.kinematic else e

    # Orientation -----------------------------------------------------------------------------------------------------

    def orient(self, turn: FileTurn) -> None:
        """Adds an orientation."""
        self.turns[turn.parent, turn.child] = turn
        self._paths.clear()

    def cosines(self, a: str, b: str) -> Rows:
        """The matrix of a_i · b_j."""
        if (a, b) not in self._paths:
            self._paths[a, b] = self._cosines(a, b)
        return self._paths[a, b]

    def _cosines(self, a: str, b: str) -> Rows:
        edges: dict[Pair, Rows] = {}
        for (p, c), turn in self.turns.items():
            edges[p, c] = turn.cosines
            edges[c, p] = transposed(turn.cosines)
        path = shortest_path(edges, a, b)
        if path is None:
            raise ModelError(
                f"Expected an orientation of {self.say(b)} in {self.say(a)}, got none. Write Simprot or Dircos first."
            )
        return reduce(product, (edges[step] for step in path), UNIT)

    def connected(self, a: str, b: str) -> bool:
        """Whether a chain of orientations connects two frames."""
        return shortest_path({**self.turns, **{(c, p): t for (p, c), t in self.turns.items()}}, a, b) is not None

    # Vectors ---------------------------------------------------------------------------------------------------------

    def express(self, v: Vec, frame: str) -> Vec:
        """The vector in components along the axes of one frame."""
        parts: list[tuple[tuple[str, int], Expr]] = []
        for (f, k), x in v.parts.items():
            if f == frame:
                parts.append(((f, k), x))
            else:
                parts += [((frame, i), row[k] * x) for i, row in enumerate(self.cosines(frame, f))]
        return gathered(parts)

    def components(self, v: Vec, frame: str) -> tuple[Expr, Expr, Expr]:
        """Measure numbers along the axes of a frame."""
        x, y, z = self.express(v, frame).components(frame)
        return x, y, z

    def dot(self, v: Vec, w: Vec) -> Expr:
        """v · w."""
        total: Expr = ZERO
        for (f, i), x in v.parts.items():
            for (g, j), y in w.parts.items():
                if f != g:
                    total = total + x * y * self.cosines(f, g)[i][j]
                elif i == j:
                    total = total + x * y
        return total

    def cross(self, v: Vec, w: Vec) -> Vec:
        """v × w."""
        total = Vec()
        for f in v.frames():
            a, b, c = v.components(f)
            for g in w.frames():
                p, q, r = self.components(w.within(g), f)
                total = total + along(f, (b * r - c * q, c * p - a * r, a * q - b * p))
        return total

    def magnitude(self, v: Vec) -> Expr:
        """|v|."""
        return sqrt(self.dot(v, v))

    def apply(self, dyad: Dyad, v: Vec) -> Vec:
        """I · v."""
        return sum((a.times(self.dot(b, v)) for a, b in dyad.terms), start=v.times(dyad.unit))

    def dt(self, v: Vec, frame: str) -> Vec:
        """The time derivative of a vector in a frame."""
        others = (f for f in v.frames() if f != frame)
        return sum((self.cross(self.spin(f, frame), v.within(f)) for f in others), start=v.map(self.rate))

    def spin(self, b: str, a: str) -> Vec:
        """The angular velocity of b in a: as assigned, else the sum of assigned ones and those of orientations between the frames."""
        return Vec() if a == b else self._added(b, a, self.spins)

    def turning(self, b: str, a: str) -> Vec:
        """The angular velocity of b in a from orientations only."""
        return self._added(b, a, {})

    def _added(self, b: str, a: str, told: dict[Pair, Vec]) -> Vec:
        """The sum of angular velocities from b to a: those in `told`, else those of orientations."""
        edges = {(q, p): t for (p, q), t in self.turns.items()} | self.turns | told
        edges |= {(p, q): v for (q, p), v in told.items()}
        path = shortest_path(edges, b, a)
        if path is None:
            raise ModelError(
                f"Expected an angular velocity of {self.say(b)} in {self.say(a)}, got neither it nor an orientation."
            )
        total = Vec()
        for c, p in path:
            if (c, p) in told or (p, c) in told:
                v = told[c, p] if (c, p) in told else told[p, c].times(-ONE)
            else:
                turn = self.turns.get((p, c))
                v = self._turning(turn) if turn else self._turning(self.turns[c, p]).times(-ONE)
            total = total + v
        return total

    def _turning(self, turn: FileTurn) -> Vec:
        if turn.axis is not None:
            return along(turn.parent, turn.axis).times(self.rate(turn.angle))
        x, y, z = transposed(turn.cosines)
        dx, dy, dz = ([self.rate(e) for e in column] for column in (x, y, z))
        pairs = ((dy, z), (dz, x), (dx, y))
        return along(turn.child, (dot(a, b) for a, b in pairs))

    # Points ----------------------------------------------------------------------------------------------------------

    def position_edges(self) -> dict[Pair, Vec]:
        """The positions of points from others, in both directions; assigned ones take precedence."""
        return {(b, a): v.times(-ONE) for (a, b), v in self.positions.items()} | self.positions

    def position(self, p: str, q: str) -> Vec:
        """The position vector from p to q."""
        edges = self.position_edges()
        path = shortest_path(edges, p, q)
        if path is None:
            raise ModelError(
                f"Expected a position of {self.say(q)} from {self.say(p)}, got none. Write P_{self.say(p)}_{self.say(q)}> first."
            )
        return sum((edges[step] for step in path), start=Vec())

    def velocity(self, p: str, frame: str) -> Vec:
        """The velocity as assigned, else that of another point plus the derivative of the position from it."""
        if (p, frame) in self.velocities:
            return self.velocities[p, frame]
        edges = self.position_edges()
        known = [q for q, f in self.velocities if f == frame] + [f"{frame}o"]
        for q in known:
            if shortest_path(edges, q, p) is not None:
                base = self.velocities.get((q, frame), Vec())
                return base + self.dt(self.position(q, p), frame)
        raise ModelError(
            f"Expected a velocity of {self.say(p)} in {self.say(frame)}, got neither it nor a position from a point whose velocity "
            "is known."
        )

    def carried(self, frame: str, body: str, p: str, q: str) -> Vec:
        """The velocity of q, where p and q are fixed in the body."""
        return self.velocity(p, frame) + self.cross(self.spin(body, frame), self.position(p, q))

    # Names such as P_No_Bo> --------------------------------------------------------------------------------------------

    def pair(self, head: str, rest: str) -> Pair | None:
        """The points or frames in a name such as P_No_Bo>, of kinds that `head` determines; None for other names."""
        if head not in _PAIRS:
            return None
        first, second = (getattr(self, kind) for kind in _PAIRS[head])
        return next(((a, b) for a, b in splits(rest) if a in first and b in second), None)

    def place(self, head: str, a: str, b: str, v: Vec, line: Line) -> None:
        """Stores a position, velocity, angular velocity or acceleration; an angular acceleration is ignored, because it follows."""
        if head == "a":
            self.accelerations[a, b] = (v, line)
        elif head != "alf":
            store = {"v": self.velocities, "w": self.spins}.get(head, self.positions)
            if head != "v":
                store.pop((b, a), None)
            store[a, b] = v

    def found(self, head: str, a: str, b: str) -> Vec:
        """The same quantity, as assigned or else derived."""
        if head == "a":
            return self.accelerations[a, b][0] if (a, b) in self.accelerations else self.dt(self.velocity(a, b), b)
        if head == "alf":
            return self.dt(self.spin(a, b), b)
        return {"v": self.velocity, "w": self.spin}.get(head, self.position)(a, b)

    def act(self, loads: list[tuple[str, Vec, Line]], on: str, back: str, v: Vec, line: Line) -> None:
        """Adds a force or torque on a point or frame, and its opposite on another one."""
        loads += [(on, v, line), (back, v.times(-ONE), line)]

    def say(self, name: str) -> str:
        """A name as written in the file."""
        return self.shown.get(name, name)


_POINTS, _FRAMES = "points", "frames"
_PAIRS = {
    "p": (_POINTS, _POINTS), "r": (_POINTS, _POINTS), "v": (_POINTS, _FRAMES), "a": (_POINTS, _FRAMES), "w": (_FRAMES, _FRAMES),
    "alf": (_FRAMES, _FRAMES),
}  # fmt: skip
"""The kinds of the two parts of a name, by its head."""


def splits(name: str) -> Iterator[tuple[str, str]]:
    """The ways to split a name at an underscore."""
    for match in re.finditer("_", name):
        yield name[: match.start()], name[match.end() :]


def shortest_path(edges: Mapping[tuple[K, K], X], start: K, end: K) -> list[tuple[K, K]] | None:
    """The shortest path along edges, with a preference for earlier ones; None if there is none."""
    if start == end:
        return []
    near: dict[K, list[K]] = {}
    for a, b in edges:
        near.setdefault(a, []).append(b)
    before: dict[K, K] = {start: start}
    queue = deque([start])
    while queue:
        here = queue.popleft()
        for there in near.get(here, ()):
            if there not in before:
                before[there] = here
                queue.append(there)
    if end not in before:
        return None
    path = []
    while end != start:
        path.append((before[end], end))
        end = before[end]
    return path[::-1]


def simple(parent: str, child: str, axis: tuple[Expr, ...], angle: Expr) -> FileTurn:
    """A simple rotation about a unit vector, which has these components in both frames."""
    c, s = cos(angle), sin(angle)
    rest = ONE - c
    rows = [[axis[i] * axis[j] * rest for j in range(3)] for i in range(3)]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        rows[i][i] = rows[i][i] + c if axis[i] is not ONE else ONE
        rows[k][j] = rows[k][j] + axis[i] * s
        rows[j][k] = rows[j][k] - axis[i] * s
    return FileTurn(parent, child, tuple(tuple(row) for row in rows), axis, angle)


def of_euler(parent: str, child: str, e: tuple[Coordinate, ...]) -> FileTurn:
    """An orientation by Euler parameters, the scalar last (Kane, Likins & Levinson 1983, sec. 1.3)."""
    a, b, c, d = e
    two = ONE + ONE
    rows: Rows = (
        (ONE - two * (b * b + c * c), two * (a * b - c * d), two * (c * a + b * d)),
        (two * (a * b + c * d), ONE - two * (c * c + a * a), two * (b * c - a * d)),
        (two * (c * a - b * d), two * (b * c + a * d), ONE - two * (a * a + b * b)),
    )
    return FileTurn(parent, child, rows, euler=e)


def of_rodrigues(parent: str, child: str, rho: tuple[Expr, ...]) -> FileTurn:
    """An orientation by Rodrigues parameters."""
    rows = cosines_of(np.array((ONE, *rho), dtype=object), unit=False)
    return FileTurn(parent, child, tuple(tuple(row) for row in rows), rodrigues=rho)
