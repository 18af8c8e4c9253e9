# SPDX-License-Identifier: BSD-3-Clause
"""The constraint manifold: configurations with f(q, t) = 0 and eᵀe = 1, found by Newton's method from many starts.

Scalar products of axes, which constrain an orientation, vanish at other orientations too: with an axis reversed, or a frame rotated
by a half or a third of a turn. Each closure gives the cosine of its angle from the branch that is meant, 1 on that branch.

Choices that hold for a whole motion, as of dependent speeds, are made at several configurations: from many random starts, so that
each branch found has several, and from all coordinates zero, since motions often begin upright or straight.

The module also finds contact points: particles of bodies whose velocity constraints determine.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from kane.errors import ModelError
from kane.expr.build import sub
from kane.expr.differentiation import jacobian
from kane.expr.evaluation import Reference, compile_reference, free_symbols, is_constant_in_time
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import AuxiliarySpeed, Parameter, Speed, Symbol, input_of, time
from kane.kinematics.speeds import Sample
from kane.kinematics.velocities import ContactPoint, Kinematics
from kane.model.constraints import ClosureBranch, Constraint
from kane.model.system import System
from kane.numeric.arrays import Array, Indices, Mask, spread
from kane.numeric.newton import Closed, ClosedMany, NaturalSizes, close, close_many, close_most, sizes
from kane.numeric.sampling import ASSEMBLY_SEED, HIGH, LOW, SEED, SEEDS, draw, finite_number, named_values, values_of
from kane.numeric.scale import CLOSED, CLOSED_NEARLY, LAST_DIGIT, ROUNDED_CHAIN, bounded
from kane.space.frame import Point
from kane.space.rotation import Basis
from kane.space.vector import Vector

ROWS = 16
"""How many configurations are looked at one by one."""
_PARALLEL = 1e-4
"""Up to which a product of unit vectors vanishes at a configuration that was closed: a root of what it may leave open, and more."""
_DRAWN, _BESIDE = 11, 0.37
"""The number of values of a coordinate within a turn by which its size is determined, and where they are, so that none is special."""
_EVERY = slice(None)


@dataclass(frozen=True, eq=False)
class Manifold:
    """The configuration constraints f = 0 of a system, with their `names`; those of Euler parameters last."""

    system: System
    names: tuple[str, ...]
    f: tuple[Expr, ...]

    @cached_property
    def gradient(self) -> Matrix:
        """∂f/∂q (m × n)."""
        q = self.system.coordinates
        return jacobian(self.f, q) if self.f else Matrix([], (0, len(q)))

    @cached_property
    def branches(self) -> tuple[ClosureBranch, ...]:
        """The branches that the closures mean, each once."""
        return branches(self.system)

    @cached_property
    def symbols(self) -> tuple[Symbol, ...]:
        """The symbols in the constraints."""
        return tuple(free_symbols(self.f))

    @cached_property
    def _references(self) -> dict[tuple[tuple[Expr, ...], tuple[Any, ...]], Reference]:
        return {}

    def reference(self, exprs: Sequence[Expr], leaves: Sequence[Any]) -> Reference:
        """`compile_reference` of expressions, compiled once for each pair of expressions and symbols."""
        key = tuple(exprs), tuple(leaves)
        if key not in self._references:
            self._references[key] = compile_reference(*key)
        return self._references[key]

    def at(self, values: Mapping[Any, Any]) -> "LevelSet":
        """The manifold at `values` of all symbols but the coordinates: numbers, or arrays with one number per start."""
        n = len(self.system.coordinates)
        return LevelSet(self, values, np.zeros(n), tuple(range(n)))


def manifold(system: System) -> Manifold:
    """The configuration constraints of a system."""
    f = [c.expr for c in system.holonomic]
    names = [c.name for c in system.holonomic]
    for s in system.euler_parameters:
        f.append(sub(dot(s.coordinates, s.coordinates), ONE))
        names.append(f"unit length of ({', '.join(e.name for e in s.coordinates)})")
    return Manifold(system, tuple(names), tuple(f))


@dataclass(frozen=True, eq=False)
class LevelSet:
    """The manifold at `values` of all other symbols: `free` coordinates (indices) vary, the others are at `base`."""

    manifold: Manifold
    values: Mapping[Any, Any]
    base: Array
    free: tuple[int, ...]
    compiled: Callable[[Array, Indices | slice], Array] | None = None

    def of(self, base: Array, free: Sequence[int]) -> "LevelSet":
        """The manifold with only the coordinates `free` varying, the others at `base`."""
        return replace(self, base=base, free=tuple(free))

    @cached_property
    def _run(self) -> Callable[[Array, Indices | slice], Array]:
        return self._evaluated([*self.manifold.f, *self.manifold.gradient.entries])

    @cached_property
    def _cosines(self) -> Callable[[Array, Indices | slice], Array]:
        return self._evaluated(branch_scalars(self.manifold.branches))

    def _evaluated(self, exprs: Sequence[Expr]) -> Callable[[Array, Indices | slice], Array]:
        """A function of q (k × n) and the numbers of the starts, with values (k × …) of the expressions."""
        q, read = self.manifold.system.coordinates, set(free_symbols(exprs))
        rest = [s for s in self.values if s in read and s not in set(q)]
        run = self.manifold.reference(exprs, [*q, *rest])
        given = [self.values[s] for s in rest]
        return lambda x, starts: in_rows(run, x, [v if np.ndim(v) == 0 else v[starts] for v in given])

    def numbers(self, q: Array, starts: Indices | slice = _EVERY) -> tuple[Array, Array]:
        """f (k × m) and ∂f/∂q (k × m × n) at q (k × n)."""
        values, m = (self.compiled or self._run)(q, starts), len(self.manifold.f)
        return values[:, :m], values[:, m:].reshape(len(q), m, len(self.base))

    def one(self, q: Array) -> tuple[Array, Array]:
        """f (m) and ∂f/∂q (m × n) at q (n)."""
        f, g = self.numbers(q[None])
        return f[0], g[0]

    def whole(self, x: Array) -> Array:
        """q (k × n) from the free coordinates (k × free)."""
        if len(self.free) == len(self.base):
            return x
        q = np.tile(self.base, (len(x), 1))
        q[:, list(self.free)] = x
        return q

    def of_free(self, x: Array, starts: Indices) -> tuple[Array, Array]:
        """f (k × m) and its derivatives by the free coordinates (k × m × free), at x (k × free)."""
        f, g = self.numbers(self.whole(x), starts)
        return f, g if len(self.free) == len(self.base) else g[:, :, list(self.free)]

    def rounding(self, x: Array, starts: Indices) -> Array:
        """A bound on the rounding error of f (k × m) at x (k × free)."""
        own = {s: v if np.ndim(v) == 0 else np.asarray(v)[starts] for s, v in self.values.items()}
        own |= zip(self.manifold.system.coordinates, self.whole(x).T, strict=True)
        return spread([e for _, e in bounded(self.manifold.f, own)], (len(x),)).T

    def sizes(self, x: Array, by_thousands: bool = True) -> NaturalSizes:
        """The natural sizes of the free coordinates and of the terms of f, from random points x (k × free)."""
        q = self.manifold.system.coordinates
        unit = {e for s in self.manifold.system.euler_parameters for e in s.coordinates}
        among = [k for k, i in enumerate(self.free) if q[i] in unit]
        return sizes(self.of_free, x, among, self.rounding, by_thousands)

    @cached_property
    def usual(self) -> NaturalSizes:
        """The natural sizes, the same in any units and order of declaration, from zero and _DRAWN points.

        Each coordinate takes the same values there, in an order of its own, so that those of equal roles have equal sizes.
        """
        q, count = self.manifold.system.coordinates, range(_DRAWN)
        order = [np.argsort([draw(ASSEMBLY_SEED + k, q[i]) for k in count]) for i in self.free]
        drawn = np.reshape(order, (len(self.free), _DRAWN)).T + _BESIDE
        points = np.vstack([np.zeros(len(self.free)), np.pi * (2 * drawn / _DRAWN - 1)])
        return self.sizes(points, by_thousands=False)

    @cached_property
    def metric(self) -> Array:
        """The sizes of the free coordinates that distances are relative to: of all lengths in one unit, one size, their mean."""
        units = [self.manifold.system.coordinates[i].unit for i in self.free]
        size, turns = self.usual.x.copy(), self.usual.turns
        for unit in set(units) - {""}:
            alike = [k for k, (own, angle) in enumerate(zip(units, turns, strict=True)) if own == unit and not angle]
            size[alike] = np.exp(np.log(size[alike]).sum() / max(len(alike), 1))
        return np.asarray(size)

    @cached_property
    def wide(self) -> Array:
        """The natural sizes of all coordinates (n), 1 for those that are not free."""
        wide = np.ones(len(self.base))
        wide[list(self.free)] = self.usual.x
        return wide

    def closest(self, q: Array, limit: float = LAST_DIGIT, steps: int = 60) -> Closed:
        """The end of Newton's method from q (n), in the free coordinates, until f is below `limit` times its size."""
        return close(self.one, q, self.free, limit, steps, (self.usual.f, self.wide))

    def reached(self, x: Array, size: NaturalSizes, quickly: bool = False) -> "Reached":
        """The ends of Newton's method from many starts x (k × free); `quickly`: in few undamped steps if these are enough."""

        def meant(x: Array, starts: Indices) -> Mask:
            return np.asarray(~self.turned(self.whole(x), starts).any(axis=1))

        found = (close_most if quickly else close_many)(self.of_free, x, size, meant)
        q = self.whole(found.x)
        return Reached(q, found, self.turned(q))

    def shares(self, residual: Array) -> Array:
        """The residual f (… × m) divided by the natural size of its terms."""
        return np.asarray(np.abs(residual) / self.usual.f)

    def turned(self, q: Array, starts: Indices | slice = _EVERY) -> Array:
        """The angle (rad) of each closure from the branch that it means (… × closures), at closed q (… × n)."""
        meant = self.manifold.branches
        if not meant:
            return np.zeros((*q.shape[:-1], 0))
        scalars = self._cosines(q.reshape(-1, q.shape[-1]), starts)
        return turned(meant, scalars.reshape(*q.shape[:-1], -1))


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """The ends of Newton's method from many starts: `q` (k × n), the residuals, and the angles `turned` of closures."""

    q: Array
    found: ClosedMany
    turned: Array

    @property
    def closed(self) -> Mask:
        """Which ends satisfy the constraints (k)."""
        firmly = self.found.left <= CLOSED
        return np.asarray(firmly if firmly.any() else self.found.left <= CLOSED_NEARLY)

    @property
    def meant(self) -> Mask:
        """Which ends satisfy the constraints on the branches that are meant (k)."""
        return np.asarray(self.closed & ~self.turned.any(axis=1))

    @property
    def best(self) -> int:
        """The number of the end with the smallest residual."""
        return int(np.argmin(np.where(np.isfinite(self.found.left), self.found.left, np.inf)))


