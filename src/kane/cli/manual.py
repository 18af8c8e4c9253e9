# SPDX-License-Identifier: BSD-3-Clause
"""The texts of `kane` without arguments and of `--help`: groups of commands, arguments and options, examples."""

import os
import textwrap
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from kane.cli import screen
from kane.cli.screen import UNBROKEN, guarded

GROUPS = {
    "Begin": ("gallery", "new", "convert", "demo"),
    "Equations": ("check", "derive", "emit", "bench"),
    "Motions": ("simulate", "sweep"),
    "Pictures": ("sketch", "animate", "report"),
    "Compiled code": ("cache",),
}
"""The commands by group, in the order of use."""

FIRST = (
    ("kane gallery", "models that are ready to look at"),
    ("kane simulate pendulum", "the motion of one of them"),
    ("kane new model.py", "a model file to change into your own"),
    ("kane check model.py", "what it declares, and whether it is sound"),
    ("kane report model.py", "its derivation and its motion as a page"),
)
"""First steps."""

EXAMPLES = {
    "kane": FIRST,
    "gallery": (("kane gallery", "the systems, each with its title"), ("kane gallery --json", "the same for programs")),
    "new": (("kane new model.py", "then: kane check model.py"),),
    "convert": (("kane convert robot.urdf -o robot.py", "a robot as a model file"),),
    "demo": (("kane demo --out out", "writes out/rolling_disk/report.html"),),
    "check": (("kane check model.py", ""), ("kane check pendulum --json", "for programs")),
    "derive": (
        ("kane derive pendulum", "all seven steps"),
        ("kane derive pendulum --step 5 --latex", "one, for a paper"),
    ),
    "emit": (
        ("kane emit pendulum --target c --out pendulum.c", "the equations in C"),
        ("kane emit pendulum --target fmu --out pendulum.fmu", "a unit for other tools"),
    ),
    "bench": (("kane bench rolling_disk", ""),),
    "simulate": (
        ("kane simulate pendulum --q theta=0.5 --t1 10", "another start, a longer motion"),
        ("kane simulate model.py --csv run.csv --plot run.png", "table and figure"),
    ),
    "sweep": (("kane sweep pendulum --design theta=0.1:1 --count 16 --store swings", "16 starts"),),
    "sketch": (("kane sketch pendulum", "writes pendulum.svg"),),
    "animate": (("kane animate pendulum --out swing.html", "a page to look at"),),
    "report": (("kane report pendulum --out pendulum.html", ""),),
    "cache": (("kane cache info", "where it is, and how large"),),
}
"""Examples by command, each with its effect."""


class Command(TyperCommand):
    """A command with help in the style of its output."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, description, arguments and options, examples."""
        formatter.write(_page(ctx, self, [("Options", _parameters(self))]))


class Guarded(TyperGroup):
    """A group of commands; errors, including those of arguments, are shown by `guarded`."""

    def make_context(self, *arguments: Any, **more: Any) -> Any:
        """Parse the options before the command."""
        with guarded():
            return super().make_context(*arguments, **({"color": screen.coloured()} | more))

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        with guarded():
            return super().invoke(ctx)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write usage, the commands by group, options, examples."""
        groups = [(title, [n for n in names if n in self.commands]) for title, names in GROUPS.items()]
        listed = {name for _, names in groups for name in names}
        groups.append(("Commands", [name for name in self.commands if name not in listed]))
        parts = [(title, [(n, _first_sentence(self.commands[n].help)) for n in names]) for title, names in groups]
        formatter.write(_page(ctx, self, [*parts, ("Options", _parameters(self))]))


def welcome() -> None:
    """Print the first steps."""
    typer.echo(f"{typer.style('kane', bold=True)} derives equations of motion by Kane's method, and simulates.")
    screen.heading("Begin with")
    screen.table(FIRST)
    typer.echo("\nAll commands: kane --help")


def _page(ctx: Any, command: Any, parts: list[tuple[str, list[tuple[str, str]]]]) -> str:
    """Usage, text, tables, examples."""
    words = " ".join(command.collect_usage_pieces(ctx)).replace("{", "").replace("}", "")
    lines = [
        *screen.prose(f"Usage: {ctx.command_path} {words}"),
        "",
        *textwrap.wrap(command.help or "", screen.columns(), **UNBROKEN),
    ]
    examples = EXAMPLES.get(ctx.info_name, FIRST if ctx.parent is None else ())
    for title, rows in (*parts, ("Examples", list(examples))):
        if rows:
            lines += ["", typer.style(title, bold=True), *screen.rows_of(rows)]
    return "\n".join(lines)


def _parameters(command: Any) -> list[tuple[str, str]]:
    """A row for each argument or option."""
    shown = [p for p in command.params if not getattr(p, "hidden", False) and p.name not in _LEFT_OUT]
    return [*map(_row, shown), ("--help", "Show this message and exit.")]


_LEFT_OUT = ("install_completion", "show_completion", "help")


_KINDS = {
    "Path": "FILE",
    "path": "FILE",
    "float": "NUMBER",
    "int": "NUMBER",
    "integer": "NUMBER",
    "str": "TEXT",
    "text": "TEXT",
}
"""Metavariables of options, by the type of the parameter."""


def _row(p: Any) -> tuple[str, str]:
    """Name and metavariable of an argument or option; its meaning, with choices and default."""
    options = screen.choices(p)
    told = f" One of {', '.join(options)}." if options else ""
    default = p.show_default if isinstance(p.show_default, str) else p.default if p.show_default else None
    plain = isinstance(default, str | int | float | os.PathLike) and not isinstance(default, bool)
    meaning = f"{p.help or ''}{told}{f' [{default}]' if plain else ''}"
    if p.param_type_name == "argument":
        return screen.called(p), meaning
    kind = screen.kind_of(p)
    what = "" if kind in ("bool", "boolean") else str(p.metavar or _KINDS.get(kind, p.name.upper()))
    return f"{', '.join(p.opts)} {what}".rstrip(), meaning


def _first_sentence(text: str | None) -> str:
    """The text up to the first full stop, semicolon or colon."""
    line = " ".join((text or "").split())
    return line.split("; ")[0].split(": ")[0].rstrip(".")
