# SPDX-License-Identifier: BSD-3-Clause
"""`shoot`: inputs, parameters and initial values for which a motion satisfies final conditions at the least cost (direct shooting).

The cost is J = e(x(T)) + ∫ L dt; the integral and its gradient come from the adjoint, across events. Derivatives of costs and
conditions are exact for the computed motion, by variational or adjoint equations (Betts 2010, ch. 3). Inputs of time that are linear
in the unknowns are determined by direct multiple shooting with many short motions (`lifted`, `least_cost`), and verified by a single
motion.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Unpack

import numpy as np
from scipy.optimize import least_squares, minimize

from kane import expect, show
from kane.dynamics.readings.quantities import asked
from kane.equations.equations import Equations
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import Attributes, KaneError, SimulationError
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.piecewise import Kind, table
from kane.expr.symbols import Parameter, Symbol, time
from kane.motion.derivatives.motion_derivatives import AdjointSensitivities, slopes_along
from kane.motion.derivatives.parametric_motion import ParametricMotion, interval
from kane.motion.derivatives.pulling import Integrand, Pulling
from kane.motion.fitting.least_cost import Limits, least_cost
from kane.motion.fitting.lifted import cut_at_bends, steps_of
from kane.motion.solution.phases import Indices
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.numeric.polynomials import gauss
from kane.program.native.machine import Settings
from kane.progress import far, working

_POINTS = 4
"""Gauss points per panel, exact to degree 7."""
_MANY = 2
"""Largest ratio of differentiated numbers to unknowns for the adjoint: with two rods it takes 3 to 6 ms, the variational equations
9 to 50; with ten rods 8 instead of 1,000."""
_SAMPLES, _TINY = 50, 1e-300
"""Samples of a motion that show the sizes of conditions, and the least size of one."""


class Curve(NamedTuple):
    """An input with unknown values, from `kn.fitting.curve`: `expression` of time through the parameters `nodes`."""

    expression: Expr
    nodes: tuple[Parameter, ...]

    def _repr_html_(self) -> str | None:
        return show.html(self)


def curve(name: str, times: Sequence[float], values: Any = 0.0, *, kind: Kind = "linear", unit: str = "") -> Curve:
    """An input for `shoot` to determine: a function of time through unknown values at given times.

    Parameters
    ----------
    name : stem of the names of the unknown parameters, name_0, name_1, …
    times : increasing times (s)
    values : initial guesses of the values, one for all or one for each time
    kind : "linear", "cubic" or "steps", as for `kn.table`
    unit : unit of the values

    Examples
    --------
    >>> F = kn.fitting.curve("F", np.linspace(0, 2, 21))
    >>> kn.shoot(eom, (0, 2), F.nodes, inputs={"F": F.expression}, end={"theta": np.pi}, integral=F.expression**2)
    """
    places = expect.floats(times, "times of the values of a curve", error=SimulationError)
    starts = expect.floats(values, "values of a curve", error=SimulationError)
    expect.that(places.ndim == 1 and len(places), "a list of times of a curve", times, error=SimulationError)
    right = starts.shape in ((), places.shape)
    expect.that(right, f"one value of a curve, or {len(places)}, one for each time", values, error=SimulationError)
    starts = np.broadcast_to(starts, places.shape)
    nodes = tuple(Parameter.declare(f"{name}_{k}", default=float(v), unit=unit) for k, v in enumerate(starts))
    parts = [
        p * table(places.tolist(), row.tolist(), kind, name="node")(time)
        for p, row in zip(nodes, np.eye(len(places)), strict=True)
    ]
    return Curve(sum(parts, start=ZERO), nodes)


@dataclass(frozen=True, eq=False, repr=False)
class Shot(Attributes):
    """The result of `kn.fitting.shoot`: a motion that satisfies its final conditions.

    Attributes
    ----------
    values : {unknown: value}
    cost : the cost J; 0 if none was given
    off : the largest residual of the final conditions
    motion : Solution
    parameters, start : parameters and initial state, for `kn.simulate`
    steps : number of motions simulated
    message : message of the optimizer
    """

    values: Mapping[Symbol, float]
    cost: float
    off: float
    motion: Solution
    parameters: Mapping[Expr, float]
    start: State
    steps: int
    message: str

    def __repr__(self) -> str:
        shown = ", ".join(f"{s} = {v:.6g}" for s, v in [*self.values.items()][:4])
        more = f" and {len(self.values) - 4} more" if len(self.values) > 4 else ""
        return f"Shot({shown}{more}; cost {self.cost:.6g}, off by {self.off:.1e}, {self.steps} motions)"


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """The problem: expressions at the end between `low` and `high`, a final cost, and an integral cost with its quadrature."""

    ends: tuple[Expr, ...]
    low: Array
    high: Array
    cost: Expr
    integral: Expr
    times: Array
    weights: Array

    @property
    def costs(self) -> bool:
        """Whether there is a cost."""
        return self.cost is not ZERO or self.integral is not ZERO

    @property
    def exprs(self) -> tuple[Expr, ...]:
        """The integrand, the final cost and the conditions."""
        return (self.integral, self.cost, *self.ends)

    def sizes(self, values: Array) -> Array:
        """The largest magnitude of each condition along a motion (k × m) and of its bounds."""
        ends = np.abs(np.vstack([values, self.low, self.high]))
        return np.asarray(np.where(np.isfinite(ends), ends, 0.0).max(axis=0))

    def missed(self, values: Array, left: Array) -> Array:
        """The violation beyond what is `left` (m) of each condition at the end of a motion (k × m), relative to its size along it."""
        off = np.maximum(np.maximum(self.low - values[-1], values[-1] - self.high) - left, 0.0)
        return np.asarray(off / np.maximum(self.sizes(values), _TINY))

    @property
    def numbers(self) -> int:
        """The number of differentiated values: the conditions, and the cost."""
        return len(self.ends) + self.costs

    def along(self, motion: Solution) -> Array:
        """The conditions at the samples of a motion (k × m)."""
        return np.array([motion[e] for e in self.ends]).reshape(len(self.ends), len(motion)).T

    def value(self, motion: Solution) -> float:
        """J of a smooth motion with samples at `times`."""
        total = 0.0 if self.cost is ZERO else float(motion[self.cost][-1])
        if self.integral is not ZERO:
            total += float(self.weights @ motion[self.integral][self.rows(motion)])
        return total

    def rows(self, motion: Solution) -> Indices:
        """The samples of a motion at the quadrature times."""
        return np.minimum(np.searchsorted(motion.t, self.times), len(motion) - 1)


class Differentiated(NamedTuple):
    """The final values (m) of the conditions and their Jacobian, the cost and its gradient."""

    ends: Array
    by_ends: Array
    cost: float
    by_cost: Array


class Flight:
    """Motions as functions of the scaled unknowns z; the last derivatives are cached."""

    def __init__(self, course: ParametricMotion, aim: Aim, sizes: Array) -> None:
        self.unsized = sizes == 0
        self.course, self.aim, self.sizes, self.steps = course, aim, np.where(self.unsized, 1.0, sizes), 0
        self._last: tuple[bytes, Differentiated] | None = None

    def at(self, z: Array) -> ParametricMotion:
        """The motions at z, in units of `sizes`."""
        return self.course.at(dict(zip(self.course.by, (z * self.sizes).tolist(), strict=True)))

    def motion(self, z: Array, times: Any) -> Solution:
        """The motion at z; SimulationError if it does not reach the end of the span."""
        motion = self.at(z).motion(times)
        self.steps += 1
        far(lambda: f"{self.steps} motions")
        if motion.status != "finished":
            raise SimulationError(
                f"Expected motions to the end of the span, got one that ended earlier: {motion.message}."
            )
        return motion

    def slopes(self, z: Array) -> Differentiated:
        """Conditions and cost at z with derivatives, by the adjoint where that is cheaper."""
        key = z.tobytes()
        if self._last is None or self._last[0] != key:
            course, motion = self.at(z), self.motion(z, 2)
            drives = motion.phases[0].inputs.values()
            back = self.aim.numbers <= _MANY * len(course.by) and Pulling.serves(drives)
            ends, by_ends, cost, by_cost = (
                self._backwards(course.backwards(motion)) if back else self._forwards(course, motion)
            )
            self._last = key, Differentiated(ends, by_ends * self.sizes, cost, by_cost * self.sizes)
        return self._last[1]

    def _forwards(self, course: ParametricMotion, motion: Solution) -> tuple[Array, Array, float, Array]:
        """Conditions, their Jacobian, the cost and its gradient by the variational equations; the integral by the adjoint."""
        aim, k, s = self.aim, len(self.sizes), course.sensitivities(motion)
        cost, by_cost = 0.0, np.zeros(k)
        if aim.cost is not ZERO:
            cost, by_cost = float(motion[aim.cost][-1]), s[aim.cost][-1]
        if aim.integral is not ZERO:
            along = course.backwards(motion).cost(integral=aim.integral)
            cost, by_cost = cost + along.value, by_cost + along.gradient
        values, slopes = [motion[e][-1] for e in aim.ends], [s[e][-1] for e in aim.ends]
        return np.array(values), np.array(slopes).reshape(-1, k), cost, by_cost

    def _backwards(self, s: AdjointSensitivities) -> tuple[Array, Array, float, Array]:
        """The same by the adjoint."""
        aim, last, m = self.aim, np.eye(len(s.motion))[-1], len(self.aim.ends)
        numbers: list[dict[Expr, Array]] = [{e: last} for e in aim.ends]
        numbers += [{} if aim.cost is ZERO else {aim.cost: last}] * aim.costs
        whole = Integrand(aim.integral, np.eye(len(numbers))[-1], s.motion.inputs)
        values, slopes = s.weighted(numbers, None if aim.integral is ZERO else whole)
        cost, by_cost = (float(values[m]), slopes[m]) if aim.costs else (0.0, np.zeros(len(self.sizes)))
        return values[:m], slopes[:m], cost, by_cost

    def conditions(self, z: Array) -> tuple[Array, Array]:
        """The conditions along the motion (k × m), and what is `left` of each (m)."""
        motion = self.motion(z, _SAMPLES)
        return self.aim.along(motion), self.left(motion)

    def left(self, motion: Solution) -> Array:
        """What the relative tolerance leaves of each condition (m) that is zero: a straight throw misses a plane by rounding alone."""
        sizes = self.course.map.tolerances[0] * self.course.sizes(motion.states, 1.0)
        slopes = np.array([slopes_along(motion, e, ())[-1] for e in self.aim.ends]).reshape(-1, len(sizes))
        return np.asarray(np.nan_to_num(np.abs(slopes) @ sizes, posinf=0.0))

    def resize(self, rows: Array, slopes: Array) -> Array:
        """The factors by which the sizes of unknowns change for which nothing gave a size, all of a unit alike.

        Afterwards such an unknown, by its size, changes a condition by its own size `rows` (m), or none by more; `slopes` (m × k).
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where((rows[:, None] > 0) & (slopes != 0), rows[:, None] / np.abs(slopes), np.inf)
        reach = reach.min(axis=0, initial=np.inf)
        units = [s.unit if open_ else None for s, open_ in zip(self.course.by, self.unsized, strict=True)]
        least = {u: min(r for r, v in zip(reach.tolist(), units, strict=True) if v == u) for u in units}
        factors = np.array([1.0 if u is None or not np.isfinite(least[u]) else least[u] for u in units])
        self.sizes, self._last = self.sizes * factors, None
        return factors


