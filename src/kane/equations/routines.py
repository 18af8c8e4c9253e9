# SPDX-License-Identifier: BSD-3-Clause
"""The routines of equations of motion, as Programs over t, x = (q, u), p and r."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from kane.dynamics.derived import Derived
from kane.dynamics.readings.values import without_unknowns
from kane.dynamics.solved import Solved
from kane.errors import ArgumentError, ValueMissingError
from kane.expr.evaluate import free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import time
from kane.program.build import Wanted, build_program
from kane.program.program import Port, Program
from kane.space.vector import Vector

ROUTINES = ("rhs", "mass_matrix", "forcing", "reactions")
"""What every set of equations has; "outputs" comes with the user's own expressions."""
SUBJECT = "equations of motion"


def ports(derived: Derived) -> tuple[Port, ...]:
    """t, x (coordinates, then speeds), p (parameters), r (inputs)."""
    system = derived.system
    return (
        Port("t", (time,), scalar=True, noun="time"),
        Port("x", (*system.coordinates, *derived.speeds), noun="state", nouns="states"),
        Port("p", system.parameters, "parameter", noun="parameters"),
        Port("r", system.inputs, noun="inputs", optional=True),
    )


def program(
    solved: Solved,
    routines: Sequence[str] = ROUTINES,
    outputs: Sequence[Output] = (),
    *,
    name: str = "model",
    reciprocals: bool = True,
) -> Program:
    """The Program of the named routines, and of "outputs" where there are any.

    "rhs" gives ẋ = (q̇, u̇), "mass_matrix" M, "forcing" f of M u̇ = f with the reactions at their solved values, "reactions" those
    values. `reciprocals` lets divisions by one divisor share its reciprocal, which rounds differently.
    """
    unknown = [r for r in routines if r not in ROUTINES]
    if unknown:
        known = ", ".join([*ROUTINES, *(["outputs"] if outputs else [])])
        raise ArgumentError(f"Expected routines among {known}, got {', '.join(map(repr, unknown))}.")
    wanted = [_routine(solved, routine) for routine in dict.fromkeys(routines)]
    if outputs:
        roots = [root for output in outputs for root in output.roots]
        labels = [label for output in outputs for label in output.labels]
        wanted.append(Wanted("outputs", roots, (len(roots),), labels))
    return build_program(name, ports(solved.derived), wanted, reciprocals, SUBJECT)


def rate_names(derived: Derived) -> list[str]:
    """Names of ẋ = (q̇, u̇)."""
    return [f"{s.name}'" for s in (*derived.system.coordinates, *derived.speeds)]


def _routine(solved: Solved, name: str) -> Wanted:
    derived, n = solved.derived, len(solved.derived.speeds)
    if name == "rhs":
        labels = rate_names(derived)
        return Wanted(name, solved.right_hand_side, (len(labels),), labels)
    if name == "mass_matrix":
        labels = [f"M[{i + 1},{j + 1}]" for i in range(n) for j in range(n)]
        return Wanted(name, without_unknowns(solved, derived.blocks.mass.entries), (n, n), labels)
    if name == "forcing":
        return Wanted(name, without_unknowns(solved, derived.forcing), (n,), [f"f[{i + 1}]" for i in range(n)])
    return Wanted(name, solved.reactions, (len(derived.reactions),), [r.name for r in derived.reactions])


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """A named output: expressions in row-major order of its shape."""

    name: str
    shape: tuple[int, ...]
    roots: tuple[Expr, ...]

    @property
    def labels(self) -> list[str]:
        """A name for each expression."""
        return [self.name] if self.shape == () else [f"{self.name}[{k}]" for k in range(len(self.roots))]


def resolved(solved: Solved, outputs: Mapping[Any, Any]) -> tuple[Output, ...]:
    """The outputs as functions of q, u, t, parameters and inputs; a vector's measure numbers are along the inertial frame.

    Raises
    ------
    ArgumentError
        if a name is not text, or an output is no expression, Vector, Matrix or sequence of expressions
    ValueMissingError
        if an output holds a symbol that is not the system's
    """
    if not isinstance(outputs, Mapping):
        raise ArgumentError(f"Expected outputs as a mapping from names to expressions, got {type(outputs).__name__}.")
    found = []
    for name, what in outputs.items():
        if not isinstance(name, str) or not name.strip():
            raise ArgumentError(f"Expected a name for every output, got {name!r}.")
        shape, parts = _parts(solved, name, what)
        roots = tuple(without_unknowns(solved, parts))
        known: set[Expr] = {s for port in ports(solved.derived) for s in port.symbols}
        unknown = [f"{s} ({type(s).__name__})" for s in free_symbols(roots) if s not in known]
        if unknown:
            raise ValueMissingError(
                f"Expected the output {name!r} in symbols of the system, got {', '.join(unknown)} in it. A reaction must be "
                "listed in System(reactions=…)."
            )
        found.append(Output(name, shape, roots))
    return tuple(found)


def _parts(solved: Solved, name: str, what: Any) -> tuple[tuple[int, ...], list[Expr]]:
    if isinstance(what, Vector):
        return (3,), list(what.components(solved.derived.system.inertial))
    if isinstance(what, Matrix):
        return what.shape, list(what.entries)
    try:
        if isinstance(what, list | tuple):
            return (len(what),), [as_expr(x) for x in what]
        return (), [as_expr(what)]
    except TypeError as error:
        raise ArgumentError(
            f"Expected an expression, Vector, Matrix or a sequence of expressions as output {name!r}, got {what!r:.60}."
        ) from error
