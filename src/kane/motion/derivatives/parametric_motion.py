# SPDX-License-Identifier: BSD-3-Clause
"""Motions over a span as functions of unknown parameters and initial values, with their derivatives."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kane import expect
from kane.analysis.flow import Flow
from kane.equations.equations import Equations, check_equations
from kane.equations.instances import own_parameters
from kane.equations.state import GROUPS, Guess, State
from kane.errors import SimulationError, cut
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol
from kane.motion.derivatives.adjoint import Adjoint, Seeds
from kane.motion.derivatives.motion_derivatives import AdjointSensitivities, Sensitivities
from kane.motion.derivatives.return_map import ReturnMap
from kane.motion.derivatives.tangent_space import Side, allowed, basis_of, flow_of, sizes_of
from kane.motion.derivatives.variation import Differential
from kane.motion.right_hand_side import routines
from kane.motion.solution.phases import Phase
from kane.motion.solution.solution import Solution
from kane.motion.start import check_span, check_tolerance
from kane.numeric.arrays import Array
from kane.numeric.sampling import named_values, symbols_named
from kane.numeric.scale import ROUNDED, SAME_TIME, SIX_DIGITS
from kane.program.native.machine import Settings

_STARTS = ("q", "u", "states")


@dataclass(frozen=True, eq=False)
class ParametricMotion:
    """Motions over a span from an assembled initial state, and their derivatives with respect to the unknowns `by` (b).

    `given` contains the parameters and initial values as the user specified them. With other values of the unknowns, motions start at
    the same independent initial values; of guesses, at those assembled for the first values.
    """

    map: ReturnMap
    given: State
    by: tuple[Symbol, ...]

    @staticmethod
    def of(
        eom: Equations, span: Any, by: Any, given: State, tolerances: tuple[float, float], settings: Settings | None,
        further: Mapping[str, Any] | None = None,
    ) -> "ParametricMotion":  # fmt: skip
        """From the user's arguments, and `further` options of the motions."""
        check_equations(eom)
        start, end = check_span(span)
        for name, value in zip(("rtol", "atol"), tolerances, strict=True):
            check_tolerance(name, value)
        map_ = ReturnMap(eom, None, end - start, given.inputs, start, end - start, tolerances, settings, further or {})
        return ParametricMotion(map_, given, unknowns(eom, given.inputs, by))

    def over(self, start: float, end: float) -> "ParametricMotion":
        """A copy with another time span."""
        return replace(self, map=replace(self.map, t0=start, period=end - start, within=end - start))

    def at(self, values: Mapping[Symbol, float]) -> "ParametricMotion":
        """A copy with given values of unknowns."""
        eom = self.map.eom
        names = {s.name for s in values if isinstance(s, Parameter)}
        parameters = {p: v for p, v in dict(self.given.parameters or {}).items() if getattr(p, "name", p) not in names}
        parameters |= {s: v for s, v in values.items() if isinstance(s, Parameter)}
        groups = dict[str, Any]()
        for kind in _STARTS:
            own, group = {s: values[s] for s in getattr(eom, GROUPS[kind]) if s in values}, getattr(self.given, kind)
            own = {**self._held.get(kind, {}), **own}
            groups[kind] = None if group is None and not own else {**self._start_values(kind), **own}
        return replace(self, given=replace(self.given, **groups, parameters=parameters))

    @cached_property
    def _held(self) -> dict[str, dict[Symbol, float]]:
        """Assembled values of the independent coordinates and speeds that are guessed or left out, which motions keep."""
        system = self.map.eom.system
        if not self.map.eom.constraints.constraints:
            return {}
        x = self.start
        given = {s for kind in _STARTS for s, v in self._start_values(kind).items() if not isinstance(v, Guess)}
        given.update(self.free, *(e.coordinates for e in system.euler_parameters))
        at = {self.map.eom.state[i]: float(x[i]) for i in _independent(self._side(x), *self._preferred)[1]}
        kinds = {kind: set(getattr(self.map.eom, GROUPS[kind])) - given for kind in _STARTS[:2]}
        return {kind: {s: v for s, v in at.items() if s in open_} for kind, open_ in kinds.items()}

    def _start_values(self, kind: str) -> dict[Any, Any]:
        """The specified initial values of a kind: q, u or further states."""
        return dict(named_values(kind, getattr(self.map.eom, GROUPS[kind]), getattr(self.given, kind)))

    @property
    def end(self) -> float:
        """The final time as motions compute it; it agrees with the specified one up to rounding."""
        return self.map.t0 + self.map.within

    @property
    def free(self) -> tuple[Symbol, ...]:
        """The unknowns that are initial values."""
        return tuple(s for s in self.by if not isinstance(s, Parameter))

    @property
    def parameters(self) -> dict[Expr, Any]:
        """Values of all parameters; those that occur only in inputs are included if specified."""
        return self.map.known(self.given.parameters)

    @property
    def start(self) -> Array:
        """The initial state (q, u, a), on the constraint manifold."""
        return self.map.admitted(replace(self.given, parameters=self.parameters))

    @property
    def first(self) -> Array:
        """Initial guesses of the unknowns: specified values, or for initial values without one those of the assembled state.

        Raises
        ------
        SimulationError
            if an unknown parameter has no value
        """
        eom, known = self.map.eom, self.parameters
        values: dict[Any, Any] = {s: known.get(s, s.default) for s in self.by if isinstance(s, Parameter)}
        missing = [s.name for s, v in values.items() if v is None]
        expect.none(missing, "a first value of each unknown", "none of {}", "Give parameters=.", error=SimulationError)
        for kind in _STARTS:
            values |= self._start_values(kind)
        if any(s not in values for s in self.by):
            values = {**dict(zip(eom.state, self.start.tolist(), strict=True)), **values}
        return np.array([float(v.value if isinstance(v := values[s], Guess) else v) for s in self.by])

    def limits(self, bounds: Mapping[Any, Any] | None) -> tuple[Array, Array]:
        """Lower and upper bounds of the unknowns, from {unknown: (low, high)} with None for no bound.

        Raises
        ------
        SimulationError
            if bounds are not two ascending numbers, or exclude the initial guess
        """
        low, high = np.full(len(self.by), -np.inf), np.full(len(self.by), np.inf)
        place = {s: k for k, s in enumerate(self.by)}
        given: dict[Any, Any] = named_values("bounds", self.by, bounds)
        for s, pair in given.items():
            a, b = interval(pair)
            if not a < b:
                raise SimulationError(f"Expected bounds of {s} as (low, high), None for none, got {cut(repr(pair))}.")
            low[place[s]], high[place[s]] = a, b
        outside = [str(s) for s, v, a, b in zip(self.by, self.first, low, high, strict=True) if not a <= v <= b]
        expect.none(outside, "first values within the bounds", "others of {}", error=SimulationError)
        return low, high

    def motion(self, samples: Any) -> Solution:
        """The motion; sample times that exceed the final time by rounding are set to it."""
        times = samples
        if np.ndim(samples):
            times = expect.floats(samples, "a number of samples or their times", error=SimulationError)
            near = times - self.end <= SAME_TIME * max(abs(self.map.t0), abs(self.end))
            times = np.where(near, np.minimum(times, self.end), times)
        return self.map.motion(self.start, self.parameters, times)

    def sensitivities(self, motion: Solution) -> Sensitivities:
        """The derivatives at the samples of a motion, by the variational equations."""
        walk, begin, places = self._begun(motion)
        found = walk.along(motion, self.map.again(motion, self.parameters), begin)
        return Sensitivities(motion, self.by, found[:, :, places])

    def _begun(self, motion: Solution) -> tuple[Differential, Array, list[int]]:
        """The `Differential` of a motion, δx of its start, and the columns of the unknowns in (initial values, parameters)."""
        own = tuple(s for s in self.by if isinstance(s, Parameter))
        walk = self.map.walk(own)
        order = {s: k for k, s in enumerate((*self.free, *own))}
        return walk, self._start_slopes(walk.side(motion, 0)), [order[s] for s in self.by]

    def _start_slopes(self, side: Side) -> Array:
        """δx of the start (n × initial values + parameters)."""
        return _start_slopes(side, self._preferred, tuple(s for s in self.by if isinstance(s, Parameter)))

    @property
    def _preferred(self) -> tuple[Sequence[Symbol], Sequence[Symbol]]:
        """The initial values that are unknowns, and those that are specified."""
        told = [s for kind in _STARTS[:2] for s, v in self._start_values(kind).items() if not isinstance(v, Guess)]
        return self.free, told

    def _side(self, x: Array) -> Side:
        """The initial state x with the equations there."""
        eom, constants, own = self.map.eom, self.parameters, set(self.map.eom.parameters)
        drives = self.map.drives(constants)
        p, usual = np.array([constants[s] for s in eom.parameters]), {s: v for s, v in constants.items() if s in own}
        now = routines(eom, p, tuple(drives[s] for s in eom.inputs), self.map.settings)
        return Side(now, Phase(usual, drives), self.map.t0, x)

    def sizes(self, states: Array, share: float) -> Array:
        """Sizes of the states (n) from some (k × n); of those that are zero up to rounding, by the energy of others at the start."""
        own = sizes_of(self.map.eom, np.abs(states).max(axis=0), share)
        return np.where(own > ROUNDED * self._first_sizes, own, self._first_sizes)

    @cached_property
    def _first_sizes(self) -> Array:
        return self.map.sizes(self.start, self.map.known(self.parameters))

    def start_slopes(self, x: Array) -> Array:
        """∂x/∂b of the initial state x (n × b)."""
        order = {s: k for k, s in enumerate((*self.free, *(s for s in self.by if isinstance(s, Parameter))))}
        found = self._start_slopes(self._side(x))
        return np.asarray(found[:, [order[s] for s in self.by]])

    def backwards(self, motion: Solution) -> AdjointSensitivities:
        """The derivatives of a motion by the adjoint."""
        walk, begin, places = self._begun(motion)
        adjoint = Adjoint(walk, motion, self.map.again(motion, self.parameters))

        def back(seeds: Seeds, count: int, own: Array) -> tuple[Array, float]:
            weights = adjoint(seeds, count)
            found = weights.x @ begin
            found[:, len(self.free) :] += weights.p + own
            return np.asarray(found[:, places]), weights.integral

        return AdjointSensitivities(motion, self.by, back)