@by_keyword
def shoot(
    eom: Equations,
    span: tuple[float, float],
    unknown: Any,
    state: State | None = None,
    *,
    end: Mapping[Any, Any] | None = None,
    cost: Any = 0,
    integral: Any = 0,
    panels: int = 50,
    bounds: Mapping[Any, tuple[float | None, float | None]] | None = None,
    rtol: float = 1e-9,
    atol: float = 1e-9,
    tolerance: float = 1e-8,
    max_steps: int = 200,
    settings: Settings | None = None,
    **by_kind: Unpack[StateValues],
) -> Shot:
    """Find inputs, parameters and initial values with which a motion satisfies conditions at its end, at the least cost.

    Without a cost the conditions are solved, with the least change of the unknowns if there are several solutions; a cost is
    minimized subject to the conditions by sequential quadratic programming. The motion may have contacts and events.

    Parameters
    ----------
    eom : Equations
    span : (float, float)
    unknown : parameters, of the equations or of inputs (`kn.fitting.curve` makes an input with unknown values), and coordinates,
        speeds or states, which stand for their initial values
    end : final conditions {name or expression: value, or (low, high)}
    cost : an expression to minimize, at the end of the motion
    integral : an expression whose integral over the motion is to be minimized, added to `cost`
    panels : number of segments in multiple shooting (see Notes) and in the quadrature; divided further at breakpoints of inputs
    bounds : {unknown: (low, high)}, None for no bound
    rtol, atol : tolerances of the motions
    tolerance : admissible residual of the conditions, each relative to its largest magnitude along the motion; what `rtol` leaves of a
        condition, by the states that it depends on, counts as zero
    max_steps : largest number of steps of the optimizer
    q, u, states, parameters, inputs : initial guess, as for `kn.simulate`

    Returns
    -------
    Shot

    Raises
    ------
    SimulationError
        if a motion does not reach the end, or the conditions are not satisfied

    Notes
    -----
    If the number of conditions and costs is at most twice that of the unknowns, derivatives are computed by one backward
    integration along each motion, as by `kn.fitting.sensitivities` with method "adjoint"; else by the variational equations. The
    optimizers are `scipy.optimize.minimize`, method "SLSQP", and `least_squares` without a cost. Betts, J. T. (2010), Practical
    Methods for Optimal Control and Estimation Using Nonlinear Programming, SIAM, ch. 3. For equations without constraints, contacts
    and events, with unknowns only in inputs of time that are linear in them, as curves are, direct multiple shooting is used instead
    (Albersmeyer, J., Diehl, M. (2010), The lifted Newton method, SIAM J. Optim. 20).

    Examples
    --------
    >>> F = kn.fitting.curve("F", np.linspace(0, 2, 21))
    >>> shot = kn.shoot(eom, (0, 2), F.nodes, q=[0, 0], u=[0, 0], inputs={"F": F.expression}, end={"theta": np.pi, "u1": 0, "u2":
    0})
    """
    given = state_of(state, **by_kind)
    course = ParametricMotion.of(eom, span, unknown, given, (rtol, atol), settings)
    aim = _aim(eom, course, end, cost, integral, panels)
    first, (low, high) = course.first, course.limits(bounds)
    flight = Flight(course, aim, _sizes(course.by, first, (low, high)))
    with working("Shooting"):
        found = _joined(flight, first, (low, high), panels, tolerance, max_steps)
        if found is not None:
            return _shot(flight, *found, tolerance, aim.value)
        z, message = first / flight.sizes, ""
        along, left = flight.conditions(z)
        rows = np.where(aim.sizes(along) > left, aim.sizes(along), 0.0)
        if flight.unsized.any():
            flight.resize(rows, flight.slopes(z).by_ends)
        rows = np.where(rows > 0, rows, np.abs(flight.slopes(z).by_ends).max(axis=1, initial=0))
        rows = np.where(rows > 0, rows, 1.0)
        if aim.ends:
            z, message = _least_residual(flight, z, (low, high), rows, max_steps)
        if aim.costs:
            sizes = _sizes(course.by, z * flight.sizes, (low, high))
            near = Flight(course, aim, np.where(sizes > 0, sizes, flight.sizes))
            near.steps = flight.steps
            z, message = _least(near, z * flight.sizes / near.sizes, (low, high), rows, tolerance, max_steps)
            flight = near
        return _shot(flight, z, message, tolerance, lambda motion: flight.slopes(z).cost)