def branches(system: System) -> tuple[ClosureBranch, ...]:
    """The branches that the closures of a system mean, each once."""
    return tuple(dict.fromkeys(c.branch for c in system.holonomic if c.branch is not None))


def branch_scalars(meant: tuple[ClosureBranch, ...]) -> list[Expr]:
    """The expressions whose values `turned` takes."""
    return [x for b in meant for x in (b.cosine, *b.rows)]


def turned(meant: tuple[ClosureBranch, ...], scalars: Array) -> Array:
    """The angle (rad) of each closure from the branch that is meant (…, b), 0 on that branch.

    `scalars` (…, k) are the values of `branch_scalars` at a closed configuration. If a system lists only some rows of a closure and
    the others do not vanish, its orientation is not constrained and the angle counts as 0.
    """
    angles = np.zeros((*scalars.shape[:-1], len(meant)))
    at = 0
    for k, b in enumerate(meant):
        cosine, rows = scalars[..., at], scalars[..., at + 1 : at + 1 + len(b.rows)]
        away = (cosine <= 0) & (np.abs(rows).max(axis=-1) <= _PARALLEL)
        angles[..., k] = np.where(away, np.arccos(np.clip(cosine, -1, 1)), 0.0)
        at += 1 + len(b.rows)
    return angles


