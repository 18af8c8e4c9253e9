# SPDX-License-Identifier: BSD-3-Clause
"""`kane derive`: the seven steps with their formulas."""

from typing import Annotated, Any

import typer

import kane as kn
from kane.cli import screen
from kane.cli.faults import columns, own_code
from kane.cli.models import Model, model_of
from kane.cli.options import AsJson, Name
from kane.dynamics.readings.steps import Step
from kane.present.formula_list import result_formulas
from kane.present.text import step_text
from kane.progress import working
from kane.write.latex import latex_name


def derive(
    name: Name,
    latex: Annotated[bool, typer.Option("--latex", help="Print LaTeX.")] = False,
    step: Annotated[int | None, typer.Option(min=1, max=7, help="This step alone.", show_default="all")] = None,
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


def derived(model: Model) -> kn.Equations:
    """The model's equations; says so where they take long."""
    with working("Deriving"), own_code(model.path, "System"):
        return kn.derive(model.system)


def _record(step: Step, eom: kn.Equations) -> dict[str, Any]:
    if step.number == 1:  # it names the coordinates, and says nothing of them
        between, shown = [], [{"name": q.name, "text": "", "latex": latex_name(q.name)} for q in eom.coordinates]
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
        return f"{head}\n\\[ {', '.join(latex_name(q.name) for q in eom.coordinates)} \\]"
    between, shown = result_formulas(step.results, eom.system.inertial)
    lines = " \\\\\n".join(f"  {f.left} &= {f.right}" for f in (*between, *shown))
    return f"{head}\n\\begin{{align*}}\n{lines}\n\\end{{align*}}"
