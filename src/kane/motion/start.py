# SPDX-License-Identifier: BSD-3-Clause
"""Checks at the start of a motion: its arguments, the model at the initial state, and rates that are not determined there.

Rates of coordinates follow from speeds by W of q̇ = W u + X, whose pivots are compared with their size at a random configuration:
cos q2 = 6e-17 at q2 = π/2 counts as zero. If the mass matrix is singular up to rounding, finite accelerations mean nothing.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from kane import expect
from kane.analysis.state_checks import check_kinetic_energy
from kane.dynamics.poles import AdmittedSpeeds, SlipEnd
from kane.dynamics.readings.regularity import mass_matrix_in_doubt, open_speeds
from kane.equations.equations import Equations, repartition
from kane.errors import SimulationError, cut
from kane.expr.evaluation import evaluate, free_symbols, is_constant_in_time
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.ops import OPS, SQRT
from kane.expr.regular import size
from kane.expr.symbols import Coordinate
from kane.model.beams.beam import Beam
from kane.model.bodies import largest_moment, least_moment, parts_of
from kane.model.solids import Inertia, Shape, limits
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.arrays import Array, Mask, distinct
from kane.numeric.rank import balance, singular
from kane.numeric.sampling import SEED, finite_number, sample
from kane.numeric.scale import EPS, MOTION_RANK, SOLVE_RANK, TAKES_PART, UNRELATED


class Vanishing(NamedTuple):
    """A pivot of W, its value at a state, and its magnitude relative to that at a random configuration."""

    pivot: Expr
    value: float
    relative: float

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates in the pivot."""
        return tuple(s for s in free_symbols([self.pivot]) if isinstance(s, Coordinate))

    def __str__(self) -> str:
        return f"{cut(self.pivot, 80)} = {self.value:.3g}"


def pivots(eom: Equations, values: Mapping[Expr, Any]) -> list[Vanishing]:
    """The pivots of W that depend on the configuration, the relatively smallest first."""
    found = moving(eom)
    if not found:
        return []
    usual = [abs(x) for x in sample(found, SEED)]
    rows = [
        Vanishing(p, float(v), abs(float(v)) / (scale or 1.0))
        for p, v, scale in zip(found, evaluate(found, values), usual, strict=True)
    ]
    return sorted(rows, key=lambda r: r.relative)


def moving(eom: Equations) -> list[Expr]:
    """The pivots of W that depend on the configuration."""
    return [p for p in dict.fromkeys(eom.solved.regular.kinematical.pivots) if not is_constant_in_time([p])]


def check_regular(eom: Equations, values: Mapping[Expr, Any], t: float) -> None:
    """A SimulationError if Y is singular at the start; it names the pivots of W that vanish, and the undetermined rates."""
    small = pivots(eom, values)
    if not small:
        return
    speeds = eom.solved.regular.kinematical
    rates = speeds.rates
    free = _free_direction([[r.get(b, ZERO) for b in rates] for r in speeds.rows], values)
    if free is None:
        return
    named = [r for r in small if r.relative <= UNRELATED] or small[:1]
    open_ = ", ".join(str(b) for b, c in zip(rates, free, strict=True) if abs(c) > TAKES_PART)
    where = ", ".join(f"{q} = {float(values[q]):.6g}" for q in dict.fromkeys(q for r in named for q in r.coordinates))
    raise SimulationError(
        f"Expected finite rates at the start, got none for {open_} at t = {t:g}: the kinematics are singular at {where}, where W of "
        f"q' = W u + X divides by {', '.join(map(str, named))}. Start elsewhere, or choose coordinates that are regular here (another "
        "sequence of angles, Euler parameters)."
    )


def regular_otherwise(
    eom: Equations, values: Mapping[Expr, Any], admitted: AdmittedSpeeds, made: Callable[..., Equations]
) -> Equations | None:
    """Equations with other dependent speeds, determined at a state, whose W is farther from a pole than that of `eom`; or None.

    `made(repartition, partition)` derives and stores the equations.
    """
    assert eom.embedding is not None
    others = admitted.others(values, eom.embedding.partition.dependent)
    if others is None:
        return None
    found = made(repartition, admitted.partition(values, eom.embedding.partition, others))
    least, now = (min((p.relative for p in pivots(e, values)), default=1.0) for e in (found, eom))
    return found if least > now else None


