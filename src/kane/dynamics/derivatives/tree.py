# SPDX-License-Identifier: BSD-3-Clause
"""∂u̇/∂x of trees: inverse dynamics differentiated with u̇ held, ∂u̇/∂x = −M⁻¹ ∂g/∂x, g = M ẇ + … what each joint speed leaves.

A symbol x changes the motion of some segments relative to the one before. At such a segment and above, the moment and force of all
that hangs on it change (`wholes`), and go to the ground as those of the motion do; below it, the row of each freedom comes up to
the segment and is multiplied by the change. M is composite, factored along the branches without fill.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce
from typing import NamedTuple, TypeVar

from kane.dynamics.assembly import sum_of
from kane.dynamics.derivation import Derived
from kane.dynamics.derivatives.changes import Changes, changes
from kane.dynamics.derivatives.stages import Stage, total
from kane.dynamics.derivatives.wholes import Row, Whole, alone
from kane.dynamics.routes.articulated import parts
from kane.dynamics.routes.block_solution import sparse_order
from kane.dynamics.routes.composite import accelerations
from kane.dynamics.routes.places import Place, working
from kane.dynamics.trees.inverse_dynamics import joint_mass
from kane.dynamics.trees.line import Line, Motion, Vectors, line_of, motions, passed_on, pressing
from kane.expr.build import add, neg
from kane.expr.differentiation import tangent
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.solve import finish, forward, ldl
from kane.expr.symbols import Symbol
from kane.kinematics.resolved import resolved

Along = TypeVar("Along", Row, Whole)
Columns = dict[Symbol, Vectors]
Exprs = tuple[Expr, ...]


def acceleration_slopes(
    derived: Derived, u_dot: Sequence[Expr], symbols: Sequence[Symbol], route: str
) -> list[Sequence[Expr]]:
    """∂u̇/∂symbols, a column for each symbol; Unsuited where the system is no tree of joint speeds.

    `route` is the recursion that found u̇, or would; λ are held, and u̇ follow from them.
    """
    line = line_of(derived, u_dot, route)
    if route == "composite":
        line = body_by_body(line)
    moving = motions(line)
    g = Tree(line, moving, changes(line, moving, symbols), symbols).left()

    def speeds_by(*lambdas: Expr) -> Exprs:
        found = resolved(((p.freedom.row, x) for p, x in zip(line.places, lambdas, strict=True)), derived.kinematics)
        return tuple(found[u] for u in derived.speeds)

    last = Stage(speeds_by, line.lambdas)
    columns = []
    for x, change in zip(symbols, _solved(line, g), strict=True):
        both = [None if change is None else last.along(change), last.slope(x)]
        columns.append(total(both) or [ZERO] * len(derived.speeds))
    return columns


def body_by_body(line: Line) -> Line:
    """The line with λ of what its bodies press with one by one, as they do in g, with which composite bodies would share nothing."""
    way = line.way
    rows = accelerations(way.on.steps, line.bodies, line.loads, line.ground, body_by_body=True).rows
    return replace(line, lambdas=[x for _, x in rows])


def _solved(line: Line, g: "Left") -> Iterator[Sequence[Expr] | None]:
    """∂λ/∂x = −M⁻¹ ∂g/∂x, None where it is zero."""
    mass = joint_mass(line)
    order = sparse_order(mass.rows)
    factors = ldl(mass.take(order, order).rows)
    for x in g.symbols:
        right = [neg(g.entries.get((i, x), ZERO)) for i in order]
        if all(e is ZERO for e in right):
            yield None
            continue
        value = dict(zip(order, finish(factors, forward(factors.lower, right)), strict=True))
        yield [value[i] for i in range(len(order))]


class Left(NamedTuple):
    """∂g/∂x by the number of the joint speed and x."""

    entries: dict[tuple[int, Symbol], Expr]
    symbols: Sequence[Symbol]

    def add(self, place: Place, x: Symbol, value: Expr) -> None:
        """One more part."""
        key = place.number, x
        self.entries[key] = add(self.entries.get(key, ZERO), value)

    def felt(self, places: Sequence[Place], columns: Columns, force: Vectors) -> None:
        """What changed moments and forces do to freedoms, and what moment and force do to changed ones."""
        wanted = frozenset(self.symbols)
        for place in places:
            axes = parts(place.freedom, place.turning)
            for x, v in columns.items():
                self.add(place, x, sum_of(map(dot, axes, v)))
            for x in free_symbols([*axes[0], *axes[1]]):
                if x in wanted:
                    changed = [[tangent(e, {x: ONE}) for e in axis] for axis in axes]
                    self.add(place, x, sum_of(map(dot, changed, force)))


class Tree(NamedTuple):
    """Segments in motion, and how that changes."""

    line: Line
    moving: Sequence[Motion]
    changed: Sequence[Changes]
    symbols: Sequence[Symbol]

    def left(self) -> Left:
        """∂g/∂symbols."""
        g, wholes, on = Left({}, self.symbols), self.wholes(), self.line.way.on
        forces: list[Vectors | None] = [None] * len(wholes)
        columns: list[Columns] = [{} for _ in wholes]
        for i in reversed(range(1, len(wholes))):
            press, work = pressing(self.line, i), self.moving[i].work
            held = Stage(press, work)
            force = total([press(*work, on.rates[i].square), forces[i]])
            assert force is not None
            for x, change in self.changed[i].items():
                _join(columns[i], x, wholes[i].pressed(change))
            self._explicit(columns[i], held)
            self._upwards(i, force, forces, columns, g)
            self._below(i, wholes[i], g)
        return g

    def wholes(self) -> list[Whole]:
        """What hangs on each segment."""
        on = self.line.way.on
        found = [alone(working(on, i, body), on.rates[i].work) for i, body in enumerate(self.line.bodies)]
        for i in reversed(range(1, len(found))):
            parent = self.line.parent(i)
            if parent:
                found[parent] = found[parent].plus(self._before(i, found[i]))
        return found

    def _before(self, i: int, along: Along) -> Along:
        """From a segment's origin and basis of work to those of its parent."""
        line, turn = self.line, self.line.own_turn(i)
        along = along if turn is None else along.turned(turn)
        return reduce(lambda v, turn: v.turned(turn), line.back(i), along.moved(line.arm(i), line.velocity(i)))

    def _upwards(self, i: int, force: Vectors, forces: list[Vectors | None], columns: list[Columns], g: Left) -> None:
        """The moment and force of a segment to its parent, with the changes of both; freedoms feel these on the way."""
        own, parent = columns[i], self.line.parent(i)
        g.felt(self.line.way.inner[i], own, force)
        for k, make in enumerate(passed_on(self.line, i)):
            own = {x: make(*v) for x, v in own.items()}
            self._explicit(own, Stage(make, force))
            force = make(*force)
            if k == 0:
                g.felt(self.line.way.outer[i], own, force)
        if parent:
            forces[parent] = total([forces[parent], force])
            for x, v in own.items():
                _join(columns[parent], x, v)

    def _explicit(self, columns: Columns, stage: Stage) -> None:
        for x in self.symbols:
            _join(columns, x, stage.slope(x))

    def _below(self, i: int, whole: Whole, g: Left) -> None:
        """What changes of motion before a segment do to its freedoms."""
        turn = self.line.own_turn(i)
        for place in (*self.line.way.inner[i], *self.line.way.outer[i]):
            axes = parts(place.freedom, place.turning)
            if turn is not None and any(p is place for p in self.line.way.outer[i]):
                axes = turn.down(axes[0]), turn.down(axes[1])
            row, k = whole.row(*axes), i
            while k and self._changes_before(k):
                row, k = self._before(k, row), self.line.parent(k)
                for x, change in self.changed[k].items():
                    g.add(place, x, row.times(change))

    def _changes_before(self, i: int) -> bool:
        while i:
            i = self.line.parent(i)
            if self.changed[i]:
                return True
        return False


def _join(columns: Columns, x: Symbol, v: Vectors | None) -> None:
    found = total([columns.get(x), v])
    if found is not None:
        columns[x] = found
