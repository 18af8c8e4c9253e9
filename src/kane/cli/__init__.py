# SPDX-License-Identifier: BSD-3-Clause
"""The `kane` command."""

from pathlib import Path
from typing import Annotated

import typer

from kane import __version__
from kane.cli import screen
from kane.cli.bench import bench
from kane.cli.check import check
from kane.cli.convert import convert
from kane.cli.derive import cache_app, derive, emit
from kane.cli.manual import Command, Guarded, welcome
from kane.cli.models import AsJson, new
from kane.cli.pictures import animate, report, sketch
from kane.cli.simulate import simulate
from kane.cli.sweep import sweep
from kane.gallery import GALLERY, load
from kane.lazy_imports import offered

app = typer.Typer(
    cls=Guarded,
    invoke_without_command=True,
    pretty_exceptions_enable=False,  # a fault of kane itself is reported with Python's own traceback
    help="Equations of motion by Kane's method.",
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"kane {__version__}")
        raise typer.Exit()


@app.callback()
def _kane(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        welcome()


@app.command(cls=Command)
def gallery(as_json: AsJson = False) -> None:
    """List the systems of the gallery; each can be given as MODEL."""
    titles = {name: str(load(name).TITLE) for name in GALLERY}
    if as_json:
        screen.as_json([{"name": name, "title": title} for name, title in titles.items()])
    else:
        screen.table(list(titles.items()), indent=0)


for command in (new, convert, check, derive, simulate, sweep, sketch, animate, report, emit, bench):
    app.command(command.__name__, cls=Command)(command)


@app.command("demo", cls=Command)
def _demo(
    out: Annotated[Path, typer.Option(help="Folder to write rolling_disk/report.html into.")] = Path("out"),
) -> None:
    """Derive, check and simulate the disk that rolls and slides; write its report."""
    from kane.cli.demo import run

    raise typer.Exit(0 if run(out) else 1)


app.add_typer(cache_app, name="cache")


def main() -> None:
    """Run the command."""
    app()


__getattr__ = offered(__name__, {"models": "STARTS model_of names_like", "screen": "LINES guarded"})
