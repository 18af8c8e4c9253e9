# SPDX-License-Identifier: BSD-3-Clause
"""`plot`: quantities along a motion as one figure, for papers, notebooks and scripts."""

import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kane.dynamics.readings.quantities import asked
from kane.errors import ArgumentError, UnitError, cut
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Symbol
from kane.model.system import System
from kane.model.unit_checks import unit_in
from kane.motion.solution.solution import Solution
from kane.present.motion_plots import label_of
from kane.space.vector import Vector
from kane.units.rules import unit_text
from kane.whole import exchange, path_of
from kane.write.arrange import to_text

FORMATS: dict[str, dict[str, str | None]] = {
    ".png": {"Software": "kane"},
    ".svg": {"Date": None, "Creator": "kane"},
    ".pdf": {"CreationDate": None, "Creator": "kane"},
}
"""Endings of the files that can be written, and the metadata that makes them the same each time, and known."""

_MARKS = (b"Software\0kane", b"<dc:title>kane</dc:title>", b"/Creator (kane)")

_LABELS, _LETTERS, _AXIS = 12, 48, 16
"""Lines beyond which a panel has no legend; letters beyond which a label is cut, or stands above the panel."""
_STRIP = 0.3
"""Height of the strip of a contact's modes, in inches."""
_MODES = {"separated": "#e5e7eb", "closed": "#bfdbfe", "stick": "#93c5fd", "slip": "#fdba74"}


class Trace(NamedTuple):
    """One line: what it is called, its unit ("" where unknown), its values, and how it is drawn."""

    label: str
    unit: str
    values: npt.NDArray[np.float64]
    style: str = "-"


Panel = tuple[str, list[Trace]]


class Picture(Figure):
    """A figure that a notebook shows without pyplot."""

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png")
        return out.getvalue()


def plot(solution: Solution, *quantities: Any, path: str | Path | None = None, ax: Axes | None = None) -> Figure:
    """Quantities against time, those of one unit in one panel; without any: coordinates, speeds, reactions and energy.

    Parameters
    ----------
    solution : a motion, from `simulate`
    quantities : symbols, expressions, vectors (by components along the inertial frame), names, or mappings from labels to these
    path : file to write, `.png`, `.svg` or `.pdf`; missing folders are made, and a file that `plot` wrote is replaced, nothing else
    ax : matplotlib's axes to draw on instead of a new figure; then everything shares them

    Returns
    -------
    The figure, to change or to save as any of matplotlib's.

    Raises
    ------
    ArgumentError
        if the path ends in something else, or something else than a figure of `plot` has that name
    ValueMissingError
        if the motion knows no such name
    """
    if not isinstance(solution, Solution):
        raise ArgumentError(f"Expected a motion from kn.simulate to plot, got {cut(repr(solution))}.")
    place = None if path is None else path_of(path, 'kn.plot(sol, path="motion.svg")')
    if place is not None and place.suffix.lower() not in FORMATS:
        raise ArgumentError(f"Expected a file for the figure that ends in {', '.join(FORMATS)}, got {str(place)!r}.")
    panels = _everything(solution) if not quantities else _panels("", solution, quantities)
    if ax is None:
        strips = len(solution.modes)
        heights = [1.9] * len(panels) + ([_STRIP * (strips + 1)] if strips else [])
        figure: Figure = Picture(figsize=(6.4, 0.5 + sum(heights)), layout="constrained")
        axes = list(figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0])
        if strips:
            _draw_modes(axes[-1], solution)
    else:
        whole = ax.get_figure(root=True)
        assert whole is not None
        figure, axes = whole, [ax]
        panels = [("", [trace for _, traces in panels for trace in traces])]
    for a, (title, traces) in zip(axes, panels, strict=False):
        _draw(a, title, traces, solution.t)
    axes[-1].set_xlabel("t [s]")
    if place is not None:
        place.parent.mkdir(parents=True, exist_ok=True)
        exchange(place, partial(save, figure), lambda p: any(mark in p.read_bytes() for mark in _MARKS))
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write a figure, the same each time, in the format that the path's ending says."""
    with matplotlib.rc_context({"svg.hashsalt": "kane"}):
        figure.savefig(path, metadata=FORMATS[path.suffix.lower()], dpi=160)


