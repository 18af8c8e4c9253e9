# SPDX-License-Identifier: BSD-3-Clause
"""What the results of the seven steps are, as records, and their names in plain text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from kane.expr.symbols import Symbol
from kane.model.constraints import Constraint
from kane.space.frame import Frame
from kane.space.point import Point

Kind = Literal[
    "coordinate", "rate", "speed", "reaction", "constraint",
    "angular velocity", "partial angular velocity", "angular acceleration", "velocity", "partial velocity", "acceleration",
    "F", "F*", "~F", "~F*", "M", "f",
]  # fmt: skip

_NAMES: dict[Kind, str] = {
    "coordinate": "{place}",
    "rate": "{place}'",
    "speed": "{place}",
    "reaction": "{place}",
    "constraint": "(A u + b)[{place}]",
    "angular velocity": "w_{place}",
    "partial angular velocity": "w_{place},{speed}",
    "angular acceleration": "alpha_{place}",
    "velocity": "v_{place}",
    "partial velocity": "v_{place},{speed}",
    "acceleration": "a_{place}",
    "F": "F_{speed}",
    "F*": "F*_{speed}",
    "~F": "~F_{speed}",
    "~F*": "~F*_{speed}",
    "M": "M[{place}, {speed}]",
    "f": "f[{speed}]",
}


@dataclass(frozen=True, slots=True)
class Quantity:
    """A result of a step: its kind, what it belongs to, and the speed for which it is taken, where there is one.

    Of M_rs, `place` is the speed r and `speed` s.
    """

    kind: Kind
    place: Frame | Point | Constraint | Symbol | None = None
    speed: Symbol | None = None

    def __str__(self) -> str:
        place, speed = (x.name if x is not None else "" for x in (self.place, self.speed))
        return _NAMES[self.kind].format(place=place, speed=speed)
