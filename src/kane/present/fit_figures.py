# SPDX-License-Identifier: BSD-3-Clause
"""The figure of a fit: residuals of each column, and the correlation of the estimates."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from kane import expect
from kane.errors import ArgumentError
from kane.motion.fitting.found import Fit
from kane.present.figure import Picture, file_path, saved
from kane.present.motion_plots import COLOURS, label_of
from kane.present.plotted.lines import look

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
