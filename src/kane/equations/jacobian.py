# SPDX-License-Identifier: BSD-3-Clause
"""`eom.jacobian(…)`: the derivatives of the right-hand side as expressions, and the routines that are made of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.dynamics.derivatives.slopes import backward, forward, second, slopes
from kane.dynamics.derived import Derived
from kane.dynamics.lazy import read
from kane.dynamics.readings.programs import inverse_dynamics
from kane.dynamics.solved import Solved
from kane.errors import ArgumentError, cut
from kane.expr.count import Operations, count_operations
from kane.expr.immutable import Immutable
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Parameter, Symbol, rate, time
from kane.numeric.named import symbols_named
from kane.program.build import Task
from kane.program.program import Port


@dataclass(frozen=True, eq=False, repr=False)
class Jacobian(Immutable):
    """∂ẋ/∂(columns) of ẋ = (q̇, u̇) as functions of all coordinates, all speeds, time, inputs and parameters.

    `matrix` holds the expressions; `rows` are q̇ and u̇, `columns` what they are differentiated by. Where there are constraints, u̇ of
    all speeds are differentiated as they stand, each as a function of the whole state: along motions that the constraints allow,
    J δx is what the flow on them does.
    """

    rows: tuple[Symbol, ...]
    columns: tuple[Symbol, ...]
    matrix: Matrix

    @read
    def pattern(self) -> npt.NDArray[np.bool_]:
        """Which entries are not zero whatever the state (rows × columns)."""
        found = np.array([x is not ZERO for x in self.matrix.entries], dtype=bool).reshape(self.matrix.shape)
        found.flags.writeable = False
        return found

    @property
    def entries(self) -> Mapping[tuple[Symbol, Symbol], Expr]:
        """The entries of the pattern, by row and column."""
        places = np.argwhere(self.pattern).tolist()
        return {(self.rows[i], self.columns[j]): self.matrix[i, j] for i, j in places}

    operations = read[Operations](
        lambda j: count_operations(j.matrix.entries), "Operations of one evaluation of all entries together."
    )

    def __getitem__(self, place: tuple[int, int]) -> Expr:
        return self.matrix[place]

    def __repr__(self) -> str:
        n, m = self.matrix.shape
        return f"Jacobian({n} × {m}, {int(self.pattern.sum())} entries not zero, {self.operations.total} operations)"


Kinds = Mapping[str, Callable[[Derived], Sequence[Symbol]]]
_KINDS: Kinds = {
    "state": lambda d: (*d.system.coordinates, *d.speeds),
    "inputs": lambda d: d.system.inputs,
    "parameters": lambda d: d.system.parameters,
    "time": lambda d: (time,),
}


def jacobian(solved: Solved, by: Any) -> Jacobian:
    """See Equations.jacobian."""
    derived = solved.derived
    columns = _columns(derived, by)
    return Jacobian(_rows(derived), columns, slopes(solved, columns))


def _rows(derived: Derived) -> tuple[Symbol, ...]:
    return tuple(map(rate, (*derived.system.coordinates, *derived.speeds)))


def _columns(derived: Derived, by: Any) -> tuple[Symbol, ...]:
    if isinstance(by, str) and by in _KINDS:
        return tuple(_KINDS[by](derived))
    if isinstance(by, str | Symbol):
        by = [by]
    if not isinstance(by, list | tuple):
        kinds = ", ".join(map(repr, _KINDS))
        raise ArgumentError(f"Expected by= one of {kinds}, or a list of symbols and names, got {cut(repr(by))}.")
    every = [s for symbols in _KINDS.values() for s in symbols(derived)]
    return tuple(symbols_named("columns", every, by))


# Routines ----------------------------------------------------------------------------------------------------------------


def _whole(kind: str) -> Callable[[Solved], Task]:
    def task(solved: Solved) -> Task:
        columns = _KINDS[kind](solved.derived)
        rows, found = _rows(solved.derived), slopes(solved, columns)
        labels = [f"d({r.name})/d({c.name})" for r in rows for c in columns]
        return Task(_NAMES[kind], found.entries, found.shape, labels)

    return task


_NAMES = {"state": "jac", "inputs": "jac_inputs", "parameters": "jac_parameters", "time": "jac_time"}


def along(what: str, symbols: Sequence[Symbol]) -> tuple[Symbol, ...]:
    """A symbol beside each of these: the components of a vector."""
    return tuple(Parameter.declare(f"{what}_{s.name}", description=f"{what} of {s.name}") for s in symbols)


def _directions(derived: Derived) -> dict[str, tuple[Symbol, ...]]:
    x = _KINDS["state"](derived)
    return {"a": tuple(map(rate, derived.speeds)), "v": along("v", x), "w": along("w", x)}


def _product(name: str) -> Callable[[Solved], Task]:
    def task(solved: Solved) -> Task:
        x, own = _KINDS["state"](solved.derived), _directions(solved.derived)
        v, w = own["v"], own["w"]
        found: Mapping[str, Callable[[], Sequence[Expr]]] = {
            "jvp": lambda: forward(solved, x, v),
            "vjp": lambda: backward(solved, x, w),
            "hvp": lambda: second(solved, x, w, v),
        }
        labels = [f"(J v)[{r.name}]" if name == "jvp" else f"({name})[{r.name}]" for r in x]
        return Task(name, found[name](), (len(x),), labels)

    return task


def _inverse_dynamics(solved: Solved) -> Task:
    labels = [f"force of {u.name}" for u in solved.derived.speeds]
    return Task("inverse_dynamics", inverse_dynamics(solved), (len(labels),), labels)


DERIVATIVES: Mapping[str, Callable[[Solved], Task]] = {
    "inverse_dynamics": _inverse_dynamics,
    **{name: _whole(kind) for kind, name in _NAMES.items()},
    **{name: _product(name) for name in ("jvp", "vjp", "hvp")},
}
"""Routines that are made where they are asked for, by name: inverse dynamics, derivatives."""
_PORTS = {"inverse_dynamics": ("a",), "jvp": ("v",), "vjp": ("w",), "hvp": ("w", "v")}


def direction_ports(derived: Derived, routines: Sequence[str]) -> tuple[Port, ...]:
    """The ports that some routines have besides: u̇ as a, v beside x, w beside ẋ."""
    names = dict.fromkeys(p for r in routines for p in _PORTS.get(r, ()))
    nouns = {"a": ("acceleration", "accelerations"), "v": ("direction", "directions"), "w": ("weight", "weights")}
    own = _directions(derived) if names else {}
    return tuple(Port(p, own[p], noun=nouns[p][0], nouns=nouns[p][1]) for p in nouns if p in names)