def _free_direction(rows: list[list[Expr]], values: Mapping[Expr, Any]) -> Array | None:
    """x with Y x = 0, with rows and columns of Y divided by their sizes at a random configuration; None if Y is regular.

    So a row that vanishes at this configuration only counts as zero, although rounding leaves a remainder.
    """
    y = np.asarray(evaluate(Matrix(rows), values), dtype=float)
    usual = np.abs(np.array(sample([x for row in rows for x in row], SEED)).reshape(y.shape))
    if not (np.all(np.isfinite(y)) and np.all(np.isfinite(usual))):
        return None
    size = balance(usual, order=(1, 0), rounding=0.0)
    scaled = singular(y / size.rows / size.columns)
    return None if scaled.regular(SOLVE_RANK) else scaled.right[-1]


def nearly_singular(eom: Equations, values: Mapping[Expr, Any]) -> str:
    """The addition to the message of a motion that stopped near a singularity of W; "" if it did not."""
    near = [r for r in pivots(eom, values) if r.relative < MOTION_RANK]
    return f"; W of q' = W u + X divides by {', '.join(map(str, near))} there" if near else ""


def check_mass_matrix(eom: Equations, values: Mapping[Expr, Any], t: float) -> None:
    """A SimulationError if M of a system without constraints is singular at the start; it names the undetermined accelerations."""
    m = mass_matrix_in_doubt(eom.solved, values)
    if m is None:
        return
    check_kinetic_energy(eom.speeds, m, f"at t = {t:g}")
    names = ", ".join(f"{eom.speeds[k]}'" for k in open_speeds(m))
    if names:
        raise SimulationError(
            f"Expected finite rates at the start, got none for {names} at t = {t:g}: the equations are singular at this state, where "
            "the mass matrix does not determine them. Start elsewhere, or choose coordinates and speeds that are regular here."
        )


_TIMES = 1000
"""Least number of spacings of floating-point numbers in a time span."""


class _Bounded(NamedTuple):
    """Values of a measure that must be ≥ 0, or > 0 if `above`, with the `expected` in words and the measure as `written`."""

    value: Any
    above: bool
    expected: str
    written: Expr | None = None


def _bounded(eom: Equations, constants: Mapping[Expr, Any]) -> Iterator[_Bounded]:
    """Measures of beams, friction, masses, sizes and least moments of inertia, at values of the parameters."""
    for beam in eom.system.bodies:
        for what, measure in beam.measures() if isinstance(beam, Beam) else ():
            yield _Bounded(evaluate(measure, constants), True, f"{what} of {beam.name} above zero", measure)
    for load in eom.system.loads:
        size = ZERO if load.slip is None else load.slip.size
        if size is not ZERO and all(s in constants for s in free_symbols([size])):
            yield _Bounded(evaluate(size, constants), False, f"a size ≥ 0 of {load.name!r}", size)
    for part in parts_of(eom.system.bodies):
        if not part.momenta and all(s in constants for s in free_symbols([part.mass])):
            yield _Bounded(evaluate(part.mass, constants), False, f"a mass ≥ 0 for {part.name}", part.mass)
        if isinstance(part.inertia, Inertia):
            yield from _sizes(part.name, part.inertia.shape, constants)
        least = least_moment(part, constants)
        if least is not None:
            yield _Bounded(least, False, f"central principal moments of inertia ≥ 0 for {part.name}")


def _sizes(name: str, shape: Shape, constants: Mapping[Expr, Any]) -> Iterator[_Bounded]:
    """The dimensions of a solid, where they contain parameters that differ from their defaults, which its declaration has judged."""
    own = [(s, constants.get(s)) for s in free_symbols(shape.sizes.values())]
    if any(x is None for _, x in own) or all(isinstance(x, float) and x == s.default for s, x in own):
        return
    found = tuple(limits(shape.kind, shape.sizes))
    for x, value in zip(found, evaluate([x.value for x in found], constants), strict=True):
        expected = f"{x.what} {name!r} {'above' if x.above else 'at or above'} zero"
        yield _Bounded(value, x.above, expected, x.value)


