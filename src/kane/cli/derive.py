# SPDX-License-Identifier: BSD-3-Clause
"""`kane derive`: the seven steps with their formulas; `kane emit`: the equations as source text; `kane cache`: compiled code."""

import sys
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

import kane as kn
from kane.cli import screen
from kane.cli.manual import Command, Guarded
from kane.cli.models import KINDS, AsJson, Force, Name, NamedModel, Out, model_of
from kane.cli.screen import Misuse, columns, user_code
from kane.dynamics.readings.seven_steps import Step
from kane.errors import ValueMissingError
from kane.interop.fmu import to_fmu, unit_name
from kane.motion.programs.simulator_c import emit_simulator
from kane.motion.programs.simulator_parts import METHODS as SIMULATORS
from kane.motion.programs.simulator_wasm import emit_simulator_wasm
from kane.present.formula_list import result_formulas, step_text
from kane.program.emit.targets import BINARY, EMITTERS
from kane.program.native import store
from kane.progress import working
from kane.write.latex import symbol_latex


def derive(
    name: Name,
    latex: Annotated[bool, typer.Option("--latex", help="Print LaTeX.")] = False,
    step: Annotated[int | None, typer.Option(min=1, max=7, help="Only this step.", show_default="all")] = None,
    as_json: AsJson = False,
) -> None:
    """Print the equations of MODEL, step by step."""
    model = model_of(name)
    eom = derived(model)
    steps = [s for s in eom.steps if step in (None, s.number)]
    if as_json:
        screen.as_json({"model": model.name, "title": model.title, "steps": [_record(s, eom) for s in steps]})
        return
    texts = [_latex(s, eom) if latex else step_text(s, eom, columns()) for s in steps]
    typer.echo("\n\n".join(text.rstrip() for text in texts))


def derived(model: NamedModel) -> kn.Equations:
    """The model's equations; shows progress if the derivation takes long."""
    with working("Deriving"), user_code(model.path, "System"):
        return kn.derive(model.system)


def inputs_at(inputs: Mapping[str, Any], t: float) -> dict[str, Any]:
    """The values of inputs at a time, with functions evaluated."""
    return {name: f(t) if callable(f) else f for name, f in inputs.items()}


def _record(step: Step, eom: kn.Equations) -> dict[str, Any]:
    if step.number == 1:  # step 1 has coordinates without formulas
        between, shown = [], [{"name": q.name, "text": "", "latex": symbol_latex(q)} for q in eom.coordinates]
    else:
        between, shown = (
            [{"name": f.name, "text": f.text, "latex": f.latex} for f in some]
            for some in result_formulas(step.results, eom.system.inertial)
        )
    head = {"number": step.number, "title": step.title, "text": step.text}
    return {**head, "intermediates": between, "formulas": shown}


def _latex(step: Step, eom: kn.Equations) -> str:
    head = f"% Step {step.number}. {step.title}"
    if step.number == 1:
        return f"{head}\n\\[ {', '.join(symbol_latex(q) for q in eom.coordinates)} \\]"
    between, shown = result_formulas(step.results, eom.system.inertial)
    lines = " \\\\\n".join(f"  {f.left} &= {f.right}" for f in (*between, *shown))
    return f"{head}\n\\begin{{align*}}\n{lines}\n\\end{{align*}}"


UNIT = "fmu"
Target: Any = StrEnum("Target", {name: name for name in (*EMITTERS, *BINARY, UNIT)})  # type: ignore[misc]  # rows of tables
"""The targets of `Compiled.emit`, and co-simulation units."""


