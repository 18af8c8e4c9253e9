# SPDX-License-Identifier: BSD-3-Clause
"""Lines on matplotlib's axes, in the colours of the report, with names at their ends if there is room."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from kane.numeric.arrays import Array
from kane.present.motion_plots import COLOURS
from kane.present.plotted.traces import Panel, Trace
from kane.units.rules import unit_text

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