def check_masses(eom: Equations, constants: Mapping[Expr, float]) -> None:
    """A SimulationError if a mass, a moment of inertia, a size or friction is negative, or a measure of a beam not above zero."""
    for value, above, expected, written in _bounded(eom, constants):
        if value < 0 or (above and not value > 0):
            came = "" if written is None else f"{cut(written)} = "
            raise SimulationError(
                f"Expected {expected}, got {came}{float(value):g} at the values of the parameters. Correct them."
            )


def surely_have_mass(eom: Equations, columns: Mapping[Expr, Array], count: int) -> Mask:
    """For which of `count` sets of parameters, in `columns`, `check_masses` certainly raises no error (count)."""
    sure = np.ones(count, dtype=bool)
    for value, above, *_ in _bounded(eom, columns):
        sure &= np.asarray(value > 0 if above else value >= 0)
    return sure


def massless(eom: Equations, constants: Mapping[Expr, float]) -> str:
    """The addition to a message on bodies without mass and inertia at the values of the parameters; "" if there are none."""
    names = []
    for part in parts_of(eom.system.bodies):
        known = all(s in constants for s in free_symbols([part.mass]))
        if known and evaluate(part.mass, constants) == 0 and not largest_moment(part, constants):
            names.append(part.name)
    return f"; {', '.join(names)} without mass and inertia at the values of the parameters" if names else ""


def check_span(span: Any) -> tuple[float, float]:
    """(t0, t1), or a SimulationError unless t1 > t0, both finite, with enough floating-point numbers between them."""
    try:
        t0, t1 = map(float, expect.reals(span))
    except (TypeError, ValueError, OverflowError) as error:
        raise SimulationError(f"Expected a time span (t0, t1), got {cut(repr(span))}. Give two times in s.") from error
    if not (np.isfinite(t0) and np.isfinite(t1) and t1 > t0):
        raise SimulationError(
            f"Expected a time span (t0, t1) with t1 > t0, got ({t0:g}, {t1:g}). Time increases during a motion: swap the two, "
            "or end later."
        )
    apart = math.ulp(max(abs(t0), abs(t1)))
    if t1 - t0 < _TIMES * apart:
        raise SimulationError(
            f"Expected a time span with enough floating-point numbers in it, got ({t0:.17g}, {t1:.17g}), where they are {apart:.2g} "
            f"s apart: {(t1 - t0) / apart:.0f} in all. Use an origin of time closer to the span, such as (0, {t1 - t0:g})."
        )
    return t0, t1


def check_tolerance(name: str, value: float) -> float:
    """A tolerance, or a SimulationError unless it is above zero, and a relative one from EPS to below 1."""
    number = finite_number("tolerance", name, value)
    if isinstance(value, bool | np.bool_) or not number > 0:
        raise SimulationError(f"Expected {name} > 0, got {value!r}. Usual tolerances are 1e-6 to 1e-12.")
    if name == "rtol" and not EPS <= number < 1:
        raise SimulationError(
            f"Expected rtol from {EPS:.1e}, the spacing of numbers at 1, to below 1, got {value!r}. Usual tolerances are 1e-6 to "
            "1e-12."
        )
    return number


def sample_times(samples: int | Sequence[float], span: tuple[float, float]) -> Array:
    """Increasing sample times within the span (n), from their number or the times; a SimulationError if they are not admissible."""
    t0, t1 = span
    if isinstance(samples, int | np.integer):
        if samples < 2:
            raise SimulationError(f"Expected at least 2 samples, got {samples}. Give more, or the times: samples=[…].")
        expect.that(samples < 10**9, "fewer than 1e9 samples", samples, error=SimulationError)
        return np.linspace(t0, t1, int(samples))
    cure = "Give a whole number, or times in s."
    times = expect.floats(samples, "a number of samples or their times", cure, error=SimulationError)
    if not np.all(np.isfinite(times)):
        raise SimulationError(
            f"Expected finite sample times, got {times[~np.isfinite(times)].flat[0]} among them. Leave it out."
        )
    if times.ndim != 1 or np.any(np.diff(times) <= 0) or (times.size and (times[0] < t0 or times[-1] > t1)):
        raise SimulationError(
            f"Expected a whole number of samples, or increasing sample times within ({t0:g}, {t1:g}), got {_out_of_order(times, span)}"
        )
    return times


