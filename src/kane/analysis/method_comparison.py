# SPDX-License-Identifier: BSD-3-Clause
"""`compare_methods`: one system by Kane's method and by others, and what each costs."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from kane import show
from kane.dynamics.methods.formulation import Formulation
from kane.dynamics.methods.table import METHODS
from kane.equations.derive import derive
from kane.equations.equations import Equations
from kane.errors import Attributes, ModelError, alike, cut, none_of
from kane.model.system import System


@dataclass(frozen=True, eq=False, repr=False)
class MethodComparison(Attributes):
    """Formulations of one system side by side; `comparison[name]` is one of them. `refused` says why a method does not take it."""

    formulations: dict[str, Formulation]
    refused: dict[str, str]

    @property
    def shortest(self) -> str:
        """The method with the fewest operations, the first of several."""
        return min(self.formulations, key=lambda name: self.formulations[name].operations.total)

    def __iter__(self) -> Iterator[str]:
        return iter(self.formulations)

    def __getitem__(self, name: str) -> Formulation:
        if name in self.refused:
            raise ModelError(self.refused[name])
        if name not in self.formulations:
            raise ModelError(f"Expected one of {none_of(self.formulations, name)}")
        return self.formulations[name]

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Head and rows, as text."""
        head = "method", "operations", "unknowns", "state", "eliminated"
        rows = [
            (
                name,
                str(f.operations.total),
                str(len(f.unknowns)),
                str(len(f.state)),
                "; ".join(f.eliminated) or "nothing",
            )
            for name, f in self.formulations.items()
        ]
        return head, [*rows, *((name, "–", "–", "–", cut(why, 100)) for name, why in self.refused.items())]

    def __repr__(self) -> str:
        return show.columns(*self.table())

    _repr_html_ = show.html


def compare_methods(system: System | Equations, methods: Sequence[str] = METHODS) -> MethodComparison:
    """The system by each of the methods that take it: operations of its right-hand side, unknowns, what had to be eliminated.

    Parameters
    ----------
    system : System, or its Equations
    methods : names that `eom.by` takes; by default all

    Raises
    ------
    ModelError
        if a method has another name
    """
    given: object = system
    if not isinstance(given, System | Equations):
        raise ModelError(f"Expected a System or its Equations, got {cut(repr(given))}.")
    wanted: Any = methods
    if isinstance(wanted, str) or not isinstance(wanted, Iterable):
        methods = (wanted,)
    names: Iterable[object] = methods
    for name in names:
        if not isinstance(name, str) or name not in METHODS:
            hint = alike(str(name), list(METHODS))
            raise ModelError(f"Expected methods among {', '.join(map(repr, METHODS))}, got {cut(repr(name))}.{hint}")
    eom = derive(system) if isinstance(system, System) else system
    found, refused = dict[str, Formulation](), dict[str, str]()
    for name in methods:
        try:
            found[name] = eom.by(name)
            _ = found[name].operations
        except ModelError as error:
            found.pop(name, None)
            refused[name] = str(error)
    return MethodComparison(found, refused)
