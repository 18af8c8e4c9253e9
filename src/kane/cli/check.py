# SPDX-License-Identifier: BSD-3-Clause
"""`kane check`: a summary of a model, as JSON or as text, with errors and warnings."""

import math
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import typer

import kane as kn
from kane.analysis.load_signs import DIRECTIONS, doubtful_loads
from kane.analysis.state_checks import start_state
from kane.cli import screen
from kane.cli.derive import derived
from kane.cli.models import AsJson, Name, NamedModel, model_of
from kane.cli.screen import Misuse, UserError, message_of, shown, user_code, warning_location
from kane.cli.simulate import NamedStart, start
from kane.dynamics.constraints.partition import choose
from kane.dynamics.poles import AdmittedSpeeds, moving_pivots
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.compiled import rate_names
from kane.equations.equations import repartition
from kane.errors import KaneError, KaneWarning, ModelError, SingularError
from kane.motion.inputs.functions import input_functions
from kane.motion.inputs.smooth import check_prescribed
from kane.motion.start import check_mass_matrix, check_masses, check_regular, regular_otherwise
from kane.numeric.sampling import finite_number
from kane.present.overview import DECLARED
from kane.space.rotation import in_degrees

_LONG = 70

_KEYS: dict[str, Mapping[str, str]] = {
    "bodies": {"name": "body", "kind": "kind", "mass": "mass", "mass_center": "mass centre"},
    "coordinates": {"name": "coordinate", "unit": "unit", "description": "meaning"},
    "speeds": {"name": "speed", "unit": "unit", "description": "meaning", "definition": "definition"},
    "states": {"name": "state", "unit": "unit", "description": "meaning", "default": "default", "rate": "rate"},
    "constraints": {"name": "constraint", "kind": "kind", "expression": "vanishes"},
    "reactions": {"name": "reaction", "unit": "unit", "description": "meaning", "at": "at", "along": "along"},
    "loads": {"name": "load", "potential": "potential"},
    "inputs": {"name": "input", "unit": "unit", "description": "meaning"},
    "parameters": {"name": "parameter", "unit": "unit", "description": "meaning", "default": "default"},
}
"""The columns of each group, by their names in JSON."""


def summary(model: NamedModel, eom: kn.Equations, told: list[str], took: float) -> dict[str, Any]:
    """The model as data for JSON."""
    groups = {
        group: [{key: _plain(row[column], key) for key, column in keys.items()} for row in DECLARED[group](eom.system)]
        for group, keys in _KEYS.items()
    }
    return {
        "model": model.name,
        "title": model.title,
        "ok": True,
        **{group: groups[group] for group in ("bodies", "coordinates", "speeds", "constraints")},
        "dependent_speeds": [u.name for u in eom.dependent_speeds],
        **groups,
        "operations": screen.operations(eom.operations),
        "warnings": told,
        "derived_s": took,
    }


def _plain(value: Any, key: str) -> Any:
    if key == "potential":
        return value is not None
    if isinstance(value, kn.Expr):
        return kn.to_text(value)
    return str(value) if isinstance(value, kn.Vector) else getattr(value, "name", value)