def _out_of_order(times: Array, span: tuple[float, float]) -> str:
    """What is wrong with sample times, and how to correct them."""
    if times.ndim == 0:
        return f"the number {float(times):g}. Give samples=[{float(times):g}] for a time."
    if times.ndim > 1:
        return f"an array of shape {times.shape}. Give one list."
    back = np.flatnonzero(np.diff(times) <= 0)
    if back.size:
        return f"{times[back[0] + 1]:.9g} after {times[back[0]]:.9g}. Sort them, and leave out repeated ones."
    return f"{times[0] if times[0] < span[0] else times[-1]:.9g}. Leave it out, or give a longer span."


def check_steps(most: Any) -> int:
    """The largest number of steps; a SimulationError unless it is a whole number above zero."""
    if isinstance(most, bool) or not isinstance(most, int | np.integer) or most < 1:
        raise SimulationError(f"Expected max_steps to be a whole number above 0, got {cut(repr(most))}.")
    return int(most)


def check_events(eom: Equations, values: Array, t0: float, at: Callable[[], Mapping[Expr, Any]]) -> None:
    """A SimulationError if the model is not valid at the start; the user's own events may start on either side of their thresholds.

    A slip that is zero up to rounding of its terms counts as zero; `at()` returns a number for every symbol.
    """
    own = {e.name for e in eom.system.events}
    for event, value in zip(eom.events, values, strict=True):
        if event.name in own:
            continue
        least = (
            UNRELATED * _speeds(event.quantity, at())
            if isinstance(event, SlipEnd) and event.by_share
            else event.threshold
        )
        if event.direction < 0 and value <= least:
            raise SimulationError(
                f"Expected a start before the event {event.name!r}, got {value:.6g} at t = {t0:g}, already at or below "
                f"{least:.6g}. {event.message}"
            )


def _speeds(slip: Expr, values: Mapping[Expr, Any]) -> float:
    """The size of the terms of a slip, |v| or √(v·v)."""
    inner = slip.args[0] if slip.op in (SQRT, OPS["abs"]) else slip
    terms = float(evaluate(size(inner, {}), values))
    return math.sqrt(terms) if slip.op is SQRT else terms


def check_rates(
    names: Sequence[str], rates: Array, t: float, why: Callable[[], str], load: Callable[[], str] = lambda: ""
) -> None:
    """A SimulationError if rates are not finite at the start; `why` names the first such value, `load` a load that is the cause."""
    bad = [n for n, v in zip(names, rates, strict=False) if not np.isfinite(v)]
    if bad:
        told = load() or (
            f"equations are singular at this state ({why()}). Start elsewhere, or choose coordinates and speeds that are regular here"
        )
        raise SimulationError(
            f"Expected finite rates at the start, got none for {', '.join(bad)} at t = {t:g}: the {told}."
        )


def check_longest(name: str, kind: str, what: str, longest: Any) -> float:
    """The largest step, or elapsed time; infinite if none is given, a SimulationError unless it is above zero."""
    if longest is None:
        return float("inf")
    number = finite_number(kind, name, longest)
    if not number > 0:
        raise SimulationError(f"Expected {name} > 0, the longest {what} in s, got {longest!r}.")
    return number


def check_first_step(first: Any, longest: Any, method: str) -> float | None:
    """The length of the first step, or None; a SimulationError unless it is above zero and at most the largest step."""
    if first is None:
        return None
    number = finite_number("length", "first_step", first)
    if not number > 0:
        raise SimulationError(f"Expected first_step > 0, the length of the first step in s, got {first!r}.")
    if method in INTEGRATORS and INTEGRATORS[method].fixed:
        raise SimulationError(
            f'Expected no first_step for method="{method}", whose steps all have the length max_step, got {first!r}. Leave it out.'
        )
    if longest is not None and number > longest:
        raise SimulationError(
            f"Expected first_step of at most max_step={longest:g}, got {first!r}. Give a shorter one, or leave it out."
        )
    return number


def check_breakpoints(times: Any) -> tuple[float, ...]:
    """Times at which steps must end, in order, each once; a SimulationError if one is not finite."""
    cure = "Give a sequence of times in s."
    found = distinct(expect.floats(times, "breakpoints as times", cure, error=SimulationError).ravel())
    if not np.all(np.isfinite(found)):
        raise SimulationError(f"Expected breakpoints at finite times, got {cut(repr(times))}.")
    return tuple(found.tolist())
