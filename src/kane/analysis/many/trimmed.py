# SPDX-License-Identifier: BSD-3-Clause
"""`trim` at many states: the branch of steady motions of the first followed along the arrays.

Which conditions apply is decided at the first. A steady motion is one where what is left of them is within the tolerance. Where
conditions do not determine all that may move, or something switches, each is looked for by itself.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from kane.analysis.many.poses import Poses
from kane.dynamics.constraints.partition import choose
from kane.equations.state import GROUPS, Guess, State
from kane.errors import KaneError, SimulationError
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.numeric.following import follow

_TOLD = 4


class Followed(NamedTuple):
    """Conditions to follow: X at the start, which of it is `free`, its `symbols` and sizes; F and ∂F/∂X_free, whether F is zero."""

    start: Array
    free: Sequence[int]
    symbols: Sequence[Symbol]
    sizes: Array
    square: Callable[[Array], tuple[Array, Array]]
    holds: Callable[[Array], bool]


class Routes(NamedTuple):
    """How the kth is found by itself, and what to follow from it, None where that cannot be."""

    alone: Callable[[int], State]
    followed: Callable[[int], Followed | None]


def trimmed(poses: Poses, routes: Routes) -> Any:
    """The steady motions as a Dataset."""
    eom, causes = poses.eom, dict(poses.failed)
    found: dict[int, State] = {}
    for start in poses.open:
        try:
            found[start] = routes.alone(start)
            break
        except SimulationError as error:
            causes[start] = str(error)
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs, *eom.parameters)
    x = np.full((poses.count, len(symbols)), np.nan)
    if found:
        (start,) = found
        x[start] = [found[start][s] for s in symbols]
        task = routes.followed(start)
        if task is not None:
            _follow(poses, task, (x, start), causes)
    for k in [k for k in poses.open if k not in causes and np.isnan(x[k]).any()]:
        try:
            one = routes.alone(k)
        except KaneError as error:
            causes[k] = str(error)
            continue
        x[k] = [one[s] for s in symbols]
    x[list(causes)] = np.nan
    return _dataset(poses, symbols, x, causes)


def _follow(poses: Poses, task: Followed, places: tuple[Array, int], causes: dict[int, str]) -> None:
    """X of all (k × …) that the branch of the one at `start` leads to."""
    (x, start), free = places, list(task.free)
    first = x[start].copy()
    _, j = task.square(first)
    rows = sorted(choose(j * task.sizes[free]).rows) if free else []
    if len(rows) < len(free):
        return
    whole = np.tile(task.start, (poses.count, 1))
    for i, s in enumerate(task.symbols):
        for kind in GROUPS:
            if s in poses.instances.columns[kind]:
                whole[:, i] = poses.instances.columns[kind][s]
    given = [i for i in range(len(first)) if i not in set(free)]
    order = [k for k in poses.open if k >= start]
    at = first.copy()

    def function(y: Array, data: Array) -> tuple[Array, Array]:
        at[free], at[given] = y, data
        f, j = task.square(at)
        return f[rows], j[rows]

    with np.errstate(invalid="ignore", divide="ignore"):
        found = follow(function, whole[order][:, given], first[free], task.sizes[free])
    for row, k in enumerate(order):
        end = found.ends.get(row)
        whole[k, free] = found.x[row] if end is None else end.x
        if end is None and task.holds(whole[k]):
            x[k] = whole[k]
            continue
        at_end = ", ".join(f"{task.symbols[i].name} = {whole[k, i]:.6g}" for i in free[:_TOLD])
        way = f" on the way from instance {order[end.last]}" if end is not None else ""
        causes[k] = (
            f"Expected a steady motion that the branch of the others leads to, got its end{way}, near {at_end}: there it meets "
            "another one, or the equations are singular. Trim what lies beyond by itself, from guesses."
        )


def _dataset(poses: Poses, symbols: Sequence[Symbol], x: Array, causes: dict[int, str]) -> Any:
    eom = poses.eom
    state = set(eom.state)
    given = {s: v for kind in ("inputs", "parameters") for s, v in poses.given(kind).items()}
    shown = [i for i, s in enumerate(symbols) if s in state or isinstance(given.get(s), Guess)]
    own = poses.variables([symbols[i] for i in shown], x[:, shown].T)
    return poses.dataset(own, causes, {})
