# SPDX-License-Identifier: BSD-3-Clause
"""`fit`: parameters, initial values and gains by weighted least squares between a motion and measurements, with standard errors.

For measurements y of columns c at times i, and the outputs h of the model, Σ ((y − h)/σ_c)² is minimized. The Jacobian is exact:
−(∂h/∂x Ψ + ∂h/∂p)/σ_c with Ψ of the variational equations. Unstable and chaotic motions are divided into segments with unknown
initial states (multiple shooting); the gaps between segments are first residuals with growing weights, then constraints (Bock 1987;
Voss, Timmer, Kurths 2004).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Unpack

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import least_squares

from kane import expect
from kane.equations.equations import Equations
from kane.equations.state import State, StateValues, by_keyword, guess, state_of
from kane.errors import KaneError, SimulationError, cut
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol
from kane.motion.derivatives.motion_derivatives import Sensitivities
from kane.motion.derivatives.parametric_motion import ParametricMotion
from kane.motion.derivatives.tangent_space import flow_of, sizes_of
from kane.motion.fitting.found import Fit, FittedRun
from kane.motion.fitting.measured import Measurements, measured, starts_of
from kane.motion.fitting.possible import Here, Possible, possible_bodies
from kane.motion.solution.phases import Indices
from kane.numeric.arrays import Array
from kane.numeric.pseudo_inertia import WEIGHT
from kane.numeric.scale import ROUNDED, SIX_DIGITS
from kane.program.native.machine import Settings
from kane.progress import far, working

_UNDETERMINED = 1e-8
"""Singular values of the scaled Jacobian, relative to the largest, that count as zero; derivatives are accurate to 1e-9."""
_NEAR = 1e-4
_ROUNDS = 8
"""Largest number of times that the standard deviations of columns are estimated again."""
_SETTLED = 0.01
_WEIGHTS = (1.0, 1e-2, WEIGHT)
_PROMISED = 1e-6
"""Predicted decrease at which the iteration ends, relative to the weight of the body distances."""
_ARRIVED, _LEAST, _FAR = 1e-10, 1e-8, 0.5
"""Step at convergence, least fraction of a step, and longest step of multiple shooting, relative to the sizes of the unknowns."""


@dataclass(frozen=True, slots=True, eq=False)
class ShootingSegment:
    """One motion of the fit as a function of the unknown parameters and of its unknown initial values, with its rows of the data.

    `first` marks the first segment of a data set; `columns` are the indices of its columns among those of all sets.
    """

    data: Measurements
    course: ParametricMotion
    first: bool
    columns: tuple[int, ...]


class _Failed(Exception):
    """Raised for a motion that does not reach the end of its segment."""


class FitProblem:
    """Residuals and their Jacobian as functions of z: the unknown parameters, then the unknown initial values of each segment."""

    def __init__(
        self, segments: Sequence[ShootingSegment], unknown: Sequence[Parameter], bodies: Sequence[Possible] = ()
    ) -> None:
        eom = segments[0].course.map.eom
        self.eom, self.segments, self.unknown, self.bodies = eom, tuple(segments), tuple(unknown), tuple(bodies)
        self.sigma, self.steps = np.ones(1 + max(k for s in segments for k in s.columns)), 0
        self.scale = np.ones(len(eom.state))
        self._last: tuple[bytes, list[tuple[Sensitivities, Indices]]] | None = None

    @property
    def start_slices(self) -> list[slice]:
        """The slice of z with the initial values of each segment."""
        ends = np.cumsum([len(self.unknown), *(len(s.course.free) for s in self.segments)])
        return [slice(int(a), int(b)) for a, b in pairwise(ends)]

    def of_segment(self, k: int, z: Array) -> dict[Symbol, float]:
        """The parameters and initial values of segment k at z."""
        values = [*z[: len(self.unknown)].tolist(), *z[self.start_slices[k]].tolist()]
        return dict(zip((*self.unknown, *self.segments[k].course.free), values, strict=True))

    @property
    def first(self) -> Array:
        """The initial guess of z."""
        starts = [s.course.first[len(self.unknown) :] for s in self.segments]
        return np.concatenate([self.segments[0].course.first[: len(self.unknown)], *starts])

    @property
    def heads(self) -> list[int]:
        """The first segment of each data set."""
        return [k for k, s in enumerate(self.segments) if s.first]

    @property
    def leading(self) -> list[tuple[int, Symbol]]:
        """The independent unknowns, each with the segment whose initial value it is (0 for parameters), in the order of `at`."""
        own = [(0, s) for s in self.unknown]
        return own + [(k, s) for k in self.heads for s in self.segments[k].course.free]

    @property
    def at(self) -> list[int]:
        """The indices of `leading` in z."""
        places = [range(len(self.unknown)), *(range(*self.start_slices[k].indices(1 << 62)) for k in self.heads)]
        return [i for some in places for i in some]

    def meetings(self) -> list[tuple[int, int]]:
        """The pairs of consecutive segments of one data set."""
        return [(k, k + 1) for k in range(len(self.segments) - 1) if not self.segments[k + 1].first]

    def _motions(self, z: Array) -> list[tuple[Sensitivities, Indices]]:
        """The sensitivities of each segment, with the samples at the times of its data; raises `_Failed`."""
        key = z.tobytes()
        if self._last is None or self._last[0] != key:
            found = list[tuple[Sensitivities, Indices]]()
            for k, segment in enumerate(self.segments):
                course = segment.course.at(self.of_segment(k, z))
                times = np.minimum(segment.data.t, course.end)
                motion = course.motion(np.unique([*times, course.end]))
                self.steps += 1
                if motion.status != "finished":
                    raise _Failed(motion.message)
                found.append((course.sensitivities(motion), np.searchsorted(motion.t, times)))
            far(lambda: f"{self.steps} motions")
            self._last = key, found
        return self._last[1]

    def both(self, z: Array) -> tuple[Array, Array]:
        """Residuals (m) and Jacobian (m × z)."""
        rows, slopes, motions = list[Array](), list[Array](), self._motions(z)
        for k, (s, at) in enumerate(motions):
            data, columns = self.segments[k].data, self.segments[k].columns
            for c, expr in enumerate(data.exprs):
                there, sigma = data.there[:, c], self.sigma[columns[c]]
                rows.append((data.values[there, c] - s.motion[expr][at][there]) / sigma)
                own = -s[expr][at][there] / sigma
                slopes.append(self._spread(own, k, len(z)))
        return np.concatenate(rows), np.concatenate(slopes)

    def bodies_at(self, z: Array) -> list[Here]:
        """The distances of bodies from the initial ones, if these must stay consistent; raises `_Failed` for an inconsistent body."""
        values = dict[Expr, Any](self.segments[0].course.parameters)
        values.update(self.of_segment(0, z).items())
        result = [here for body in self.bodies if (here := body.at(values)) is not None]
        if len(result) < len(self.bodies):
            raise _Failed("no such body")
        return result

    def joints(self, z: Array) -> tuple[Array, Array]:
        """The gaps between consecutive segments, relative to the size of each state, and their Jacobian."""
        motions, rows, slopes = self._motions(z), list[Array](), list[Array]()
        for k, next_ in self.meetings():
            (before, _), (after, _) = motions[k], motions[next_]
            free = set(self.segments[next_].course.free)
            kept = [i for i, x in enumerate(self.eom.state) if x in free]
            size = self.scale[kept, None]
            rows.append((before.motion.states[-1, kept] - after.motion.states[0, kept]) / size[:, 0])
            own = self._spread(before.states[-1, kept] / size, k, len(z))
            slopes.append(own - self._spread(after.states[0, kept] / size, k + 1, len(z)))
        return np.concatenate(rows), np.concatenate(slopes)

    def condensed(self, z: Array) -> Array:
        """The Jacobian by the independent unknowns; the initial values of later segments are eliminated by continuity."""
        _, j = self.both(z)
        first = self.at
        if j.shape[1] == len(first):
            return j[:, first]
        _, g = self.joints(z)
        rest = sorted({*range(len(z))} - {*first})
        return np.asarray(j[:, first] - j[:, rest] @ np.linalg.solve(g[:, rest], g[:, first]))

    def _spread(self, own: Array, k: int, width: int) -> Array:
        """Columns by the unknowns of segment k inserted into a matrix of columns by all of z."""
        whole, k_p = np.zeros((len(own), width)), len(self.unknown)
        whole[:, :k_p], whole[:, self.start_slices[k]] = own[:, :k_p], own[:, k_p:]
        return whole

    def residuals(self, z: Array) -> Array:
        """Residuals (m), infinite if a motion does not reach the end of its segment."""
        try:
            return self.both(z)[0]
        except (_Failed, KaneError):
            return np.full(sum(int(s.data.there.sum()) for s in self.segments), np.inf)

    @property
    def _gaps(self) -> int:
        return sum(len(s.course.free) for s in self.segments if not s.first)

    def gap(self, z: Array) -> float:
        """The largest gap between segments, relative to the size of a state."""
        motions, most = self._motions(z), 0.0
        for k, next_ in self.meetings():
            (before, _), (after, _) = motions[k], motions[next_]
            apart = np.abs(before.motion.states[-1] - after.motion.states[0]) / self.scale
            most = max(most, float(apart.max(initial=0.0)))
        return most


@by_keyword
def fit(
    eom: Equations,
    data: Any,
    unknown: Any,
    state: State | Sequence[State] | None = None,
    *,
    outputs: Mapping[str, Any] | None = None,
    sigma: Any = None,
    bounds: Mapping[Any, tuple[float | None, float | None]] | None = None,
    physical: bool = False,
    segments: int = 1,
    rtol: float = 1e-10,
    atol: float = 1e-10,
    max_steps: int = 100,
    settings: Settings | None = None,
    **by_kind: Unpack[StateValues],
) -> Fit:
    """Estimate parameters and initial values from measurements of a motion, by least squares with exact Jacobians.

    Systems may have closed loops, contacts with stick and slip, events, and inputs with unknown gains: motions must be
    differentiable.

    Parameters
    ----------
    eom : Equations
    data : DataFrame, Dataset, or dict of arrays; or a list of these
        times "t" (s), and columns named as symbols of the equations or as `outputs`; NaN for missing values. The motion starts at
        the first time. Each of several sets is a motion with its own initial values, and with the same unknown parameters
    unknown : parameters, of the equations or of inputs that are expressions; and coordinates, speeds or states with unknown initial
        values. `parameters`, `q`, `u` contain the initial guesses
    outputs : {column: expression} for measured quantities that are not symbols
    sigma : standard deviations {column: σ}, or a number for all columns; by default estimated from the residuals. Required with
        several segments
    bounds : {unknown: (low, high)}, None for no bound
    physical : whether to keep inertial parameters physically consistent: positive masses, and inertias of a distribution of
        positive mass. Standard errors ignore this condition: where it is active, they are too large
    segments : number of segments of the motion, each with its own initial state (multiple shooting); use several if small errors
        grow a thousandfold over the time of the data
    rtol, atol : tolerances of the motions
    max_steps : largest number of evaluations of one least-squares problem
    state : for several sets, one `kn.State` for all, or a list: initial values, inputs, and known parameters
    q, u, states, parameters, inputs : as for `kn.simulate`

    Returns
    -------
    Fit
        values, standard errors, covariance, residuals and the motion

    Raises
    ------
    SimulationError
        if data do not match the equations, the measurements do not determine the unknowns (the message names them), the first
        motion does not reach the end of the data, or no minimum is found

    Notes
    -----
    Bock, H. G. (1987), Randwertproblemmethoden zur Parameteridentifizierung in Systemen nichtlinearer Differentialgleichungen,
    Bonner Mathematische Schriften 183; `scipy.optimize.least_squares`, method "trf".

    Examples
    --------
    >>> fit = kn.fit(eom, data, ["k", "c", "x"], q={"x": 0.1}, u=[0], parameters={"k": 1})
    >>> fit.values[k], fit.errors[k], fit.residuals["x"]
    """
    sets = list(data) if isinstance(data, list | tuple) else [data]
    states: Sequence[Any] = list(state) if isinstance(state, list | tuple) else [state] * len(sets)
    expect.that(bool(sets), "data, or a list of sets of them", data, error=SimulationError)
    expect.that(len(states) == len(sets), "one state for each set of data", len(states), error=SimulationError)
    found = [measured(eom, one, outputs) for one in sets]
    count = expect.whole(segments, "segments= as a whole number above 0", least=1, error=SimulationError)
    few = min(len(one.t) for one in found)
    expect.that(count <= few // 2, "two rows of data or more a segment", count, "Take fewer.", error=SimulationError)
    if count > 1 and sigma is None:
        raise SimulationError(
            "Expected sigma= with segments=, got none: gaps between segments, which close during the iteration, are weighed "
            "against the accuracy of the data. Give the standard deviation of each column, sigma={'q1': 0.001}."
        )
    courses = [
        ParametricMotion.of(eom, (one.t[0], one.t[-1]), unknown, state_of(own, **by_kind), (rtol, atol), settings)
        for one, own in zip(found, states, strict=True)
    ]
    names = list(dict.fromkeys(name for one in found for name in one.names))
    parameters = [s for s in courses[0].by if isinstance(s, Parameter)]
    with working("Fitting"):
        pieces = [
            piece for course, one in zip(courses, found, strict=True) for piece in _segments(course, one, count, names)
        ]
        first = courses[0].at(dict(zip(courses[0].by, courses[0].first.tolist(), strict=True)))
        bodies = possible_bodies(eom, parameters, first.parameters) if physical else ()
        search = FitSearch(
            FitProblem(pieces, parameters, bodies),
            courses,
            found,
            names,
            [c.limits(bounds) for c in courses],
            max_steps,
        )
        return search.run(_sigma(names, sigma))


def _sigma(names: Sequence[str], given: Any) -> Array | None:
    if given is None:
        return None
    try:
        given = dict.fromkeys(names, given) if expect.is_number(given) else dict(given)
    except (TypeError, ValueError):
        expected = "sigma= as a number, or a dict of columns and numbers"
        raise expect.refusal(SimulationError, expected, cut(repr(given))) from None
    missing = [name for name in names if name not in given]
    expect.none(missing, "σ of every column", "none of {}", error=SimulationError)
    result = np.array(
        [expect.number(given[name], f"σ of {name!r} as a number", error=SimulationError) for name in names]
    )
    expect.that(bool((result > 0).all()), "σ above zero", given, error=SimulationError)
    return result


def _segments(course: ParametricMotion, data: Measurements, count: int, names: Sequence[str]) -> list[ShootingSegment]:
    """The segments of a data set, with initial states estimated from the measurements and the motion with the initial guesses.

    After the first segment the whole state is unknown: its independent part as unknowns, the rest as guesses for assembly.
    """
    unknown = [s for s in course.by if isinstance(s, Parameter)]
    columns = tuple(names.index(name) for name in data.names)
    if count == 1:
        return [ShootingSegment(data, replace(course, by=(*unknown, *course.free)), True, columns)]
    eom, rows = course.map.eom, [len(data.t) * k // count for k in range(count + 1)]
    ends = [*data.t[rows[1:-1]].tolist(), float(data.t[-1])]
    motion = course.motion(data.t)
    independent = set(eom.state)
    if eom.constraints.constraints or eom.system.euler_parameters:
        free = set(flow_of(course.map.walk(()).side(motion, 0)).states)
        independent = {s for s in eom.state if s.name in free}
    by = (*unknown, *(s for s in eom.state if s in independent))
    values, rates = starts_of(data, rows[1:-1])
    first = replace(course.over(float(data.t[0]), ends[0]), by=(*unknown, *course.free))
    result = [ShootingSegment(data.between(0, rows[1]), first, True, columns)]
    for k, row in enumerate(rows[1:-1]):
        at = int(min(np.searchsorted(motion.t, data.t[row]), len(motion) - 1))
        own = course.map.state(motion.states[at])
        state: dict[Any, float] = {**own.q, **own.u, **own.states, **_measured_state(course, values, rates, k)}
        groups = {
            kind: {s: state[s] if s in independent else guess(state[s]) for s in getattr(own, kind)}
            for kind in ("q", "u", "states")
        }
        piece = replace(course.over(float(data.t[row]), ends[k + 1]), given=replace(course.given, **groups), by=by)
        result.append(ShootingSegment(data.between(row, rows[k + 2]), piece, False, columns))
    return result


def _measured_state(
    course: ParametricMotion, values: Mapping[Expr, Array], rates: Mapping[Expr, Array], k: int
) -> dict[Symbol, float]:
    """The measured part of a state at the start of a segment; speeds follow from the rates if all coordinates are measured."""
    eom, result = course.map.eom, dict[Symbol, float]()
    result |= {s: float(values[s][k]) for s in eom.state if s in values}
    if all(q in values for q in eom.coordinates) and not eom.system.euler_parameters:
        q, rate = ({s: float(own[s][k]) for s in eom.coordinates} for own in (values, rates))
        own = {s: v for s, v in course.parameters.items() if s in set(eom.parameters)}
        u = eom.speeds_from_rates(q=q, rates=rate, parameters=own)
        result |= {s: float(v) for s, v in u.items() if s not in result}
    return result


@dataclass(frozen=True, eq=False)
class FitSearch:
    """The sequence of least-squares problems, with σ estimated again from the residuals; `most` limits the steps of each."""

    problem: FitProblem
    courses: Sequence[ParametricMotion]
    data: Sequence[Measurements]
    names: Sequence[str]
    bounds: Sequence[tuple[Array, Array]]
    most: int

    def run(self, sigma: Array | None) -> Fit:
        """Solves the problems and returns the fit; SimulationError if a motion fails or no minimum is found."""
        problem = self.problem
        z = problem.first
        columns = [[d.values[:, d.names.index(n)] for d in self.data if n in d.names] for n in self.names]
        spread = np.array([np.nanstd(np.concatenate(some)) for some in columns])
        problem.sigma = np.where(spread > 0, spread, 1.0) if sigma is None else sigma
        try:
            problem.both(z)
        except _Failed as failed:
            raise SimulationError(
                f"Expected a first motion over all of the data, got one that ended earlier: {failed}. Give better first "
                "values of the unknowns in parameters=, q= and u=, or use segments=."
            ) from None
        problem.scale = self._sizes(z)
        z = self._solved(z)
        for _ in range(_ROUNDS if sigma is None else 0):
            before, problem.sigma = problem.sigma, self._left(z)
            if np.all(np.abs(problem.sigma / before - 1) < _SETTLED):
                break
            z = self._solved(z) if len(before) > 1 or problem.bodies else z
        return self._fit_at(z)

    def _sizes(self, z: Array) -> Array:
        """The sizes of states, relative to which gaps are measured."""
        states = np.concatenate([s.motion.states for s, _ in self.problem._motions(z)])
        return sizes_of(self.problem.eom, np.abs(states).max(axis=0), 1e-3)

    def _solved(self, z: Array) -> Array:
        """The solution of the least-squares problem, starting at z."""
        problem, low, high = self.problem, np.full(len(z), -np.inf), np.full(len(z), np.inf)
        set_of = {k: i for i, k in enumerate(problem.heads)}
        for i, (k, s) in zip(problem.at, problem.leading, strict=True):
            own = {other: n for n, other in enumerate(self.courses[set_of[k]].by)}[s]
            low[i], high[i] = (end[own] for end in self.bounds[set_of[k]])
        for weight in _WEIGHTS if problem.bodies else (0.0,) if problem._gaps else ():
            z = (self._joined if problem._gaps else self._possible)(z, (low, high), weight)
        if problem.bodies or problem._gaps:
            return z
        call: Callable[..., Any] = least_squares
        found = call(
            problem.residuals, z, jac=lambda at: problem.both(at)[1], bounds=(low, high), x_scale="jac", method="trf",
            xtol=1e-12, ftol=1e-12, gtol=1e-13, max_nfev=self.most,
        )  # fmt: skip
        if found.status <= 0:
            raise self._none(str(found.message))
        return np.asarray(found.x)

    def _joined(self, z: Array, bounds: tuple[Array, Array], weight: float) -> Array:
        """Least squares constrained by continuity of the segments, by Gauss–Newton steps (Bock 1987).

        A step d minimizes |r + J d| subject to c + G d = 0; it is halved until ½ r² + μ |c| decreases, with μ above the multipliers.
        Distances of bodies enter with their `weight`, as in `_possible`.
        """
        problem = self.problem
        z = self._nearer(z, bounds)
        scale = dict(zip(problem.eom.state, problem.scale.tolist(), strict=True))
        own = [scale[s] for segment in problem.segments for s in segment.course.free]
        size = np.append(np.abs(z[: len(problem.unknown)]), own)
        size = np.where(size > 0, size, 1.0)
        for _ in range(self.most):
            (r, j), (c, g) = self._beside_bodies(z, weight), problem.joints(z)
            j, g = j * size, g * size
            back = -np.linalg.lstsq(g, c)[0]
            free = null_space(g)
            d = back + free @ np.linalg.lstsq(j @ free, -(r + j @ back))[0]
            if max(np.abs(d).max(), np.abs(c).max()) <= _ARRIVED:
                return np.asarray(z + size * d)
            if weight and np.abs(c).max() <= _ARRIVED and float(np.sum((j @ d) ** 2)) <= _PROMISED * weight:
                return z
            mu = 2.0 * float(np.abs(np.linalg.lstsq(g.T, -j.T @ (r + j @ d))[0]).max())
            fall = float(r @ (j @ d)) - mu * float(np.abs(c).sum())
            now = self._merit(z, mu, weight)
            share = self._share(z, size * d, bounds, _FAR / float(np.abs(d).max()), (now, fall, mu, weight))
            if share <= _LEAST:
                if np.abs(d).max() <= SIX_DIGITS and np.abs(c).max() <= SIX_DIGITS:
                    return z
                raise self._none("no step decreases the merit function")
            z = z + share * size * d
        raise self._none("all steps were used")

    def _share(
        self, z: Array, step: Array, bounds: tuple[Array, Array], most: float, sought: tuple[float, float, float, float]
    ) -> float:
        """The fraction of a step, within bounds, that decreases the merit `now` by enough of the predicted `fall`, or `_LEAST`."""
        now, fall, mu, weight = sought
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(step > 0, (bounds[1] - z) / step, np.where(step < 0, (bounds[0] - z) / step, np.inf))
        share = min(1.0, most, 0.99 * float(room.min()))
        while share > _LEAST and not self._merit(z + share * step, mu, weight) <= now + 1e-4 * share * fall:
            share /= 2
        return share

    def _possible(self, z: Array, bounds: tuple[Array, Array], weight: float) -> Array:
        """Minimizes ½ r² plus `weight` times the distances of bodies, by Gauss–Newton steps, each halved until the sum decreases."""
        for _ in range(self.most):
            rest, whole = self._beside_bodies(z, weight)
            sizes = np.linalg.norm(whole, axis=0)
            d = -np.linalg.lstsq(whole / sizes, rest)[0] / sizes
            fall, now = float(np.sum((whole @ d) ** 2)), self._merit(z, 0.0, weight)
            if fall <= _PROMISED * max(weight, ROUNDED * now):
                return z
            share = self._share(z, d, bounds, 1.0, (now + ROUNDED * abs(now), -fall, 0.0, weight))
            if share <= _LEAST:
                if fall <= SIX_DIGITS:
                    return z
                raise self._none("no step decreases the merit function")
            z = z + share * d
        raise self._none("all steps were used")

    def _nearer(self, z: Array, bounds: tuple[Array, Array]) -> Array:
        """An approach to continuity: gaps are residuals whose weight grows tenfold twice, since they need not close at once."""
        problem = self.problem
        call: Callable[..., Any] = least_squares
        (r, _), (c, _) = problem.both(z), problem.joints(z)
        if float(np.abs(c).max()) <= SIX_DIGITS:
            return z
        weight = float(np.linalg.norm(r)) / float(np.linalg.norm(c))

        def both(at: Array, share: float) -> tuple[Array, Array]:
            problem.bodies_at(at)  # raises if a body is inconsistent
            (r, j), (c, g) = problem.both(at), problem.joints(at)
            return np.concatenate([r, share * c]), np.vstack([j, share * g])

        def residuals(at: Array, share: float) -> Array:
            try:
                return both(at, share)[0]
            except (_Failed, KaneError):
                return np.full(len(r) + len(c), np.inf)

        for share in (weight, 10 * weight, 100 * weight):
            found = call(
                residuals, z, jac=lambda at, share: both(at, share)[1], bounds=bounds, x_scale="jac", args=(share,),
                xtol=_NEAR, ftol=_NEAR, max_nfev=self.most,
            )  # fmt: skip
            z = np.asarray(found.x)
        return z

    def _merit(self, z: Array, mu: float, weight: float) -> float:
        try:
            far = sum(here.distance for here in self.problem.bodies_at(z))
            r, c = self.problem.both(z)[0], self.problem.joints(z)[0] if self.problem._gaps else np.zeros(0)
        except (_Failed, KaneError):
            return float("inf")
        return 0.5 * float(r @ r) + weight * far + mu * float(np.abs(c).sum())

    def _beside_bodies(self, z: Array, weight: float) -> tuple[Array, Array]:
        """Residuals and Jacobian, with rows appended whose squares represent `weight` times the distances of bodies."""
        r, j = self.problem.both(z)
        rows, rest, more = [j], [r], len(z) - len(self.problem.unknown)
        for here in self.problem.bodies_at(z):
            rows.append(weight**0.5 * np.pad(here.slopes, ((0, 0), (0, more))))
            rest.append(weight**0.5 * here.rest)
        return np.concatenate(rest), np.vstack(rows)

    def _none(self, said: str) -> SimulationError:
        return SimulationError(
            f"Expected a minimum within {self.most} steps, got none: {said.rstrip('.')}. Give better first values, more "
            "segments=, or a larger max_steps=."
        )

    def _left(self, z: Array) -> Array:
        """σ of each column estimated from the residuals; degrees of freedom are reduced by its share of the unknowns."""
        motions, count = self.problem._motions(z), len(self.problem.sigma)
        total, values = np.zeros(count), np.zeros(count)
        for (s, at), segment in zip(motions, self.problem.segments, strict=True):
            for c, expr in enumerate(segment.data.exprs):
                there, column = segment.data.there[:, c], segment.columns[c]
                total[column] += float(np.sum((segment.data.values[there, c] - s.motion[expr][at][there]) ** 2))
                values[column] += int(there.sum())
        free = len(z) - self.problem._gaps
        share = 1 - free / max(values.sum(), free + 1)
        floor = 1e-12 * np.maximum(self.problem.sigma, 1e-300)
        return np.asarray(np.maximum(np.sqrt(total / np.maximum(values * share, 1e-300)), floor))

    def _fit_at(self, z: Array) -> Fit:
        problem = self.problem
        whole = self._covariance(z)
        errors = dict(zip(problem.leading, np.sqrt(np.diag(whole)).tolist(), strict=True))
        place = {key: i for i, key in enumerate(problem.leading)}
        order = [place[0, s] for s in self.courses[0].by]
        order += [i for i in range(len(place)) if i not in set(order)]
        runs = [self._run(i, k, z, errors) for i, k in enumerate(problem.heads)]
        first = runs[0]
        return Fit(
            first.values,
            first.errors,
            whole[np.ix_(order, order)],
            dict(zip(self.names, problem.sigma.tolist(), strict=True)),
            first.residuals,
            first.motion,
            self.courses[0].at(first.values).parameters,
            first.start,
            problem.gap(z),
            problem.steps,
            tuple(runs),
        )

    def _run(self, i: int, k: int, z: Array, errors: Mapping[tuple[int, Symbol], float]) -> FittedRun:
        """The results for data set i, whose first segment is k."""
        problem, data, by = self.problem, self.data[i], self.courses[i].by
        values = problem.of_segment(k, z)
        course = self.courses[i].at(values)
        motion = course.motion(data.t)
        at = np.minimum(np.searchsorted(motion.t, np.minimum(data.t, course.end)), len(motion) - 1)
        own = [motion[e][at] if motion.status == "finished" else np.full(len(data.t), np.nan) for e in data.exprs]
        return FittedRun(
            {s: values[s] for s in by},
            {s: errors[(0 if isinstance(s, Parameter) else k), s] for s in by},
            {name: data.values[:, c] - own[c] for c, name in enumerate(data.names)},
            motion,
            course.map.state(motion.states[0]),
            data,
        )

    def _covariance(self, z: Array) -> Array:
        """(JᵀJ)⁻¹, by columns of J of equal size; SimulationError names the unknowns which the measurements do not determine."""
        problem = self.problem
        j, set_of = problem.condensed(z), {k: i for i, k in enumerate(problem.heads)}
        symbols = [f"{s} of set {set_of[k]}" if k else str(s) for k, s in problem.leading]
        sizes = np.linalg.norm(j, axis=0)
        dead = [s for s, size in zip(symbols, sizes, strict=True) if not size > 0]
        if dead:
            raise SimulationError(
                f"Expected unknowns on which the measured columns depend, got {', '.join(dead)}, on which no column depends. "
                "Measure more, or give their values."
            )
        _, values, rows = np.linalg.svd(j / sizes, full_matrices=False)
        weak = np.flatnonzero(values <= _UNDETERMINED * values[0])
        if len(j) < j.shape[1] or len(weak):
            shares = np.abs(rows[weak]).max(axis=0) if len(weak) else np.ones(j.shape[1])
            names = dict.fromkeys(s for s, x in zip(symbols, shares, strict=True) if x > 0.1 * shares.max())
            raise SimulationError(
                f"Expected data that determine the unknowns, got data that leave {', '.join(names)} undetermined: a combined "
                f"change of them does not change any measured value ({max(len(weak), j.shape[1] - len(j))} of {j.shape[1]} "
                "directions). Give values of some, or measure more."
            )
        back = rows.T / values / sizes[:, None]
        return np.asarray(back @ back.T)
