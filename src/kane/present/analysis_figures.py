# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the energy and power of a motion, of limit cycles along a branch, of a fit, and of the modes and motion of a beam."""

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from numbers import Integral
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure

from kane import expect
from kane.errors import ArgumentError, SimulationError
from kane.model.beams.beam import Beam
from kane.motion.cycles.branch import CycleBranch
from kane.motion.fitting.found import Fit
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.numeric.scale import SAME_TIME
from kane.present.figure import ABOVE, Picture, draw, file_path, look, panel_column, saved
from kane.present.linearized.branch_figures import label_along
from kane.present.motion_plots import COLOURS, label_of
from kane.present.traces import NOISE, Axis, Panel, PlottedRun, energies, in_time, judged, readable, runs_of, smooth
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


_NUMBERS = 12
"""Largest number of unknowns for which correlations are printed."""


def fit_figure(fit: Fit, path: str | Path | None = None) -> Figure:
    """Plot the residuals of a fit over time, with a band of ±2 σ for each column of data, and the correlation of the estimates.

    Residuals that are not noise indicate errors of the model; estimates with a correlation near ±1 are hardly distinguished by the
    data.

    Parameters
    ----------
    fit : from `kn.fitting.fit`; each of several sets of data has its own colour
    path : file to write, `.png`, `.svg` or `.pdf`

    Raises
    ------
    ArgumentError
        if `fit` is not a fit, or the path has a different ending
    """
    expect.instance(fit, Fit, "a fit from kn.fit", error=ArgumentError)
    place = file_path(path, 'kn.figures.fit_figure(fit, "fit.svg")')
    names = [*fit.sigma]
    figure = Picture(figsize=(8.4, 1.0 + 1.7 * max(2, len(names))), layout="constrained")
    parts: Any = figure.subfigures(1, 2, width_ratios=(3, 2))
    left, right = parts
    axes = list(left.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0])
    for a, name in zip(axes, names, strict=True):
        look(a)
        sigma = fit.sigma[name]
        a.axhspan(-2 * sigma, 2 * sigma, color=COLOURS[0], alpha=0.12, linewidth=0)
        for k, run in enumerate(fit.runs):
            if name in run.residuals:
                a.plot(run.data.t, run.residuals[name], ".", color=COLOURS[k % len(COLOURS)], markersize=4)
        a.set_ylabel(f"left of {label_of(name)}")
    axes[-1].set_xlabel("t [s]")
    labels = [label_of(s) for s in fit.values]
    count = len(labels)
    table = fit.correlation[:count, :count]
    b = right.add_subplot()
    b.imshow(table, cmap="RdBu_r", vmin=-1, vmax=1)
    b.set_xticks(range(count), labels)
    b.set_yticks(range(count), labels)
    b.set_title("correlation", fontsize="medium")
    for (i, j), value in np.ndenumerate(table) if count <= _NUMBERS else ():
        b.text(
            j, i, f"{value:.2f}", ha="center", va="center", color="white" if abs(value) > 0.6 else "black", fontsize=8
        )
    return saved(figure, place)


_STATIONS = 33
_NAMED = 9
"""Largest number of times in a legend; more are shown by a colour scale."""
_NAMES = {"v": "v", "w": "w", "s": "stretch", "t": "twist", "g": "v by shear", "h": "w by shear"}


def mode_figure(beam: Beam, path: str | Path | None = None) -> Figure:
    """Plot the shape functions of a beam against ξ = x/L, scaled to a maximum of 1, with one panel for each kind of deformation.

    Parameters
    ----------
    beam : kn.Beam
    path : file to write, `.png`, `.svg` or `.pdf`; an existing file is replaced if it is such a figure
    """
    expect.instance(beam, Beam, "a kn.Beam")
    place = file_path(path, 'kn.figures.mode_figure(beam, "modes.svg")')
    fields = beam.deformation.fields
    figure, column = panel_column(len(fields), 2.2, "ξ = x/L")
    x = np.linspace(0, 1, 201)
    for f, axes in zip(fields, column, strict=True):
        values = f.shapes.evaluate(x, 0)
        size = np.abs(values).max(axis=0)
        for k, q in enumerate(f.coordinates):
            axes.plot(x, values[:, k] / size[k], linewidth=1.3, label=q.name)
        axes.axhline(0, color="0.6", linewidth=0.8)
        axes.set_ylabel(_NAMES[f.stem])
        axes.legend(frameon=False, fontsize=8, ncols=3)
    return saved(figure, place)


