# SPDX-License-Identifier: BSD-3-Clause
"""`kane derive`: the seven steps with their formulas."""

from typing import Annotated, Any

import typer

import kane as kn
from kane.cli import screen
from kane.cli.faults import own_code
from kane.cli.models import Model, model_of
from kane.cli.options import AsJson, Name
from kane.dynamics.readings.steps import Step
from kane.present.formulas import Formula, formulas
from kane.present.names import quantity_latex
from kane.present.text import step_text
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
    texts = [_latex(s, eom) if latex else step_text(s, eom) for s in steps]
    typer.echo("\n\n".join(text.rstrip() for text in texts))


def derived(model: Model) -> kn.Equations:
    """The model's equations; says so where they take long."""
    with screen.working("Deriving"), own_code(model.path, "System"):
        return kn.derive(model.system)


def _written(step: Step, eom: kn.Equations) -> tuple[list[Formula], list[Formula]]:
    """The step's intermediates and formulas; what it only names stands as a name without a right side."""
    if step.number == 1:
        return [], [Formula(q.name, "", latex_name(q.name), "") for q in eom.coordinates]
    return formulas(step.results, lambda quantity: quantity_latex(quantity, eom.system.inertial))


def _record(step: Step, eom: kn.Equations) -> dict[str, Any]:
    between, shown = _written(step, eom)
    return {
        "number": step.number,
        "title": step.title,
        "text": step.text,
        "intermediates": [_formula(f) for f in between],
        "formulas": [_formula(f) for f in shown],
    }


def _formula(f: Formula) -> dict[str, str]:
    return {"name": f.name, "text": f.text, "latex": f.latex if f.right else f.left}


def _latex(step: Step, eom: kn.Equations) -> str:
    between, shown = _written(step, eom)
    head = f"% Step {step.number}. {step.title}"
    if not any(f.right for f in shown):
        return f"{head}\n\\[ {', '.join(f.left for f in shown)} \\]"
    lines = " \\\\\n".join(f"  {f.left} &= {f.right}" for f in (*between, *shown))
    return f"{head}\n\\begin{{align*}}\n{lines}\n\\end{{align*}}"