def _sizes(by: Sequence[Symbol], values: Array, bounds: tuple[Array, Array]) -> Array:
    """The scale of each unknown for the optimizer: its magnitude, at least a tenth of the largest one with the same unit.

    If all values with this unit are zero, it is that of their bounds, or 0 without bounds.
    """
    units, ends = [getattr(s, "unit", "") for s in by], np.abs(bounds)

    def shared(magnitudes: Array) -> Array:
        own = list(zip(magnitudes.tolist(), units, strict=True))
        return np.array([max(x, 0.1 * max(y for y, v in own if v == u)) for x, u in own])

    first = shared(np.abs(values))
    return np.where(first > 0, first, shared(np.where(np.isfinite(ends), ends, 0.0).max(axis=0)))


def _aim(eom: Equations, course: ParametricMotion, end: Any, cost: Any, integral: Any, panels: Any) -> Aim:
    count = expect.whole(panels, "panels= as a whole number above 0", least=1, error=SimulationError)
    ends, low, high = list[Expr](), list[float](), list[float]()
    right = end is None or isinstance(end, Mapping)
    expect.that(right, "end= as a dict of expressions and their values", end, error=SimulationError)
    for what, wanted in (end or {}).items():
        found = asked(eom.derived, what)
        expect.that(found.shape == (), "expressions at the end", what, error=SimulationError)
        a, b = interval(wanted if isinstance(wanted, tuple | list | np.ndarray) else (wanted, wanted))
        expect.that(a <= b, f"a value of {what} at the end, or (low, high)", wanted, error=SimulationError)
        ends.append(found.roots[0])
        low.append(a)
        high.append(b)
    costs = [asked(eom.derived, e).roots[0] if isinstance(e, str) else as_expr(e) for e in (cost, integral)]
    if not ends and all(e is ZERO for e in costs):
        raise SimulationError("Expected end=, cost= or integral= as the aim of the motion, got none of them.")
    drives = course.map.drives(course.parameters)
    edges = cut_at_bends(course, count, Integrand(costs[1], np.ones(1), drives).checked(eom))
    times, weights = gauss(_POINTS, edges.tolist())
    if costs[1] is ZERO:
        times, weights = edges[[0, -1]], np.zeros(2)
    return Aim(tuple(ends), np.array(low), np.array(high), costs[0], costs[1], times, weights)


