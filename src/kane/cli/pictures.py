# SPDX-License-Identifier: BSD-3-Clause
"""`kane sketch`: a labelled drawing; `kane animate`: a motion to look at; `kane report`: a motion with its derivation, as a page."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import kane as kn
from kane.cli import screen
from kane.cli.derive import derived, inputs_at
from kane.cli.models import End, Force, Inputs, Name, Out, Parameters, Q, States, U, model_of
from kane.cli.screen import Misuse
from kane.cli.simulate import motion, start
from kane.errors import ArgumentError
from kane.present.check_figures import energy_check
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


def animate(
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
    """Write a motion of MODEL to look at: a page (.html), glTF (.glb), or pictures (.gif, .webp, .png, .mp4), as --out ends."""
    from kane.present.animation import FORMATS
    from kane.present.animation import animate as animated  # matplotlib and jinja2 only here

    screen.ending(out, FORMATS)
    model = model_of(name)
    place = screen.target(out or Path(f"{model.name}_motion.html"), model.path, force)
    eom = derived(model)
    begin = start(model, eom, {"q": q, "u": u, "parameters": parameter, "inputs": input, "states": state})
    sol = motion(model, eom, begin, t1)
    with working("Drawing"):
        screen.put(place, animated(sol, shapes=model.shapes).write, force)
    screen.say(f"From {sol.t[0]:g} s: {sol.message}.")
    typer.echo(f"Animation: {place}")
    if sol.status == "stopped":
        raise typer.Exit(1)


def report(
    name: Name,
    out: Out = None,
    form: Annotated[
        str | None,
        typer.Option("--format", help="html, latex or markdown.", show_default="by the ending of --out, else html"),
    ] = None,
    language: Annotated[str, typer.Option("--language", help="en or ko.")] = "en",
    linearization: Annotated[
        bool,
        typer.Option(
            "--linearization", help="Add a chapter on the equilibrium or steady motion near START, linearized."
        ),
    ] = False,
    root_locus: Annotated[
        str | None,
        typer.Option(
            "--root-locus",
            metavar="NAME=LOW:HIGH",
            help="Add a chapter on the eigenvalues over a range of a value.",
            show_default=False,
        ),
    ] = None,
    t1: End = None,
    q: Q = None,
    u: U = None,
    parameter: Parameters = None,
    input: Inputs = None,
    state: States = None,
    force: Force = False,
) -> None:
    """Write the derivation of MODEL, and a motion where START is known, as --out ends: HTML, LaTeX (.tex), Markdown (.md)."""
    from kane.present.report import FORMATS, document, format_of, spoken_in  # jinja2 only here

    model = model_of(name)
    try:
        known = format_of(out or Path(), form)
        spoken_in(known, language)
    except ArgumentError as error:
        raise Misuse(str(error)) from error
    place = screen.target(out or Path(f"{model.name}{FORMATS[known].endings[0]}"), model.path, force)
    eom = derived(model)
    begin = start(model, eom, {"q": q, "u": u, "parameters": parameter, "inputs": input, "states": state})
    asked = t1 is not None or any((q, u, parameter, input, state))
    sol = None if begin.missing and not asked else motion(model, eom, begin, t1)
    if sol is None:
        screen.say(f"The report has no motion: START does not give {' '.join(begin.missing)}.", err=True)
    checks = [energy_check(sol)] if sol is not None else []
    told = {"title": model.title, "sources": model.sources, "checks": checks, "shapes": model.shapes}
    told |= steady_chapters(eom, begin, model.span[0], linearization, root_locus)
    written = document(eom, place, known, language=language, solution=sol, **told)
    figures = {screen.target(place.with_name(n), model.path, force): save for n, save in written.beside.items()}
    for path, save in figures.items():
        screen.put(path, save, force)
    screen.put(place, written.text, force)
    if sol is not None:
        screen.say(f"From {sol.t[0]:g} s: {sol.message}.")
        screen.say(str(checks[0]))
    typer.echo(f"Report: {place}")
    if sol is not None and (sol.status == "stopped" or not checks[0].passed):
        raise typer.Exit(1)


_POINTS = 41
"""Number of points of a branch."""


def steady_chapters(eom: kn.Equations, begin: Any, t: float, linearization: bool, locus: str | None) -> dict[str, Any]:
    """Arguments of `report`: the linearization at the steady motion or equilibrium near START; the branch NAME=LOW:HIGH.

    Inputs have their values at the time t.
    """
    values = begin.values
    guesses = {kind: {s: kn.guess(float(v)) for s, v in values[kind].items()} for kind in ("q", "u", "states")}
    given: dict[str, Any] = {**guesses, "parameters": values["parameters"], "inputs": inputs_at(values["inputs"], t)}
    result: dict[str, Any] = {}
    if linearization:
        result["linearization"] = kn.linearize(eom, kn.trim(eom, **given))
    if locus is not None:
        name, low, high = _range(locus)
        result["root_locus"] = kn.analysis.continuation(eom, name, np.linspace(low, high, _POINTS).tolist(), **given)
    return result


def _range(text: str) -> tuple[str, float, float]:
    name, _, values = (part.strip() for part in text.partition("="))
    low, _, high = values.partition(":")
    try:
        return name, float(low), float(high)
    except ValueError:
        raise Misuse(f"Expected NAME=LOW:HIGH in --root-locus, got {text!r}.") from None
