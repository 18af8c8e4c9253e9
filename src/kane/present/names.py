# SPDX-License-Identifier: BSD-3-Clause
r"""LaTeX of the results of the seven steps: the angular velocity of C is {}^N\boldsymbol\omega^C."""

from kane.dynamics.readings.steps import Kind, Quantity, Step
from kane.present.formulas import Formula, formulas
from kane.space.frame import Frame
from kane.write.latex import latex_name, place_latex

_VECTORS = {
    Kind.ANGULAR_VELOCITY: r"\boldsymbol{\omega}",
    Kind.PARTIAL_ANGULAR_VELOCITY: r"\boldsymbol{\omega}",
    Kind.ANGULAR_ACCELERATION: r"\boldsymbol{\alpha}",
    Kind.VELOCITY: r"\mathbf{v}",
    Kind.PARTIAL_VELOCITY: r"\mathbf{v}",
    Kind.ACCELERATION: r"\mathbf{a}",
}
_SCALARS = {
    Kind.CONSTRAINT: r"\left(A u + b\right)_{{{place}}}",
    Kind.ACTIVE_FORCE: "F_{{{place}}}",
    Kind.INERTIA_FORCE: "F^{{*}}_{{{place}}}",
    Kind.NONHOLONOMIC_ACTIVE_FORCE: r"\tilde{{F}}_{{{place}}}",
    Kind.NONHOLONOMIC_INERTIA_FORCE: r"\tilde{{F}}^{{*}}_{{{place}}}",
    Kind.MASS: r"M_{{{place}\,{speed}}}",
    Kind.FORCING: "f_{{{place}}}",
}


def quantity_latex(quantity: Quantity, inertial: Frame) -> str:
    """LaTeX of a quantity; that of a symbol is its own."""
    if quantity.kind in _SCALARS:
        return quantity.named(_SCALARS[quantity.kind], latex_name)
    letter = _VECTORS.get(quantity.kind)
    if letter is None:
        return latex_name(str(quantity))
    lower = f"_{{{latex_name(quantity.speed.name)}}}" if quantity.speed is not None else ""
    return rf"{{}}^{{{place_latex(inertial.name)}}}{letter}^{{{place_latex(quantity.place.name)}}}{lower}"


def step_formulas(step: Step, inertial: Frame) -> tuple[list[Formula], list[Formula]]:
    """A step's shared intermediates, and a formula for each of its results."""
    return formulas(step.results, lambda quantity: quantity_latex(quantity, inertial))
