# SPDX-License-Identifier: BSD-3-Clause
r"""LaTeX of the names in the seven steps: `w_C` is {}^N\boldsymbol\omega^C, `v_C*,u1` is {}^N\mathbf v^{C^*}_{u_1}."""

from __future__ import annotations

from kane.equations.equations import Equations
from kane.space.frame import Frame
from kane.space.latex import place_latex
from kane.space.point import Point
from kane.write.latex import latex_name


def quantity_latex(letter: str, place: Frame | Point, inertial: Frame, speed: str = "") -> str:
    """LaTeX of a vector of a frame or point in the inertial frame; with a speed, of its partial velocity."""
    lower = f"_{{{latex_name(speed)}}}" if speed else ""
    return rf"{{}}^{{{place_latex(inertial.name)}}}{letter}^{{{place_latex(place.name)}}}{lower}"


def item_names(eom: Equations) -> dict[str, str]:
    """LaTeX by the name that an item has in `eom.steps`."""
    inertial = eom.system.inertial
    speeds = [s.name for s in (*eom.speeds, *eom.auxiliary_speeds)]
    found: dict[str, str] = {}
    kinds: list[tuple[str, str, tuple[Frame | Point, ...]]] = [
        ("w", r"\boldsymbol{\omega}", eom.frames),
        ("alpha", r"\boldsymbol{\alpha}", eom.frames),
        ("v", r"\mathbf{v}", eom.points),
        ("a", r"\mathbf{a}", eom.points),
    ]
    for kind, letter, places in kinds:
        for place in places:
            found[f"{kind}_{place.name}"] = quantity_latex(letter, place, inertial)
            if kind in ("w", "v"):
                for s in speeds:
                    found[f"{kind}_{place.name},{s}"] = quantity_latex(letter, place, inertial, s)
    for s in speeds:
        found[f"F_{s}"] = f"F_{{{latex_name(s)}}}"
        found[f"F*_{s}"] = f"F^{{*}}_{{{latex_name(s)}}}"
        found[f"~F_{s}"] = rf"\tilde{{F}}_{{{latex_name(s)}}}"
        found[f"~F*_{s}"] = rf"\tilde{{F}}^{{*}}_{{{latex_name(s)}}}"
        found[f"f[{s}]"] = f"f_{{{latex_name(s)}}}"
        for r in speeds:
            found[f"M[{s}, {r}]"] = rf"M_{{{latex_name(s)}\,{latex_name(r)}}}"
    for c in eom.constraints.constraints:
        found[f"(A u + b)[{c.name}]"] = rf"\left(A u + b\right)_{{{latex_name(c.name)}}}"
    return found