def turned_closures(meant: tuple[ClosureBranch, ...], angles: Array) -> str:
    """Words for a message: which closures are on another branch, and their angles; "" if there are none."""
    return ", ".join(
        f"{b.name!r} with its {b.what} turned by {np.degrees(x):.0f}°" for b, x in zip(meant, angles, strict=True) if x
    )


def in_rows(run: Reference, x: Array, others: Sequence[Any]) -> Array:
    """The results (k × results) of `run` at each row of x (k × n) and of `others`, which are numbers or arrays (k).

    A few rows are computed one by one in Python floats, in a twentieth of the time of short arrays.
    """
    if 0 < len(x) <= ROWS:
        columns = [np.broadcast_to(v, len(x)).tolist() if np.ndim(v) else [float(v)] * len(x) for v in others]
        return np.array(run.rows([[*row, *rest] for row, *rest in zip(x.tolist(), *columns, strict=True)]), dtype=float)
    values = run([*x.T, *others])
    numbers = np.empty((len(x), len(values)))
    for k, value in enumerate(values):
        numbers[:, k] = value
    return numbers


class PointConstraints(NamedTuple):
    """Constraints, by their rows, each on the velocity of one point along one direction; None as point if it is not known."""

    rows: tuple[int, ...]
    point: Point | None
    other: Point | None
    directions: tuple[Vector, ...]