def _everything(solution: Solution) -> list[Panel]:
    eom = solution.equations
    kinds = {"coordinates": eom.coordinates, "speeds": eom.speeds, "states": eom.states, "reactions": eom.reactions}
    touching = ((c.normal_force, *c.friction_forces) for c in eom.system.contacts)
    kinds["contacts"] = tuple(dict.fromkeys(f for own in touching for f in own if f is not None))
    kinetic, potential, total = solution[[eom.kinetic_energy, eom.potential_energy, eom.energy]]
    energies = [Trace("K", "J", kinetic), Trace("V", "J", potential), Trace("E = K + V", "J", total)]
    energies.append(Trace("E − ∫P dt", "J", total - solution.work, "--"))
    return [*(p for kind, symbols in kinds.items() for p in _panels(kind, solution, symbols)), ("energy", energies)]


def _panels(title: str, solution: Solution, quantities: Iterable[Any]) -> list[Panel]:
    """Quantities of one unit together; one of unknown unit by itself."""
    groups: dict[Any, list[Trace]] = {}
    for k, (label, what) in enumerate(_labelled(quantities)):
        traces = _traces(solution, what, label)
        groups.setdefault(traces[0].unit or k, []).extend(traces)
    return [(title, traces) for traces in groups.values()]


def _labelled(quantities: Iterable[Any]) -> Iterator[tuple[str, Any]]:
    for what in quantities:
        if isinstance(what, Mapping):
            yield from ((str(label), quantity) for label, quantity in what.items())
        else:
            yield "", what


def _traces(solution: Solution, what: Any, label: str) -> list[Trace]:
    eom = solution.equations
    if isinstance(what, str):
        (what,) = asked(eom.derived, what).roots
    values = solution[what]  # before anything else: it says what is wrong with `what`
    if isinstance(what, Vector):
        inertial = eom.system.inertial
        units = [_unit(eom.system, c) for c in what.components(inertial)]
        unit = next(filter(None, units), "")
        names = [f"{label or f'({_cut(str(what))})'} · {inertial.name}.{axis}" for axis in "xyz"]
        return [Trace(name, unit, component) for name, component in zip(names, values.T, strict=True)]
    e = as_expr(what)
    name = label_of(e.name) if isinstance(e, Symbol) else _cut(to_text(e))
    return [Trace(label or name, _unit(eom.system, e), values)]


def _unit(system: System, e: Expr) -> str:
    try:
        return unit_in(system, e)
    except UnitError:  # what is drawn need not be a quantity of the model
        return ""


def _cut(text: str) -> str:
    return text if len(text) <= _LETTERS else text[: _LETTERS - 1] + "…"


def _draw(a: Axes, title: str, traces: Sequence[Trace], t: npt.NDArray[np.float64]) -> None:
    for trace in traces:
        a.plot(t, trace.values, trace.style, linewidth=1.4, label=trace.label)
    a.grid(True, linewidth=0.5, alpha=0.5)
    a.margins(x=0.01)
    short = len(traces) == 1 and len(traces[0].label) <= _AXIS
    units = ", ".join(unit_text(u) for u in dict.fromkeys(trace.unit for trace in traces) if u)
    name = traces[0].label if short else title
    a.set_ylabel(f"{name} [{units}]".strip() if units else name)
    if not short and len(traces) <= _LABELS:
        columns = max(1, 2 * _LETTERS // (6 + max(len(trace.label) for trace in traces)))
        a.legend(frameon=False, ncols=min(columns, 6), loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0.1)


def _draw_modes(a: Axes, solution: Solution) -> None:
    """What each contact does, one strip a contact."""
    used: dict[str, None] = {}
    for k, (name, words) in enumerate(solution.modes.items()):
        begins = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist()]
        for first, end in zip(begins, [*begins[1:], len(words) - 1], strict=True):
            start, word = solution.t[first], str(words[first])
            label = word if word not in used else None
            used[word] = None
            width = solution.t[end] - start
            a.broken_barh([(start, width)], (-k - 0.4, 0.8), facecolor=_MODES[word], label=label)
        a.annotate(name, (0, -k), (4, 0), ("axes fraction", "data"), "offset points", va="center", fontsize="small")
    a.set(yticks=[], ylim=(-len(solution.modes) + 0.5, 0.5))
    for side in ("left", "right", "top"):
        a.spines[side].set_visible(False)
    a.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0.1, fontsize="small")
