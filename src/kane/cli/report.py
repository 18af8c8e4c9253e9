# SPDX-License-Identifier: BSD-3-Clause
"""`kane report`: derivation and motion as one HTML page."""

from pathlib import Path

import typer

from kane.cli import screen
from kane.cli.derive import derived
from kane.cli.models import model_of
from kane.cli.motion import motion, start
from kane.cli.options import End, Force, Inputs, Name, Out, Parameters, Q, States, U
from kane.present.checks import energy_check
from kane.progress import working


def report(
    name: Name,
    out: Out = None,
    t1: End = None,
    q: Q = None,
    u: U = None,
    parameter: Parameters = None,
    input: Inputs = None,
    state: States = None,
    force: Force = False,
) -> None:
    """Write the derivation of MODEL, and a motion where START is known, as one HTML page that works offline."""
    from kane.present.report import page  # matplotlib and jinja2 only here

    model = model_of(name)
    place = screen.target(out or Path(f"{model.name}.html"), model.path, force)
    eom = derived(model)
    begin = start(model, eom, {"q": q, "u": u, "parameters": parameter, "inputs": input, "states": state})
    asked = t1 is not None or any((q, u, parameter, input, state))
    sol = None if begin.missing and not asked else motion(model, eom, begin, t1)
    if sol is None:
        screen.say(f"Without a motion: START does not say {' '.join(begin.missing)}.", err=True)
    checks = [energy_check(sol)] if sol is not None else []
    with working("Writing the report"):
        screen.put(place, page(eom, solution=sol, title=model.title, sources=model.sources, checks=checks), force)
    if sol is not None:
        screen.say(f"From {sol.t[0]:g} s: {sol.message}.")
        screen.say(str(checks[0]))
    typer.echo(f"Report: {place}")
    if sol is not None and (sol.status == "stopped" or not checks[0].passed):
        raise typer.Exit(1)
