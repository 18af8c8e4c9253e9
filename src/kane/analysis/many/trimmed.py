# SPDX-License-Identifier: BSD-3-Clause
"""`trim` at many states: the branch of steady motions of the first followed along the arrays.

Which conditions apply is decided at the first. A steady motion is one where what is left of them is within the tolerance. Where
conditions do not determine all that may move, or something switches, each is looked for by itself.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from kane.analysis.many.following import Unknowns, follow
from kane.analysis.many.poses import Poses
from kane.equations.state import GROUPS, Guess, State
from kane.errors import KaneError, SimulationError
from kane.expr.symbols import Symbol, time
from kane.numeric.arrays import Array
from kane.program.native.compiled_routine import CompiledRoutine

_TOLD = 4


class SteadyEquations(NamedTuple):
    """Conditions to follow from X at the start, which of X is `free`, its `symbols`, and their places in a row of data after t.

    Of `routine` z = (u̇, λ, R) is unknown too, behind what is free, and `last` at the start. `left` gives the largest share that is
    left of the conditions at each X (k × …); no more than `tolerance` may be.
    """

    start: Array
    free: Sequence[int]
    symbols: Sequence[Symbol]
    places: Sequence[int]
    routine: CompiledRoutine
    unknowns: Unknowns
    last: Array
    left: Callable[[Array], Array]
    tolerance: float


class Routes(NamedTuple):
    """How the kth is found by itself, and what to follow from the X that it has, None where that cannot be."""

    alone: Callable[[int], State]
    followed: Callable[[int, Array], SteadyEquations | None]


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
        task = routes.followed(start, x[start])
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


def _follow(poses: Poses, task: SteadyEquations, places: tuple[Array, int], causes: dict[int, str]) -> None:
    """X of all (k × …) that the branch of the one at `start` leads to."""
    (x, start), free = places, list(task.free)
    whole = np.tile(task.start, (poses.count, 1))
    for i, s in enumerate(task.symbols):
        for kind in GROUPS:
            if s in poses.instances.columns[kind]:
                whole[:, i] = poses.instances.columns[kind][s]
    order = [k for k in poses.open if k >= start]
    data = np.zeros((len(order), 1 + sum(len(port.symbols) for port in task.routine.program.ports[1:])))
    data[:, 0] = poses.given("t")[time]
    data[:, 1 + np.array(task.places)] = whole[order]
    found = follow(task.routine, data, np.concatenate([x[start, free], task.last]), task.unknowns)
    ended = np.array([row in found.ends for row in range(len(order))])
    for row, k in enumerate(order):
        end = found.ends.get(row)
        whole[k, free] = (found.x[row] if end is None else end.x)[: len(free)]
    there = np.array(order)[~ended]
    steady = dict(zip(there.tolist(), (task.left(whole[there]) <= task.tolerance).tolist(), strict=True))
    for row, k in enumerate(order):
        end = found.ends.get(row)
        if steady.get(k, False):
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
