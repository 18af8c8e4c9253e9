# SPDX-License-Identifier: BSD-3-Clause
"""`kane sketch`: a labelled drawing of a model as SVG, PDF or PNG."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from kane.cli import screen
from kane.cli.models import Force, Name, model_of
from kane.progress import working


def sketch(
    name: Name,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="File to write: .svg, .pdf or .png.", show_default="MODEL.svg")
    ] = None,
    width: Annotated[
        int, typer.Option(min=240, max=2000, help="Width in pixels when displayed; 330 for a phone.")
    ] = 640,
    force: Force = False,
) -> None:
    """Draw MODEL: bodies, frames, loads, coordinates with their symbols."""
    from kane.present.sketch.draw import FORMATS, save  # not before it is asked for
    from kane.present.sketch.draw import sketch as drawn

    screen.ending(out, FORMATS)
    model = model_of(name)
    place = screen.target(out or Path(f"{model.name}.svg"), model.path, force)
    with working("Drawing"):
        made = drawn(model.system, width=width, shapes=model.shapes, title=model.title)
    screen.put(place, partial(save, made), force)
    typer.echo(f"Sketch: {place}")
