# SPDX-License-Identifier: BSD-3-Clause
"""Whether a state is an equilibrium or a steady motion.

A steady motion may move coordinates on which nothing depends: those from which no path of dependence leads to the speeds. That is
read off A at the state, and tried at states displaced along what moves.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kane.analysis.flow import Choice, Flow, flow_at
from kane.analysis.magnitudes import share
from kane.analysis.state import State, open_shares
from kane.analysis.tangents import perturbations, turning
from kane.numeric.arrays import Array, Mask
from kane.numeric.projection import least_squares
from kane.numeric.scale import GIVEN, ROUNDED, ROUNDED_ROOT, UNRELATED

_SHIFTS = (0.71, -1.13)
"""For how long what moves is followed, in the time in which the state changes: any one place would show a dependence."""


def dependence(a: Array, count: int, last: int | None = None) -> Mask:
    """Which of the states the speeds depend on, through whatever chain; the first `count` are coordinates, from `last` on others.

    What rounding left of zero is dropped before units are balanced: with a chain that leads back, balancing would make it as large as
    the others.
    """
    from scipy.linalg import matrix_balance

    a = np.where(np.abs(a) > ROUNDED * np.abs(a).max(initial=0), a, 0.0)
    scaled = np.abs(matrix_balance(a, permute=False)[0])
    linked = scaled > UNRELATED * scaled.max(initial=0)
    places = np.arange(len(a))
    matters = (places >= count) & (places < (len(a) if last is None else last))
    while True:
        more = matters | linked[matters].any(axis=0)
        if np.array_equal(more, matters):
            return matters
        matters = more


@dataclass(frozen=True, slots=True, eq=False)
class Steadiness:
    """Which of the states matter to the speeds, and what is not steady.

    `left` are those that matter and change, by index; `varies` those that move and change the equations, −1 for the time.
    """

    matters: Mask
    left: tuple[int, ...]
    varies: tuple[int, ...]

    @property
    def holds(self) -> bool:
        """Whether the state is an equilibrium or a steady motion."""
        return not self.left and not self.varies


def steadiness(flow: Flow, tolerance: float) -> Steadiness:
    """Whether nothing that matters changes."""
    matters = dependence(scaled(flow.a, flow), *flow.counts)
    constant = share(flow.rest, flow.terms) <= tolerance
    left = tuple(np.flatnonzero(matters & ~constant).tolist())
    moving = np.flatnonzero(~matters & ~constant)
    if left or not (len(moving) or flow.numeric.value(perturbations).timed):
        return Steadiness(matters, left, ())
    same = all(_same(flow, matters, moving, shift / (flow.magnitudes.pace or 1.0), tolerance) for shift in _SHIFTS)
    return Steadiness(matters, (), () if same else tuple(moving.tolist()) or (-1,))


def changing(flow: Flow, tolerance: float) -> tuple[int, ...]:
    """The speeds that change, u̇ ≠ 0, or turn back at this instant, u̇ = 0 ≠ ü, of all whether dependent or not."""
    n, count = len(flow.numeric.equations.speeds), len(flow.rest)
    slopes, size = flow.answers[:n, :count], flow.magnitudes
    turns = slopes @ flow.rest
    noise = ROUNDED_ROOT * (np.abs(slopes) @ np.abs(flow.rest))
    least = np.maximum(tolerance * size.pace * size.accelerations, noise)
    changed = share(flow.z[:n], size.accelerations) > tolerance
    return tuple(np.flatnonzero(changed | (np.abs(turns) > least)).tolist())


def scaled(a: Array, flow: Flow) -> Array:
    """D⁻¹ A D with the scale D of the states, the same in any units."""
    return np.asarray(a * flow.scale / flow.scale[:, None])


def _same(flow: Flow, matters: Mask, moving: npt.NDArray[np.intp], shift: float, tolerance: float) -> bool:
    """Whether the flow of what matters is the same a while later, as far as what moves goes."""
    numeric, state, tangent = flow.numeric, flow.state, flow.tangents
    eom, perturbed = numeric.equations, numeric.value(perturbations)
    nq, n = len(eom.coordinates), len(eom.speeds)
    x = state.x.copy()
    step = np.zeros(len(perturbed.names))
    placed = moving[moving < flow.counts[0]]
    step[[tangent.free_q[i] for i in placed]] = shift * flow.rest[placed]
    others = moving[moving >= flow.counts[1]]
    x[nq + n + others - flow.counts[1]] += shift * flow.rest[others]
    for at, place in enumerate(perturbed.coordinates):
        x[place] += step[at]
    for k, places in enumerate(perturbed.sets):
        angles = step[len(perturbed.coordinates) + 3 * k :][:3]
        x[list(places)] = _turned(x[list(places)], angles)
    moved = State(state.t + shift if perturbed.timed else state.t, x, state.p, state.r)
    held = [i for i in range(n) if i not in tangent.free_u]
    values = flow.numbers.values(moved)
    open_ = open_shares(eom, values.configuration, values.configuration_terms, moved.given(eom))
    if not open_.max(initial=0) <= GIVEN or not np.all(np.isfinite(values.motion)):
        return False
    if len(values.motion):
        x[nq : nq + n][held] -= least_squares(values.constraints(n)[:, held], values.motion)
    there = flow_at(numeric, moved, Choice(flow.choice.q, tuple(held)), flow.numbers)
    if there.tangents.free_u != tangent.free_u or there.tangents.free_q != tangent.free_q:
        return False
    inner = np.ix_(matters, matters)
    before, after = scaled(flow.a, flow)[inner], scaled(there.a, flow)[inner]
    change = (there.rest - flow.rest)[matters]
    return bool(
        np.abs(after - before).max(initial=0) <= ROUNDED_ROOT * np.abs(before).max(initial=0)
        and share(change, flow.terms[matters]).max(initial=0) <= max(ROUNDED_ROOT, tolerance)
    )


def _turned(e: Array, angles: Array) -> Array:
    """e (4) after a turn about the frame's own axes: e cos φ/2 + E(e) n sin φ/2, the angles being φ n."""
    half = np.linalg.norm(angles) / 2
    return np.asarray(e * np.cos(half) + turning(e) @ angles * np.sinc(half / np.pi))