def touches(constraints: Sequence[Constraint], rows: Iterable[int], kinematics: Kinematics) -> list[PointConstraints]:
    """The constraints among `rows` grouped by the point whose velocity they constrain, and motion constraints without a point."""
    found: dict[tuple[Point | int, Point | None], list[tuple[int, Vector]]] = {}
    for r in sorted(rows):
        c = constraints[r]
        if c.torques or c.own is not ZERO or len(c.forces) > 2 or not (c.forces or c.kind == "motion"):
            continue
        points = [p for p, _ in c.forces]
        other = points[1] if len(points) == 2 and not kinematics.point(points[1]).is_still else None
        key = (points[0] if points else r, other)
        found.setdefault(key, []).append((r, c.forces[0][1] if points else Vector()))
    return [
        PointConstraints(
            tuple(r for r, _ in held), p if isinstance(p, Point) else None, other, tuple(n for _, n in held)
        )
        for (p, other), held in found.items()
    ]


def contacts(
    held: Iterable[PointConstraints], w: Mapping[int, Speed], kinematics: Kinematics
) -> dict[Point, ContactPoint]:
    """The contact point for each point of a body with a known one; `w` are speeds that stand for the rates of rows."""
    result: dict[Point, ContactPoint] = {}
    for t in held:
        body = None if t.point is None else _body(t.point)
        if t.point is None or t.point.parent is None or body is None:
            continue
        start = t.point.parent
        if start.parent is None or start in result:
            continue
        if start not in _needed(t.other, result) and _is_known(t, t.point, kinematics):
            directions = {w[r]: n for r, n in zip(t.rows, t.directions, strict=True) if r in w}
            result[start] = ContactPoint(t.point, body, t.other, directions)
    return result


def _body(point: Point) -> Basis | None:
    """The frame of the body in which the particle at a point, and the point's parent, are fixed; None if there is none."""
    if point.body is not None:
        return point.body
    frames = [f for f, _ in point.offset.parts]
    return frames[0] if len(frames) == 1 and is_constant_in_time(point.offset.scalars()) else None


def _needed(point: Point | None, found: Mapping[Point, ContactPoint]) -> set[Point]:
    """The points whose velocities that of a point is computed from."""
    needed: set[Point] = set()
    waiting = [point]
    while waiting:
        p = waiting.pop()
        if p is None:
            continue
        for x in p.ancestry():
            if x not in needed:
                needed.add(x)
                waiting.append(found[x].other if x in found else None)
    return needed


