# SPDX-License-Identifier: BSD-3-Clause
"""`plot`: quantities along motions in one figure, for papers, notebooks and scripts; lines, named at their ends if there is room."""

import io
import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kane import expect
from kane.errors import ArgumentError
from kane.motion.cycles.section import SectionPoints
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.present.motion_plots import COLOURS
from kane.present.traces import Panel, PlottedRun, Trace, panels, runs_of
from kane.units.rules import unit_text
from kane.whole import FIGURES, exchange_marked, path_of

_LABELS, _LETTERS, _AXIS = 12, 72, 16
"""Limits in lines and letters: lines of a legend, width of a legend, label beside an axis or a line."""
_BESIDE, _APART, _AWAY = 6, 0.1, 0.2
"""Most lines with names at their ends, height of a name and its largest displacement, as fractions of a panel."""
ABOVE: dict[str, Any] = {"frameon": False, "loc": "lower left", "bbox_to_anchor": (0, 1), "borderaxespad": 0.1}
"""The position of legends."""
_STYLES = ("-", "--", ":", "-.")
_MODES = {"separated": "#e5e7eb", "closed": "#bfdbfe", "stick": "#93c5fd", "slip": "#fdba74"}


def look(a: Axes) -> None:
    """Apply the style of the report's plots."""
    a.set_prop_cycle(color=COLOURS)
    a.grid(True, linewidth=0.6, color="0.9")
    a.set_axisbelow(True)
    for side, spine in a.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color("0.7")


def draw(a: Axes, panel: Panel, runs: Sequence[str], beside: bool = True) -> None:
    """Draw the lines of a panel with their names. Several runs differ in colour, and then quantities in line style."""
    quantities = list(dict.fromkeys(trace.label for trace in panel.traces))
    several = len(runs) > 1
    shown = []
    for trace in panel.traces:
        name = _name(trace, len(quantities))
        if trace.note and not panel.across:
            a.plot([], [], linestyle="none", label=f"{name} {trace.note}")
            continue
        number = quantities.index(trace.label)
        colour = COLOURS[(runs.index(trace.run) if several else number) % len(COLOURS)]
        style = _STYLES[number % len(_STYLES)] if several and trace.style == "-" else trace.style
        marker: dict[str, Any] = {"marker": ".", "markersize": 4} if trace.dotted else {}
        a.plot(trace.x.values, trace.y.values, linestyle=style, color=colour, linewidth=1.4, label=name, **marker)
        shown.append((trace, colour, name))
        if panel.across and style != "none":
            _ends(a, trace, colour)
    a.margins(x=0.03 if panel.across else 0.01)
    _axes(a, panel, quantities)
    if not shown:
        a.set(ylim=(-1, 1), yticks=[0])
    alone = len(panel.traces) == 1 and not panel.traces[0].note and (panel.across or _letters(quantities[0]) <= _AXIS)
    if not alone and not (beside and not panel.across and _named_at_ends(a, shown)):
        _legend(a)
    elif any(trace.note for trace in panel.traces) and not panel.across:
        _legend(a, notes_only=True)


def _name(trace: Trace, quantities: int) -> str:
    """The name of a line in the legend."""
    return " · ".join(filter(None, (trace.label if quantities > 1 or not trace.run else "", trace.run)))


def _letters(label: str) -> int:
    """The approximate width of a label in letters."""
    return len(re.sub(r"\\[a-z]+", "x", label).translate(str.maketrans("", "", "${}_^\\")))


def _axes(a: Axes, panel: Panel, quantities: Sequence[str]) -> None:
    """Write names and units on the axes; a quantity's name if it is the only one."""
    if panel.across:
        sides = [[trace.x for trace in panel.traces], [trace.y for trace in panel.traces]]
        puts: tuple[Any, ...] = (a.set_xlabel, a.set_ylabel)
        for side, put in zip(sides, puts, strict=True):
            names = dict.fromkeys(axis.label for axis in side)
            put(_with_units(next(iter(names)) if len(names) == 1 else "", [axis.unit for axis in side]))
        if {axis.unit for side in sides for axis in side} == {"m"}:
            a.set_aspect("equal", adjustable="datalim")
        return
    short = len(quantities) == 1 and _letters(quantities[0]) <= _AXIS
    a.set_ylabel(_with_units(quantities[0] if short else panel.title, [trace.y.unit for trace in panel.traces]))
    a.set_xlabel("t [s]")