_ROUNDS = 4
"""Largest number of corrections or refinements of multiple shooting."""
_COARSE = 1e-5
"""Largest relative difference of final conditions between multiple shooting and a single motion without refinement."""


def _joined(
    flight: Flight, first: Array, bounds: tuple[Array, Array], count: int, tolerance: float, most: int
) -> tuple[Array, str] | None:
    """The least cost, or the least change of the unknowns, by multiple shooting; None if it is inapplicable or fails.

    The difference of the final conditions of a single motion is subtracted from the target of the next round.
    """
    aim, course = flight.aim, flight.course
    z = start = first / flight.sizes
    steps, x, shift = steps_of(course, aim.exprs, flight.sizes, count), None, np.zeros(len(aim.ends))
    for _ in range(_ROUNDS):
        if steps is None:
            return None
        limits = Limits(*_scaled(bounds, flight), aim.low - shift, aim.high - shift)
        x = _guessed(flight, z, steps.edges) if x is None else x
        if flight.unsized.any() and not flight.steps:
            values, slopes = steps.end_by(x, z)
            factors = flight.resize(aim.sizes(np.vstack([steps.end(x[0])[0][1:], values])), slopes)
            steps, start = steps.resized(factors), start / factors
            z = start
        found = least_cost(steps, z, x, limits, most, course.sizes, None if aim.costs else start)
        if found is None:
            return None
        z, x = np.clip(found.z, limits.low, limits.high), found.x
        flight.steps += found.rounds
        values, left = flight.conditions(z)
        if aim.missed(values, left).max(initial=0.0) <= tolerance / 2:
            return z, f"a minimum with {len(steps.h)} joined motions"
        shift = values[-1] - steps.end(x[-1])[0][1:]
        if (np.abs(shift) > _COARSE * aim.sizes(values)).any():
            count, shift, x = 2 * count, 0 * shift, None
            steps = steps_of(course, aim.exprs, flight.sizes, count)
    return None


