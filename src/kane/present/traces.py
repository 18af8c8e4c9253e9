# SPDX-License-Identifier: BSD-3-Clause
"""Quantities of motions as lines with labels and units, samples added where curves would show corners; their grouping into panels."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from kane.dynamics.readings.quantities import asked
from kane.errors import ArgumentError, SimulationError, UnitError, cut
from kane.expr.node import Expr, as_expr
from kane.expr.ops import ADD, DIV, MUL, NEG, SUB, Op
from kane.expr.symbols import Symbol
from kane.expr.visit import fold
from kane.model.unit_checks import unit_in
from kane.motion.cycles.section import SectionPoints
from kane.motion.solution.phases import Indices
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.present.motion_plots import label_of
from kane.space.vector import Vector
from kane.write.arrange import to_text

R = TypeVar("R")

_MOST = 4000
"""Largest number of samples drawn, unless the motion itself has more."""
_BEND = 0.003
"""Largest deviation of a sample from the line through its neighbours, as a fraction of a panel; half of it shows no corner."""
_FEW = 9
"""Number of samples below which the deviation cannot be estimated."""
_ROUNDS = 2
"""Number of refinements, as the first estimate from few samples is inaccurate."""


@dataclass(frozen=True, slots=True)
class PlottedRun:
    """A motion or section points, with its name in the legend ("" if it is the only one)."""

    name: str
    motion: Solution | SectionPoints
    dotted: bool = False

    @property
    def t(self) -> Array:
        """The times of the samples."""
        return self.motion.t

    @property
    def line(self) -> str:
        """The line style in matplotlib; section points have none."""
        return "none" if isinstance(self.motion, SectionPoints) else "-"


def runs_of(solution: Any) -> list[PlottedRun]:
    """The runs for one motion, a list, or a mapping from labels.

    Raises
    ------
    ArgumentError
        if an item is not a motion, or there is none
    """
    if isinstance(solution, Mapping):
        named = [(str(label), motion) for label, motion in solution.items()]
    elif isinstance(solution, Sequence) and not isinstance(solution, str):
        named = [(f"{k}", motion) for k, motion in enumerate(solution, 1)]
    else:
        named = [("", solution)]
    for label, motion in named:
        if not isinstance(motion, Solution | SectionPoints):
            where = f" for {label!r}" if label else ""
            raise ArgumentError(
                f"Expected a motion from kn.simulate to plot, passages from kn.poincare, or a list or mapping of these, got "
                f"{cut(repr(motion))}{where}."
            )
    if not named:
        raise ArgumentError(f"Expected at least one motion to plot, got {cut(repr(solution))}.")
    return [PlottedRun(label, motion, isinstance(motion, SectionPoints)) for label, motion in named]


def smooth(
    run: PlottedRun, read: Callable[[PlottedRun], R], curves: Callable[[R], Sequence[Array]]
) -> tuple[PlottedRun, R]:
    """The run with enough samples that curves show no corners, and the result of `read` for it; `curves` extracts them."""
    fine, found, parts = run, read(run), 1
    for _ in range(_ROUNDS):
        more = _pieces(fine, curves(found))
        if more == 1:
            break
        parts *= more
        fine = _finer(run, parts)
        found = read(fine)
    return fine, found


def _pieces(run: PlottedRun, curves: Sequence[Array]) -> int:
    """Number of pieces into which each step between samples is to be divided so that curves show no corners."""
    if run.dotted or len(run.t) < 2 or not curves:
        return 1
    own = run.motion.phase if isinstance(run.motion, Solution) else np.zeros(len(run.t), dtype=np.int64)
    worst = max((bend(run.t, own, curve) for curve in curves), default=0.0)
    least = 8 if len(run.t) < _FEW else 1
    wanted = max(least, int(np.ceil(np.sqrt(worst / _BEND))))
    return max(1, min(wanted, 64, _MOST // len(run.t)))


def bend(t: Array, phase: Indices, values: Array) -> float:
    """Largest distance of a sample from the line through its neighbours of the same phase, relative to the range of all values."""
    before, after = np.diff(t)[:-1], np.diff(t)[1:]
    inside = (
        (phase[2:] == phase[:-2]) & (before > 0) & (after > 0) & np.isfinite(values[2:] + values[1:-1] + values[:-2])
    )
    size = float(np.ptp(values[np.isfinite(values)])) if np.isfinite(values).any() else 0.0
    if not size or not inside.any():
        return 0.0
    first, middle, last = (part[inside] for part in (values[:-2], values[1:-1], values[2:]))
    share = before[inside] / (before + after)[inside]
    return float(np.max(np.abs(middle - first - share * (last - first)))) / size


def _finer(run: PlottedRun, parts: int) -> PlottedRun:
    """The motion with `parts` − 1 added samples in each step, from dense output.

    Without dense output, as for a motion from a file, the samples are drawn as visible dots.
    """
    motion = run.motion
    assert isinstance(motion, Solution)
    steps = np.flatnonzero((np.diff(motion.phase) == 0) & (np.diff(motion.t) > 0))
    shares = np.arange(1, parts) / parts
    times = (motion.t[steps, None] + shares * np.diff(motion.t)[steps, None]).ravel()
    try:
        between = motion.at(times)
    except SimulationError:
        return replace(run, dotted=True)
    places = np.repeat(steps + 1, parts - 1)
    whole = np.insert(np.arange(len(motion)), places, len(motion) + np.arange(len(times)))
    equations = [s.samples or (s.equations,) * len(s) for s in (motion, between)]
    every = (*equations[0], *equations[1])

    def both(name: str) -> Array:
        rows: Array = np.concatenate([getattr(motion, name), getattr(between, name)])[whole]
        return rows

    merged = replace(
        motion,
        t=both("t"),
        states=both("states"),
        work=both("work"),
        phase=np.insert(motion.phase, places, motion.phase[places - 1]),
        samples=tuple(every[k] for k in whole),
    )
    return replace(run, motion=merged)


_LETTERS = 48
"""Number of letters at which a label is cut."""
NOISE = 1e-12
"""Relative size of rounding residues: of a sum beside its terms, or of a line in a panel, which cannot show it."""
_FAINT = 1e-3
"""Fraction of the absolute tolerance below which values of the state are rounding residues."""
_UNLIKE = 1e3
"""Ratio of sizes above which quantities of one unit have separate panels."""


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """The data along an axis: name, unit ("" if unknown) and values."""

    label: str
    unit: str
    values: Array


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """One line: a quantity against time or another quantity, for one run.

    `note` is the reason why it is not drawn, if any; `floor` is the size below which values are rounding errors.
    """

    y: Axis
    run: str
    x: Axis
    dotted: bool
    style: str
    label: str
    note: str = ""
    floor: float = 0.0

    @property
    def size(self) -> float:
        """The largest absolute value."""
        return largest(self.y.values)


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """Lines that share axes; `across` is true if they are drawn against another quantity than time."""

    title: str
    traces: tuple[Trace, ...]
    across: bool = False


_ACROSS = object()
Keyed = list[tuple[Any, Trace]]


def largest(values: Array) -> float:
    """The largest finite absolute value."""
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


def panels(runs: Sequence[PlottedRun], quantities: Sequence[Any]) -> list[Panel]:
    """The panels of a figure: those against time first, each with lines of all runs."""
    groups: dict[Any, list[Trace]] = {}
    quantities = [one for what in quantities for one in (what if isinstance(what, list) else [what])]
    for run in runs:
        for key, trace in _smooth(run, quantities):
            groups.setdefault(key, []).append(trace)
    made = [panel for key, traces in groups.items() for panel in _apart(key, traces)]
    return sorted(made, key=lambda panel: panel.across)


def _smooth(run: PlottedRun, quantities: Sequence[Any]) -> Keyed:
    """The lines of a run, with samples added between its own if curves would have visible corners."""

    def curves(traces: Keyed) -> list[Array]:
        return [axis.values for _, trace in traces if not trace.note for axis in (trace.y, trace.x)]

    run, traces = smooth(run, lambda r: _of(r, quantities), curves)
    return [(key, _parted(trace, run) if key[1] is _ACROSS else trace) for key, trace in traces]


def _parted(trace: Trace, run: PlottedRun) -> Trace:
    """A path with gaps where phases of the motion begin, as no states between them occur."""
    if not isinstance(run.motion, Solution):
        return trace
    gaps = np.flatnonzero(np.diff(run.motion.phase)) + 1
    x, y = (replace(axis, values=np.insert(axis.values, gaps, np.nan)) for axis in (trace.x, trace.y))
    return replace(trace, x=x, y=y)


def _of(run: PlottedRun, quantities: Sequence[Any]) -> Keyed:
    return list(_listed("", run, quantities) if quantities else _everything(run))


def _everything(run: PlottedRun) -> Iterator[tuple[Any, Trace]]:
    eom, motion = run.motion.equations, run.motion
    kinds = {"coordinates": eom.coordinates, "speeds": eom.speeds, "states": eom.states}
    if isinstance(motion, Solution):
        touching = ((c.normal_force, *c.friction_forces) for c in eom.system.contacts)
        kinds["reactions"] = eom.reactions
        kinds["contacts"] = tuple(dict.fromkeys(f for own in touching for f in own if f is not None))
    for kind, symbols in kinds.items():
        yield from _listed(kind, run, symbols)
    for label, values, style in energies(motion) if isinstance(motion, Solution) else ():
        yield ("energy", "J"), judged(in_time(run, Axis(label, "J", values), style), 0.0)


def in_time(run: PlottedRun, axis: Axis, style: str) -> Trace:
    """A quantity against time."""
    return Trace(axis, run.name, Axis("t", "s", run.t), run.dotted, style, axis.label)


def energies(motion: Solution) -> tuple[tuple[str, Array, str], ...]:
    """K, V, their sum, and the sum without the work of loads that have no potential; with line styles."""
    eom = motion.equations
    kinetic, potential, total = motion[[eom.kinetic_energy, eom.potential_energy, eom.energy]]
    rows = (("K", kinetic), ("V", potential), ("E = K + V", total))
    return *((label, values, "-") for label, values in rows), ("E − ∫P dt", total - motion.work, "--")


def _listed(title: str, run: PlottedRun, quantities: Iterable[Any]) -> Iterator[tuple[Any, Trace]]:
    """Lines with the keys of their panels: one for each unit, one for each quantity of unknown unit, one for each (x, y)."""
    for k, what in enumerate(quantities):
        for j, (label, own) in enumerate(what.items() if isinstance(what, Mapping) else [("", what)]):
            if isinstance(own, tuple):
                yield (title, _ACROSS, k), _across(run, own, str(label))
                continue
            for axis, floor in _axes(run, own, str(label)):
                yield (title, axis.unit or (k, j)), judged(in_time(run, axis, run.line), floor)


def _across(run: PlottedRun, pair: tuple[Any, ...], label: str) -> Trace:
    if len(pair) != 2:
        raise ArgumentError(f"Expected (x, y), two quantities to draw y against x, got {cut(repr(pair))}.")
    x, y = (readable(run, one) for one in pair)
    return Trace(y, run.name, x, run.dotted, run.line, label or y.label)


def readable(run: PlottedRun, what: Any) -> Axis:
    """A scalar quantity, or a mapping of its label to it, along a motion; noise is replaced by zeros.

    Raises
    ------
    ArgumentError
        if it has several values
    """
    pairs = what.items() if isinstance(what, Mapping) else [("", what)]
    found = [pair for label, own in pairs for pair in _axes(run, own, str(label))]
    if len(found) != 1:
        raise ArgumentError(f"Expected a quantity with one value, or one label with it, got {cut(repr(what))}.")
    ((axis, floor),) = found
    return axis if largest(axis.values) > floor else replace(axis, values=np.zeros_like(axis.values))


def _axes(run: PlottedRun, what: Any, label: str) -> list[tuple[Axis, float]]:
    """A quantity, or the components of a vector, each with the size below which it is noise."""
    eom, motion = run.motion.equations, run.motion
    if isinstance(motion, SectionPoints):
        values = motion[what]  # first, as it raises errors for a wrong `what`
        (what,) = asked(eom.derived, what).roots
        return [(_axis(eom, what, label, values), 0.0)]
    if isinstance(what, str):
        (what,) = asked(eom.derived, what).roots
    values = motion[what]
    if isinstance(what, Vector):
        inertial = eom.system.inertial
        components = what.components(inertial)
        unit = next(filter(None, (_unit(eom, c) for c in components)), "")
        names = [f"{label or f'({_cut(str(what))})'} · {inertial.name}.{axis}" for axis in "xyz"]
        axes = [Axis(name, unit, component) for name, component in zip(names, values.T, strict=True)]
        return [(axis, _floor(motion, as_expr(c))) for axis, c in zip(axes, components, strict=True)]
    e = as_expr(what)
    return [(_axis(eom, e, label, values), _floor(motion, e))]


def _axis(eom: Any, e: Expr, label: str, values: Array) -> Axis:
    name = label_of(e) if isinstance(e, Symbol) else _cut(to_text(e))
    return Axis(label or name, _unit(eom, e), values)


def _unit(eom: Any, e: Expr) -> str:
    try:
        return unit_in(eom.system, e)
    except UnitError:  # expressions may have inconsistent units
        return ""


def _cut(text: str) -> str:
    return text if len(text) <= _LETTERS else text[: _LETTERS - 1] + "…"


# Rounding residues -----------------------------------------------------------------------------------------------------------

_SIZES: dict[Op, Callable[..., Any]] = {
    ADD: lambda a, b: a + b,
    SUB: lambda a, b: a + b,
    MUL: lambda a, b: a * b,
    DIV: lambda a, b: a / b,
    NEG: lambda a: a,
}
"""The size of the terms of a node from those of its arguments; other nodes have the size of their values."""


def size_of_terms(e: Expr) -> Expr:
    """|a| + |b| for a + b and for a − b, products of these for products, |e| for everything else."""
    sizes: dict[Expr, Expr] = {}

    def size(node: Expr) -> Expr:
        rule = _SIZES.get(node.op)
        if rule is None:
            return as_expr(abs(node))
        own = [sizes[a] for a in node.args]
        if node.op is DIV:
            own[1] = as_expr(abs(node.args[1]))
        return as_expr(rule(*own))

    return fold(e, sizes, size)


def _floor(motion: Solution, e: Expr) -> float:
    """The size below which the values of an expression are rounding errors."""
    if isinstance(e, Symbol):
        return _FAINT * motion.atol if any(e is s for s in motion.equations.state) else 0.0
    if not e.args:
        return 0.0
    return NOISE * largest(np.asarray(motion[size_of_terms(e)]))


def judged(trace: Trace, floor: float) -> Trace:
    """The trace, with a note instead of a line if all values are zero or noise."""
    size = trace.size
    if size > floor or not np.isfinite(trace.y.values).any():
        return replace(trace, floor=floor)
    return replace(trace, floor=floor, note="= 0" if size == 0 else "= 0 but for rounding")


def _apart(key: Any, traces: Sequence[Trace]) -> Iterator[Panel]:
    """The lines of a panel, in separate panels if their sizes differ much; noise beside the largest becomes a note."""
    title = key[0]
    if key[1] is _ACROSS:
        yield Panel(title, tuple(traces), across=True)
        return
    top = max(trace.size for trace in traces)
    traces = [judged(trace, max(trace.floor, NOISE * top)) for trace in traces]
    by_quantity: dict[str, float] = {}
    for trace in traces:
        by_quantity[trace.label] = max(by_quantity.get(trace.label, 0.0), trace.size if not trace.note else 0.0)
    level: dict[str, int] = {}
    number, largest_here = 0, top
    for label, size in sorted(by_quantity.items(), key=lambda item: -item[1]):
        if 0 < size * _UNLIKE < largest_here:
            number, largest_here = number + 1, size
        level[label] = number if size else 0
    for n in dict.fromkeys(level[trace.label] for trace in traces):
        yield Panel(title, tuple(trace for trace in traces if level[trace.label] == n))
