# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the energy and power of a motion, and of limit cycles along a branch."""

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kane import expect
from kane.errors import ArgumentError, SimulationError
from kane.motion.cycles.branch import CycleBranch
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.present.figure import file_path, panel_column, saved
from kane.present.linearized.branch_figures import label_along
from kane.present.motion_plots import COLOURS
from kane.present.plotted.lines import ABOVE, draw
from kane.present.plotted.runs import PlottedRun, runs_of, smooth
from kane.present.plotted.traces import NOISE, Axis, Panel, energies, in_time, judged, readable
from kane.units.rules import unit_text

_LEAST = 1e-6
"""Ratio to the energy's scale over the duration of the motion below which powers are rounding residues."""
_ON_CIRCLE = 1e-4
"""Distance from the unit circle within which multipliers are shown on it."""
_KINDS = dict(zip(("fold", "flip", "torus"), COLOURS[1:], strict=False))


def energy_balance(solution: Solution, path: str | Path | None = None) -> Figure:
    """Plot the energies of a motion, the power of loads without potential beside dE/dt, and the residual E − E(0) − ∫P dt.

    Parameters
    ----------
    solution : a motion, from `simulate`
    path : file to write, `.png`, `.svg` or `.pdf`

    Raises
    ------
    ArgumentError
        if `solution` is not a motion, or the path has a different ending
    """
    expect.instance(solution, Solution, "a motion from kn.simulate", error=ArgumentError)
    place = file_path(path, 'kn.figures.energy_balance(sol, "energy.svg")')
    (run,) = runs_of(solution)
    _, made = smooth(run, _balance, _seen)
    figure, axes = panel_column(len(made), 5 / 3)
    for a, panel in zip(axes, made, strict=True):
        draw(a, panel, [""])
        a.label_outer()
    return saved(figure, place)


def _seen(made: Sequence[Panel]) -> list[Array]:
    """The curves of energies and powers; the residual is excluded, as its rounding errors are never smooth."""
    return [trace.y.values for panel in made[:2] for trace in panel.traces if not trace.note]


def _balance(run: PlottedRun) -> list[Panel]:
    """The three panels."""
    motion = run.motion
    assert isinstance(motion, Solution)
    eom = motion.equations
    power, rate = motion.power, motion[eom.time_derivative(eom.energy)]
    scale = motion.energy_check.scale
    least = _LEAST * scale / (float(np.ptp(motion.t)) or 1.0)
    rows = {
        ("energy", "J", 0.0): energies(motion),
        ("power", "W", least): (("P", power, "-"), ("dE/dt", rate, "--")),
        ("drift", "J", NOISE * scale): (("E − E(0) − ∫P dt", motion.energy_drift, "-"),),
    }
    panels = []
    for (title, unit, floor), lines in rows.items():
        traces = (in_time(run, Axis(label, unit, values), style) for label, values, style in lines)
        panels.append(Panel(title, tuple(judged(trace, floor) for trace in traces)))
    return panels


def cycle_figure(branch: CycleBranch, *quantities: Any, path: str | Path | None = None) -> Figure:
    """Plot a branch of limit cycles: minimum and maximum of quantities over a cycle, and the period, against the parameter.

    Lines are solid for stable cycles and dashed for unstable ones; folds, flips and torus bifurcations are marked.

    Parameters
    ----------
    branch : from `cycle.follow`
    quantities : scalar quantities as for `sol[…]`, or mappings {label: quantity}; by default the coordinates
    path : file to write, `.png`, `.svg` or `.pdf`

    Raises
    ------
    SimulationError
        if `branch` is not a branch of cycles, or has one cycle only
    ArgumentError
        if the path has a different ending, or a quantity has several values
    """
    expect.instance(branch, CycleBranch, "a branch from cycle.follow", error=SimulationError)
    place = file_path(path, 'kn.figures.cycle_figure(branch, path="cycles.svg")')
    if len(branch) < 2:
        raise SimulationError(f"Expected a branch of two cycles or more, got {branch!r}. Follow it further.")
    coordinates = branch.cycles[0].solution.equations.coordinates
    rows = _rows(branch)
    ranges = [_range(rows, what) for what in (quantities or coordinates)]
    periods = np.array([cycle.period for _, cycle, _ in rows])
    figure, axes = panel_column(len(ranges) + 1, 1.9, label_along(branch))
    for a, (label, bounds) in zip(axes, [*ranges, ("T [s]", [periods])], strict=True):
        for values in bounds:
            _along(a, rows, values)
        _marks(a, branch)
        a.set_ylabel(label)
    handles, labels = axes[0].get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    axes[0].legend(named.values(), named, ncols=5, fontsize=9, **ABOVE)
    return saved(figure, place)


def _rows(branch: CycleBranch) -> list[tuple[float, Any, bool]]:
    """Value, cycle, and stability up to the next row; the cycles at which stability changes are included."""
    rows: list[tuple[float, Any, bool]] = []
    for k, (value, cycle) in enumerate(zip(branch.values.tolist(), branch.cycles, strict=True)):
        rows.append((value, cycle, cycle.stable))
        met = [change for change in branch.changes if change.between[0] == k]
        for change in sorted(met, key=lambda change: abs(change.value - value)):
            others = np.abs(change.cycle.multipliers) > 1 + _ON_CIRCLE
            rows.append((change.value, change.cycle, not change.grows and not others.any()))
    return rows


def _range(rows: Sequence[tuple[float, Any, bool]], what: Any) -> tuple[str, list[Array]]:
    """The label of a quantity, and its minimum and maximum over each cycle."""
    found: list[tuple[float, float]] = []
    label = ""
    for _, cycle, _ in rows:
        (run,) = runs_of(cycle.solution)
        _, axis = smooth(run, partial(readable, what=what), lambda axis: [axis.values])
        found.append((float(np.nanmin(axis.values)), float(np.nanmax(axis.values))))
        label = f"{axis.label} [{unit_text(axis.unit)}]" if axis.unit else axis.label
    return label, list(np.array(found).T)


def _along(a: Axes, rows: Sequence[tuple[float, Any, bool]], values: Array) -> None:
    """Draw one line along the branch, in sections of constant stability."""
    at = np.array([value for value, _, _ in rows])
    stable = np.array([flag for _, _, flag in rows])[:-1]
    cuts = [0, *(np.flatnonzero(stable[1:] != stable[:-1]) + 1).tolist(), len(stable)]
    for begin, end in pairwise(cuts):
        style, name = ("-", "stable") if stable[begin] else ("--", "unstable")
        here = slice(begin, end + 1)
        a.plot(at[here], values[here], linestyle=style, color=COLOURS[0], linewidth=1.4, label=name)


def _marks(a: Axes, branch: CycleBranch) -> None:
    """Mark the values at which stability changes."""
    for change in branch.changes:
        a.axvline(change.value, color=_KINDS[change.kind], linewidth=0.9, linestyle=(0, (4, 2)), label=change.kind)
