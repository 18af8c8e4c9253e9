# SPDX-License-Identifier: BSD-3-Clause
"""Why a motion broke off: constraints that a drive cannot hold any further, or equations that are singular."""

import numpy as np

from kane.dynamics.constraints.closure import OFF, closure, residual_function
from kane.expr.evaluate import free_symbols
from kane.expr.symbols import input_of, time
from kane.motion.singular_rates import nearly_singular
from kane.motion.steps import Stepper, share_of_rank
from kane.numeric.arrays import Array
from kane.numeric.newton import close

_AHEAD = 1e-3
"""Share of the time after which a motion that broke off is asked whether its constraints can be held there."""
_SHORT_OF_RANK = 0.02
"""Least singular value of A over the largest below which a motion that broke off may have come to a lock."""


def broken_off(stepper: Stepper, t: float, y: Array, span: tuple[float, float], failure: str | None) -> str:
    """Why there is no step from y at t; `failure` is what the solver said."""
    return _locked(stepper, t, y, t + _AHEAD * (span[1] - span[0])) or (
        f"the right-hand side is singular or not finite near t = {t:.6g} ({failure or 'no progress'})"
        f"{nearly_singular(stepper.eom, stepper.now.values(t, y))}"
    )


def _locked(stepper: Stepper, t: float, y: Array, later: float) -> str:
    """Which constraint a drive cannot hold beyond t, as no configuration near y closes it at `later`; "" without that evidence."""
    eom = stepper.eom
    driving = free_symbols(c.expr for c in eom.system.holonomic)
    if not any(s is time or input_of(s) is not None for s in driving):
        return ""
    kept, numbers = stepper.keep(t, y)
    if numbers is None or not all(np.all(np.isfinite(v)) for v in (numbers.a, numbers.f)):
        return ""
    least = share_of_rank(numbers.a, len(eom.dependent_speeds), stepper.reach)
    constraints, moving = closure(eom.system), set(eom.coordinates)
    rest = {s: v for s, v in stepper.now.values(later, kept).items() if s not in moving}
    nearest = close(residual_function(eom.system, constraints, rest), kept[: len(moving)], range(len(moving)))
    if not (least < _SHORT_OF_RANK and OFF < nearest.size < np.inf):
        return ""
    worst = int(np.argmax(np.abs(nearest.residual)))
    return (
        f"{constraints.names[worst]!r} cannot be held beyond t = {t:.6g}, where the constraints lose rank (least singular value "
        f"{least:.1e} of the largest): at t = {later:.6g} {nearest.residual[worst]:.2g} is left of it in the nearest "
        "configuration. The drive carries the parts further than they reach: end before, drive them another way, or correct the "
        "lengths"
    )