def interval(given: Any) -> tuple[float, float]:
    """(low, high) as floats, infinite for None; NaN if `given` is not such a pair."""
    try:
        low, high = given
        return (-np.inf if low is None else float(low)), (np.inf if high is None else float(high))
    except (TypeError, ValueError):
        return np.nan, np.nan


def unknowns(eom: Equations, given: Any, by: Any) -> tuple[Symbol, ...]:
    """The unknowns, in order and without duplicates; `given` are the inputs, whose parameters may be among them."""
    own: tuple[Symbol, ...] = (*eom.state, *eom.parameters, *own_parameters(eom, given))
    listed = [by] if isinstance(by, Symbol | str) else list(by) if expect.is_list(by) else []
    result = tuple(symbols_named("by", own, listed))
    expect.that(bool(result), "some parameters or start values to differentiate by", by, error=SimulationError)
    twice = [name for name, count in Counter(s.name for s in result).items() if count > 1]
    expect.none(twice, "each one once", "{} twice", error=SimulationError)
    return result


def _independent(side: Side, free: Sequence[Symbol], told: Sequence[Symbol]) -> tuple[Flow, list[int]]:
    """The flow at the start, and the indices of the independent initial values.

    These are first those that are unknowns, then specified ones, then others, up to the number that the constraints leave free.
    """
    place = {s: i for i, s in enumerate(side.now.eom.state)}
    flow = flow_of(side)
    basis, names = basis_of(flow), {s.name: s for s in side.now.eom.state}
    kept = [place[s] for s in free]
    basis = basis * flow.scale  # metres beside radians at one energy
    _check_independent(basis, kept, free, flow.states)
    sizes = np.abs(basis).max(axis=1)
    for i in (place[s] for s in (*told, *(names[name] for name in flow.states if name in names))):
        some = [*kept, i]
        if sizes[i] > 0 and np.linalg.matrix_rank(basis[some] / sizes[some, None], SIX_DIGITS) > len(kept):
            kept.append(i)
    return flow, kept


