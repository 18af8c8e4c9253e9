# SPDX-License-Identifier: BSD-3-Clause
"""Figures of a beam: its shape functions, and its deformed axis along a motion."""

from collections.abc import Sequence
from numbers import Integral
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure

from kane import expect
from kane.errors import SimulationError
from kane.model.beams.beam import Beam
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.numeric.scale import SAME_TIME
from kane.present.figure import file_path, panel_column, saved

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
