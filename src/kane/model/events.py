# SPDX-License-Identifier: BSD-3-Clause
"""Events: a quantity that crosses a threshold during the motion."""

from dataclasses import dataclass

from kane.expr.node import Expr


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """`quantity` falls below (direction −1), rises above (+1) or crosses (0) `threshold`.

    A terminal event ends the simulation there; the solution returns what there is and names it.
    """

    name: str
    quantity: Expr
    threshold: float = 0.0
    direction: int = 0
    terminal: bool = True
    message: str = ""