def _guessed(flight: Flight, z: Array, times: Array) -> Array:
    """Initial states of segments: linear from start to end if all final values are specified, else from the motion at z."""
    course, aim = flight.course, flight.aim
    start, wanted = course.start, dict(zip(aim.ends, aim.low.tolist(), strict=True))
    if all(s in wanted for s in course.map.eom.state) and np.array_equal(aim.low, aim.high):
        end = np.array([wanted[s] for s in course.map.eom.state])
        share = (times - times[0]) / (times[-1] - times[0])
        return np.asarray(start + share[:, None] * (end - start))
    motion = flight.motion(z, times)
    return np.asarray(motion.states[np.searchsorted(motion.t, np.minimum(times, motion.t[-1]))])


def _least_residual(flight: Flight, z: Array, bounds: tuple[Array, Array], rows: Array, most: int) -> tuple[Array, str]:
    """Solves the conditions alone, by least squares, relative to their sizes `rows`."""
    aim = flight.aim
    call: Callable[..., Any] = least_squares

    def missed(at: Array) -> tuple[Array, Array]:
        values, slopes, *_ = flight.slopes(at)
        below, above = np.minimum(values - aim.low, 0), np.maximum(values - aim.high, 0)
        return (below + above) / rows, np.where((below + above != 0)[:, None], slopes, 0.0) / rows[:, None]

    def residuals(at: Array) -> Array:
        try:
            return missed(at)[0]
        except KaneError:
            return np.full(len(aim.ends), np.inf)

    found = call(
        residuals, z, jac=lambda at: missed(at)[1], bounds=_scaled(bounds, flight), xtol=1e-14, ftol=1e-14, gtol=1e-15,
        max_nfev=most,
    )  # fmt: skip
    return np.asarray(found.x), str(found.message)


