# SPDX-License-Identifier: BSD-3-Clause
"""Colours of what is drawn, as the page has them: bodies in turn, and what is beside them by its role."""

from __future__ import annotations

from kane.present.viewer.parts import DrawnModel, DrawnPart

BODIES = ("#2563a8", "#0f766e", "#7c4dbd", "#b45309", "#be3a6e", "#567d0c")
ROLES = {"ground": "#6b7076", "constraint": "#70757a", "load": "#c2410c"}
PAPER, RULE, SHADOW, PATH = "#f4f4ef", "#cfcfc9", "#d3d3cd", "#b3266b"


def of_part(model: DrawnModel, part: DrawnPart) -> str:
    """The colour of a part."""
    if part.role != "body":
        return ROLES.get(part.role, ROLES["ground"])
    bodies = list(dict.fromkeys(p.name for p in model.parts if p.role == "body"))
    return BODIES[bodies.index(part.name) % len(BODIES)]
