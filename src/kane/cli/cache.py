# SPDX-License-Identifier: BSD-3-Clause
"""`kane cache`: the folder of compiled code."""

import typer

from kane.cli import screen
from kane.program.native import store

app = typer.Typer(no_args_is_help=True, help="Look at or empty the cache of compiled code.")


@app.command("info")
def _info() -> None:
    """Say where the cache is and how much is in it."""
    place = store.folder()
    if place is None:
        typer.echo("The cache is off (KANE_CACHE).")
        return
    count, size = store.size()
    screen.say(f"{place}: {_amount(count, size)} of at most {store.LIMIT / 2**20:.0f} MiB")


@app.command("clear")
def _clear() -> None:
    """Remove all compiled code; it is compiled anew when needed."""
    typer.echo(f"Removed {_amount(*store.clear())}.")


def _amount(count: int, size: int) -> str:
    return f"{count} {'entry' if count == 1 else 'entries'}, {size / 2**20:.1f} MiB"
