# SPDX-License-Identifier: BSD-3-Clause
"""`linearize` at many states: A and B of all states at once where possible, otherwise state by state.

The independent perturbations of the first state are those of all states. At once means the implicit function theorem of
`kane.analysis.perturbations` on stacks of matrices; a state in doubt, by rank, constraints or values that are not finite, is
linearized by itself.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from kane.analysis.linear import Linear
from kane.analysis.local import Outputs, Values, all_switches, answers, coded, regular_rows, slopes, values
from kane.analysis.many.poses import Poses
from kane.analysis.one_sided import lengths
from kane.analysis.perturbations import Tangents, perturbations
from kane.analysis.stacks import Entries, Stack, solve_each
from kane.analysis.state_checks import StateArrays
from kane.dynamics.constraints.partition import choose
from kane.equations.compiled import Numeric
from kane.equations.datasets import package
from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.numeric.arrays import Array, Mask, blocks
from kane.numeric.scale import NEAR_SINGULAR, ROUNDED_CHAIN
from kane.program.native.machine import Settings

PARTS = {"A": "A", "B": "B", "C": "C", "D": "D", "rates": "rates", "values": "output_values"}
"""Arrays of a `Linear`, with their names in a Dataset, in which `values` is already a method."""
_TINY = np.finfo(float).tiny


def linearized(
    poses: Poses,
    numeric: Numeric[Equations],
    outputs: Outputs,
    alone: Callable[[int, Sequence[str]], Linear],
    leave_out: Sequence[str],
    together: bool,
) -> Any:
    """A, B, C, D, rates and output values of all states as a Dataset, without the states `leave_out`.

    `alone` linearizes state k by itself with named independent perturbations; `together` allows all states at once.
    """

    def begun(k: int) -> tuple[Linear, Linear]:
        whole = alone(k, ())
        return whole, whole.without(*leave_out)

    causes = dict(poses.failed)
    place = poses.first(begun, causes, (SimulationError, ArithmeticError))
    if place is None:
        raise SimulationError(f"Expected a state to linearize about, got none of {poses.count}. {causes[0]}")
    whole_first, first = place[1]
    names = [s for s in whole_first.states if s not in whole_first.further]
    gone = [s for s in whole_first.states if s not in first.states]
    found = {part: np.full((poses.count, *getattr(first, part).shape), np.nan) for part in PARTS}
    sure = np.zeros(poses.count, dtype=bool)
    if together and is_plain(numeric, outputs):
        sure = _together(poses, numeric, outputs, first, found)
    for k, own in poses.rest(lambda k: alone(k, names).without(*gone), causes, set(np.flatnonzero(sure))):
        for part, whole in found.items():
            whole[k] = getattr(own, part)
    for whole in found.values():
        whole[list(causes)] = np.nan
    return _dataset(poses, first, found, causes)


def is_plain(numeric: Numeric[Equations], outputs: Outputs) -> bool:
    """Whether there are no switches, lengths, false poles or Euler parameters."""
    tables = (numeric.value(make, *outputs.roots) for make in (all_switches, lengths))
    return numeric.equations.solved.twin is None and not numeric.value(perturbations).sets and not any(tables)


def _together(
    poses: Poses, numeric: Numeric[Equations], outputs: Outputs, first: Linear, found: Mapping[str, Array]
) -> Mask:
    """Fill the arrays `found` for all states, and return where they are reliable."""
    t, p, r = poses.numbers()
    state, sure, chosen = (t, _states(poses), p, r), np.zeros(poses.count, dtype=bool), dict[str, list[int]]()
    for at in blocks(poses.count):
        part = {name: whole[at] for name, whole in found.items()}
        sure[at] = _of_block(numeric, outputs, first, tuple(x[at] for x in state), part, chosen)
    return sure


def _of_block(
    numeric: Numeric[Equations],
    outputs: Outputs,
    first: Linear,
    state: tuple[Array, ...],
    found: Mapping[str, Array],
    chosen: dict[str, list[int]],
) -> Mask:
    """As `_together`, for a block of states; rows for dependent variables are stored in `chosen` at the first block."""
    eom, run, count = numeric.equations, coded(numeric), len(state[0])
    nq, n, keep = len(eom.coordinates), len(eom.speeds), list(regular_rows(eom))
    own, solved, sure = _solved(numeric, keep, state)
    z = np.zeros(own.right.shape)
    z[:, keep] = np.where(sure[:, None], solved.x[:, :, 0], 0.0)
    sloped = run(slopes)(*state, z)
    sure &= _placed(eom, own, state)
    free_q = [i for i, q in enumerate(eom.coordinates) if q.name in first.coordinates]
    free_u = [i for i, u in enumerate(eom.speeds) if u.name in first.speeds]
    by_free = partial(_by_free, settings=numeric.settings, kept=chosen)
    of_q, sure_q = by_free("q", sloped.configuration, range(nq), free_q, range(nq + n, sloped.configuration.shape[2]))
    shift = sloped.motion[:, :, :nq] @ of_q
    shift[:, :, len(free_q) :] += sloped.motion[:, :, nq + n :]
    whole = np.concatenate([sloped.motion[:, :, nq : nq + n], shift], axis=2)
    of_u, sure_u = by_free("u", whole, range(n), free_u, range(n, whole.shape[2]))
    sure &= sure_q & sure_u
    moves = Tangents.of(free_q, of_q, free_u, of_u).moves
    answer = np.zeros((*z.shape, moves.shape[2]))
    answer[:, keep] = -(solved.inverse @ (sloped.residual @ moves)[:, keep])
    rows = np.concatenate([(sloped.rates @ moves)[:, free_q], answer[:, free_u], sloped.states @ moves], axis=1)
    rates = rows.shape[1]
    found["A"][:], found["B"][:] = rows[:, :, :rates], rows[:, :, rates:]
    found["rates"][:] = np.concatenate([own.rates[:, free_q], z[:, free_u], own.states], axis=1)
    if outputs.roots:
        out = run(answers, *outputs.roots)(*state, z)
        by = out.slopes @ np.concatenate([moves, answer], axis=1)
        found["values"][:], found["C"][:], found["D"][:] = out.values, by[:, :, :rates], by[:, :, rates:]
    finite = [np.isfinite(x.reshape(count, -1)).all(axis=1) for x in found.values() if x.size]
    return np.asarray(sure & np.logical_and.reduce(finite) if finite else sure)


def _states(poses: Poses) -> Array:
    """(q, u, a) of all states (k × …)."""
    eom, x = poses.eom, np.zeros((poses.count, len(poses.eom.state)))
    given = {**poses.given("q"), **poses.given("u"), **poses.given("states")}
    for i, s in enumerate(eom.state):
        x[:, i] = given[s] if s in given else s.default or 0.0 if s in set(eom.states) else np.nan
    return x


def _solved(numeric: Numeric[Equations], keep: Sequence[int], state: tuple[Array, ...]) -> tuple[Values, Stack, Mask]:
    """K z = k without rows of redundant constraints: its values, its solution, and where K is certainly regular."""
    routine = numeric.routine(values)
    rows = routine.flat(*state)
    matrix, right = routine.bundle.places("matrix"), routine.bundle.places("right")
    a, b = Entries(rows, matrix[np.ix_(keep, keep)]), Entries(rows, right[list(keep), None])
    found = solve_each(a, b, numeric.settings, inverse=True)
    sure = found.regular(NEAR_SINGULAR**2) & np.isfinite(found.x[:, :, 0]).all(axis=1)
    found.inverse[~sure] = 0.0
    return routine.bundle.split(rows), found, np.asarray(sure)


def _placed(eom: Equations, own: Values, state: tuple[Array, ...]) -> Mask:
    """Which states are on the constraints within rounding, with closures on their specified branches."""
    t, x, p, r = state
    nq, n = len(eom.coordinates), len(eom.speeds)
    off = (np.abs(own.configuration) > ROUNDED_CHAIN * np.maximum(own.configuration_terms, _TINY)).any(axis=1)
    terms = (np.abs(own.constraints(n)) @ np.abs(x[:, nq : nq + n, None]))[:, :, 0]
    off |= (np.abs(own.motion) > ROUNDED_CHAIN * np.maximum(terms, _TINY)).any(axis=1)
    if eom.derived.conditions.branches:
        rest = StateArrays(t, x, p, r).given(eom)
        off |= eom.derived.conditions.at(rest).turned(x[:, :nq]).any(axis=1)
    return np.asarray(~off)


def _by_free(
    name: str,
    a: Array,
    own: Sequence[int],
    free: Sequence[int],
    rest: Sequence[int],
    *,
    settings: Settings,
    kept: dict[str, list[int]],
) -> tuple[Array, Mask]:
    """S of x = S (x_free, y), the solution of A x + rest y = 0 at all states, and where A is certainly regular.

    A is in the columns `own` of `a` (k × m × …), the factor of y in the columns `rest`. The chosen rows are stored in `kept` by name.
    """
    dependent = [i for i in own if i not in set(free)]
    columns = [*(own[i] for i in free), *rest]
    solution = np.zeros((len(a), len(own), len(columns)))
    solution[:, list(free), range(len(free))] = 1.0
    if not dependent:
        return solution, np.ones(len(a), dtype=bool)
    sure = np.asarray(np.isfinite(a).all(axis=(1, 2)))
    if name not in kept and sure.any():
        kept[name] = sorted(choose(a[int(np.argmax(sure))][:, dependent]).rows)
    rows = kept.get(name, [])
    if len(rows) < len(dependent):
        return solution, np.zeros(len(a), dtype=bool)
    entries, places = a.reshape(len(a), -1), np.arange(a[0].size).reshape(a.shape[1:])
    found = solve_each(
        Entries(entries, places[np.ix_(rows, dependent)]), Entries(entries, places[np.ix_(rows, columns)]), settings
    )
    sure &= found.regular(NEAR_SINGULAR)
    solution[:, dependent] = np.where(sure[:, None, None], -found.x, 0.0)
    return solution, sure


def _dataset(poses: Poses, first: Linear, found: Mapping[str, Array], causes: Mapping[int, str]) -> Any:
    xarray = package("xarray")
    dims: dict[str, tuple[str, ...]] = {"A": ("rate", "state"), "B": ("rate", "input"), "rates": ("rate",)}
    dims |= {"C": ("output", "state"), "D": ("output", "input"), "values": ("output",)}
    names = {"rate": [f"{s}'" for s in first.states], "state": list(first.states), "input": list(first.inputs)}
    names["output"] = list(first.outputs)
    told = {"rates": "rates of the states at the point itself", "values": "outputs at the point itself"}
    own = {
        PARTS[part]: xarray.Variable(
            ("instance", *dims[part]), x, {"long_name": told.get(part, f"{part} of the linear equations")}
        )
        for part, x in found.items()
    }
    return poses.dataset(own, causes, names)
