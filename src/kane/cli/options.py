# SPDX-License-Identifier: BSD-3-Clause
"""Arguments and options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from kane.cli.models import names_like

Name = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A system of the gallery, or a Python file with system().",
        autocompletion=names_like,
        show_default=False,
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Out = Annotated[Path | None, typer.Option("--out", help="File to write.", show_default=False)]
Force = Annotated[bool, typer.Option("--force", help="Write over a file that is there.")]
End = Annotated[float | None, typer.Option("--t1", help="End of the motion, s.", show_default="SPAN, or 5")]
Q = Annotated[list[str] | None, typer.Option("--q", metavar="NAME=VALUE", help="Start value of a coordinate.")]
U = Annotated[list[str] | None, typer.Option("--u", metavar="NAME=VALUE", help="Start value of a speed.")]
Parameters = Annotated[
    list[str] | None, typer.Option("--parameter", metavar="NAME=VALUE", help="Value in place of the default.")
]
States = Annotated[
    list[str] | None, typer.Option("--state", metavar="NAME=VALUE", help="Start value of a further state.")
]
Inputs = Annotated[list[str] | None, typer.Option("--input", metavar="NAME=VALUE", help="Constant value of an input.")]
