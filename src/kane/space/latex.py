# SPDX-License-Identifier: BSD-3-Clause
r"""LaTeX of the names of points, frames and unit vectors: C^{*}, \hat{b}_{x}."""

from __future__ import annotations

import re

from kane.space.rotation import Basis
from kane.write.latex import latex_name


def place_latex(name: str) -> str:
    r"""LaTeX of a frame's or point's name: C* is C^{*}, C^ is \hat{C}, B1* is B_{1}^{*}."""
    stem = name.rstrip("*^'")
    marks = name[len(stem) :]
    text = latex_name(stem) if stem else latex_name(name)
    if "^" in marks:
        text = rf"\hat{{{text}}}"
    raised = "*" * marks.count("*") + r"\prime" * marks.count("'")
    return f"{text}^{{{raised}}}" if raised else text


def unit_vector_latex(frame: Basis, axis: str) -> str:
    r"""\hat{b}_{x} of a frame B, \hat{b}_{1x} of a frame B1, \widehat{\mathrm{rod}}_{x} of a frame rod."""
    parts = re.fullmatch(r"([A-Za-z])([0-9]*)", frame.name)
    if parts:
        return rf"\hat{{{parts[1].lower()}}}_{{{parts[2]}{axis}}}"
    return rf"\widehat{{{latex_name(frame.name)}}}_{{{axis}}}"
