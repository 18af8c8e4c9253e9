# SPDX-License-Identifier: BSD-3-Clause
"""Figures of eigenvalues along a branch of steady motions or limit cycles, and the chapter on root loci."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kane.analysis.solution_branches import Branch, Crossing
from kane.errors import SimulationError
from kane.motion.cycles.branch import CycleBranch
from kane.numeric.arrays import Array, Complex
from kane.numeric.scale import EQUAL, ROUNDED_ROOT
from kane.present.chapters import Part, Section, number
from kane.present.figure import Picture, file_path, look, saved
from kane.present.languages.catalogue import tr
from kane.present.motion_plots import COLOURS, FAINT, INK, SERIES, Plot, label_of, panels
from kane.present.overview import PageTable, Tex
from kane.units.rules import unit_text
from kane.write.latex import symbol_latex

_ENDS = np.array([0.0, 1.0])
_POINTS = 12
"""Rows drawn on each side of a point where two eigenvalues meet."""


class Inks(NamedTuple):
    """The colours of a locus: lines, axes, turning points, positive real parts, and in the complex plane lines and ends.

    With the colour map `scale`, the colour of points in the plane gives the varied value.
    """

    line: str
    guide: str
    turn: str
    grows: str
    plane: str
    ends: str
    scale: str = ""


_INKS = Inks(COLOURS[0], "0.6", "#555555", "#b3261e", "0.8", "black", "viridis_r")


def root_locus(branch: Branch | CycleBranch, path: str | Path | None = None) -> Figure:
    """Plot the eigenvalues along a branch: real and imaginary parts against the varied value, and in the complex plane.

    Positive real parts, which make a motion unstable, are red. Turning points are marked; in the complex plane the branch starts
    at ○ and ends at ●, and the colour gives the value.

    Parameters
    ----------
    branch : from `kn.analysis.continuation`; or from `cycle.follow`, for the Floquet exponents ln μ/T
    path : file to write, `.png`, `.svg` or `.pdf`; an existing file is replaced if it is such a figure
    """
    label, place = label_along(branch), file_path(path, 'kn.figures.root_locus(branch, "locus.svg")')
    figure = Picture(figsize=(9.6, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 2)
    above, below = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    below.sharex(above)
    right = figure.add_subplot(grid[:, 1])
    for a in (above, below, right):
        look(a)
    values, eigenvalues, _ = through_meetings(branch.values, branch.eigenvalues)
    against(above, branch, values, eigenvalues.real, "Re λ [1/s]")
    against(below, branch, values, eigenvalues.imag, "Im λ [1/s]")
    grow(above, values, eigenvalues)
    if above.get_legend_handles_labels()[0]:
        above.legend(frameon=False, fontsize=8)
    above.tick_params(labelbottom=False)
    below.set_xlabel(label)
    mapped = plane(right, branch, eigenvalues)
    figure.colorbar(mapped, ax=right, label=label, pad=0.02)
    figure.draw_without_rendering()  # the layout settles at the second drawing only
    return saved(figure, place)


# Interpolation between points ------------------------------------------------------------------------------------------------


def through_meetings(values: Array, eigenvalues: Complex) -> tuple[Array, Complex, list[int]]:
    """Values and eigenvalues with added rows where two real eigenvalues become a pair or vice versa; and indices of the given rows.

    Two eigenvalues that meet are m ± √D with smooth m and D, which are interpolated linearly: lines then pass through D = 0 on the
    real axis, which straight lines from ±σ to ±iω would miss.
    """
    rows_v, rows_e, kept = [values[:1]], [eigenvalues[:1]], [0]
    for k, (before, after) in enumerate(pairwise(eigenvalues)):
        met = _meetings(before, after)
        shares = np.unique(np.concatenate([_shares(before[[i, j]], after[[i, j]]) for i, j in met])) if met else _ENDS
        between = before + shares[1:, None] * (after - before)
        for i, j in met:
            between[:, i], between[:, j] = _meeting(before[[i, j]], after[[i, j]], shares[1:])
        rows_v.append(values[k] + shares[1:] * (values[k + 1] - values[k]))
        rows_e.append(between)
        kept.append(kept[-1] + len(between))
    along, drawn = np.concatenate(rows_v), np.concatenate(rows_e)
    along[kept], drawn[kept] = values, eigenvalues
    return along, drawn, kept


def _meetings(before: Complex, after: Complex) -> list[tuple[int, int]]:
    """Columns that are real at one end and a conjugate pair at the other."""
    pairs = []
    for real, pair in ((before, after), (after, before)):
        for i in np.flatnonzero((real.imag == 0) & (pair.imag > 0)):
            away = np.where(real.imag == 0, np.abs(pair - pair[i].conj()), np.inf)
            j = int(np.argmin(away))
            if away[j] <= EQUAL * abs(pair[i]):
                pairs.append((int(i), j))
    return pairs


def _halves(ends: Complex) -> tuple[complex, complex, float]:
    """m, δ and D = δ² of two eigenvalues m ± δ."""
    middle, half = ends.sum() / 2, (ends[0] - ends[1]) / 2
    return middle.real, half, (half**2).real


def _shares(before: Complex, after: Complex) -> Array:
    """Fractions of the interval, including the meeting point, denser near it, where √D is steep."""
    (_, _, d0), (_, _, d1) = _halves(before), _halves(after)
    at, x = d0 / (d0 - d1), np.linspace(0, 1, _POINTS) ** 2
    return np.concatenate([at * (1 - x), at + (1 - at) * x])


def _meeting(before: Complex, after: Complex, shares: Array) -> tuple[Complex, Complex]:
    """Both eigenvalues m ± √D at fractions of the interval; each keeps its column."""
    (m0, h0, d0), (m1, h1, d1) = _halves(before), _halves(after)
    d = d0 + shares * (d1 - d0)
    way = np.where(d * d0 > 0, _unit(h0, d0), _unit(h1, d1))
    half = way * np.sqrt(d + 0j)
    middle = m0 + shares * (m1 - m0)
    return middle + half, middle - half


def _unit(half: complex, square: float) -> complex:
    root = np.sqrt(square + 0j)
    return complex(half / root) if root else 1.0


def label_along(branch: Any) -> str:
    """Label of the varied value of a branch, with its unit; raises SimulationError for other objects."""
    if not isinstance(branch, Branch | CycleBranch):
        raise SimulationError(f"Expected a branch from kn.continuation or cycle.follow, got {type(branch).__name__}.")
    unit = unit_text(branch.symbol.unit)
    return label_of(branch.symbol) + (f" [{unit}]" if unit else "")


# Axes ------------------------------------------------------------------------------------------------------------------------


def against(a: Axes, branch: Branch | CycleBranch, values: Array, parts: Array, label: str, inks: Inks = _INKS) -> None:
    """Plot real or imaginary parts against the varied value, with the turning points of the branch."""
    a.axhline(0, color=inks.guide, linewidth=0.8)
    a.plot(values, parts, color=inks.line, linewidth=1.4)
    for k, i in enumerate(branch.turning):
        label_once = None if k else "turning point"
        a.axvline(branch.values[i], color=inks.turn, linewidth=0.9, linestyle=(0, (4, 2)), label=label_once)
    a.set_ylabel(label)


def grow(a: Axes, values: Array, eigenvalues: Complex, inks: Inks = _INKS) -> None:
    """Plot the positive real parts again in another colour."""
    real = eigenvalues.real
    size = np.abs(eigenvalues).max(initial=1.0)
    above = np.where(real > ROUNDED_ROOT * size, real, np.nan)
    if not np.all(np.isnan(above)):
        lines = a.plot(values, above, color=inks.grows, linewidth=2.2)
        lines[0].set_label("unstable")


def plane(a: Axes, branch: Branch | CycleBranch, lines: Complex, inks: Inks = _INKS) -> Any:
    """Plot the complex plane with the start ○ and the end ●; returns the points coloured by the varied value."""
    a.axhline(0, color=inks.guide, linewidth=0.8)
    a.axvline(0, color=inks.guide, linewidth=0.8)
    values = branch.eigenvalues
    shown = None
    a.plot(
        lines.real, lines.imag, color=inks.plane, linewidth=0.8 if inks.scale else 1.4, zorder=1 if inks.scale else 2.1
    )
    for column in values.T if inks.scale else ():
        colours = mpl.colormaps[inks.scale]
        shown = a.scatter(column.real, column.imag, c=branch.values, cmap=colours, s=9, zorder=2, linewidths=0)
    start, end = values[0], values[-1]
    a.plot(start.real, start.imag, linestyle="", marker="o", markerfacecolor="none", color=inks.ends, markersize=6)
    a.plot(end.real, end.imag, linestyle="", marker="o", color=inks.ends, markersize=4)
    a.set_xlabel("Re λ [1/s]")
    a.set_ylabel("Im λ [1/s]")
    return shown


def campbell_diagram(
    branch: Branch, path: str | Path | None = None, *, orders: Sequence[float] = (1, 2, 3), count: int = 6
) -> Figure:
    """Campbell diagram: the lowest frequencies of a branch of steady rotations against the spin Ω (rad/s).

    Where a frequency meets a line k |Ω|, an excitation at k times the spin is in resonance.

    Parameters
    ----------
    branch : from `kn.analysis.continuation`, with a spin as the varied symbol
    path : file to write, `.png`, `.svg` or `.pdf`; an existing file is replaced if it is such a figure
    orders : the factors k of the lines k |Ω|
    count : number of frequencies

    Raises
    ------
    SimulationError
        if `branch` is not a Branch
    """
    label, place = label_along(branch), file_path(path, 'kn.figures.campbell_diagram(branch, "campbell.svg")')
    figure = Picture(figsize=(6.4, 4.6), layout="constrained")
    axes: Any = figure.add_subplot()
    look(axes)
    rows = branch.frequencies[:, :count]
    axes.plot(branch.values, rows, color=_INKS.line, linewidth=1.4)
    top = 1.05 * float(np.max(rows, initial=0.0)) or 1.0
    for k in orders:
        axes.plot(branch.values, k * np.abs(branch.values), color=_INKS.guide, linewidth=0.8, linestyle=(0, (4, 2)))
        _name(axes, k, float(max(reversed(branch.values[[0, -1]]), key=abs)), top)
    axes.set_ylim(0, top)
    axes.set_xlabel(label)
    axes.set_ylabel("ω [rad/s]")
    return saved(figure, place)


def _name(axes: Any, k: float, far: float, top: float) -> None:
    """Label the line k |Ω| where it ends at the fastest spin or leaves the picture."""
    steep = k * abs(far) > top
    place = (np.copysign(top / k, far), top) if steep else (far, k * abs(far))
    aside: dict[str, Any] = {"xytext": (0, 2), "ha": "center"} if steep else {"xytext": (3, 0), "va": "center"}
    axes.annotate(
        f"{k:g} Ω", place, textcoords="offset points", fontsize=8, color="0.4", annotation_clip=False, **aside
    )


_PAGE = Inks(SERIES[0], FAINT, INK, SERIES[1], SERIES[0], INK)
"""Placeholders for the colours of a page."""


def root_loci(branch: Branch) -> Section:
    """Eigenvalues against the varied value and in the complex plane, crossings of the imaginary axis, turning points."""
    return Section("loci", tr("Root loci"), tuple(_along_branch(branch)), tuple(_branch_plots(branch)))


def _along_branch(branch: Branch) -> Iterator[Part]:
    symbol, unit = symbol_latex(branch.symbol), unit_text(branch.symbol.unit)
    begin, *turns, end = (
        f"{x:.5g} {unit}".rstrip() for x in (branch.values[0], *branch.turning_points, branch.values[-1])
    )
    yield tr(
        "Eigenvalues of %(n)s steady motions as $%(symbol)s$ goes from %(begin)s to %(end)s.",
        n=len(branch), symbol=symbol, begin=begin, end=end,
    )  # fmt: skip
    if turns:
        yield tr("The branch turns back at $%(symbol)s$ = %(values)s.", symbol=symbol, values=", ".join(turns))
    if branch.crossings:
        rows = ((Tex(number(c.value, 7)), Tex(_crossed(c)), _change(c)) for c in branch.crossings)
        head = (f"${symbol}$" + (f" ({unit})" if unit else ""), r"$\lambda$ (1/s)", tr("from there on"))
        yield PageTable(tr("Where the stability changes"), head, tuple(rows))
    else:
        yield tr("No mode changes between growth and decay in this range.")


def _crossed(crossing: Crossing) -> str:
    real, imaginary = crossing.eigenvalue.real, abs(crossing.eigenvalue.imag)
    return (number(real) if real or not imaginary else "") + (
        rf" \pm {number(imaginary)}\,\mathrm{{i}}" if imaginary else ""
    )


def _change(crossing: Crossing) -> str:
    if crossing.eigenvalue.imag:
        return tr("a swinging mode grows") if crossing.grows else tr("a swinging mode decays")
    return tr("a mode grows without swinging") if crossing.grows else tr("a mode decays without swinging")


def _branch_plots(branch: Branch) -> Iterator[Plot]:
    values, roots, _ = through_meetings(branch.values, branch.eigenvalues)
    figure, (above, below) = panels(2, 1.7, sharex=True)
    against(above, branch, values, roots.real, "Re λ [1/s]", _PAGE)
    against(below, branch, values, roots.imag, "Im λ [1/s]", _PAGE)
    grow(above, values, roots, _PAGE)
    below.set_xlabel(label_along(branch))
    title = tr("Eigenvalues over the value")
    yield Plot(
        "loci",
        title,
        tr("Real parts above zero are drawn twice as thick: there a mode grows. Dashed: turning points."),
        figure,
    )
    figure, (whole,) = panels(1, 3.4)
    plane(whole, branch, roots, _PAGE)
    yield Plot("plane", tr("In the complex plane"), tr("Start ○, end ●."), figure)
