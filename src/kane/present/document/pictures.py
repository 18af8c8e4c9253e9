# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a report in files beside it: the sketch, and plots of a motion."""

import io
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kane.present.content import Content
from kane.present.notes import Image, title_of
from kane.present.pages import plain
from kane.present.sketch.draw import MARKS, WIDE, draw_each
from kane.present.sketch.draw import save as save_sketch
from kane.whole import FIGURES

if TYPE_CHECKING:
    from kane.present.motion_plots import Plot

_COPIED = b"<!-- A picture in a report of kane -->"
DRAWN = (*MARKS, *FIGURES, _COPIED)
"""Marks by which a figure written by kane is recognized."""


@dataclass(frozen=True, slots=True)
class ReportPicture:
    """A figure: its name within the report, heading, caption (with LaTeX), and the function that writes it in the format of a path.

    A picture that is copied from a file has its `ending`.
    """

    name: str
    title: str
    caption: str
    save: Callable[[Path], object]
    ending: str = ""


def sketch_of(content: Content) -> Iterator[ReportPicture]:
    """The labelled sketch, if the system can be drawn."""
    if content.seen.drawable:
        (drawn,) = draw_each(content.seen, (WIDE,), title=content.title)
        said = "; ".join(f"${symbol}$ {plain(meaning)}" for symbol, meaning in content.meanings)
        yield ReportPicture("sketch", "", said, partial(save_sketch, drawn))


def plots_of(content: Content) -> Iterator[ReportPicture]:
    """The plots of the motion."""
    if content.solution is None:
        return
    from kane.present.motion_plots import plots

    yield from map(printed, plots(content.solution))


def printed(plot: "Plot") -> ReportPicture:
    """A plot in colours for white paper."""
    from kane.present.figure import save
    from kane.present.motion_plots import to_print

    return ReportPicture(plot.name, plot.title, plain(plot.caption), partial(save, to_print(plot.figure)))


def picture_of(note: Any, name: str) -> ReportPicture:
    """A matplotlib figure, or a picture read from a file, among the notes."""
    if isinstance(note, Image):
        return ReportPicture(name, "", "", partial(_copy, note.data), note.ending)
    from kane.present.figure import save

    return ReportPicture(name, "", plain(title_of(note)), partial(save, note))


def _copy(data: bytes, path: Path) -> None:
    """Write a copy of a picture, marked as part of a report."""
    if path.suffix == ".svg":
        path.write_bytes(data.rstrip() + b"\n" + _COPIED + b"\n")
        return
    from PIL import Image as Pixels
    from PIL.PngImagePlugin import PngInfo

    told = PngInfo()
    told.add_text("Software", "kane")
    Pixels.open(io.BytesIO(data)).save(path, pnginfo=told)


def beside(pieces: Iterable[object], report: str, ending: str) -> dict[str, Callable[[Path], object]]:
    """Functions that write the figures among the pieces, by file name."""
    return {file_name(report, p, ending): p.save for p in pieces if isinstance(p, ReportPicture)}


def file_name(report: str, picture: ReportPicture, ending: str) -> str:
    """The file name of a figure beside a report, in characters that LaTeX and URLs accept."""
    return f"{re.sub(r'[^A-Za-z0-9.-]+', '-', report)}-{picture.name}{picture.ending or ending}"
