# SPDX-License-Identifier: BSD-3-Clause
"""The frames and points of a sheet as objects of kane, consistent with the velocities that the file assigns.

If the file assigns an angular velocity without an orientation, or one that differs from that of the orientation, the body gets an
additional frame with this angular velocity: rotated by an angle if the axis is fixed, else by Euler parameters. A point whose velocity
differs from the derivative of its position is displaced by three lengths. Rows are the kinematical equations of these coordinates.
"""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

from kane.errors import ModelError
from kane.expr.node import ONE, ZERO, Expr, constant_value
from kane.expr.symbols import Coordinate, Parameter
from kane.expr.visit import substituting
from kane.interop.autolev.model import LastForm, agree
from kane.interop.autolev.sheet import FileTurn, Sheet, shortest_path
from kane.interop.autolev.values import Dyad, Vec
from kane.interop.driven import GivenRates, moved, spinning, turned_about, turned_freely
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector


@dataclass(frozen=True, slots=True, eq=False)
class RateRow:
    """A kinematical equation: an expression in rates equals an affine function of speeds."""

    rates: Expr
    value: Expr
    made: bool = False


class Space:
    """Frames and points by the names of the file, and the kinematical equations of additional coordinates."""

    def __init__(self, sheet: Sheet, names: LastForm) -> None:
        self.sheet, self.names = sheet, names
        self.rows: list[RateRow] = []
        self.groups: list[tuple[Coordinate, ...]] = []
        self.euler: dict[Expr, Expr] = {}
        root = Frame(sheet.say(sheet.inertial))
        self.frames: dict[str, Frame] = {sheet.inertial: root}
        self.turning: dict[str, Frame] = {sheet.inertial: root}
        self._noted: list[tuple[Frame, Vec]] = []
        self._orient()
        self._drive()
        self._apply_angular_velocities()
        self.origin = Point(f"{sheet.say(sheet.inertial)}O", fixed_in=root)
        self.points: dict[str, Point] = {f"{sheet.inertial}o": self.origin}
        self._told = self._velocities()
        self._locate_points()

    @property
    def root(self) -> Frame:
        """The inertial frame."""
        return self.frames[self.sheet.inertial]

    def by_speeds(self, e: Expr) -> Expr:
        """An expression in which functions of speeds replace all rates."""
        changes = {**self.names.kinematic, **self.euler, **{r.rates: r.value for r in self.rows if r.made}}
        return substituting(changes)(self.names.final(e))

    def vector(self, v: Vec) -> Vector:
        """A vector of the file in its final form."""
        return self._vector(self.names.vector(v))

    def _vector(self, v: Vec) -> Vector:
        total = Vector()
        for (name, k), x in v.parts.items():
            frame = self.frames.get(name)
            if frame is None:
                raise ModelError(
                    f"Expected an orientation of {self.sheet.say(name)}, got none. Write Simprot or Dircos."
                )
            total = total + (frame.x, frame.y, frame.z)[k] * x
        return total

    def inertia(self, dyad: Dyad, body: str) -> Dyadic:
        """The inertia dyadic of a body, along the axes of the frame with the body's angular velocity.

        Axes of another frame are replaced by the body's if it rotates about one of them and the moments about the others are equal.
        """
        own, told = self.turning[body], self.frames.get(body)
        whole = Dyadic((self._turned(a, told, own), self._turned(b, told, own)) for a, b in dyad.terms)
        others = [f for f in whole.frames() if f is not own]
        if len(others) != 1 or len(whole.frames()) > 1:
            return whole
        rows = whole.components(others[0]).rows
        if any(x is not ZERO for i, row in enumerate(rows) for j, x in enumerate(row) if i != j):
            return whole
        axes = [a.components(others[0])[k] for k, a in enumerate((own.x, own.y, own.z))]
        for k in range(3):
            first, second = rows[k - 2][k - 2], rows[k - 1][k - 1]
            if axes[k] is ONE and self._one_value(first, second, body):
                diagonal = [rows[k][k] if i == k else first for i in range(3)]
                return Dyadic.of(own, [[diagonal[i] if i == j else ZERO for j in range(3)] for i in range(3)])
        same = rows[0][0] is rows[1][1] is rows[2][2]
        return Dyadic.of(own, rows) if same else whole

    def _turned(self, v: Vec, told: Frame | None, own: Frame) -> Vector:
        """A vector in which the axes of `own` replace those of `told`."""
        return Vector((own if f is told else f, xyz) for f, xyz in self.vector(v).parts)

    def _one_value(self, a: Expr, b: Expr, body: str) -> bool:
        """Whether two moments of inertia are identical, or constants with equal defaults."""
        if a is b:
            return True
        if isinstance(a, Parameter) and isinstance(b, Parameter) and a.default is not None and a.default == b.default:
            text = f"{b.name} is {a.name}: {self.sheet.say(body)} turns in the frame that its inertia is given in"
            self.sheet.remarks.say("changed", text)
            return True
        return False

    def components(self, v: Vector) -> list[Expr]:
        """Measure numbers along the inertial axes, with rates expressed by speeds."""
        return [self.by_speeds(x) for x in v.components(self.root)]

    def same(self, mine: Vector, told: Vec) -> bool:
        """Whether a velocity in terms of rates agrees with that of the file."""
        return agree(self.components(mine), self.components(self.vector(told)), self.groups)

    # Frames ----------------------------------------------------------------------------------------------------------

    def _orient(self) -> None:
        """Makes frames with an orientation, from the inertial one outwards; then those with an angular velocity only."""
        waiting = True
        while waiting:
            waiting = False
            for turn in self.sheet.turns.values():
                for a, b, forth in ((turn.parent, turn.child, True), (turn.child, turn.parent, False)):
                    if a in self.frames and b not in self.frames:
                        self.frames[b] = self._oriented(self.frames[a], b, turn, forth=forth)
                        waiting = True
            waiting = waiting or self._next_spin()

    def _oriented(self, parent: Frame, name: str, turn: FileTurn, *, forth: bool) -> Frame:
        shown, f = self.sheet.say(name), self.names.geometric
        if turn.axis is not None:
            units = zip((parent.x, parent.y, parent.z), turn.axis, strict=True)
            axis, angle = sum((unit * f(x) for unit, x in units), start=Vector()), f(turn.angle)
            return parent.rotate(shown, angle if forth else -angle, axis)
        if turn.euler:
            x, y, z, w = turn.euler
            signed = (w, x, y, z)
            if forth:
                self.groups.append(signed)
                frame = parent.rotate_euler_parameters(shown, signed)
                self._noted.append(
                    (frame, self.sheet.spin(turn.child, turn.parent))
                )  # its quasi-rates are set when all frames exist
                return frame
        if turn.rodrigues:
            rho = [f(x) for x in turn.rodrigues]
            return parent.rotate_rodrigues_parameters(shown, rho if forth else [-x for x in rho])
        rows = [[f(x) for x in row] for row in turn.cosines]
        return parent.rotate_matrix(shown, rows if forth else [list(c) for c in zip(*rows, strict=True)])

    def _drive(self) -> None:
        """Sets the quasi-rates, when all frames exist."""
        for frame, told in self._noted:
            self._set_quasi(frame, self.vector(told))

    def _set_quasi(self, frame: Frame, spin: Vector) -> None:
        driven = spinning(frame, map(self.names.final, spin.components(frame)))
        self.euler |= dict(driven.rates)
        self._drive_by(driven)

    def _drive_by(self, driven: GivenRates) -> None:
        self.rows += [RateRow(left, right, made=True) for left, right in driven.rates]

    def _about(self, base: Frame, name: str, axis: int, spin: Expr, shown: str) -> Frame:
        """A frame rotated about an axis of another one by an additional angle, whose name begins with `shown`."""
        frame, driven = turned_about(base, name, axis, spin, partial(self._new, shown))
        self._drive_by(driven)
        return frame

    def _freely(self, base: Frame, name: str, shown: str) -> Frame:
        """A frame rotated by additional Euler parameters."""
        frame, e = turned_freely(base, name, partial(self._new, shown))
        self.groups.append(e)
        return frame

    def _next_spin(self) -> bool:
        """Makes a frame that has an angular velocity in an existing frame, and no orientation; False if there is none."""
        used = self._used()
        for (b, a), v in self.sheet.spins.items():
            for child, parent, told in ((b, a, v), (a, b, v.times(-ONE))):
                if parent in self.frames and child not in self.frames and child in used:
                    self.frames[child] = self._spinning(child, parent, told, self.sheet.say(child))
                    self.sheet.remarks.say(
                        "inferred", f"{self.sheet.say(child)} has an angular velocity in {self.sheet.say(parent)} and no orientation: "
                        "it gets additional coordinates"
                    )  # fmt: skip
                    return True
        return False

    def _used(self) -> set[str]:
        """The frames of bodies, those along which vectors are written, and those from which others are oriented."""
        s = self.sheet
        loads = [v for _, v, _ in (*s.forces, *s.torques)]
        dyads = [v for dyad, _, _ in s.inertias.values() for pair in dyad.terms for v in pair]
        vectors = [*s.positions.values(), *s.velocities.values(), *s.spins.values(), *loads, *dyads]
        between = [f for pair in (*s.turns, *s.spins) for f in pair]
        named = [f for f in s.frames if between.count(f) > 1]
        return {*s.bodies, *named, *(f for v in vectors for f in v.frames()), *(f for f, _, _ in s.torques)}

    def _spinning(self, child: str, parent: str, told: Vec, shown: str) -> Frame:
        """A frame with an angular velocity in its parent, by additional coordinates."""
        base, spin = self.frames[parent], self.names.vector(told)
        others = [f for f in spin.frames() if f != child and f not in self.frames]
        alone = (
            set(spin.frames()) == {child} and len(spin.parts) == 1
        )  # about an axis of its own, which is then fixed in the parent too
        if not others and (alone or child not in spin.frames()):
            ahead = Vec({(parent, k): x for (_, k), x in spin.parts.items()}) if alone else told
            x = self.vector(ahead).components(base)
            turning = [k for k in range(3) if x[k] is not ZERO]
            if not turning:
                return base.rotate(shown, 0, base.z)
            if len(turning) == 1:
                return self._about(base, shown, turning[0], x[turning[0]], shown)
        frame = self._freely(base, shown, shown)
        self._noted.append((frame, told))
        return frame

    def _new(self, of: str, what: str) -> Coordinate:
        name = f"{of}_{what}"
        taken = {s.name for s in self.sheet.symbols.values()}
        while name in taken:
            name += "_"
        return Coordinate.declare(name, None, "", "")

    def _apply_angular_velocities(self) -> None:
        """Gives each body the frame of its name, or an additional frame if the file assigns a different angular velocity."""
        for body in self.sheet.bodies:
            frame = self.frames.get(body)
            if frame is None:
                if body in self.sheet.masses:
                    raise ModelError(
                        f"Expected an orientation or angular velocity of the body {self.sheet.say(body)}, got neither. Write Simprot, "
                        f"Dircos or W_{self.sheet.say(body)}_{self.sheet.say(self.sheet.inertial)}>."
                    )
                continue
            told = self.sheet.spin(body, self.sheet.inertial)
            mine = frame.angular_velocity(self.root)
            self.turning[body] = frame
            if self.same(mine, told):
                continue
            if mine.is_zero and set(told.frames()) == {body} and not any(p == body for p, _ in self.sheet.turns):
                self.turning[body] = self.frames[body] = self._from_start(body, frame, told)
                continue
            extra = self.vector(told) - mine.map(self.by_speeds)
            self.turning[body] = self._extra(body, frame, extra)

    def _from_start(self, body: str, start: Frame, told: Vec) -> Frame:
        """The frame of a body with an angular velocity along its axes and a constant orientation, which is the initial one."""
        made = self._freely(start, f"{self.sheet.say(body)}_turning", self.sheet.say(body))
        self.frames[body] = made
        self._set_quasi(made, self.vector(told))
        text = f"{self.sheet.say(body)} has an angular velocity, and a constant orientation, which is used as the initial one"
        self.sheet.remarks.say("inferred", text)
        return made

    def _extra(self, body: str, frame: Frame, extra: Vector) -> Frame:
        shown = self.sheet.say(body)
        spin = tuple(map(self.names.final, extra.components(frame)))
        big = [k for k in range(3) if not agree([spin[k]], [ZERO], self.groups)]
        self.sheet.remarks.say(
            "inferred", f"{shown} does not turn as its orientation implies: it gets additional coordinates"
        )
        if len(big) == 1:
            return self._about(frame, f"{shown}_turning", big[0], spin[big[0]], shown)
        made = self._freely(frame, f"{shown}_turning", shown)
        self._set_quasi(made, extra)
        return made

    # Points ----------------------------------------------------------------------------------------------------------

    def _centers(self) -> list[str]:
        """Mass centres: geometric points, whose acceleration is the derivative of their velocity."""
        return [self.sheet.bodies.get(name, name) for name in self.sheet.masses]

    def needed(self) -> list[str]:
        """Points that the model needs: mass centres and points where forces act."""
        s = self.sheet
        about = [point for body, (_, point, _) in s.inertias.items() if body in s.masses]
        return list(dict.fromkeys([*self._centers(), *about, *(p for p, _, _ in s.forces)]))

    def _velocities(self) -> dict[str, Vec]:
        """The inertial velocities of points: those of the file, and derived ones for points that the model needs."""
        s, n = self.sheet, self.sheet.inertial
        told = {p: Vec() for (p, f), (a, _) in s.accelerations.items() if f == n and not a.parts and p in s.points}
        told |= {p: v for (p, f), v in s.velocities.items() if f == n}
        for p in self.needed():
            with suppress(ModelError):  # the point has a position from one at rest, or no position
                told.setdefault(p, s.velocity(p, n))
        return told

    def _locate_points(self) -> None:
        s, n = self.sheet, self.sheet.inertial
        edges = s.position_edges()
        wanted = self._needed_points(edges)
        while True:
            open_ = [p for p in wanted if p not in self.points]
            if not open_:
                return
            made = next((p for p in open_ if self._near(p, edges)), None)
            if made is None and not self._by_velocity(open_, edges) and not self._massless(open_):
                name, base = s.say(open_[0]), s.say(n)
                raise ModelError(
                    f"Expected a position of {name} from {base}O or from a point fixed in {base}, or its velocity in {base}, got none "
                    f"of them. Write V_{name}_{base}>."
                )

    def _needed_points(self, edges: dict[tuple[str, str], Vec]) -> list[str]:
        """The needed points, and those between them and points at rest."""
        s = self.sheet
        wanted: dict[str, None] = {}
        roots = [
            self.sheet.inertial + "o",
            *(p for (p, f), v in s.velocities.items() if f == s.inertial and not v.parts),
        ]
        for p in self.needed():
            wanted[p] = None
            for root in roots:
                path = shortest_path(edges, root, p)
                if path is not None:
                    wanted = {a: None for a, _ in path} | {b: None for _, b in path} | wanted
                    break
        return list(wanted)

    def _near(self, p: str, edges: dict[tuple[str, str], Vec]) -> bool:
        """Locates a point relative to an existing one, if its velocity is then that of the file; whether it did."""
        s = self.sheet
        told = self._told.get(p)
        if told is not None and not told.parts and not any(b == p and a in self.points for a, b in edges):
            self.points[p] = self.origin.at(s.say(p), 0)
            return True
        for (a, b), v in edges.items():
            base = self.points.get(a)
            if b != p or base is None or base.body is not None or not set(v.frames()) <= self.frames.keys():
                continue
            offset = self._vector(v.map(self.names.geometric))
            point = base.at(s.say(p), offset)
            if told is None or self.same(point.velocity(self.root), told):
                self.points[p] = point
                return True
            if p in self._centers():
                continue
            for frame in dict.fromkeys((*self.turning.values(), *self.frames.values())):
                particle = base.fixed_in(frame, s.say(p), offset)
                if self.same(particle.velocity(self.root), told):
                    self.points[p] = particle
                    return True
        return False

    def _massless(self, open_: Iterable[str]) -> bool:
        """Places the centre of a massless body at the body's origin or at that of the inertial frame, because it does not matter."""
        s = self.sheet
        bodies = {
            s.bodies[b]: b for b, m in s.masses.items() if b in s.bodies and constant_value(self.names.final(m)) == 0
        }
        p = next((p for p in open_ if p in bodies), None)
        if p is None:
            return False
        self.points[p] = self.points.get(f"{bodies[p]}o", self.origin).at(s.say(p), 0)
        s.remarks.say("inferred", f"{s.say(p)} has no position; {s.say(bodies[p])} has no mass, so that none is needed")
        return True

    def _by_velocity(self, open_: Iterable[str], edges: dict[tuple[str, str], Vec]) -> bool:
        """Gives the first point that has a velocity additional coordinates, whose rates are the velocity; whether it did."""
        s = self.sheet
        told = next(((p, v) for p, v in self._told.items() if p in set(open_)), None)
        if told is None:
            return False
        p, v = told
        velocity = self.components(self.vector(v))
        self.points[p], driven = moved(self.origin, s.say(p), self.root, velocity, partial(self._new, s.say(p)))
        self._drive_by(driven)
        positioned = any(b == p for _, b in edges)
        why = "has a velocity that is not the rate of its position" if positioned else "has a velocity and no position"
        s.remarks.say("inferred", f"{s.say(p)} {why}: it gets additional coordinates, driven by its velocity")
        return True