def _scaled(bounds: tuple[Array, Array], flight: Flight) -> tuple[Array, Array]:
    return bounds[0] / flight.sizes, bounds[1] / flight.sizes


def _least(
    flight: Flight, z: Array, bounds: tuple[Array, Array], rows: Array, tolerance: float, most: int
) -> tuple[Array, str]:
    """Minimizes the cost subject to the conditions, relative to their sizes `rows`."""
    aim = flight.aim
    equal = aim.low == aim.high
    kinds = (
        ("eq", np.flatnonzero(equal), aim.low, 1.0),
        ("ineq", np.flatnonzero(~equal & np.isfinite(aim.low)), aim.low, 1.0),
        ("ineq", np.flatnonzero(~equal & np.isfinite(aim.high)), aim.high, -1.0),
    )
    conditions = [
        {
            "type": kind,
            "fun": lambda at, k=k, to=to, sign=sign: sign * ((flight.slopes(at).ends - to) / rows)[k],
            "jac": lambda at, k=k, sign=sign: sign * (flight.slopes(at).by_ends / rows[:, None])[k],
        }
        for kind, k, to, sign in kinds
        if len(k)
    ]
    first = flight.slopes(z)
    scale = max(abs(first.cost), float(np.abs(first.by_cost).max())) or 1.0
    call: Callable[..., Any] = minimize
    found = call(
        lambda at: flight.slopes(at).cost / scale, z, jac=lambda at: flight.slopes(at).by_cost / scale, constraints=conditions,
        bounds=list(zip(*_scaled(bounds, flight), strict=True)), method="SLSQP", options={"maxiter": most, "ftol": tolerance},
    )  # fmt: skip
    return np.asarray(found.x), str(found.message)


def _shot(flight: Flight, z: Array, message: str, tolerance: float, cost: Callable[[Solution], float]) -> Shot:
    aim, course = flight.aim, flight.at(z)
    at = flight.motion(z, np.unique(np.append(aim.times, np.linspace(course.map.t0, course.end, _SAMPLES))))
    along = aim.along(at)
    values, missed = along[-1], aim.missed(along, flight.left(at))
    off = np.maximum(np.maximum(aim.low - values, values - aim.high), 0)
    if not missed.max(initial=0.0) <= 10 * tolerance:
        k = int(np.argmax(missed))
        raise SimulationError(
            f"Expected unknowns for which the motion satisfies the end conditions, got {aim.ends[k]} = {values[k]:.6g} there, off "
            f"by {off[k]:.2g}: {message.rstrip('.')}. Give better first values, free more unknowns, or widen bounds and conditions."
        )
    motion = course.motion(np.linspace(course.map.t0, course.end, 501))
    return Shot(
        dict(zip(course.by, (z * flight.sizes).tolist(), strict=True)),
        cost(at),
        float(off.max(initial=0.0)),
        motion,
        course.parameters,
        course.map.state(motion.states[0]),
        flight.steps,
        message,
    )
