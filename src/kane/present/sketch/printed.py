# SPDX-License-Identifier: BSD-3-Clause
"""A sketch for paper, as PDF or PNG: the strokes and labels of the SVG, in the styles of its style sheet."""

import unicodedata
from collections.abc import Iterable
from pathlib import Path
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D

from kane.numeric.arrays import Array
from kane.present.sketch.labels import LEADER, SMALL, Label, Span
from kane.present.sketch.paper import Stroke
from kane.present.sketch.svg import LIGHT, SHIFT, TEXT, leader, looks, shapes_of

_INCH = 96.0
"""Pixels per inch, as in a browser."""
_POINT = 72 / _INCH
_METADATA = {".pdf": {"CreationDate": None, "Creator": "kane sketch"}, ".png": {"Software": "kane sketch"}}
_HALO = 3.0
_MARKS = {"\u0302": "\u02c6", "\u0303": "\u02dc", "\u0307": "\u02d9", "\u0308": "\u00a8", "\u20db": "\u2026"}
"""Combining marks, and similar separate signs that the font has."""


def printed(strokes: Iterable[Stroke], labels: Iterable[Label], width: int, height: int, path: Path) -> None:
    """Write a drawing of `width` × `height` pixels to a .pdf or .png."""
    figure = Figure(figsize=(width / _INCH, height / _INCH))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.set_axis_off()
    for s in sorted(strokes, key=lambda s: s.order):
        for look, lines in shapes_of(s):
            _draw(axes, look, lines)
    for label in labels:
        if label.reach >= LEADER:
            _draw(axes, "leader", [(leader(label), False)])
    for label in labels:
        _write(axes, label)
    figure.savefig(path, metadata=_METADATA[path.suffix.lower()], dpi=2.5 * _INCH)


def _draw(axes: Axes, look: str, lines: list[tuple[Array, bool]]) -> None:
    style = looks(look)
    outline = Outline.make_compound_path(*(Outline([*p, p[0]] if closed else p, closed=closed) for p, closed in lines))
    dashes = [float(x) for x in style.get("stroke-dasharray", "none").split() if x != "none"]
    fill, stroke = style.get("fill", "none"), style.get("stroke", "none")
    wide = float(style.get("stroke-width", 1)) * _POINT
    axes.add_patch(
        PathPatch(
            outline, facecolor="none", edgecolor=stroke, linewidth=wide if stroke != "none" else 0, capstyle="round",
            joinstyle="round", linestyle=(0, [d * _POINT / wide for d in dashes]) if dashes else "solid", zorder=2,
        )
    ).set(facecolor=fill if fill == "none" else (fill, float(style.get("fill-opacity", 1))))  # fmt: skip


def _write(axes: Axes, label: Label) -> None:
    """Write the runs of a label side by side about its centre, as outlines with a halo."""
    bold = label.look in ("axis-name", "inertial-name")
    pieces, x = [], 0.0
    for run in label.runs:
        size = label.size * (SMALL if run.shift else 1.0)
        outline, wide = _letters(run, size, bold)
        pieces.append(outline.transformed(Affine2D().scale(1, -1).translate(x, SHIFT[run.shift] * label.size)))
        x += wide
    whole = Outline.make_compound_path(*pieces).transformed(
        Affine2D().translate(label.x - x / 2, label.y + 0.34 * label.size)
    )
    colour = LIGHT[TEXT[label.look]]
    halo = withStroke(linewidth=_HALO, foreground=LIGHT["card"])
    axes.add_patch(PathPatch(whole, facecolor=colour, edgecolor="none", linewidth=0, zorder=3, path_effects=[halo]))


def _letters(run: Span, size: float, bold: bool) -> tuple[Outline, float]:
    """Outlines of a run's letters, with marks centred above them, and their width."""
    slanted: Literal["italic", "normal"] = "italic" if run.slanted else "normal"
    font = FontProperties(family=["STIXGeneral"], style=slanted, weight="bold" if bold else "normal")
    space = (
        TextPath((0, 0), "n n", size, prop=font).get_extents().width
        - TextPath((0, 0), "nn", size, prop=font).get_extents().width
    )
    pieces: list[Outline] = []
    x = 0.0
    for c in unicodedata.normalize("NFC", run.text):
        if c == " ":
            x += space
            continue
        outline = TextPath((0, 0), _MARKS.get(c, c), size, prop=font)
        box = outline.get_extents()
        if unicodedata.combining(c) and pieces:
            below = pieces[-1].get_extents()
            middle = (below.x0 + below.x1) / 2 - (box.x0 + box.x1) / 2
            lift = max(0.0, below.y1 + 0.08 * size - box.y0)
            pieces.append(outline.transformed(Affine2D().translate(middle, lift)))
            continue
        pieces.append(outline.transformed(Affine2D().translate(x, 0)))
        x += float(box.x1) + 0.06 * size
    return (Outline.make_compound_path(*pieces) if pieces else Outline(np.zeros((1, 2)))), x
