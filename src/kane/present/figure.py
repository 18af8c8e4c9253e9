# SPDX-License-Identifier: BSD-3-Clause
"""`plot`: quantities along motions in one figure, for papers, notebooks and scripts."""

import io
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kane import expect
from kane.errors import ArgumentError
from kane.motion.cycles.section import SectionPoints
from kane.motion.solution.solution import Solution
from kane.present.plotted.lines import draw, draw_modes, look
from kane.present.plotted.runs import PlottedRun, runs_of
from kane.present.plotted.traces import Panel, panels
from kane.whole import FIGURES, exchange_marked, path_of

FORMATS: dict[str, dict[str, str | None]] = {
    ".png": {"Software": "kane"},
    ".svg": {"Date": None, "Creator": "kane"},
    ".pdf": {"CreationDate": None, "Creator": "kane"},
}
"""Endings of figure files, with metadata that make them reproducible and recognizable."""

_HIGH, _SQUARE, _STRIP = 1.9, 3.6, 0.3
"""Heights in inches: a panel against time, one of y against x, the strip of a contact's modes."""


class Picture(Figure):
    """A figure that a notebook displays without pyplot."""

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png")
        return out.getvalue()


def plot(
    solution: Solution | SectionPoints | Sequence[Solution | SectionPoints] | Mapping[str, Solution | SectionPoints],
    *quantities: Any,
    path: str | Path | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Plot quantities against time, or y against x; by default coordinates, speeds, reactions and energy against time.

    Quantities of the same unit share a panel unless their magnitudes differ by more than a factor of 1000. If samples are too
    coarse for smooth lines, more points are computed with the integrator's interpolation (`sol.at`); if this is impossible, as for
    a motion from a file, dots mark the samples. Quantities that are zero to rounding (1e-12 of the size of their terms) are named
    in the legend and not drawn.

    Parameters
    ----------
    solution : a motion, from `kn.simulate`, or section points, from `kn.cycles.poincare`; or several to compare, as a list or as a
        mapping {label: motion}
    quantities : symbols, expressions, vectors (by components along the inertial axes), or names; a tuple (x, y) of two of these
        plots y against x; a mapping {label: quantity} sets labels; or lists of these
    path : file to write, `.png`, `.svg` or `.pdf`; missing folders are created. An existing file is replaced if `plot` wrote it
    ax : matplotlib axes to plot all quantities into, instead of a new figure

    Returns
    -------
    The matplotlib figure, to modify or save.

    Raises
    ------
    ArgumentError
        if the path has a different ending, or is that of a file not written by `plot`; if a tuple is not (x, y), or if quantities
        against time and against others would share axes
    ValueMissingError
        if a name is unknown
    """
    runs = runs_of(solution)
    place = file_path(path, 'kn.plot(sol, path="motion.svg")')
    made = panels(runs, quantities)
    expect.that(made, "quantities to plot", quantities, error=ArgumentError)
    names = [run.name for run in runs]
    if ax is None:
        figure = _new(runs, made, names)
    else:
        holder = expect.instance(ax, Axes, "ax= as axes of matplotlib", error=ArgumentError).get_figure(root=True)
        figure = expect.instance(holder, Figure, "ax= as axes that belong to a figure", error=ArgumentError)
        if len({panel.across for panel in made}) > 1:
            raise ArgumentError("Expected quantities against time, or tuples (x, y), for one pair of axes, got both.")
        one = Panel("", tuple(trace for panel in made for trace in panel.traces), made[0].across)
        draw(ax, one, names, beside=False)
    return saved(figure, place)


def _new(runs: Sequence[PlottedRun], made: Sequence[Panel], names: Sequence[str]) -> Figure:
    """A new figure with all panels: against time, modes of contacts, y against x."""
    along = [panel for panel in made if not panel.across]
    across = [panel for panel in made if panel.across]
    strips = [
        (" · ".join(filter(None, (run.name, name))), run.t, words)
        for run in runs
        if along and isinstance(run.motion, Solution)
        for name, words in run.motion.modes.items()
    ]
    heights = [_HIGH] * len(along) + ([_STRIP * (len(strips) + 1)] if strips else []) + [_SQUARE] * len(across)
    figure = Picture(figsize=(6.4, 0.5 + sum(heights)), layout="constrained")
    axes = list(figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0])
    timed = axes[: len(heights) - len(across)]
    for a, panel in zip([*axes[: len(along)], *axes[len(timed) :]], [*along, *across], strict=True):
        look(a)
        draw(a, panel, names)
    if strips:
        draw_modes(timed[-1], strips)
    for a in timed[:-1]:
        a.sharex(timed[-1])
        a.tick_params(labelbottom=False)
        a.set_xlabel("")
    if timed:
        timed[-1].autoscale_view()
        timed[-1].set_xlabel("t [s]")
    return figure


def panel_column(rows: int, height: float, below: str = "") -> tuple[Figure, list[Axes]]:
    """A figure of panels one above the other, `height` inches each, with one label below."""
    figure = Picture(figsize=(6.4, height * rows + 0.6), layout="constrained")
    axes = list(figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0])
    for a in axes:
        look(a)
    axes[-1].set_xlabel(below)
    return figure, axes


def file_path(path: str | Path | None, example: str) -> Path | None:
    """The path of a figure's file, or None; raises ArgumentError for an unknown ending."""
    place = None if path is None else path_of(path, example)
    if place is not None and place.suffix.lower() not in FORMATS:
        raise ArgumentError(f"Expected a file for the figure that ends in {', '.join(FORMATS)}, got {str(place)!r}.")
    return place


def saved(figure: Figure, place: Path | None) -> Figure:
    """The figure, also written to a file if `place` is given, which must be new or written by `kane`."""
    if place is not None:
        exchange_marked(place, partial(save, figure), *FIGURES)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write a figure reproducibly, in the format of the path's ending."""
    with matplotlib.rc_context({"svg.hashsalt": "kane"}):
        figure.savefig(path, metadata=FORMATS[path.suffix.lower()], dpi=160)
