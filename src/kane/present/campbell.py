# SPDX-License-Identifier: BSD-3-Clause
"""`campbell_diagram`: the frequencies about steady rotation against the spin, with the multiples of it that excite."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from kane.analysis.solution_branches import Branch
from kane.errors import SimulationError, cut
from kane.present.labels import label as label_of
from kane.units.text import unit_text

_LINE, _GUIDE = "#1f5fa8", "0.6"


def campbell_diagram(
    branch: Branch, path: str | Path | None = None, *, orders: Sequence[float] = (1, 2, 3), count: int = 6
) -> Figure:
    """The lowest frequencies of a branch of steady rotations against the value that changes, the spin in rad/s.

    Where one meets a line k Ω an excitation k times a turn finds its resonance.

    Parameters
    ----------
    branch : from `kn.continuation`, with a spin as the symbol
    path : where to write the figure, if anywhere: .svg, .png, .pdf
    orders : the k of the lines k Ω
    count : how many frequencies

    Raises
    ------
    SimulationError
        if `branch` is no branch
    """
    if not isinstance(branch, Branch):
        raise SimulationError(f"Expected a branch from kn.continuation, got {cut(type(branch).__name__)}.")
    figure = Figure(figsize=(6.4, 4.6), layout="constrained")
    axes: Any = figure.add_subplot()
    rows = branch.frequencies[:, :count]
    axes.plot(branch.values, rows, color=_LINE, linewidth=1.4)
    top = 1.05 * float(np.max(rows, initial=0.0)) or 1.0
    for k in orders:
        axes.plot(branch.values, k * branch.values, color=_GUIDE, linewidth=0.8, linestyle=(0, (4, 2)))
        _name(axes, k, float(branch.values[-1]), top)
    axes.set_ylim(0, top)
    unit = unit_text(branch.symbol.unit)
    axes.set_xlabel(label_of(branch.symbol.name) + (f" [{unit}]" if unit else ""))
    axes.set_ylabel("ω [rad/s]")
    axes.grid(True, color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if path is not None:
        figure.savefig(path)
    return figure


def _name(axes: Any, k: float, last: float, top: float) -> None:
    """The name of the line k Ω where it ends, or leaves the picture."""
    steep = k * last > top
    place = (top / k, top) if steep else (last, k * last)
    aside: dict[str, Any] = {"xytext": (0, 2), "ha": "center"} if steep else {"xytext": (3, 0), "va": "center"}
    axes.annotate(
        f"{k:g} Ω", place, textcoords="offset points", fontsize=8, color="0.4", annotation_clip=False, **aside
    )
