# SPDX-License-Identifier: BSD-3-Clause
"""Comparison of the accelerations of the imported system with those of SymPy's matrices, at random states."""

import warnings
from collections.abc import Callable, Sequence

import numpy as np

from kane.equations.equations import Equations
from kane.errors import KaneWarning, ModelError
from kane.expr.symbols import Coordinate, Input, Parameter, Rate, Speed, Symbol, rate, time
from kane.interop.imported import Remarks
from kane.interop.sympy_mechanics.auxiliary import Auxiliary
from kane.interop.sympy_mechanics.given import Given
from kane.interop.sympy_mechanics.names import Translation
from kane.interop.sympy_mechanics.states import COUNT, States
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL, LAST_DIGIT, ROUNDED_ROOT, SOLVE_RANK

_UNKNOWN_CAUSE = "look for acceleration constraints that were given, and matrices that were changed."


def theirs(given: Given, known: Translation, states: States) -> tuple[Array, Array]:
    """u̇ from SymPy's matrices (speeds × states), and their reciprocal condition numbers."""
    mass, forcing = given.matrices()
    rows, columns = mass.shape
    m = states.of(known.scalars(mass)).reshape(rows, columns, -1)
    f = states.of(known.scalars(forcing)).reshape(rows, -1)
    n = len(given.u)
    found, condition = np.full((n, m.shape[2]), np.nan), np.zeros(m.shape[2])
    for k in range(m.shape[2]):
        a, size = m[:, :, k], np.abs(m[:, :, k]).max(axis=1, keepdims=True, initial=0)
        if np.isfinite(a).all() and np.isfinite(f[:, k]).all() and (size > 0).all():
            condition[k] = 1 / np.linalg.cond(a / size)
            if condition[k] > SOLVE_RANK:
                found[:, k] = np.linalg.solve(a / size, f[:, k] / size[:, 0])[:n]
    return found, condition


def ours(eom: Equations, sought: Sequence[Symbol], states: States) -> Array:
    """u̇ and reactions of the imported system (speeds and reactions × states)."""
    values, system = states.values, eom.system
    states.of(
        [*system.parameters, *(s for s in system.inputs if isinstance(s, Input))]
    )  # draws values for symbols that occur only in loads
    q, parameters, inputs = (
        {s: values[s] for s in x if s in values} for x in (system.coordinates, system.parameters, system.inputs)
    )
    u = {s: values.get(s, np.zeros(COUNT)) for s in system.speeds}
    wanted = [rate(s) if isinstance(s, Speed) else s for s in sought]
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", KaneWarning
        )  # speeds that violate a constraint give different accelerations, which `check` reports
        found = eom.evaluate(wanted, q=q, u=u, parameters=parameters, inputs=inputs, t=values.get(time, 0.0))
    return np.array(np.broadcast_arrays(*found, np.zeros(COUNT))[:-1])


def check(
    given: Given,
    eom: Equations,
    known: Translation,
    states: States,
    remarks: Remarks,
    auxiliary: Auxiliary,
    cause: Callable[[], str],
) -> None:
    """Compares accelerations; a ModelError shows the largest difference and the `cause`, if it is known."""
    got = ours(eom, (*known.speeds, *auxiliary.reactions), states)
    states.values.update(zip(auxiliary.reactions, got[len(known.speeds) :], strict=True))
    expected, condition = theirs(given, known, states)
    usable = np.isfinite(expected).all(axis=0)
    if not usable.any():
        remarks.say(
            "refused", "the comparison of accelerations: SymPy's matrices are singular or not finite at random states"
        )
        return
    got = got[: len(known.speeds)]
    size = np.maximum(np.abs(expected).max(axis=0), np.abs(got).max(axis=0))
    tolerance = np.maximum(EQUAL, 1000 * LAST_DIGIT / np.maximum(condition, LAST_DIGIT)) * np.maximum(size, 1e-6)
    off = np.where(usable, np.abs(got - expected) / tolerance, 0.0)
    off = np.where(np.isnan(off), np.inf, off)
    if off.max(initial=0) > 1:
        r, k = np.unravel_index(int(np.argmax(off)), off.shape)
        said = _difference(known.speeds[r].name, float(got[r, k]), float(expected[r, k]), states, int(k))
        raise ModelError(
            f"{said} {cause() or _UNKNOWN_CAUSE} Pass check=False to import the bodies, loads and constraints as they are."
        )
    if auxiliary.reactions:
        left = auxiliary.equations_left({rate(s): x for s, x in zip(known.speeds, got, strict=True)})
        if left > ROUNDED_ROOT:
            raise ModelError(
                f"Expected reactions that satisfy SymPy's auxiliary equations, got a residual of {left:.3g} of their terms. "
                "Pass check=False to import the bodies, loads and constraints as they are."
            )
    share = float((np.abs(got - expected)[:, usable] / np.maximum(size, 1e-6)[usable]).max())
    remarks.say(
        "checked",
        f"accelerations equal SymPy's to {max(share, 1e-16):.0e} of the largest at {usable.sum()} random states",
    )


def _difference(speed: str, got: float, expected: float, states: States, k: int) -> str:
    shown = ", ".join(
        f"{s.name} = {x[k]:.4g}"
        for s, x in states.values.items()
        if isinstance(s, Coordinate | Speed | Parameter | Input) and not isinstance(s, Rate)
    )
    return (
        f"Expected the accelerations of SymPy's equations, got {speed}' = {got:.9g} from the bodies, positions, loads and constraints "
        f"where SymPy's matrices give {expected:.9g}, at {shown}. Its equations contradict the model that they were derived from:"
    )
