# SPDX-License-Identifier: BSD-3-Clause
r"""LaTeX of the results of the seven steps: the angular velocity of C is {}^N\boldsymbol\omega^C."""

from __future__ import annotations

from kane.dynamics.readings.quantity import Kind, Quantity
from kane.space.frame import Frame
from kane.space.latex import place_latex
from kane.write.latex import latex_name

_VECTORS: dict[Kind, str] = {
    "angular velocity": r"\boldsymbol{\omega}",
    "partial angular velocity": r"\boldsymbol{\omega}",
    "angular acceleration": r"\boldsymbol{\alpha}",
    "velocity": r"\mathbf{v}",
    "partial velocity": r"\mathbf{v}",
    "acceleration": r"\mathbf{a}",
}
_SCALARS: dict[Kind, str] = {
    "constraint": r"\left(A u + b\right)_{{{place}}}",
    "F": "F_{{{speed}}}",
    "F*": "F^{{*}}_{{{speed}}}",
    "~F": r"\tilde{{F}}_{{{speed}}}",
    "~F*": r"\tilde{{F}}^{{*}}_{{{speed}}}",
    "M": r"M_{{{place}\,{speed}}}",
    "f": "f_{{{speed}}}",
}


def quantity_latex(quantity: Quantity, inertial: Frame) -> str:
    """LaTeX of a quantity; that of a symbol is its own."""
    place, speed = (x.name if x is not None else "" for x in (quantity.place, quantity.speed))
    letter, scalar = _VECTORS.get(quantity.kind), _SCALARS.get(quantity.kind)
    if letter is not None:
        lower = f"_{{{latex_name(speed)}}}" if speed else ""
        return rf"{{}}^{{{place_latex(inertial.name)}}}{letter}^{{{place_latex(place)}}}{lower}"
    return scalar.format(place=latex_name(place), speed=latex_name(speed)) if scalar else latex_name(str(quantity))
