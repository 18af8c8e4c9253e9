# SPDX-License-Identifier: BSD-3-Clause
"""Which method runs a motion: in machine code where nothing has to be asked of Python between two steps.

What a motion asks for, and no kernel gives yet, is a row of a table: such motions are stepped by SciPy's solvers.
"""

from collections.abc import Callable, Sequence
from typing import Any

from kane.errors import SimulationError
from kane.expr.ops import OPS
from kane.motion.drives import constant
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steps import Stepper
from kane.motion.switches import switches
from kane.program.emit.llvm_forms import LIBRARY
from kane.program.native.machine_code import target

SOLVERS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
"""SciPy's."""
AUTO = "auto"
METHODS = (AUTO, *INTEGRATORS, *SOLVERS)
_STEPPED = "DOP853"
"""What "auto" is where a motion does not run in machine code."""
_WIDE, _NARROW = "gauss16", "dop853"
"""What it is in machine code: by rates on lanes, or where the machine has few of them, the library is called lane by lane, or rates
have corners, which collocation's estimate does not see."""
_LANES = 4
_NOT_WIDE = {*LIBRARY, *(OPS[name] for name in ("abs", "sign", "min", "max", "less", "where"))}

_EVENTS = "events are watched"
_IN_PYTHON: tuple[tuple[Callable[[Stepper, Sequence[Any]], bool], str], ...] = (
    (lambda stepper, drives: stepper.manifold is not None, "constraints are kept"),
    (lambda stepper, drives: bool(switches(stepper.eom)), "loads switch"),
    (lambda stepper, drives: any(constant(f) is None for f in drives), "inputs are functions of time"),
)
"""What is looked after between two steps, in words, and whether there is something of it."""


def chosen(method: str, stepper: Stepper, drives: Sequence[Any]) -> str:
    """The method that runs.

    Raises
    ------
    SimulationError
        if it runs in machine code, and the motion asks for what only Python gives
    """
    native = _native(stepper) if method == AUTO else method
    reasons = [text for holds, text in _IN_PYTHON if holds(stepper, drives)]
    if native in INTEGRATORS and stepper.eom.events and not INTEGRATORS[native].watches:
        reasons.append(_EVENTS)
    if method == AUTO:
        return _STEPPED if reasons else native
    if method in INTEGRATORS and reasons:
        raise SimulationError(
            f'Expected a motion that runs in machine code for method="{method}", got one in which {" and ".join(reasons)}. Take '
            f'method="{AUTO}", which steps such motions by SciPy\'s DOP853.'
        )
    return method


def _native(stepper: Stepper) -> str:
    rates, settings = stepper.now.rates, stepper.now.rates.settings
    narrow = any(rates.program.op(i) in _NOT_WIDE for i in rates.routine.body)
    return _NARROW if narrow or target(settings.cpu, settings.features).lanes < _LANES else _WIDE


def check_method(method: Any) -> str:
    """A method by its name."""
    if method not in METHODS:
        raise SimulationError(f"Expected method to be one of {', '.join(METHODS)}, got {method!r}.")
    return str(method)
