# SPDX-License-Identifier: BSD-3-Clause
"""What a model is, as JSON and as lines to read."""

from collections.abc import Mapping, Sequence
from typing import Any

import typer

import kane as kn
from kane.cli import screen
from kane.cli.faults import shown
from kane.cli.models import Model
from kane.present.declared import DECLARED

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
"""Of each group what is told: JSON's names, and the columns."""


def summary(model: Model, eom: kn.Equations, told: list[str], took: float) -> dict[str, Any]:
    """What the model is, ready for JSON."""
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
    """Print the summary, and below it what is doubtful."""
    typer.echo(typer.style(f"{what['model']}: {what['title']}", bold=True))
    parts: list[tuple[str, list[tuple[str, ...]]]] = [
        ("Bodies", [(b["name"], b["kind"], f"mass {_brief(b['mass'])} at {b['mass_center']}") for b in what["bodies"]]),
        ("Coordinates", [_words(q) for q in what["coordinates"]]),
        (
            "Speeds",
            [(u["name"], f"= {_brief(u['definition'])}", _kind(u, what), *_words(u)[1:]) for u in what["speeds"]],
        ),
        ("Constraints", [(c["name"], c["kind"], f"{_brief(c['expression'])} = 0") for c in what["constraints"]]),
        ("Reactions", [(r["name"], r["unit"], _place(r)) for r in what["reactions"]]),
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
    """Which of the speeds the constraints give; nothing where there are none."""
    dependent = what["dependent_speeds"]
    return "dependent" if speed["name"] in dependent else "independent" if dependent else ""


def _words(s: Mapping[str, str]) -> tuple[str, str, str]:
    return (s["name"], s["unit"], s["description"])


def _place(r: Mapping[str, str]) -> str:
    if not r["at"]:
        return r["description"]
    return f"at {r['at']}, along {_brief(r['along'])}" if r["along"] else f"holds {r['at']}"


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"


def _brief(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _LONG else f"{line[:_LONG]}…"
