# SPDX-License-Identifier: BSD-3-Clause
"""Several configurations that satisfy the constraints: what is decided once for all of a motion is decided by them.

They are closed from many starts at once, so that they lie on every branch that was found, and several on each. One more start is
where all coordinates are zero: random ones never lie upright or straight, where motions begin.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kane.dynamics.constraints.manifold import Manifold, Reached, branch_scalars, manifold
from kane.errors import ModelError
from kane.expr.evaluation import compile_reference, free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol, input_of, time
from kane.model.system import System
from kane.numeric.arrays import Array, Mask, spread
from kane.numeric.newton import Indices
from kane.numeric.sampling import HIGH, LOW, SEED, finite_number, named_values, values_of
from kane.numeric.scale import CLOSED_NEARLY

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

    `missed` are constraints that resist, with what is left of them, the worst first, where no configuration was found: the values are
    random ones then. `drawn` names what constraints depend on and is no default: parameters without one, and inputs. `starts` is how
    many were tried at each of `times`, if constraints depend on the time. `special` are those closed from zero, and their like.
    """

    values: Mapping[Symbol, Any]
    count: int
    special: Mask
    missed: tuple[tuple[str, float], ...] = ()
    drawn: tuple[str, ...] = ()
    starts: int = 0
    times: tuple[float, ...] = ()

    def at(self, k: int) -> dict[Symbol, float]:
        """The values at one of them."""
        return {s: float(v[k] if np.ndim(v) else v) for s, v in self.values.items()}

    def only(self, kept: Indices) -> "Configurations":
        """Some of them."""
        values = {s: v if np.ndim(v) == 0 else v[kept] for s, v in self.values.items()}
        return replace(self, values=values, count=len(kept), special=self.special[kept])

    def and_those_of(self, other: "Configurations") -> "Configurations":
        """These, then those of another search."""

        def joined(own: Any, others: Any) -> Any:
            if np.ndim(own) == np.ndim(others) == 0 and own == others:
                return own
            return np.concatenate([np.broadcast_to(own, self.count), np.broadcast_to(others, other.count)])

        values = {s: joined(v, other.values[s]) for s, v in self.values.items()}
        special = np.concatenate([self.special, other.special])
        return replace(self, values=values, count=self.count + other.count, special=special)

    def matrices(self, matrix: Matrix) -> Array:
        """A matrix in numbers at each (count × m × n)."""
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
    """Values of every symbol below `roots` at configurations that satisfy the constraints, if those can be reached.

    Parameters take their defaults; what has none is drawn at random, for each start anew. With `near`, values of coordinates and of
    what else constraints depend on, all are closed from there; a ModelError where that cannot be done.
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


def place(system: System, near: Mapping[Any, Any] | Sequence[float] | None) -> dict[Symbol, float] | None:
    """`near` by symbol, a number each: coordinates, and what else constraints depend on."""
    if near is None:
        return None
    known: tuple[Symbol, ...] = system.coordinates
    if isinstance(near, Mapping):
        known = (*known, *system.parameters, *system.inputs, time)
    given = named_values("coordinates, parameters, inputs and t, near= which the motion is,", known, near)
    return {s: finite_number("value near= which the motion is", s.name, given[s]) for s in known if s in given}


@dataclass(frozen=True, slots=True, eq=False)
class _ConfigurationSearch:
    """The configuration constraints of a system, and the values of the first start.

    `turning` are coordinates that change what is asked for but none of these constraints.
    """

    system: System
    conditions: Manifold
    turning: Sequence[Symbol]
    values: dict[Symbol, float]
    rng: "np.random.Generator"  # which takes its time to import

    def tried(self, count: int, moment: Mapping[Symbol, float]) -> Configurations:
        """Configurations from so many starts, the first of them at `values`, and from zero; at random ones where none closes."""
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
        """These, and that from zero, where it closed, with one coordinate after the other turned that no such constraint holds."""
        zero, count = np.flatnonzero(found.special), len(self.turning)
        if not len(zero) or not count:
            return found
        others = found.only(np.repeat(zero, count))
        turned = {q: others.values[q] + np.pi / 2 * row for q, row in zip(self.turning, np.eye(count), strict=True)}
        return found.and_those_of(replace(others, values={**others.values, **turned}))

    def more(self, found: Configurations, moment: Mapping[Symbol, float]) -> Configurations:
        """Those found and, if they are few, others, which may move in another way; around that from zero, if it is the only one."""
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
        """The configuration that the place given is nearest to first, then others beside it."""
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
        """Constraints that are left open where least is, the worst first; or closures that are turned away from what they mean."""
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
            why = f"one that was found lies at {there}. Give that, if it is on the branch that is meant"
        else:
            ((worst, left), *_) = self._missed(reached)
            why = f"{worst!r} resists most, by {left:.3g}. Give a place nearer to a configuration"
        return (
            f"Expected a place near= at which the constraints nearly hold, got {told}, from which none is reached: {why}"
            f"{f', and values of {drawn}, which were drawn at random' if drawn else ''}."
        )
