# SPDX-License-Identifier: BSD-3-Clause
"""What a method gives: equations in its own unknowns and variables, solved, and u̇ from them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from kane import show
from kane.dynamics.lazy import read
from kane.expr.count import Operations, count_operations
from kane.expr.immutable import Immutable
from kane.expr.node import Expr

Exprs = tuple[Expr, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Formulation(Immutable):
    """The equations of motion of a system by one method.

    `equations`, each of which is zero, hold the `unknowns`; solved they give the rates of the method's own `state`, `right_hand_side`.
    `eliminated` says what had to be eliminated for that. `accelerations` are the u̇ that follow for the declared generalized speeds,
    in q and u, by which methods are compared.
    """

    method: str
    source: str
    state: Exprs
    unknowns: Exprs
    eliminated: tuple[str, ...]
    equations_by: Callable[[], Exprs]
    right_hand_side_by: Callable[[], Exprs]
    accelerations_by: Callable[[], Exprs]

    equations = read[Exprs](lambda f: f.equations_by(), "What must vanish, in the unknowns.")
    right_hand_side = read[Exprs](lambda f: f.right_hand_side_by(), "The rates of the state.")
    accelerations = read[Exprs](lambda f: f.accelerations_by(), "u̇ of the declared generalized speeds, in q and u.")
    operations = read[Operations](
        lambda f: count_operations(f.right_hand_side), "Operations of one evaluation of the right-hand side."
    )

    def __reduce__(self) -> tuple[Callable[..., "Formulation"], tuple[Any, ...]]:
        written = (self.equations, self.right_hand_side, self.accelerations)
        return _restored, (self.method, self.source, self.state, self.unknowns, self.eliminated, written)

    def __repr__(self) -> str:
        gone = f"; eliminated: {', '.join(self.eliminated)}" if self.eliminated else ""
        return f"Formulation({self.method}: {len(self.unknowns)} unknowns{gone})"

    def __str__(self) -> str:
        lines = [f"0 = {e}" for e in self.equations]
        return "\n".join([f"{self.method} ({self.source}), in {', '.join(map(str, self.unknowns))}", *lines])

    _repr_html_ = show.html


def _restored(
    method: str, source: str, state: Exprs, unknowns: Exprs, gone: tuple[str, ...], written: Sequence[Exprs]
) -> Formulation:
    equations, right_hand_side, accelerations = written
    return Formulation(
        method, source, state, unknowns, gone, lambda: equations, lambda: right_hand_side, lambda: accelerations
    )
