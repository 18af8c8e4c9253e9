# SPDX-License-Identifier: BSD-3-Clause
"""`kane emit`: the equations as source text of another language."""

from enum import StrEnum
from typing import Annotated

import typer

from kane.cli import screen
from kane.cli.derive import derived
from kane.cli.faults import Misuse
from kane.cli.models import model_of
from kane.cli.options import Force, Name, Out
from kane.motion.simulator_c import METHODS as SIMULATORS
from kane.motion.simulator_c import emit_simulator
from kane.progress import working


class Target(StrEnum):
    """What `Compiled.emit` can print."""

    c = "c"
    h = "h"
    numpy = "numpy"


def emit(
    name: Name,
    target: Annotated[Target, typer.Option(help="C99, its header, or a NumPy module.", show_default=False)],
    out: Out = None,
    called: Annotated[
        str | None, typer.Option("--name", help="What the emitted functions are called after.", show_default="MODEL's")
    ] = None,
    with_integrator: Annotated[
        str | None,
        typer.Option(
            help=f"A whole program in C that simulates, by {', '.join(SIMULATORS)}: compile it with cc alone.",
            metavar="METHOD",
            show_default=False,
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Print the equations of MODEL as C or NumPy source."""
    if with_integrator is not None and target is not Target.c:
        raise Misuse(f"Expected --target c with --with-integrator, got {target.value}.")
    model = model_of(name)
    if called is not None and not (called.isidentifier() and called.isascii()):
        raise Misuse(f"Expected an identifier of letters, digits and _ as --name, got {called!r}.")
    place = screen.target(out, model.path, force) if out else None
    eom = derived(model)
    with working("Compiling"):
        compiled = eom.compile(name=called or model.name)
        source = emit_simulator(compiled, with_integrator) if with_integrator else compiled.emit(target.value)
    if place:
        screen.write(place, source, force)
    else:
        typer.echo(source, nl=False)
