# SPDX-License-Identifier: BSD-3-Clause
"""A step of the method as text to read in a terminal."""

from kane.dynamics.readings.steps import Step
from kane.equations.equations import Equations
from kane.expr.symbols import Symbol
from kane.present.formulas import text_formulas
from kane.present.wrap import WIDTH, wrapped

_INDENT = 3


def step_text(step: Step, eom: Equations, *, width: int = WIDTH) -> str:
    """The step with one shared list of intermediates, lines of about `width` columns at most."""
    lines = [f"Step {step.number}. {step.title}", *wrapped(step.text, indent=_INDENT, hang=_INDENT, width=width)]
    if step.number == 1:
        return "\n".join([*lines, *(f"{'':{_INDENT}}{described(q)}" for q in eom.coordinates)])
    between, shown = text_formulas(step.results)
    if between:
        lines += _block(between, width)
        lines.append("")
    return "\n".join(lines + _block(shown, width))


def described(symbol: Symbol) -> str:
    """A symbol with its description and unit: `q1  yaw, rad`."""
    return f"{symbol.name}  {', '.join(w for w in (symbol.description, symbol.unit) if w)}".rstrip()


def _block(named: list[tuple[str, str]], width: int) -> list[str]:
    column = max((len(name) for name, _ in named), default=0)
    lines: list[str] = []
    for name, text in named:
        hang = _INDENT + column + 3
        lines += wrapped(f"{name:<{column}} = {text}", indent=_INDENT, hang=hang, width=width)
    return lines