def _is_known(t: PointConstraints, point: Point, kinematics: Kinematics) -> bool:
    """Whether the directions are perpendicular and the velocity has no other component."""
    if len(t.rows) not in (2, 3) or any(a.dot(b) is not ZERO for a, b in combinations(t.directions, 2)):
        return False
    if len(t.rows) == 3:
        return True
    across = t.directions[0].cross(t.directions[1])
    motion = kinematics.point(point)
    apart: dict[Expr, Vector] = {ONE: motion.rest, **motion.partials}
    if t.other is not None:
        touched = kinematics.point(t.other)
        for s, v in {ONE: touched.rest, **touched.partials}.items():
            apart[s] = apart.get(s, Vector()) - v
    pairs = [(v.dot(across), v.dot(v)) for s, v in apart.items() if not isinstance(s, AuxiliarySpeed)]
    open_ = [(x, square) for x, square in pairs if x is not ZERO]
    return all(_vanishes(open_, Sample(kinematics.speeds, seed)) for seed in SEEDS) if open_ else True


def _vanishes(pairs: Sequence[tuple[Expr, Expr]], sample: Sample) -> bool:
    """Whether each value vanishes beside a length, whose square is given with it, at a random state."""
    numbers = sample.numbers([x for pair in pairs for x in pair])
    return all(
        bool(np.all(np.abs(x) <= ROUNDED_CHAIN * np.sqrt(np.abs(square))))
        for x, square in zip(numbers[::2], numbers[1::2], strict=True)
    )


_TRIES = (12, 60, 300, 1500)
"""How many starts are made together: more where none of those before was closed."""
_FEW, _MORE = 6, 1500
"""How many configurations are so few that more are looked for, and how many coordinates are moved at once for that."""
_TIMES = (1.0, 0.01, 0.0)
"""Shares of a random time at which a mechanism that is driven is closed: t = 0, which may be a special position, comes last."""
_SAME = 1e-3
"""Distance up to which a configuration is one that was found before, in rad or the coordinate's size."""
_AROUND, _NEAR = 0.1, 1.0
"""How far starts are spread around a place that is given, and how far steps may lead from it, in rad or the coordinate's size."""


@dataclass(frozen=True, slots=True, eq=False)
class Configurations:
    """Values of symbols at several configurations: arrays (count), or one number for all.

    If no configuration was found, the values are random and `missed` lists open constraints with their residuals, the worst first.
    `drawn` names parameters without defaults and inputs in the constraints, which are random. `starts` is the number of starts, at
    each of `times` if constraints depend on time. `special` marks the configurations closed from zero coordinates.
    """

    values: Mapping[Symbol, Any]
    count: int
    special: Mask
    missed: tuple[tuple[str, float], ...] = ()
    drawn: tuple[str, ...] = ()
    starts: int = 0
    times: tuple[float, ...] = ()

    def at(self, k: int) -> dict[Symbol, float]:
        """The values at configuration k."""
        return {s: float(v[k] if np.ndim(v) else v) for s, v in self.values.items()}

    def only(self, kept: Indices) -> "Configurations":
        """The configurations `kept`."""
        values = {s: v if np.ndim(v) == 0 else v[kept] for s, v in self.values.items()}
        return replace(self, values=values, count=len(kept), special=self.special[kept])

    def and_those_of(self, other: "Configurations") -> "Configurations":
        """These configurations, then those of `other`."""

        def joined(own: Any, others: Any) -> Any:
            if np.ndim(own) == np.ndim(others) == 0 and own == others:
                return own
            return np.concatenate([np.broadcast_to(own, self.count), np.broadcast_to(others, other.count)])

        values = {s: joined(v, other.values[s]) for s, v in self.values.items()}
        special = np.concatenate([self.special, other.special])
        return replace(self, values=values, count=self.count + other.count, special=special)

    def matrices(self, matrix: Matrix) -> Array:
        """The values of a matrix (count × m × n) at the configurations."""
        symbols = free_symbols(matrix.entries)
        run = compile_reference(matrix.entries, list(symbols))
        entries = spread(run([self.values[s] for s in symbols]), (self.count,))
        return entries.T.reshape(self.count, *matrix.shape)


