# SPDX-License-Identifier: BSD-3-Clause
"""Figures as SVG inside a page: colours follow the page's theme, identifiers are unique and reproducible."""

import io
import re
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

INK, RULE, FAINT = "#010203", "#010204", "#010205"
SERIES = tuple(f"#0203{i:02x}" for i in range(1, 7))
"""Stand-ins that `to_svg` replaces by the page's colours."""

_THEME = {INK: "currentColor", RULE: "var(--rule)", FAINT: "var(--faint)"} | {
    c: f"var(--series-{i})" for i, c in enumerate(SERIES, 1)
}
WIDTH = 5.4
"""Width of a figure in inches: one column of the page, and a phone."""


def panels(rows: int, height: float, **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure of `rows` panels above each other, styled; `height` inches each."""
    total = height * rows + 0.45
    figure = Figure(figsize=(WIDTH, total))
    figure.patch.set_visible(False)
    # fixed margins: a layout engine draws everything twice
    figure.subplots_adjust(left=0.15, right=0.985, top=1 - 0.14 / total, bottom=0.46 / total, hspace=0.27 / height)
    grid = figure.subplots(rows, 1, squeeze=False, **options)
    axes: list[Axes] = list(grid[:, 0])
    for a in axes:
        _style(a)
    return figure, axes


def _style(a: Axes) -> None:
    a.patch.set_visible(False)
    a.grid(True, color=RULE, linewidth=0.6)
    a.set_axisbelow(True)
    a.tick_params(colors=INK, labelsize=9, length=0)
    for side, spine in a.spines.items():
        spine.set_color(FAINT)
        spine.set_visible(side in ("left", "bottom"))
    for label in (a.xaxis.label, a.yaxis.label):
        label.set_color(INK)
        label.set_fontsize(10)
        label.set_math_fontfamily("cm")
    a.yaxis.set_label_coords(-0.115, 0.5)


def legend(a: Axes, **options: Any) -> None:
    """A legend without a box."""
    box = a.legend(frameon=False, fontsize=9, labelcolor=INK, **options)
    for text in box.get_texts():
        text.set_math_fontfamily("cm")


def to_svg(figure: Figure, prefix: str) -> str:
    """The figure as an `<svg>` element; its identifiers begin with `prefix`."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = out.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    for stand_in, colour in _THEME.items():
        text = text.replace(stand_in, colour)
    identifiers: dict[str, str] = {}
    for name in re.findall(r'\bid="([^"]+)"', text):
        identifiers.setdefault(name, f"{prefix}-{len(identifiers)}")
    text = re.sub(r'\bid="([^"]+)"', lambda m: f'id="{identifiers[m[1]]}"', text)
    return re.sub(r"#([\w.-]+)(?=[\")])", lambda m: f"#{identifiers.get(m[1], m[1])}", text)
