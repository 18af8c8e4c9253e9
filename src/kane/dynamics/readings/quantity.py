# SPDX-License-Identifier: BSD-3-Clause
"""What the results of the seven steps are, as records, and their names in plain text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from kane.expr.symbols import Symbol
from kane.model.constraints import Constraint
from kane.space.frame import Frame
from kane.space.point import Point


class Kind(Enum):
    """The kinds of results, each with its name in plain text."""

    SYMBOL = "{place}"
    RATE = "{place}'"
    CONSTRAINT = "(A u + b)[{place}]"
    ANGULAR_VELOCITY = "w_{place}"
    PARTIAL_ANGULAR_VELOCITY = "w_{place},{speed}"
    ANGULAR_ACCELERATION = "alpha_{place}"
    VELOCITY = "v_{place}"
    PARTIAL_VELOCITY = "v_{place},{speed}"
    ACCELERATION = "a_{place}"
    ACTIVE_FORCE = "F_{place}"
    INERTIA_FORCE = "F*_{place}"
    NONHOLONOMIC_ACTIVE_FORCE = "~F_{place}"
    NONHOLONOMIC_INERTIA_FORCE = "~F*_{place}"
    MASS = "M[{place}, {speed}]"
    FORCING = "f[{place}]"


@dataclass(frozen=True, slots=True)
class Quantity:
    """A result of a step: its kind, what it belongs to (of F_r, M_rs and f_r the speed r), and the other speed, if it has one."""

    kind: Kind
    place: Frame | Point | Constraint | Symbol
    speed: Symbol | None = None

    def named(self, form: str, written: Callable[[str], str] = str) -> str:
        """`form` with the names of place and speed, as `written` writes them."""
        return form.format(
            place=written(self.place.name), speed=written(self.speed.name if self.speed is not None else "")
        )

    def __str__(self) -> str:
        return self.named(self.kind.value)