def beam_figure(
    beam: Beam, solution: Solution, times: Sequence[float] | int = 9, path: str | Path | None = None
) -> Figure:
    """Plot the deformed axis of a beam, in its frame, at several times of a motion: deflections against the position along the axis.

    Parameters
    ----------
    beam : kn.Beam
    solution : a motion of a system with this beam
    times : times (s), or the number of evenly spaced times
    path : file to write, `.png`, `.svg` or `.pdf`; an existing file is replaced if it is such a figure

    Raises
    ------
    ModelError
        if `beam` is not a Beam
    SimulationError
        if the beam does not belong to the solution's system, or a time is outside the motion
    """
    expect.instance(beam, Beam, "a kn.Beam")
    place = file_path(path, 'kn.figures.beam_figure(beam, sol, path="beam.svg")')
    motion = expect.instance(solution, Solution, "a motion from kn.simulate", error=SimulationError)
    if all(b is not beam for b in motion.equations.system.bodies):
        raise SimulationError(f"Expected a motion of a system with the beam {beam.name}, got one without it.")
    bending = beam.deformation.bending
    motion, rows = _at(motion, times)
    places = deformed(beam, motion, np.linspace(0, 1, _STATIONS))
    figure, column = panel_column(len(bending), 2.6, "along the axis [m]")
    scale = _scale(motion.t[rows])
    colours = scale.to_rgba(motion.t[rows])
    for k, (f, axes) in enumerate(zip(bending, column, strict=True), 1):
        for row, colour in zip(rows, colours, strict=True):
            label = f"t = {motion.t[row]:.3g} s"
            axes.plot(places[row, :, 0], places[row, :, k], color=colour, linewidth=1.2, label=label)
        axes.set_ylabel(f"{_NAMES[f.stem]} [m]")
    if len(rows) <= _NAMED:
        column[0].legend(frameon=False, fontsize=7, ncols=3)
    else:
        figure.colorbar(scale, ax=column, label="t [s]", aspect=40)
    return saved(figure, place)


def _at(solution: Solution, times: Any) -> tuple[Solution, list[int]]:
    """The motion with its samples at the times; if it cannot be evaluated between samples, as one from a file, the nearest samples."""
    begin, end = float(solution.t[0]), float(solution.t[-1])
    told = f"times= as times of the motion, from {begin:.9g} to {end:.9g}, or how many"
    if isinstance(times, Integral):
        wanted = np.linspace(begin, end, expect.whole(times, told, least=1, error=SimulationError))
    else:
        wanted = expect.floats(times, told, error=SimulationError)
        ends = np.clip(wanted, begin, end)
        wanted = np.where(np.abs(wanted - ends) <= SAME_TIME * (abs(begin) + abs(end)), ends, wanted)
    inside = (begin <= wanted) & (wanted <= end)
    expect.that(wanted.ndim == 1 and wanted.size and inside.all(), told, times, error=SimulationError)
    distinct, rows = np.unique(wanted, return_inverse=True)
    try:
        return solution.at(distinct), rows.tolist()
    except SimulationError:
        return solution, [int(np.argmin(np.abs(solution.t - t))) for t in wanted]


def _scale(times: Array) -> ScalarMappable:
    """The colours of times, without the palest."""
    shades = ListedColormap(mpl.colormaps["viridis"](np.linspace(0, 0.9, 256)))
    return ScalarMappable(Normalize(float(times.min()), float(times.max())), shades)


def deformed(beam: Beam, solution: Solution, stations: Array) -> Array:
    """Positions of the axis in the beam's frame (times × stations × (1 + deflections)): along the axis, then v and w."""
    whole = beam.deformation
    directions = [whole.axis, *(f.along for f in whole.bending)]
    wanted = [whole.place(float(x)).dot(e) for x in stations for e in directions]
    values = np.array(solution[wanted])
    return np.moveaxis(values.reshape(len(stations), len(directions), -1), 2, 0)