def configurations(
    system: System,
    roots: Sequence[Expr],
    near: Mapping[Symbol, float] | None = None,
    seed: int = SEED,
    conditions: Manifold | None = None,
) -> Configurations:
    """Values of every symbol in `roots` at configurations on the constraints; at random ones, with `missed`, if none is found.

    Parameters take their defaults; without default they are random, different for each start. With values `near`, of coordinates and
    other symbols of the constraints, all starts are beside these; ModelError if no configuration is reached from there.
    """
    conditions = conditions or manifold(system)
    read = free_symbols(roots)
    angles = free_symbols(branch_scalars(conditions.branches))
    values = values_of((*read, *angles, *conditions.symbols, *system.coordinates), seed)
    turning = [q for q in system.coordinates if q in set(read) - set(conditions.symbols)]
    search = _ConfigurationSearch(system, conditions, turning, values, np.random.default_rng(seed))
    if near:
        return search.around(near)
    if not conditions.f:
        return search.tried(_TRIES[0], {})
    moments: list[dict[Symbol, float]] = [{}]
    if time in set(conditions.symbols):
        moments = [{time: values[time] * share} for share in _TIMES]
    first: Configurations | None = None
    for count in _TRIES:
        for moment in moments:
            found = search.tried(count, moment)
            if not found.missed:
                return search.more(found, moment)
            first = first or found
    assert first is not None
    return replace(first, starts=sum(_TRIES), times=tuple(m[time] for m in moments if m))


def numbers_near(system: System, near: Mapping[Any, Any] | Sequence[float]) -> dict[Symbol, float]:
    """The numbers of `near` by symbol: of coordinates and, in a mapping, of parameters, inputs and time."""
    known: tuple[Symbol, ...] = system.coordinates
    if isinstance(near, Mapping):
        known = (*known, *system.parameters, *system.inputs, time)
    given = named_values("coordinates, parameters, inputs and t in near=", known, near)
    return {s: finite_number("value in near=", s.name, given[s]) for s in known if s in given}