def _start_slopes(side: Side, starts: tuple[Sequence[Symbol], Sequence[Symbol]], by: Sequence[Parameter]) -> Array:
    """δx of the start: by initial values, and the change that constraints require where a parameter changes.

    Independent initial values do not change with a parameter.
    """
    free, told = starts
    eom, n = side.now.eom, side.now.width
    if not eom.system.euler_parameters and not eom.constraints.constraints:
        place = {s: i for i, s in enumerate(eom.state)}
        return np.hstack([np.eye(n)[:, [place[s] for s in free]], np.zeros((n, len(by)))])
    flow, kept = _independent(side, free, told)
    basis, names = basis_of(flow), {s.name for s in eom.state}
    rest = basis[kept]
    if len(kept) < basis.shape[1]:  # angles of Euler parameters
        angles = [j for j, name in enumerate(flow.states) if name not in names]
        rest = np.vstack([rest, np.eye(basis.shape[1])[angles]])
    own = np.linalg.solve(rest, np.eye(len(rest)))
    shifts = allowed(side, by)[2] if len(by) else np.zeros((n, 0))
    moved = shifts - basis @ own[:, : len(kept)] @ shifts[kept]
    return np.hstack([(basis @ own)[:, : len(free)], moved])


def _check_independent(basis: Array, kept: Sequence[int], free: Sequence[Symbol], names: Sequence[str]) -> None:
    if not kept:
        return
    sizes = np.abs(basis[kept]).max(axis=1)
    regular = (sizes > 0).all() and np.linalg.matrix_rank(basis[kept] / sizes[:, None], SIX_DIGITS) == len(kept)
    if not regular:
        raise SimulationError(
            f"Expected start values that the constraints leave independent, got {', '.join(s.name for s in free)}, some of "
            f"which follow from the others. Independent ones are {', '.join(names)}."
        )