def show(what: Mapping[str, Any], told: Sequence[str]) -> None:
    """Print the summary, and warnings below it."""
    typer.echo(typer.style(f"{what['model']}: {what['title']}", bold=True))
    parts: list[tuple[str, list[tuple[str, ...]]]] = [
        ("Bodies", [(b["name"], b["kind"], f"mass {_brief(b['mass'])} at {b['mass_center']}") for b in what["bodies"]]),
        ("Coordinates", [_words(q) for q in what["coordinates"]]),
        (
            "Speeds",
            [(u["name"], f"= {_brief(u['definition'])}", _kind(u, what), *_words(u)[1:]) for u in what["speeds"]],
        ),
        ("Constraints", [(c["name"], c["kind"], f"{_brief(c['expression'])} = 0") for c in what["constraints"]]),
        ("Reactions", [(r["name"], r["unit"], _location(r)) for r in what["reactions"]]),
        ("Further states", [(a["name"], f"' = {_brief(a['rate'])}", *_words(a)[1:]) for a in what["states"]]),
        ("Loads", [(x["name"], "with a potential" if x["potential"] else "does work") for x in what["loads"]]),
        ("Inputs", [_words(r) for r in what["inputs"]]),
        ("Parameters", [(p["name"], _number(p["default"]), *_words(p)[1:]) for p in what["parameters"]]),
    ]
    for title, rows in parts:
        if rows:
            screen.heading(f"{title} ({len(rows)})")
            screen.table(rows)
    cost = what["operations"]
    screen.heading("One evaluation")
    screen.say(f"  {cost['total']} operations: {cost['state']} with the state, {cost['parameter']} of parameters")
    if told:
        screen.heading("Warnings")
        for text in told:
            typer.echo(shown(f"  {text}"))
    typer.echo(f"\nNo error found; derived in {what['derived_s'] * 1e3:.0f} ms.")


def _kind(speed: Mapping[str, str], what: Mapping[str, Any]) -> str:
    """Whether a speed is dependent or independent; "" without constraints."""
    dependent = what["dependent_speeds"]
    return "dependent" if speed["name"] in dependent else "independent" if dependent else ""


def _words(s: Mapping[str, str]) -> tuple[str, str, str]:
    return (s["name"], s["unit"], s["description"])


def _location(r: Mapping[str, str]) -> str:
    if not r["at"]:
        return r["description"]
    return f"at {r['at']}, along {_brief(r['along'])}" if r["along"] else f"holds {r['at']}"


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"


