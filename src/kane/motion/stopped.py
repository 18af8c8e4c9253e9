# SPDX-License-Identifier: BSD-3-Clause
"""Why a motion in machine code comes to no step, in words."""

import numpy as np

from kane.motion.singular_rates import nearly_singular
from kane.motion.steppers.outline import At, Back
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.stepping import Method
from kane.motion.steps import Stepper
from kane.motion.time_breaks import told_apart
from kane.numeric.arrays import Array

_DOUBLINGS = 80


def why(back: Back, method: Method, stepper: Stepper, s: Array, y: Array, span: tuple[float, float]) -> str:
    """Why there is no step from the time in `s` and the state y."""
    t, now = float(s[At.TIME]), stepper.now
    if back is Back.UNDERFLOW and INTEGRATORS[method.name].fixed:
        return f"a step of max_step={method.max_step:g} from t = {t:.6g} is not found by iteration: give a shorter one"
    fastest = now.rates.labels[int(s[At.WORST])]
    told = (
        f"no step is short enough for {fastest}, which changes fastest"
        if back is Back.UNDERFLOW
        else _not_finite(stepper, s, y)
    )
    if back is Back.UNDERFLOW and (coarse := told_apart(t, span)):
        return f"{told} at t = {t:.17g}: {coarse}"
    singular = nearly_singular(stepper.eom, now.values(t, y))
    return f"the right-hand side is singular or not finite near t = {t:.6g} ({told}){singular}"


def _not_finite(stepper: Stepper, s: Array, y: Array) -> str:
    """What is not finite first, on the way on by ever longer steps."""
    t, now = float(s[At.TIME]), stepper.now
    rate = stepper.rate(t, y)
    for k in range(_DOUBLINGS):
        step = float(s[At.SHORTEST]) * 2.0**k
        told = now.explain(t + step, y + step * np.nan_to_num(rate)) if np.isfinite(step) else ""
        if told:
            return told
    return "a stage of the step is not finite"
