# SPDX-License-Identifier: BSD-3-Clause
"""`kane simulate`: a motion from START with changes by options, as numbers, table or drawing."""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

import kane as kn
from kane.cli import screen
from kane.cli.derive import derived, inputs_at
from kane.cli.models import KINDS, AsJson, End, Force, Inputs, Name, NamedModel, Parameters, Q, States, U, model_of
from kane.cli.screen import Misuse, user_code
from kane.dynamics.poles import KinematicsEnd
from kane.errors import ModelError, ValueMissingError, alike
from kane.present.check_figures import energy_check
from kane.progress import check_whole, working

_OPTIONS = dict(zip(KINDS, ("--q", "--u", "--parameter", "--input", "--state"), strict=True))
_WHAT = dict(zip(KINDS, ("coordinate", "speed", "parameter", "input", "further state"), strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class NamedStart:
    """Values by name for `simulate`, for each of `KINDS`, and options for the missing ones."""

    values: Mapping[str, Any]
    missing: tuple[str, ...]


def start(model: NamedModel, eom: kn.Equations, told: Mapping[str, Sequence[str] | None]) -> NamedStart:
    """START, changed by `told`: texts NAME=VALUE for some of `KINDS`.

    A name that the system does not have raises Misuse in `told`, and ModelError in START.
    """
    with user_code(model.path, "START"):
        begin = declared_start(model, eom, told)
        return _assembled(eom, begin, model.span[0]) if eom.system.constraints else begin


def declared_start(model: NamedModel, eom: kn.Equations, options: Mapping[str, Sequence[str] | None]) -> NamedStart:
    """As `start`, without solving for values that START guesses or leaves out."""
    symbols_of: dict[str, list[Any]] = {
        "q": list(eom.coordinates),
        "u": list(eom.speeds),
        "parameters": list(eom.parameters),
        "inputs": [s for s in eom.inputs if isinstance(s, kn.expr.Input)],
        "states": list(eom.states),
    }
    values: dict[str, dict[str, Any]] = {}
    missing: list[str] = []
    for kind, symbols in symbols_of.items():
        names = [s.name for s in symbols]
        own, option = model.start.get(kind, {}), _OPTIONS[kind]
        told = _assignments(option, options.get(kind))
        for name in told:
            if name not in names:
                raise Misuse(f"{_expected(kind, names)} in {option}, got {name!r}.{alike(name, names)}")
        for name in own:
            if name not in names:
                raise ModelError(f"{_expected(kind, names)} in START[{kind!r}], got {name!r}.{alike(str(name), names)}")
        values[kind] = {**own, **told}
        missing += [
            f"{option} {s.name}=…"
            for s in symbols
            if s.name not in values[kind] and not (kind in ("parameters", "states") and s.default is not None)
        ]
    return NamedStart(values, tuple(missing))


def _assignments(option: str, texts: Sequence[str] | None) -> dict[str, float]:
    """Values by name from texts NAME=VALUE."""
    values: dict[str, float] = {}
    for text in texts or ():
        name, sign, value = (part.strip() for part in text.partition("="))
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (name and sign and math.isfinite(number)):
            raise Misuse(f"Expected {option} NAME=VALUE with a finite number, got {text!r}.")
        if name in values:
            raise Misuse(f"Expected one value for each name, got {option} {name}=… twice.")
        values[name] = number
    return values


def _assembled(eom: kn.Equations, begin: NamedStart, t: float) -> NamedStart:
    """The start with guessed and missing values solved for, as far as constraints determine them."""
    given = begin.values
    values = {p.name: p.default for p in eom.parameters} | dict(given["parameters"])
    if None in values.values():
        return begin
    inputs = inputs_at(given["inputs"], t)
    for speeds in (given["u"], None):  # without speeds, coordinates are solved for if too few speeds are given
        try:
            assembled = kn.assemble(eom, q=given["q"], u=speeds, parameters=values, inputs=inputs, t=t)
        except ValueMissingError:
            continue
        q, u = ({s.name: x for s, x in part.items()} for part in (assembled.q, assembled.u))
        free = [] if speeds is not None else [s.name for s in eom.independent_speeds if s.name not in given["u"]]
        rest = [option for option in begin.missing if not option.startswith((_OPTIONS["q"], _OPTIONS["u"]))]
        missing = (*(f"{_OPTIONS['u']} {name}=…" for name in free), *rest)
        return NamedStart({**given, "q": q, "u": given["u"] if free else u}, missing)
    return begin


def _expected(kind: str, names: Sequence[str]) -> str:
    return f"Expected the name of {'an' if kind == 'inputs' else 'a'} {_WHAT[kind]} ({', '.join(names) or 'the model has none'})"


def motion(model: NamedModel, eom: kn.Equations, begin: NamedStart, end: float | None) -> kn.Solution:
    """The motion from the start of SPAN to `end`, or to the end of SPAN; raises Misuse if start values are missing."""
    check_complete(begin.missing)
    span = (model.span[0], model.span[1] if end is None else end)
    if not span[0] < span[1] < math.inf:
        raise Misuse(f"Expected the motion to end after its start at {span[0]:g} s, got --t1 {span[1]:g}.")
    with working("Simulating"), user_code(model.path, "START"):
        solution = kn.simulate(eom, span, **begin.values)
    whole: kn.Solution = check_whole(solution)
    return whole


def check_complete(missing: Sequence[str]) -> None:
    """Raise Misuse for missing start values, naming the options for them."""
    if missing:
        raise Misuse(
            f"Expected a start value of every quantity, got none for some: add {' '.join(missing)}, or set them in START of "
            "the model's file."
        )


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
    screen.ending(figure, ENDINGS, "--plot")
    drawing = screen.target(figure, model.path, force) if figure else None
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


def summary(sol: kn.Solution) -> dict[str, Any]:
    """A summary of a motion as data for JSON."""
    eom, check = sol.equations, energy_check(sol)
    energy = sol.energy_check
    singular = isinstance(sol.event, KinematicsEnd)  # singular coordinates, not a fault of the model
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