def _brief(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _LONG else f"{line[:_LONG]}…"


_TURN = 2 * math.pi


def check(name: Name, as_json: AsJson = False) -> None:
    """Say what MODEL is; leave with 1 if it is wrong."""
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", KaneWarning)
            model = model_of(name)
            began = time.perf_counter()
            eom = derived(model)
            took = time.perf_counter() - began
            begin = start(model, eom, {})
            with user_code(model.path, "START"):
                numbers = _check_start(model, eom, begin)
    except (KaneError, UserError) as error:
        if not as_json or isinstance(error, Misuse):
            raise
        text = shown(message_of(error))
        screen.as_json({"model": name, "ok": False, "error": {"type": type(error).__name__, "message": text}})
        raise typer.Exit(1) from None
    else:
        told = [str(w.message) for w in caught]
        # warnings of probable mistakes
        doubtful = [*_missing(eom, begin), *_degrees(eom, begin), *_loads(eom), *_signs(eom, numbers)]
        what = summary(model, eom, [*told, *doubtful], took)
        if as_json:
            screen.as_json(what)
        else:
            placed = ["\n  ".join(filter(None, (str(w.message), warning_location(w, model.path)))) for w in caught]
            show(what, [*placed, *doubtful])


def _check_start(model: NamedModel, eom: kn.Equations, begin: NamedStart) -> dict[kn.Expr, Any]:
    """Check that start values are admissible and equations finite at the start; returns all values, if START is complete."""
    values = begin.values
    for kind, told in values.items():
        for name, value in told.items():
            if not callable(value):
                finite_number("start value" if kind in ("q", "u", "states") else "value", name, value)
    if begin.missing:
        return {}
    t = model.span[0]
    constants = parameter_values(eom.system, values["parameters"])
    check_masses(eom, constants)
    state = start_state(eom, values["q"], values["u"], values["states"])
    check_prescribed(eom, constants, model.span)
    inputs = {s: f(t) for s, f in input_functions(eom, values["inputs"], model.span).items()}
    numbers: dict[kn.Expr, Any] = {kn.time: t, **constants, **inputs}
    numbers.update(zip(eom.state, state, strict=True))
    if eom.embedding is not None and moving_pivots(eom.derived):
        admitted = AdmittedSpeeds(eom.derived, numbers)
        eom = regular_otherwise(eom, numbers, admitted, lambda make, *by: make(eom, *by)) or eom  # as a simulation does
    check_regular(eom, numbers, t)
    check_mass_matrix(eom, numbers, t)
    with np.errstate(all="ignore"):
        rates = _rates(eom, numbers, {**values, "inputs": inputs, "t": t})
    bad = [n for n, v in zip(rate_names(eom.derived), rates, strict=False) if not np.all(np.isfinite(v))]
    if bad:
        raise ModelError(
            f"Expected finite rates at START, got none for {', '.join(bad)}: the equations are singular there, or a load is not "
            "defined. Start elsewhere, or choose coordinates and speeds that are regular there."
        )
    return numbers


def _rates(eom: kn.Equations, numbers: dict[kn.Expr, Any], given: dict[str, Any]) -> list[Any]:
    """q̇ and u̇, with the other dependent speeds that a simulation would choose if the first choice is singular."""
    try:
        rates: list[Any] = eom.evaluate(list(eom.right_hand_side), **given)
    except SingularError:
        a = np.asarray(kn.evaluate(eom.A, numbers), dtype=float)
        other, first = choose(a), eom.embedding
        if first is None or len(other.rows) < len(first.partition.rows):
            return list(kn.evaluate(list(eom.rates), numbers))  # lower rank here: a motion has u̇ of least norm
        eom = repartition(eom, other)
        rates = eom.evaluate(list(eom.right_hand_side), **given)
    return rates


def _missing(eom: kn.Equations, begin: NamedStart) -> Iterator[str]:
    bare = [p.name for p in eom.parameters if p.default is None and p.name not in begin.values["parameters"]]
    if bare:
        yield f"No default for {', '.join(bare)}: every simulation needs --parameter NAME=VALUE for them."
    state = [option for option in begin.missing if not option.startswith("--parameter")]
    if state:
        yield f"START is incomplete: a simulation needs {' '.join(state)}."


def _degrees(eom: kn.Equations, begin: NamedStart) -> Iterator[str]:
    """Messages about angles beyond a full turn, which may be in degrees."""
    angles = {f: f.orientation.angle for f in eom.system.frames if f.orientation and f.orientation.angle is not None}
    for f, angle in angles.items():
        symbols = kn.free_symbols([angle])  # numbers cause a warning when the frame is declared
        if symbols and all(s.default is not None for s in symbols):
            value = float(kn.evaluate(angle, {}))
            if abs(value) > _TURN:
                yield in_degrees(f"The frame {f.name} is turned by {value:g} rad", value)
    for q in dict.fromkeys(s for s in kn.free_symbols(angles.values()) if isinstance(s, kn.expr.Coordinate)):
        value = float(begin.values["q"].get(q.name, 0.0))
        if abs(value) > _TURN:
            yield in_degrees(f"START has the angle {q.name} = {value:g} rad", value)


def _loads(eom: kn.Equations) -> Iterator[str]:
    system = eom.system
    if not eom.loads:
        yield "No loads: only inertia forces act."
    if len(system.gravities) > 1:
        names = " and ".join(g.name for g in system.gravities)
        yield (
            f"{len(system.gravities)} loads of gravity ({names}) act on every body, and their sum is applied. List one of them unless "
            "all are meant."
        )


_DOES = {
    "feeds": (
        "The load {name!r} adds energy to the motion: the part of it that changes sign with the speeds has positive power at START, "
        "at {count} random speeds, up to {most:.3g} W for speeds about 1. A damper dissipates energy: check the sign of the force, or "
        "of its coefficient."
    ),
    "pushes": (
        "The load {name!r} pushes away: at START it increases when its point of application moves in its own direction, by up to "
        "{most:.3g} per unit, in {count} random directions. A spring opposes the displacement: check the sign of the force, or of its "
        "stiffness."
    ),
}


def _signs(eom: kn.Equations, numbers: dict[kn.Expr, Any]) -> Iterator[str]:
    """Messages about loads with doubtful signs."""
    for doubt in doubtful_loads(eom, numbers) if numbers else ():
        yield _DOES[doubt.does].format(name=doubt.load.name, count=DIRECTIONS, most=doubt.most)