def _with_units(name: str, units: Sequence[str]) -> str:
    known = ", ".join(unit_text(unit) for unit in dict.fromkeys(units) if unit)
    return f"{name} [{known}]".strip() if known else name


def _ends(a: Axes, trace: Trace, colour: str) -> None:
    """Draw start ○ and end ● of a path."""
    dot: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5, "color": colour}
    for k, face, label in ((0, "white", "_start"), (-1, colour, "_end")):
        a.plot(trace.x.values[[k]], trace.y.values[[k]], markerfacecolor=face, label=label, **dot)


def _named_at_ends(a: Axes, shown: Sequence[tuple[Trace, str, str]]) -> bool:
    """Write names beside the ends of lines, moved apart; returns False, and writes nothing, if there is no room."""
    if not shown or len(shown) > _BESIDE or any(_letters(name) > _AXIS for _, _, name in shown):
        return False
    if len({float(trace.x.values[-1]) for trace, _, _ in shown}) > 1:  # they end at several places
        return False
    low, high = a.get_ylim()
    ends = np.array([(float(trace.y.values[-1]) - low) / (high - low) for trace, _, _ in shown])
    if not np.isfinite(ends).all():
        return False
    places = spread(ends, _APART)
    if np.max(np.abs(places - ends)) > _AWAY:
        return False
    look: dict[str, Any] = {"va": "center", "fontsize": 9, "annotation_clip": False}
    for (_, colour, name), y in zip(shown, places, strict=True):
        a.annotate(name, (1, y), (4, 0), "axes fraction", "offset points", color=colour, **look)
    return True


def spread(wanted: Array, gap: float) -> Array:
    """Positions in [0, 1] in the order of `wanted`, at least `gap` apart, with least displacements in clusters."""
    order = np.argsort(wanted, kind="stable")
    groups: list[tuple[float, int]] = []
    for w in wanted[order].tolist():
        groups.append((w, 1))
        while len(groups) > 1 and groups[-1][0] - groups[-2][0] < gap * (groups[-1][1] + groups[-2][1]) / 2:
            (second, n), (first, m) = groups.pop(), groups.pop()
            groups.append(((first * m + second * n) / (m + n), m + n))
    along = [middle + gap * (k - (n - 1) / 2) for middle, n in groups for k in range(n)]
    places = np.empty(len(wanted))
    places[order] = along
    return places


def _legend(a: Axes, notes_only: bool = False) -> None:
    handles, labels = a.get_legend_handles_labels()
    every: Any = zip(handles, labels, strict=True)  # all are lines
    rows = [pair for pair in every if not notes_only or not len(pair[0].get_xdata())]
    if not rows or len(rows) > _LABELS:
        return
    columns = max(1, _LETTERS // (8 + max(_letters(label) for _, label in rows)))
    a.legend(*zip(*rows, strict=True), ncols=min(columns, 6), fontsize=9, **ABOVE)


def draw_modes(a: Axes, rows: Sequence[tuple[str, Array, Any]]) -> None:
    """Draw the modes of each contact as a strip: its name, times and words."""
    used: dict[str, None] = {}
    for k, (name, t, words) in enumerate(rows):
        begins = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist()]
        for first, end in zip(begins, [*begins[1:], len(words) - 1], strict=True):
            start, word = t[first], str(words[first])
            label = word if word not in used else None
            used[word] = None
            a.broken_barh([(start, t[end] - start)], (-k - 0.4, 0.8), facecolor=_MODES[word], label=label)
        a.annotate(name, (0, -k), (4, 0), ("axes fraction", "data"), "offset points", va="center", fontsize="small")
    a.margins(x=0.01)
    a.set(yticks=[], ylim=(-len(rows) + 0.5, 0.5))
    for side in ("left", "right", "top"):
        a.spines[side].set_visible(False)
    a.legend(ncols=3, fontsize="small", **ABOVE)


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
