# SPDX-License-Identifier: BSD-3-Clause
"""The `kane` command."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from kane.cli.cache import app as cache_app

app = typer.Typer(add_completion=False, no_args_is_help=True, help="Equations of motion by Kane's method.")


def _version(wanted: bool) -> None:
    if wanted:
        from kane import __version__

        typer.echo(f"kane {__version__}")
        raise typer.Exit()


app.add_typer(cache_app, name="cache")


@app.callback()
def _kane(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    pass


@app.command("demo")
def _demo(
    out: Annotated[Path, typer.Option(help="Folder to write rolling_disk/report.html into.")] = Path("out"),
) -> None:
    """Derive, check and simulate the disk that rolls and slides; write its report."""
    from kane.cli.demo import run

    raise typer.Exit(0 if run(out) else 1)


def main() -> None:
    """Run the command."""
    app()
