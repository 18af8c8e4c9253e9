# SPDX-License-Identifier: BSD-3-Clause
"""Messages of motions that stop early: no step is short enough, constraints cannot be satisfied, loads chatter at a switch.

Frequent causes are a drive that cannot satisfy its constraints beyond some time, and singular equations.
"""

from collections.abc import Collection, Iterable, Sequence

import numpy as np

from kane.dynamics.constraints.manifold import manifold
from kane.errors import cut
from kane.expr.build import neg
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import input_of, time
from kane.model.contact_modes import friction_name
from kane.motion.inputs.breakpoints import indistinct_times
from kane.motion.right_hand_side import Routines, Switch, switches
from kane.motion.start import nearly_singular
from kane.motion.steppers.context import ReturnCode, Slot
from kane.motion.steps import Stepper, share_of_rank
from kane.numeric.arrays import Array
from kane.numeric.scale import CHANGES_SIDE, CLOSED_FULLY, CLOSED_NEARLY, LATER, POOR

_TURNS, _DOUBLINGS = 2, 80
NESTED = (
    "LSODA is not reentrant, and a function of an input or of an event, which is called during the motion, runs LSODA itself: "
    "use another method for one of them, such as method='auto' here or 'DOP853' there. The motion ends"
)


def no_step(
    back: ReturnCode, fixed: float | None, stepper: Stepper, s: Array, y: Array, span: tuple[float, float]
) -> str:
    """Why a kernel finds no step from the time in `s` and the state y; `fixed` is the length of fixed steps, else None."""
    t, now = float(s[Slot.TIME]), stepper.now
    if back is ReturnCode.UNDERFLOW and fixed:
        return f"the iteration for a step of max_step={fixed:g} from t = {t:.6g} does not converge: give a shorter max_step="
    fastest = now.rates.labels[int(s[Slot.WORST])]
    told = (
        f"no step is short enough for {fastest}, which changes fastest"
        if back is ReturnCode.UNDERFLOW
        else _not_finite(stepper, s, y)
    )
    if back is ReturnCode.UNDERFLOW and (coarse := indistinct_times(t, span)):
        return f"{told} at t = {t:.17g}: {coarse}"
    singular = nearly_singular(stepper.eom, now.values(t, y))
    return f"the right-hand side is singular or not finite near t = {t:.6g} ({told}){singular}"


def _not_finite(stepper: Stepper, s: Array, y: Array) -> str:
    """The first value that is not finite after Euler steps of doubling length from y."""
    t, now = float(s[Slot.TIME]), stepper.now
    rate = stepper.rate(t, y)
    for k in range(_DOUBLINGS):
        step = float(s[Slot.SHORTEST]) * 2.0**k
        told = now.explain(t + step, y + step * np.nan_to_num(rate)) if np.isfinite(step) else ""
        if told:
            return told
    return "a stage of the step is not finite"


def broken_off(stepper: Stepper, t: float, y: Array, span: tuple[float, float], failure: str | None, told: str) -> str:
    """Why a solver in Python finds no step from y at t; `failure` is its message, `told` that of `chattering`."""
    if failure == NESTED:
        return f"{failure} at t = {t:.6g}"
    if told:
        return f"the motion makes no progress beyond t = {t:.6g} ({failure or 'no progress'}): {told}"
    coarse = indistinct_times(t, span)
    if coarse:
        return f"no step is short enough at t = {t:.17g}: {coarse}"
    return _locked(stepper, t, y, t + LATER * (span[1] - span[0])) or (
        f"the right-hand side is singular or not finite near t = {t:.6g} ({failure or 'no progress'})"
        f"{nearly_singular(stepper.eom, stepper.now.values(t, y))}"
    )


def constraint_failure(stepper: Stepper, t: float, y: Array, span: tuple[float, float], missed: str) -> str:
    """Why constraints can be satisfied up to y at t but not beyond; `missed` is the violation as text."""
    return _locked(stepper, t, y, t + LATER * (span[1] - span[0])) or (
        f"the constraints cannot be satisfied beyond t = {t:.6g}: {missed} there, more than the tolerances allow. From there on "
        "they contradict each other, or constraints that were redundant before require something else: leave one out, or correct it"
    )


def _locked(stepper: Stepper, t: float, y: Array, later: float) -> str:
    """The constraint that a drive cannot satisfy beyond t, since no configuration near y satisfies it at time `later`; "" if none."""
    eom = stepper.eom
    driving = free_symbols(c.expr for c in eom.system.holonomic)
    if not any(s is time or input_of(s) is not None for s in driving):
        return ""
    kept, numbers = stepper.keep(t, y)
    if numbers is None or not all(np.all(np.isfinite(v)) for v in (numbers.a, numbers.f)):
        return ""
    least = share_of_rank(numbers.a, len(eom.dependent_speeds), stepper.reach, stepper.mixes[1])
    constraints, moving = manifold(eom.system), set(eom.coordinates)
    rest = {s: v for s, v in stepper.now.values(later, kept).items() if s not in moving}
    level = constraints.at(rest)
    nearest = level.closest(kept[: len(moving)], CLOSED_FULLY)
    left = level.shares(nearest.residual)
    if not (least < POOR and CLOSED_NEARLY < left.max(initial=0) < np.inf):
        return ""
    worst = int(np.argmax(left))
    return (
        f"{constraints.names[worst]!r} cannot be satisfied beyond t = {t:.6g}, where the constraints lose rank (smallest "
        f"singular value {least:.1e} of the largest): at t = {later:.6g} its residual is {nearest.residual[worst]:.2g} in the "
        "nearest configuration. The prescribed motion leads beyond the reach of the parts: end the motion earlier, prescribe "
        "another one, or correct the lengths"
    )


def chattering(now: Routines, states: Collection[tuple[float, Array]], before: Sequence[tuple[float, Array]]) -> str:
    """The load that chatters at a switch in the last `states`, or ends at its threshold, with advice; "" if there is none.

    The final value is compared with the largest one, at the earlier states `before` too.
    """
    ends = {friction_name(c) for c in now.eom.system.contacts}  # slip ends by an event just before |v| = 0
    found = [s for s in switches(now.eom, now.laws) if s.jumps or s.load not in ends]
    if not found or not states:
        return ""

    def numbers(states: Iterable[tuple[float, Array]]) -> Array:
        return np.array([evaluate([s.quantity for s in found], now.values(t, y)) for t, y in states], dtype=float)

    table = numbers(states)
    turns = (np.diff(np.sign(table), axis=0) != 0).sum(axis=0)
    size = np.abs(np.vstack([numbers(before), table]))
    near = size[-1] <= CHANGES_SIDE * np.maximum(size.max(axis=0), np.finfo(float).tiny)
    for s, count, at in zip(found, turns, near, strict=True):
        if count >= _TURNS or at:
            return _switch_message(s)
    return ""


def standing(now: Routines, quantities: Sequence[Expr]) -> str:
    """The message on a load with a switch in one of `quantities`, on no side of which the motion continues."""
    found = [s for s in switches(now.eom, now.laws) if s.jumps]
    return _switch_message(
        next((s for s in found for c in quantities if c is s.quantity or c is neg(s.quantity)), found[0])
    )


def _switch_message(s: Switch) -> str:
    return (
        f"{cut(s.text, 80)} in the {s.load} switches back and forth, as {cut(s.quantity)} reaches zero again and again. "
        f'Declare friction by kn.friction(…) or kn.dry_friction(…), or {s.smooth} instead and choose method="Radau"'
    )
