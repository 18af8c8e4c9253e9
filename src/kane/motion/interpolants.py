# SPDX-License-Identifier: BSD-3-Clause
"""The state along a step that a kernel has found, as a function of times: what the kernel samples, for Python."""

from collections.abc import Callable

import numpy as np

from kane.motion.collocated import Given, after_stages, polynomial
from kane.motion.steppers.explicit import rows
from kane.motion.steppers.radau import AFTER, STAGES, Z
from kane.motion.steppers.radau_stages import radau_stages
from kane.motion.steppers.table import EXPLICIT
from kane.motion.steppers.tableau import Tableau
from kane.numeric.arrays import Array

_EXPLICIT = {tableau.name: tableau for tableau in EXPLICIT}


def interpolant(name: str, given: Given, h: float, start: float) -> Callable[[Array], Array]:
    """The state (k × n) at times (k) in the step of length h from `start`, by the numbers that the integrator has left."""
    if name in _EXPLICIT:
        return _nested(_EXPLICIT[name], given, h, start)
    if name == "radau9":
        return _collocated(given, h, start)
    return polynomial(given, h, start)


def after(name: str, given: Given) -> Array:
    """The end of the step that is looked at, on its constraints; but, of collocation, for the last component."""
    n = len(given["y"])
    if name in _EXPLICIT:
        first = (rows(_EXPLICIT[name]) - len(_EXPLICIT[name].dense) - 2) * n
    else:
        first = AFTER * n if name == "radau9" else after_stages(n)
    found: Array = given["work"][first : first + n].copy()
    return found


def _nested(tableau: Tableau, given: Given, h: float, start: float) -> Callable[[Array], Array]:
    begin, n, parts = (given["y"] + given["lag"]).copy(), len(given["y"]), len(tableau.dense)
    weights = given["work"].reshape(rows(tableau), n)[-parts:].copy()

    def state(times: Array) -> Array:
        theta = ((times - start) / h)[:, None]
        value = np.broadcast_to(weights[-1], (len(times), n))
        for k in reversed(range(parts - 1)):
            value = weights[k] + (theta if k % 2 else 1 - theta) * value
        found: Array = begin + theta * value
        return found

    return state


def _collocated(given: Given, h: float, start: float) -> Callable[[Array], Array]:
    begin, n, stages = (given["y"] + given["lag"]).copy(), len(given["y"]), radau_stages(STAGES)
    z, c = given["work"][Z * n : (Z + STAGES) * n].reshape(STAGES, n).copy(), np.array(stages.c)

    def state(times: Array) -> Array:
        theta = ((times - start) / h)[:, None]
        others = np.array([np.delete(c, i) for i in range(STAGES)])
        weights = theta * np.prod(theta[:, :, None] - others, axis=2) * stages.lagrange
        found: Array = begin + weights @ z
        return found

    return state
