# SPDX-License-Identifier: BSD-3-Clause
"""`kane simulate`: a motion in figures, as a table of values, or drawn."""

import csv
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import kane as kn
from kane.cli import screen
from kane.cli.derive import derived
from kane.cli.faults import Misuse
from kane.cli.models import model_of
from kane.cli.motion import motion, start
from kane.cli.options import AsJson, End, Force, Inputs, Name, Parameters, Q, States, U
from kane.dynamics.events import KinematicsEnd
from kane.present.checks import energy_check

ENDINGS = (".png", ".svg", ".pdf")


def simulate(
    name: Name,
    t1: End = None,
    q: Q = None,
    u: U = None,
    parameter: Parameters = None,
    input: Inputs = None,
    state: States = None,
    table: Annotated[
        Path | None, typer.Option("--csv", help="File for time, coordinates, speeds, reactions and energy.")
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option("--plot", help="File for coordinates, speeds, reactions and energy: .png, .svg or .pdf."),
    ] = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Simulate MODEL from START; leave with 1 if the motion breaks off or its energy does not hold."""
    model = model_of(name)
    eom = derived(model)
    begin = start(model, eom, {"q": q, "u": u, "parameters": parameter, "inputs": input, "states": state})
    place = screen.target(table, model.path, force) if table else None
    drawing = screen.target(_drawable(figure), model.path, force) if figure else None
    sol = motion(model, eom, begin, t1)
    if place:
        screen.write(place, lambda path: _write(path, sol), force)
    if drawing:
        from kane.present.figure import save  # matplotlib only here

        screen.write(drawing, partial(save, kn.plot(sol)), force)
    what = summary(sol)
    if as_json:
        screen.as_json({"model": model.name, "title": model.title, **what})
    else:
        _show(sol, what)
    raise typer.Exit(0 if what["ok"] else 1)


def _drawable(path: Path) -> Path:
    if path.suffix.lower() not in ENDINGS:
        raise Misuse(f"Expected --plot FILE that ends in {', '.join(ENDINGS)}, got {path}.")
    return path


def summary(sol: kn.Solution) -> dict[str, Any]:
    """A motion in figures, ready for JSON."""
    eom, check = sol.equations, energy_check(sol)
    energy = sol.energy_check
    singular = isinstance(sol.event, KinematicsEnd)  # of the coordinates, not of the model
    rows = {s.name: np.asarray(sol[s]) for s in (*eom.state, *eom.reactions)}
    return {
        "ok": check.passed and sol.status != "stopped" and not singular,
        "status": sol.status,
        "message": sol.message,
        "t0": sol.t[0],
        "t1": sol.t[-1],
        "samples": len(sol),
        "steps": sol.steps,
        "evaluations": sol.evaluations,
        "parameters": {str(p): v for p, v in sol.parameters.items()},
        "values": {
            n: {"start": v[0], "end": v[-1], "least": float(v.min()), "most": float(v.max())} for n, v in rows.items()
        },
        "energy": {
            "drift": energy.drift,
            "scale": energy.scale,
            "relative": energy.relative,
            "limit": check.limit,
            "passed": check.passed,
        },
        "events": [{"name": event.name, "t": t} for event, t in sol.events],
    }


def _show(sol: kn.Solution, what: dict[str, Any]) -> None:
    eom = sol.equations
    units = {s.name: s.unit for s in (*eom.state, *eom.reactions)}
    screen.say(f"From {sol.t[0]:g} s: {sol.message}.")
    typer.echo(f"{len(sol)} samples, {sol.steps} steps, {sol.evaluations} evaluations\n")
    keys = ("start", "end", "least", "most")
    rows = [(n, *(f"{v[k]:.6g}" for k in keys), units[n]) for n, v in what["values"].items()]
    screen.table([("", *keys, "unit"), *rows], indent=0)
    for event in what["events"]:
        typer.echo(f"\nEvent {event['name']} at {event['t']:.6g} s")
    check = energy_check(sol)
    typer.echo()
    screen.say(str(check), fg="green" if check.passed else "red")
    screen.say(f"      {check.detail}")


def _write(place: Path, sol: kn.Solution) -> None:
    eom = sol.equations
    symbols = [*eom.state, *eom.reactions]
    columns = [sol.t, *(sol[s] for s in symbols), sol.energy]
    with place.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(["t", *(s.name for s in symbols), "E"])
        out.writerows([repr(float(v)) for v in row] for row in zip(*columns, strict=True))
