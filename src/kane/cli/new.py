# SPDX-License-Identifier: BSD-3-Clause
"""`kane new`: a model file to begin with."""

from importlib.resources import files
from pathlib import Path
from typing import Annotated

import typer

from kane.cli import screen
from kane.cli.faults import Misuse
from kane.cli.options import Force


def new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Python file to write.", show_default=False)],
    force: Force = False,
) -> None:
    """Write a commented model file: a double pendulum on a cart held by a spring."""
    if file.suffix != ".py":
        raise Misuse(f"Expected a name that ends in .py, got {file}: `kane new {file.with_suffix('.py')}`.")
    _, _, text = (files("kane.cli") / "example.py").read_text(encoding="utf-8").partition("\n")  # without the licence
    screen.write(screen.target(file, None, force), text, force)
    typer.echo(f"Go on with: kane check {file}", err=True)
