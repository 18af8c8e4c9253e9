# SPDX-License-Identifier: BSD-3-Clause
"""Named groups of expressions that one routine computes, and gives back as a record of arrays with their shapes."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from kane.errors import ProgramError
from kane.expr.evaluation import compile_reference
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr
from kane.numeric.arrays import Array
from kane.program.build import Task
from kane.program.program import Port

R = TypeVar("R")


@dataclass(frozen=True, slots=True, eq=False)
class Shaped:
    """Expressions in row-major order of a shape."""

    shape: tuple[int, ...]
    roots: tuple[Expr, ...]


def shaped(what: Any) -> Shaped:
    """One expression (shape ()), a sequence (n,) or a Matrix (m, n)."""
    if isinstance(what, Shaped):
        return what
    if isinstance(what, Matrix):
        return Shaped(what.shape, tuple(what.entries))
    if isinstance(what, list | tuple):
        return Shaped((len(what),), tuple(as_expr(x) for x in what))
    return Shaped((), (as_expr(what),))


class Bundle(Generic[R]):
    """Groups of expressions of the symbols of `ports`: `record(*arrays)` is what their routine gives, in the order of the groups."""

    __slots__ = ("_places", "groups", "labels", "name", "ports", "record")

    def __init__(
        self,
        name: str,
        ports: Sequence[Port],
        record: Callable[..., R],
        groups: Mapping[str, Any],
        labels: Sequence[str] | None = None,
    ) -> None:
        names = [f.name for f in fields(record)] if is_dataclass(record) else getattr(record, "_fields", groups)
        if list(names) != list(groups):
            raise ProgramError(f"Expected the groups {', '.join(names)}, got {', '.join(groups)}.")
        self.name, self.ports, self.record = name, tuple(ports), record
        self.groups = {name: shaped(what) for name, what in groups.items()}
        self.labels = [x for n, g in self.groups.items() for x in _labels(n, g)] if labels is None else list(labels)
        self._places: list[tuple[slice, tuple[int, ...]]] = []
        end = 0
        for g in self.groups.values():
            start, end = end, end + math.prod(g.shape)
            self._places.append((slice(start, end), g.shape))

    @property
    def task(self) -> Task:
        """What its routine computes: all groups, one after the other."""
        roots = tuple(root for g in self.groups.values() for root in g.roots)
        return Task(self.name, roots, (len(roots),), self.labels)

    def split(self, values: Array) -> R:
        """The record of results (…, n): views of them, with their leading axes, then the shape of the group."""
        lead = values.shape[:-1]
        return self.record(*(values[..., place].reshape(lead + shape) for place, shape in self._places))

    def reference(self, leaves: Sequence[Expr]) -> Callable[[Sequence[Any]], R]:
        """A function from numbers for `leaves` to the record, on the reference evaluator: nothing is compiled."""
        run = compile_reference(self.task.roots, leaves)
        return lambda values: self.split(np.array(run(values), dtype=float))


def _labels(name: str, group: Shaped) -> list[str]:
    return [name] if group.shape == () else [f"{name}[{k}]" for k in range(len(group.roots))]