@dataclass(frozen=True, slots=True, eq=False)
class _ConfigurationSearch:
    """The search for configurations on `conditions`, whose first start is at `values`.

    `turning` are coordinates in the expressions asked for but in none of these constraints.
    """

    system: System
    conditions: Manifold
    turning: Sequence[Symbol]
    values: dict[Symbol, float]
    rng: "np.random.Generator"  # which takes its time to import

    def tried(self, count: int, moment: Mapping[Symbol, float]) -> Configurations:
        """Configurations from `count` starts, the first at `values`, and from zero; random ones with `missed` if none closes."""
        drawn = self._drawn()
        values: dict[Symbol, Any] = {**self.values, **moment}
        x = np.tile([values[q] for q in self.system.coordinates], (count, 1))
        x[1:] = self.rng.uniform(-np.pi, np.pi, (count - 1, x.shape[1]))
        for s in drawn:
            values[s] = np.append(values[s], [*self.rng.uniform(LOW, HIGH, count - 1), values[s]])
        zero = np.arange(count + 1) == count
        scalar = {s.coordinates[0] for s in self.system.euler_parameters}  # of frames that are not turned
        starts = np.vstack([x, [float(q in scalar) for q in self.system.coordinates]])
        if not self.conditions.f:
            return self._with_turned(self._found(values, starts, special=zero))
        level = self.conditions.at(values)
        size = level.sizes(x)
        starts[1:count] *= np.where(size.turns, 1.0, size.x / 2)
        reached = level.reached(starts, size, quickly=True)
        names = tuple(s.name for s in drawn)
        if reached.meant.any():
            every = self._found(values, reached.q, special=zero, drawn=names, starts=count)
            return self._with_turned(every.only(np.flatnonzero(reached.meant)))
        missed = self._missed(reached)
        every = self._found(values, starts, special=zero, missed=missed, drawn=names, starts=count)
        return every.only(np.arange(count))

    def _with_turned(self, found: Configurations) -> Configurations:
        """The configurations, and copies of the special ones with each coordinate of `turning` increased by π/2."""
        zero, count = np.flatnonzero(found.special), len(self.turning)
        if not len(zero) or not count:
            return found
        others = found.only(np.repeat(zero, count))
        turned = {q: others.values[q] + np.pi / 2 * row for q, row in zip(self.turning, np.eye(count), strict=True)}
        return found.and_those_of(replace(others, values={**others.values, **turned}))

    def more(self, found: Configurations, moment: Mapping[Symbol, float]) -> Configurations:
        """The configurations and, if they are few, those of more starts; those around the special one if there is no other."""
        if (~found.special).sum() < _FEW and found.starts == _TRIES[0]:
            count = _MORE // len(self.system.coordinates)
            others = self.tried(min(max(count, _TRIES[0]), _TRIES[1]), moment)
            if not others.missed:
                found = found.and_those_of(others.only(np.flatnonzero(~others.special)))
        if not found.special.all():
            return found
        known = {*self.conditions.symbols, *self.system.coordinates}
        beside = self.around({s: v for s, v in found.at(0).items() if s in known})
        return self._with_turned(replace(beside, special=np.arange(beside.count) == 0))

    def around(self, near: Mapping[Symbol, float]) -> Configurations:
        """The configuration nearest to `near`, then others beside it. ModelError if none is reached."""
        coordinates = self.system.coordinates
        values: dict[Symbol, Any] = {**self.values, time: 0.0, **near}
        x = np.tile([values[q] for q in coordinates], (_TRIES[0], 1))
        given = np.array([q in near for q in coordinates])
        if not self.conditions.f:
            x[1:] += _AROUND * self.rng.normal(size=x[1:].shape)
            return self._found(values, x)
        level = self.conditions.at(values)
        size = level.sizes(np.vstack([x[:1], self.rng.uniform(-np.pi, np.pi, x[1:].shape)]))
        x[1:] += np.where(given, _AROUND, 2.0) * size.x * self.rng.normal(size=x[1:].shape)
        reached = level.reached(x, size)
        away = (np.abs(reached.q - x[0]) / size.x)[:, given].max(axis=1, initial=0)
        away = np.where(reached.meant & (away <= _NEAR), away, np.inf)
        first = 0 if given.all() else int(np.argmin(away))
        if not np.isfinite(away[first]):
            raise ModelError(self._not_near(reached, near))
        apart = (np.abs(reached.q - reached.q[first]) / size.x).max(axis=1)
        others = np.flatnonzero(np.isfinite(away) & (apart <= _NEAR) & (apart > _SAME))
        return self._found(values, reached.q).only(np.array([first, *others]))

    def _found(
        self, values: Mapping[Symbol, Any], x: Array, special: Mask | None = None, **more: Any
    ) -> Configurations:
        own: dict[Symbol, Any] = {**values, **dict(zip(self.system.coordinates, x.T, strict=True))}
        return Configurations(own, len(x), special=np.zeros(len(x), dtype=bool) if special is None else special, **more)

    def _drawn(self) -> list[Symbol]:
        return [
            s
            for s in self.conditions.symbols
            if (isinstance(s, Parameter) and s.default is None) or input_of(s) is not None
        ]

    def _missed(self, reached: Reached) -> tuple[tuple[str, float], ...]:
        """The open constraints at the end with the smallest residual, the worst first, or its closures on another branch."""
        best, found = reached.best, reached.found
        rows = zip(self.conditions.names, found.residual[best], found.shares[best], strict=True)
        left = [(abs(share), name, float(r)) for name, r, share in rows if not abs(share) <= CLOSED_NEARLY]
        if left:
            return tuple((name, r) for _, name, r in sorted(left, reverse=True))
        pairs = zip(self.conditions.branches, reached.turned[best], strict=True)
        return tuple((f"{b.name}: its {b.what} turned", float(x)) for b, x in pairs if x)

    def _not_near(self, reached: Reached, near: Mapping[Symbol, float]) -> str:
        told = ", ".join(f"{s} = {v:.6g}" for s, v in near.items())
        drawn = ", ".join(s.name for s in self._drawn() if s not in near)
        elsewhere = reached.q[reached.meant]
        if len(elsewhere):
            way = zip(self.system.coordinates, elsewhere[0], strict=True)
            there = ", ".join(f"{q} = {v:.6g}" for q, v in way)
            why = f"the configuration found is {there}. Give that one if it is on the intended branch"
        else:
            ((worst, left), *_) = self._missed(reached)
            why = f"the largest residual is {left:.3g}, of {worst!r}. Give values closer to a configuration that satisfies them"
        return (
            f"Expected near= at which the constraints nearly hold, got {told}, from which no such configuration is reached: {why}"
            f"{f', and values of {drawn}, which were drawn at random' if drawn else ''}."
        )