def emit(
    name: Name,
    target: Annotated[
        Target,
        typer.Option(
            help="A language, a header or package file for it, or an FMU (FMI 3.0) with START as its start values.",
            show_default=False,
        ),
    ],
    out: Out = None,
    called: Annotated[
        str | None, typer.Option("--name", help="Base name of the emitted functions.", show_default="MODEL's")
    ] = None,
    with_integrator: Annotated[
        str | None,
        typer.Option(
            help=f"A complete simulation program with this integrator ({', '.join(SIMULATORS)}), in C for cc alone or in WebAssembly.",
            metavar="METHOD",
            show_default=False,
        ),
    ] = None,
    period: Annotated[
        float | None,
        typer.Option(
            help="With --with-integrator: sampling period at which a C function NAME_control sets the inputs.",
            metavar="SECONDS",
            show_default=False,
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Print the equations of MODEL as source of another language, whose head says how to call it, or write WebAssembly or an FMU."""
    _check_options(target, with_integrator, period, out)
    model = model_of(name)
    if called is not None and not (called.isidentifier() and called.isascii()):
        raise Misuse(f"Expected an identifier of letters, digits and _ as --name, got {called!r}.")
    place = screen.target(out, model.path, force) if out else None
    eom = derived(model)
    if place and target == UNIT:
        screen.write(
            place, lambda path: _write_unit(path, model, eom, called or unit_name(model.name), with_integrator), force
        )
        return
    with working("Compiling"):
        compiled = eom.compile(name=called or model.name)
        if with_integrator and target in BINARY:
            source: str | bytes = emit_simulator_wasm(compiled, with_integrator)
        else:
            source = (with_integrator and emit_simulator(compiled, with_integrator, period)) or compiled.emit(
                target.value
            )
    if place is None:
        typer.echo(source, nl=False)
    elif isinstance(source, str):
        screen.write(place, source, force)
    else:
        raw = source
        screen.write(place, lambda path: path.write_bytes(raw), force)


def _check_options(target: str, with_integrator: str | None, period: float | None, out: Path | None) -> None:
    """Raise Misuse for options that exclude each other."""
    if with_integrator is not None and target not in ("c", "wasm", UNIT):
        raise Misuse(f"Expected --target c, wasm or fmu with --with-integrator, got {target}.")
    if target == UNIT and (out is None or period is not None):
        raise Misuse("Expected --out FILE.fmu, and no --period, with --target fmu.")
    if target == UNIT:
        screen.ending(out, (".fmu",))
    if period is not None and (with_integrator is None or target != "c"):
        raise Misuse("Expected --target c and --with-integrator beside --period.")
    if target in BINARY and out is None and sys.stdout.isatty():
        raise Misuse("Expected --out FILE with --target wasm, a binary format, got a terminal.")


def _write_unit(path: Path, model: NamedModel, eom: kn.Equations, called: str, method: str | None) -> None:
    """Write a functional mock-up unit of a model with its START."""
    t = model.span[0]
    given = {kind: dict(model.start[kind]) for kind in KINDS if model.start.get(kind)}
    given["inputs"] = inputs_at(given.get("inputs", {}), t)
    with user_code(model.path, "START"):
        try:
            unit = to_fmu(eom, path, name=called, title=model.title, method=method or "dop853", t=t, **given)
        except ValueMissingError as error:
            raise Misuse(f"{error} See START of the model's file.") from error
    if not unit.binary:
        screen.say("No C compiler was found: the unit contains only its sources.")


cache_app = typer.Typer(cls=Guarded, no_args_is_help=True, help="Show or clear the cache of compiled code.")


@cache_app.command("info", cls=Command)
def _info() -> None:
    """Say where the cache is and how much is in it."""
    place = store.folder()
    if place is None:
        typer.echo("The cache is off (KANE_CACHE).")
        return
    count, size = store.size()
    screen.say(f"{place}: {_amount(count, size)} of at most {store.LIMIT / 2**20:.0f} MiB")


@cache_app.command("clear", cls=Command)
def _clear() -> None:
    """Remove all compiled code; it is compiled anew when needed."""
    typer.echo(f"Removed {_amount(*store.clear())}.")


def _amount(count: int, size: int) -> str:
    return f"{count} {'entry' if count == 1 else 'entries'}, {size / 2**20:.1f} MiB"
