# SPDX-License-Identifier: BSD-3-Clause
"""What is asked of a linearization besides the flow: named outputs h(q, u, u̇, λ, R, r), and their derivatives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from kane.analysis.local import unknowns
from kane.dynamics.readings.unsolved import partials
from kane.dynamics.readings.values import asked
from kane.equations.equations import Equations
from kane.equations.routines import ports
from kane.errors import ArgumentError, ValueMissingError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import time
from kane.expr.visit import substituted
from kane.numeric.arrays import Array
from kane.program.bundle import Bundle


@dataclass(frozen=True, slots=True, eq=False)
class Outputs:
    """Named expressions of q, u, u̇, λ, R, inputs and t."""

    names: tuple[str, ...]
    roots: tuple[Expr, ...]


def outputs_of(eom: Equations, outputs: Mapping[str, Any] | Sequence[Any] | None) -> Outputs:
    """The outputs with every rate written in speeds; a sequence is named by its expressions."""
    if outputs is None:
        return Outputs((), ())
    pairs = outputs.items() if isinstance(outputs, Mapping) else [(e, e) for e in _listed(outputs)]
    names, roots = [], []
    for key, e in pairs:
        name = str(key)
        try:
            wanted = asked(eom.derived, e)
        except TypeError as error:
            raise ArgumentError(
                f"Expected an expression, vector or name as the output {name!r}, got {cut(repr(e))}."
            ) from error
        if wanted.shape not in ((), (3,)) or wanted.parts is not None:
            raise ArgumentError(f"Expected an expression, vector or name as the output {name!r}, got {cut(repr(e))}.")
        names += [f"{name}.{axis}" for axis in "xyz"] if wanted.shape else [name]
        roots += [substituted(eom.in_speeds(root), dict.fromkeys(eom.auxiliary_speeds, ZERO)) for root in wanted.roots]
    allowed = {time, *eom.state, *eom.parameters, *eom.inputs, *unknowns(eom).symbols}
    unknown = [str(s) for s in free_symbols(roots) if s not in allowed]
    if unknown:
        raise ValueMissingError(
            f"Expected outputs in symbols of the system, got {', '.join(unknown)}. A reaction must be listed in System(reactions=…)."
        )
    return Outputs(tuple(names), tuple(roots))


def _listed(outputs: Any) -> Sequence[Any]:
    if isinstance(outputs, str | Expr) or not isinstance(outputs, Sequence):
        raise ArgumentError(f"Expected outputs as a list or a dict {{name: expression}}, got {cut(repr(outputs))}.")
    return outputs


class Answers(NamedTuple):
    """h, and ∂h/∂(q, u, a, r, z), a row for each output."""

    values: Array
    slopes: Array


def answers(eom: Equations, *roots: Expr) -> Bundle[Answers]:
    """Outputs h and their derivatives; z is an argument."""
    z = unknowns(eom)
    slopes = partials(roots, (*eom.state, *eom.inputs, *z.symbols))
    return Bundle("outputs", (*ports(eom.derived), z), Answers, {"values": roots, "slopes": slopes})
