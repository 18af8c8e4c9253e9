# SPDX-License-Identifier: BSD-3-Clause
"""`continuation`: pseudo-arclength continuation of steady motions, past turning points, with the eigenvalues along the branch.

Crossings of the imaginary axis, Re λ = 0, are found by bisection on the branch.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple, Unpack

import numpy as np
import numpy.typing as npt

from kane import expect
from kane.analysis.linear import Linear
from kane.analysis.linearization import Linearizer, linearizer
from kane.analysis.one_sided import Side
from kane.analysis.operating_point import closed, state_from, warn_of_beams, warn_of_contacts
from kane.analysis.steady_conditions import ScaledConditions, SteadyProblem
from kane.analysis.trimming import null_space, problem, solve_problem, undetermined
from kane.equations.compiled import Numeric
from kane.equations.equations import Equations, check_equations
from kane.equations.state import GROUPS, State, StateValues, by_keyword, state_of
from kane.errors import Attributes, CornerError, SimulationError, ValueMissingError, none_of, warn
from kane.expr.symbols import Symbol
from kane.numeric.arclength import ImplicitCurve, Path
from kane.numeric.arrays import Array, Complex
from kane.numeric.scale import ROUNDED, ROUNDED_ROOT, SOLVED
from kane.program.native.machine import Settings
from kane.progress import far, working

Middle = Callable[[Array, Array], Array | None]
Spectrum = Callable[[Array], Complex]

_BISECTIONS = 60


@dataclass(frozen=True, slots=True, eq=False)
class Crossing(Attributes):
    """A crossing of the imaginary axis: `eigenvalue` is i ω at the onset of an oscillation (flutter), 0 at that of divergence.

    If a switch in the equations makes the eigenvalue jump across the axis, `eigenvalue` is that on the side nearer to the axis,
    with a nonzero real part. `value` is that of the varied symbol, `point` the steady motion there, and `between` the indices of
    the points of the branch before and after it; `grows` is whether the mode is growing after the crossing, or decaying.
    """

    value: float
    eigenvalue: complex
    point: State
    between: tuple[int, int]
    grows: bool

    def __repr__(self) -> str:
        return f"Crossing({self.value:.9g}, λ = {self.eigenvalue:.6g}, {'grows' if self.grows else 'decays'} after it)"


class Change(NamedTuple):
    """A crossing of the imaginary axis in interval k of a path: the point Y, the eigenvalue `root`, and whether it grows after it."""

    interval: int
    y: Array
    root: complex
    grows: bool


def tracked(rows: Sequence[Complex]) -> Complex:
    """Eigenvalues in rows, each row in the order nearest to its linear extrapolation from the rows before."""
    ordered = [np.asarray(rows[0])]
    for row in rows[1:]:
        guess = 2 * ordered[-1] - ordered[-2] if len(ordered) > 1 else ordered[-1]
        ordered.append(_matched(row, np.abs(guess[:, None] - row)))
    return np.array(ordered)


def changes(path: Sequence[Array], roots: Sequence[Complex], middle: Middle, spectrum: Spectrum) -> list[Change]:
    """Crossings of the imaginary axis by eigenvalues along a path.

    Parameters
    ----------
    path : points Y, so close that `middle` finds the branch between two of them
    roots : the eigenvalues at each point
    middle : returns the point of the branch halfway between two, or None if it is not found
    spectrum : returns the eigenvalues at a point
    """
    size = max((float(np.abs(r).max(initial=0)) for r in roots), default=0.0)
    least = ROUNDED_ROOT * size
    crossings = []
    for k, (first, last) in enumerate(pairwise(roots)):
        before, after = tracked([first, last])
        met: list[Change] = []
        for j, (start, end) in enumerate(zip(before.tolist(), after.tolist(), strict=True)):
            grows = end.real > least
            if (start.real > least) == grows or (start.imag < 0 and end.imag < 0):
                continue
            y, root = _bisected((path[k], before), (path[k + 1], after), j, least, middle, spectrum)
            new = Change(k, y, root, grows)
            # one of a conjugate pair suffices; if a pair is real at one end only, both are found here
            if (start.imag == 0 and end.imag == 0) or not any(_same(new, c, least) for c in met):
                met.append(new)
        crossings += met
    return crossings


def _same(one: Change, other: Change, least: float) -> bool:
    """Whether two crossings are those of a conjugate pair."""
    apart = np.linalg.norm(one.y - other.y)
    return bool(one.grows == other.grows and apart < ROUNDED_ROOT and abs(one.root - other.root) <= 10 * least)


def _bisected(
    a: tuple[Array, Complex], b: tuple[Array, Complex], k: int, least: float, middle: Middle, spectrum: Spectrum
) -> tuple[Array, complex]:
    """Y and i |ω| where Re λ of mode k is zero, or where the mode leaves the axis if one end is on it within rounding.

    If Re λ jumps across zero, λ on the side nearer to zero.
    """
    level = 0.0 if min(abs(a[1][k].real), abs(b[1][k].real)) > least else least
    for _ in range(_BISECTIONS):
        y = middle(a[0], b[0]) if np.linalg.norm(b[0] - a[0]) > ROUNDED else None
        if y is None:
            break
        # match roots to those at both ends, all modes together, so that each is matched once
        roots = spectrum(y)
        roots = _matched(roots, np.abs(a[1][:, None] - roots) + np.abs(b[1][:, None] - roots))
        if (roots[k].real > level) == (b[1][k].real > level):
            b = y, roots
        else:
            a = y, roots
    y, roots = min(a, b, key=lambda end: abs(end[1][k].real))
    frequency = abs(roots[k].imag)
    if np.linalg.norm(b[0] - a[0]) <= 10 * ROUNDED and abs(b[1][k].real - a[1][k].real) > 100 * least:
        return y, complex(roots[k])  # λ jumps at a switch
    return y, complex(0.0, frequency if frequency > 10 * least else 0.0)


def _matched(row: Complex, distance: Array) -> Complex:
    """The row in the order of the least total distance; among equal ones, that in which more modes stay in place.

    Otherwise rounding would decide between a mode that stays on the axis and one that crosses it.
    """
    from scipy.optimize import linear_sum_assignment

    least = ROUNDED_ROOT * np.abs(row).max(initial=0)
    return np.asarray(row[linear_sum_assignment(distance + least * (distance > least))[1]])


@dataclass(frozen=True, slots=True, eq=False)
class Branch(Attributes):
    """A branch of steady motions: `points` (states) and their linearizations `linear` at `values` of `symbol`, in order along it.

    `eigenvalues` (points × states) has each eigenvalue in one column, without cyclic coordinates. `turning` holds the indices of
    the turning points, `crossings` a record for each crossing of the imaginary axis by an eigenvalue: the value of `symbol`, the
    steady motion there, and the points between which it lies.
    """

    symbol: Symbol
    values: Array
    points: tuple[State, ...]
    linear: tuple[Linear, ...]
    eigenvalues: npt.NDArray[np.complex128]
    turning: tuple[int, ...]
    crossings: tuple[Crossing, ...]
    message: str

    @property
    def turning_points(self) -> tuple[float, ...]:
        """The values of `symbol` at the turning points of the branch."""
        return tuple(self.values[list(self.turning)].tolist())

    @property
    def frequencies(self) -> Array:
        """|Im λ| (rad/s) at each point, ascending, one for each pair of eigenvalues (points × ⌈states/2⌉); 0 for a real pair."""
        rows: Array = np.sort(np.abs(self.eigenvalues.imag), axis=1)[:, ::-2][:, ::-1]
        return rows

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        turns = ", ".join(f"{v:.6g}" for v in self.turning_points) or "none"
        return (
            f"Branch({len(self)} points, {self.symbol.name} = {self.values[0]:.6g} … {self.values[-1]:.6g}; turning points: {turns}; "
            f"{self.message})"
        )


@by_keyword
def continuation(
    eom: Equations,
    symbol: Any,
    values: Sequence[float],
    state: State | None = None,
    *,
    moving: Sequence[Any] = (),
    independent: Sequence[Any] = (),
    outputs: Mapping[str, Any] | Sequence[Any] | None = None,
    max_points: int = 2000,
    settings: Settings | None = None,
    **by_kind: Unpack[StateValues],
) -> Branch:
    """Follow a branch of steady motions as `symbol` varies from the first of `values` to the last, by pseudo-arclength continuation.

    The branch starts with `kn.trim` at the first value, and passes turning points, so that a value may occur several times. It
    ends where it reaches the last value, or the first one again.

    Parameters
    ----------
    eom : Equations
    symbol : the parameter, input, speed or coordinate to vary, by symbol or name
    values : increasing or decreasing; the branch has a point at each of them, and at each turning point
    state : a `kn.State` of values and guesses instead of q, u, states, parameters, inputs and t
    q, u, states, parameters, inputs, moving, independent : as for `kn.trim`, without a value of `symbol`
    outputs, settings : as for `kn.linearize`

    Raises
    ------
    SimulationError
        if there is no steady motion at the first value
    ValueMissingError
        if the conditions do not determine a single branch
    """
    check_equations(eom)
    wanted = _values(values)
    expect.whole(max_points, "max_points= as a number of points", least=0, error=SimulationError)
    task, place = _problem(eom.numeric(settings), symbol, wanted[0], state_of(state, **by_kind), moving, independent)
    with working("Following the branch"):
        start = solve_problem(task, SOLVED)
        unknowns = _unknowns(task, place, start, float(wanted[-1] - wanted[0]))
        curve, y = ImplicitCurve(unknowns), start[list(unknowns.places)] / unknowns.columns
        path = curve.follow(y, wanted / unknowns.columns[-1], max_points, unknowns.last)
        branch = _branch(unknowns, curve, path, linearizer(eom, outputs=outputs, settings=settings), independent)
    warn_of_beams(eom, branch.points)
    warn_of_contacts(eom, branch.points)
    return branch


def _values(values: Sequence[float]) -> Array:
    expected = "two or more increasing or decreasing values to follow"
    series = np.atleast_1d(expect.floats(values, expected, error=SimulationError))
    step = np.diff(series)
    monotonic = series.ndim == 1 and len(series) > 1 and (np.all(step > 0) or np.all(step < 0))
    expect.that(monotonic and np.all(np.isfinite(series)), expected, values, error=SimulationError)
    return series


def _problem(
    numeric: Numeric[Equations],
    symbol: Any,
    value: float,
    given: State,
    moving: Sequence[Any],
    independent: Sequence[Any],
) -> tuple[SteadyProblem, int]:
    eom = numeric.equations
    name = symbol.name if isinstance(symbol, Symbol) else symbol
    kinds: dict[str, tuple[Symbol, ...]] = {k: getattr(eom, GROUPS[k]) for k in ("q", "u", "parameters", "inputs")}
    for kind, symbols in kinds.items():
        if isinstance(name, str) and name in [s.name for s in symbols]:
            values = getattr(given, kind)
            if values is not None and not isinstance(values, Mapping):
                raise SimulationError(f"Expected {kind}= by symbol or name where {name} changes, got a sequence.")
            others = {k: v for k, v in (values or {}).items() if (k.name if isinstance(k, Symbol) else k) != name}
            start = replace(given, **{kind: {**others, name: value}})
            task = problem(numeric, start, moving, independent)
            return task, [s.name for s in task.conditions.symbols].index(name)
    names = [s.name for symbols in kinds.values() for s in symbols]
    raise ValueMissingError(f"Expected a value of the system to change, one of {none_of(names, symbol)}")


def _unknowns(task: SteadyProblem, place: int, start: Array, span: float) -> ScaledConditions:
    """The unknowns with, last, the varied value, scaled by its range; unknowns on which nothing depends keep their values."""
    expected, came = "values that determine one branch", "a family of branches: {} can have other values at the start"
    cure = "Give some of them as numbers."
    expect.none(undetermined(task, start, task.free), expected, came, cure, error=ValueMissingError)
    frozen: set[int] = set()
    inert = [i for i in task.free if i not in set(task.mattering)]
    for row in null_space(task, start):
        part = {i: abs(row[task.free.index(i)]) for i in inert if i not in frozen}
        frozen.update(sorted(part, key=part.__getitem__)[-1:])
    places = (*(i for i in task.free if i not in frozen), place)
    # without the range of the varied value nothing has a size where a branch begins at rest and unloaded
    _, rows, columns = task.conditions.sizes(start, {place: abs(span)})
    columns = np.append(columns[list(places[:-1])], abs(span))
    return replace(task.measured, rows=rows, columns=columns, start=start, places=places)


def _linear(lin: Linearizer, point: State, independent: Sequence[Any], side: Callable[[], Side]) -> tuple[Linear, str]:
    """The linearization at a point of a branch, at a corner on the side of the next points, and a remark for messages."""
    try:
        return lin(point, independent=independent, steady=False), ""
    except CornerError as error:
        way = {name: d for name, d in side().items() if name in error.names}
        try:
            return lin(point, independent=independent, steady=False, side=way), str(error)
        except (CornerError, ValueMissingError):
            raise error from None


def _branch(
    unknowns: ScaledConditions, curve: ImplicitCurve, path: Path, lin: Linearizer, independent: Sequence[Any]
) -> Branch:
    conditions, scale = unknowns.conditions, float(unknowns.columns[-1])
    kept = {conditions.perturbed.names[i] for i in conditions.constant}
    states = len(conditions.eom.state)
    kept |= {conditions.eom.states[i].name for i in conditions.further}

    def beside(y: Array) -> dict[str, float]:
        """The direction to the nearest other point of the branch."""
        others = [other for other in path.points if not np.array_equal(other, y)]
        change = min((other - y for other in others), key=lambda d: float(np.linalg.norm(d)))
        moved = zip(unknowns.places, change * unknowns.columns, strict=True)
        return {conditions.symbols[i].name: float(d) for i, d in moved if i < states}

    def at(y: Array) -> tuple[State, Linear, str]:
        far(lambda: f"linearizing at {unknowns.last(y)}")
        y = np.where(np.abs(y) <= ROUNDED, 0.0, y)
        point = state_from(conditions.eom, closed(conditions.numeric, conditions.state(unknowns.spread(y))))
        at_point, corner = _linear(lin, point, independent, lambda: beside(y))
        gone = [n for n in (*at_point.coordinates, *at_point.further) if n not in kept]
        return point, replace(at_point, cyclic=tuple(gone)).without("cyclic"), corner

    every = [at(y) for y in path.points]
    spectra = [linear.eigenvalues for _, linear, _ in every]
    met = changes(path.points, spectra, curve.middle, lambda y: at(y)[1].eigenvalues)
    points, linear, corners = zip(*(every[k] for k in path.marked), strict=True)
    if any(corners):
        where = ", ".join(unknowns.last(path.points[k]) for k, told in zip(path.marked, corners, strict=True) if told)
        warn(
            f"Expected equations with one derivative all along the branch, got corners at {where}: eigenvalues there are "
            f"one-sided, on the side of the nearest other point of the branch. {next(filter(None, corners))}"
        )
    # indices of the marked points that follow the crossings
    after = np.searchsorted(path.marked, [c.interval for c in met], side="right").tolist()
    pairs = zip(met, after, strict=True)
    crossings = [Crossing(float(c.y[-1] * scale), c.root, at(c.y)[0], (k - 1, k), c.grows) for c, k in pairs]
    symbol = conditions.symbols[unknowns.places[-1]]
    values = np.array([path.points[k][-1] * scale for k in path.marked])
    eigenvalues = tracked([at.eigenvalues for at in linear])
    return Branch(symbol, values, points, linear, eigenvalues, path.turning, tuple(crossings), path.message)
