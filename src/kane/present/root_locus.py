# SPDX-License-Identifier: BSD-3-Clause
"""`root_locus`: how the eigenvalues move along a branch of steady motions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from kane.errors import SimulationError
from kane.expr.html import unit_text
from kane.expr.latex import latex_name
from kane.simulate.continuation import Branch

_LINE, _GUIDE, _TURN, _GROWS = "#1f5fa8", "0.6", "#555555", "#b3261e"


def root_locus(branch: Branch, path: str | Path | None = None) -> Figure:
    """The eigenvalues of a branch: their real and imaginary parts against the value that changes, and in the complex plane.

    Where a real part is above zero, drawn in red, the motion is unstable. Turning points are marked; in the complex plane the start
    is ○ and the end ●, the colour tells the value.

    Parameters
    ----------
    branch : from `kn.continuation`
    path : where to write the figure, if anywhere: .svg, .png, .pdf
    """
    if not isinstance(branch, Branch):
        raise SimulationError(f"Expected a branch from kn.continuation, got {type(branch).__name__}.")
    figure = Figure(figsize=(9.6, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 2)
    above, below = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    below.sharex(above)
    plane = figure.add_subplot(grid[:, 1])
    unit = unit_text(branch.symbol.unit)
    label = f"${latex_name(branch.symbol.name)}$" + (f" [{unit}]" if unit else "")
    _against(above, branch, branch.eigenvalues.real, "Re λ [1/s]")
    _against(below, branch, branch.eigenvalues.imag, "Im λ [1/s]")
    _grow(above, branch)
    if above.get_legend_handles_labels()[0]:
        above.legend(frameon=False, fontsize=8)
    above.tick_params(labelbottom=False)
    below.set_xlabel(label)
    mapped = _plane(plane, branch)
    figure.colorbar(mapped, ax=plane, label=label, pad=0.02)
    if path is not None:
        figure.savefig(path)
    return figure


def _style(a: Axes) -> None:
    a.grid(True, color="0.9", linewidth=0.6)
    a.set_axisbelow(True)
    for side in ("top", "right"):
        a.spines[side].set_visible(False)


def _against(a: Axes, branch: Branch, values: Any, label: str) -> None:
    _style(a)
    a.axhline(0, color=_GUIDE, linewidth=0.8)
    a.plot(branch.values, values, color=_LINE, linewidth=1.4)
    for k, i in enumerate(branch.turning):
        a.axvline(
            branch.values[i],
            color=_TURN,
            linewidth=0.9,
            linestyle=(0, (4, 2)),
            label="turning point" if not k else None,
        )
    a.set_ylabel(label)


def _grow(a: Axes, branch: Branch) -> None:
    """The real parts above zero once more, in red."""
    real = branch.eigenvalues.real
    size = np.abs(branch.eigenvalues).max(initial=1.0)
    above = np.where(real > 1e-7 * size, real, np.nan)
    if not np.all(np.isnan(above)):
        lines = a.plot(branch.values, above, color=_GROWS, linewidth=2.2)
        lines[0].set_label("unstable")


def _plane(a: Axes, branch: Branch) -> Any:
    _style(a)
    a.axhline(0, color=_GUIDE, linewidth=0.8)
    a.axvline(0, color=_GUIDE, linewidth=0.8)
    values = branch.eigenvalues
    colours = mpl.colormaps["viridis_r"]
    shown = None
    for column in values.T:
        a.plot(column.real, column.imag, color="0.8", linewidth=0.8, zorder=1)
        shown = a.scatter(column.real, column.imag, c=branch.values, cmap=colours, s=9, zorder=2, linewidths=0)
    a.plot(
        values[0].real, values[0].imag, linestyle="", marker="o", markerfacecolor="none", color="black", markersize=6
    )
    a.plot(values[-1].real, values[-1].imag, linestyle="", marker="o", color="black", markersize=4)
    a.set_xlabel("Re λ [1/s]")
    a.set_ylabel("Im λ [1/s]")
    return shown
