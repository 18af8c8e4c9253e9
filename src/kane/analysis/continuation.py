# SPDX-License-Identifier: BSD-3-Clause
"""`continuation`: a branch of steady motions followed as a value changes, past turning points, with its eigenvalues.

Pseudo-arclength (Keller 1977): with X the unknowns and the value μ, F(X, μ) = 0 is solved together with τ·(ΔX, Δμ) = Δs, τ the
tangent of the branch, so that a point where the branch turns back is as good as any other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.analysis.linear import Linear
from kane.analysis.linearize import Linearizer, linearizer
from kane.analysis.point import OperatingPoint, closed, point_of
from kane.analysis.stability import Crossing, changes, tracked
from kane.analysis.trim import Problem, loose, null_space, problem, solve_problem
from kane.equations.equations import Equations
from kane.errors import SimulationError, ValueMissingError
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.numeric.newton import close
from kane.numeric.rank import level, singular

_FIRST, _LARGEST, _SMALLEST = 0.02, 0.08, 1e-7
"""Steps along the branch, where the whole range of the value counts 1."""
_CLOSED, _SAME = 1e-9, 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """Steady motions along a branch: `points` and their linearizations `linear` at `values` of `symbol`, in order along the branch.

    `eigenvalues` (points × states) keeps each eigenvalue in one column, cyclic coordinates left out. `turning` holds the indices of
    the points at which the branch turns back, `crossings` say where an eigenvalue crosses the imaginary axis: at which value of
    `symbol`, in which steady motion, and between which of the points.
    """

    symbol: Symbol
    values: Array
    points: tuple[OperatingPoint, ...]
    linear: tuple[Linear, ...]
    eigenvalues: npt.NDArray[np.complex128]
    turning: tuple[int, ...]
    crossings: tuple[Crossing, ...]
    message: str

    @property
    def turning_points(self) -> tuple[float, ...]:
        """The values at which the branch turns back."""
        return tuple(self.values[list(self.turning)].tolist())

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        turns = ", ".join(f"{v:.6g}" for v in self.turning_points) or "none"
        return (
            f"Branch({len(self)} points, {self.symbol.name} = {self.values[0]:.6g} … {self.values[-1]:.6g}; turning points: {turns}; "
            f"{self.message})"
        )


def continuation(
    eom: Equations,
    symbol: Any,
    values: Sequence[float],
    *,
    q: Mapping[Any, Any] | Sequence[Any] | None = None,
    u: Mapping[Any, Any] | Sequence[Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    moving: Sequence[Any] = (),
    independent: Sequence[Any] = (),
    outputs: Mapping[str, Any] | Sequence[Any] | None = None,
    max_points: int = 2000,
) -> Branch:
    """Steady motions as `symbol` goes from the first of `values` to the last, by pseudo-arclength.

    The start is `trim` with the first value. Where the branch turns back it is followed on, so that a value may come several
    times; it ends where the last value is reached, or the first again.

    Parameters
    ----------
    eom : Equations
    symbol : the parameter, input, speed or coordinate that changes, by symbol or name
    values : increasing or decreasing; the branch has a point at each of them, and at each turning point
    q, u, parameters, inputs, moving, independent : as for `trim`, the value of `symbol` apart
    outputs : as for `linearize`

    Raises
    ------
    SimulationError
        if there is no steady motion at the first value
    ValueMissingError
        if the conditions leave more than one branch open
    """
    wanted = _values(values)
    groups = {"q": q, "u": u, "parameters": parameters, "inputs": inputs}
    made, place = _problem(eom, symbol, wanted[0], groups, moving, independent)
    start = solve_problem(made, _CLOSED)
    follower = _follower(made, place, start, float(wanted[-1] - wanted[0]))
    return _branch(follower, follower.follow(start, wanted, max_points), linearizer(eom, outputs=outputs), independent)


def _values(values: Sequence[float]) -> Array:
    found = np.asarray(values, dtype=float)
    step = np.diff(found)
    if (
        found.ndim != 1
        or len(found) < 2
        or not np.all(np.isfinite(found))
        or not (np.all(step > 0) or np.all(step < 0))
    ):
        raise SimulationError(f"Expected two or more increasing or decreasing values to follow, got {values!r:.60}.")
    return found


def _problem(
    eom: Equations, symbol: Any, value: float, groups: dict[str, Any], moving: Sequence[Any], independent: Sequence[Any]
) -> tuple[Problem, int]:
    name = symbol.name if isinstance(symbol, Symbol) else symbol
    kinds = {"q": eom.coordinates, "u": eom.speeds, "parameters": eom.parameters, "inputs": eom.inputs}
    for kind, symbols in kinds.items():
        if name in [s.name for s in symbols]:
            given = groups[kind]
            if given is not None and not isinstance(given, Mapping):
                raise SimulationError(f"Expected {kind}= by symbol or name where {name} changes, got a sequence.")
            others = {k: v for k, v in (given or {}).items() if (k.name if isinstance(k, Symbol) else k) != name}
            made = problem(
                eom, t=0.0, moving=moving, independent=independent, **groups | {kind: {**others, name: value}}
            )
            return made, [s.name for s in made.conditions.symbols].index(name)
    known = ", ".join(s.name for symbols in kinds.values() for s in symbols)
    raise ValueMissingError(f"Expected a value of the system to change ({known}), got {symbol!r}.")


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """All points Y of a branch in order, the steps between included; `turning` are places in `marked`, those to be shown."""

    points: tuple[Array, ...]
    marked: tuple[int, ...]
    turning: tuple[int, ...]
    message: str


@dataclass(frozen=True, slots=True, eq=False)
class _Follower:
    """The branch in Y = (free unknowns, μ over its range); unknowns that nothing depends on stay where they are."""

    made: Problem
    place: int
    free: tuple[int, ...]
    scale: Array
    base: Array

    def spread(self, y: Array) -> Array:
        """X of Y."""
        x = self.base.copy()
        x[[*self.free, self.place]] = y * self.scale
        return x

    def reduced(self, x: Array) -> Array:
        """Y of X."""
        return np.asarray(x[[*self.free, self.place]] / self.scale)

    def tangent(self, y: Array, along: Array) -> Array:
        """The unit tangent of the branch that points along."""
        _, j = self.made.conditions(self.spread(y))
        columns = j[:, [*self.free, self.place]] * self.scale
        found = singular(level(columns)).right[-1]
        return np.asarray(found if found @ along >= 0 else -found)

    def corrected(self, y: Array, across: Array) -> Array | None:
        """The point of the branch in the plane through y across a direction."""

        def bordered(trial: Array) -> tuple[Array, Array]:
            f, j = self.made.conditions(self.spread(trial))
            columns = j[:, [*self.free, self.place]] * self.scale
            return np.append(f, across @ (trial - y)), np.vstack([columns, across])

        found = close(bordered, y, range(len(y)), limit=1e-13)
        return found.x if found.size <= _CLOSED else None

    def middle(self, a: Array, b: Array) -> Array | None:
        """The point of the branch halfway between two, in the plane across their chord."""
        chord = b - a
        return self.corrected((a + b) / 2, chord / np.linalg.norm(chord))

    def follow(self, start: Array, wanted: Array, max_points: int) -> _Path:
        """The branch from a start X, marked at the wanted values and the turning points."""
        y = self.reduced(start)
        up = np.zeros(len(y))
        up[-1] = np.sign(self.scale[-1]) * np.sign(wanted[-1] - wanted[0])
        tau = self.tangent(y, up)
        marks = wanted / self.scale[-1]
        low, high = sorted((marks[0], marks[-1]))
        points, marked, turning, step = [y], [0], list[int](), _FIRST

        def path(message: str) -> _Path:
            # what lies beyond the last mark is not asked for
            return _Path(tuple(points[: marked[-1] + 1]), tuple(marked), tuple(turning), message)

        for _ in range(max_points):
            new = self.corrected(y + step * tau, tau)
            if new is None or np.linalg.norm(new - y) > 3 * step:
                step /= 2
                if step < _SMALLEST:
                    return path(f"the branch could not be followed beyond {self._where(y)}")
                continue
            ahead = self.tangent(new, tau)
            if ahead @ tau < 0.9 and step > 100 * _SMALLEST:
                step /= 2
                continue
            stages = [(y, new)]
            if tau[-1] * ahead[-1] < 0:
                fold = self._fold(y, tau, step)
                stages = [(y, fold), (fold, new)]
            for k, (a, b) in enumerate(stages):
                between = self._between(a, b, marks)
                marked += range(len(points), len(points) + len(between))
                points += between
                met = bool(between) and float(np.linalg.norm(between[-1] - b)) < _SAME
                if k == 0 and len(stages) == 2:
                    turning.append(len(marked) - met)
                    marked += [] if met else [len(points)]
                points += [] if met else [b]
            y, tau, step = new, ahead, min(1.5 * step, _LARGEST)
            if not low <= y[-1] <= high:
                back = (y[-1] < low) == (marks[0] == low)
                return path("the first value was reached again" if back else "the last value was reached")
        return path(f"{max_points} steps were taken")

    def _where(self, y: Array) -> str:
        return f"{self.made.conditions.symbols[self.place].name} = {y[-1] * self.scale[-1]:.6g}"

    def _between(self, a: Array, b: Array, marks: Array) -> list[Array]:
        """Points at the wanted values between two points."""
        rows = []
        ordered = marks if (b[-1] - a[-1]) * (marks[-1] - marks[0]) > 0 else marks[::-1]
        across = np.zeros(len(a))
        across[-1] = 1.0
        for m in ordered:
            share = (m - a[-1]) / (b[-1] - a[-1])
            if 1e-12 < share <= 1:
                guess = a + share * (b - a)
                guess[-1] = m
                found = self.corrected(guess, across)
                if found is not None:
                    rows.append(found)
        return rows

    def _fold(self, y: Array, tau: Array, step: float) -> Array:
        """Where the tangent has no part along μ, by bisection along the branch."""
        low, high, at = 0.0, step, y
        for _ in range(60):
            middle = (low + high) / 2
            found = self.corrected(y + middle * tau, tau)
            if found is None:
                break
            at = found
            if self.tangent(found, tau)[-1] * tau[-1] > 0:
                low = middle
            else:
                high = middle
            if high - low < 1e-12:
                break
        return at


def _follower(made: Problem, place: int, start: Array, span: float) -> _Follower:
    names = loose(made, start, made.free)
    if names:
        raise ValueMissingError(
            f"Expected values that leave one branch, got a family: {', '.join(names)} can take other values at the start. Give some "
            "of them as numbers."
        )
    frozen: set[int] = set()
    inert = [i for i in made.free if i not in set(made.mattering)]
    for row in null_space(made, start):
        part = {i: abs(row[made.free.index(i)]) for i in inert if i not in frozen}
        frozen.update(sorted(part, key=part.__getitem__)[-1:])
    free = tuple(i for i in made.free if i not in frozen)
    scale = np.append(np.ones(len(free)), abs(span))
    return _Follower(made, place, free, scale, start)


def _branch(follower: _Follower, path: _Path, lin: Linearizer, independent: Sequence[Any]) -> Branch:
    found = follower.made.conditions
    kept = {found.known.names[i] for i in found.still}
    symbol, scale = found.symbols[follower.place], float(follower.scale[-1])

    def at(y: Array) -> tuple[OperatingPoint, Linear]:
        point = point_of(found.eom, closed(found.eom, found.known, found.state(follower.spread(y))))
        made = lin(**point.arguments, independent=independent, steady=False)
        gone = [n for n in made.coordinates if n not in kept]
        return point, replace(made, cyclic=tuple(gone)).without("cyclic")

    every = [at(y) for y in path.points]
    met = changes(
        path.points, [linear.eigenvalues for _, linear in every], follower.middle, lambda y: at(y)[1].eigenvalues
    )
    points, linear = zip(*(every[k] for k in path.marked), strict=True)
    return Branch(
        symbol,
        np.array([path.points[k][-1] * scale for k in path.marked]),
        points,
        linear,
        tracked([at.eigenvalues for at in linear]),
        path.turning,
        tuple(
            Crossing(float(c.y[-1] * scale), c.root, at(c.y)[0], _neighbours(path.marked, c.interval), c.grows)
            for c in met
        ),
        path.message,
    )


def _neighbours(marked: Sequence[int], interval: int) -> tuple[int, int]:
    """The marked points before and after an interval of the path."""
    after = int(np.searchsorted(marked, interval, side="right"))
    return after - 1, after
