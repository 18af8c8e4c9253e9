# SPDX-License-Identifier: BSD-3-Clause
"""The choice of the integration method of a motion: in machine code if no step needs a decision in Python.

Tables list the requirements of motions that kernels do not meet; motions with such requirements are integrated by SciPy's solvers.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakKeyDictionary

from kane.dynamics.poles import SlipEnd
from kane.equations.equations import Equations
from kane.errors import SimulationError, none_of
from kane.expr.node import Expr, postorder
from kane.expr.ops import OPS, Op
from kane.expr.piecewise import Piecewise
from kane.expr.symbols import time
from kane.motion.inputs.expressions import CORNERS, Formula, HeldInput
from kane.motion.inputs.functions import asked, following
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Routines, has_jumps, is_long, on_one_side, unfit
from kane.motion.solvers.cvode import CVODE, check_installed
from kane.motion.solvers.stepping import IMPLICIT as SLOW
from kane.motion.solvers.stepping import STEPPED
from kane.motion.steppers.table import INTEGRATORS, Integrator, compiled
from kane.motion.steps import Stepper, unheld
from kane.program.emit.walk import LIBRARY
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import CompiledKernel
from kane.program.native.machine import Settings, target

JUMPING = CORNERS | {OPS["floor"], OPS["atan2"]}


_known: WeakKeyDictionary[CompiledRoutine, frozenset[Op]] = WeakKeyDictionary()


def operations(now: Routines) -> frozenset[Op]:
    """The operations in the rates and in inputs that depend on the state, with switches that a kernel decides on one side."""
    laws = [f.expr for f in now.drives if isinstance(f, Formula) and f.of_state]
    if has_jumps(now.eom, now.laws):
        return now.eom.numeric(now.settings).value(_on_one_side, *laws)
    if now.rates not in _known:
        _known[now.rates] = frozenset(now.rates.program.op(i) for i in now.rates.routine.body)
    return _known[now.rates] | {node.op for node in postorder(laws)}


def _on_one_side(eom: Equations, *laws: Expr) -> frozenset[Op]:
    return frozenset(node.op for node in postorder(on_one_side(eom, laws)))


def cornered(now: Routines) -> bool:
    """Whether operations with corners or jumps occur in the rates, or in inputs that depend on the state."""
    return any(op in JUMPING or isinstance(op, Piecewise) for op in operations(now))


def kernel_of(name: str, now: Routines, held: bool = False) -> CompiledKernel:
    """The kernel of a method for these equations: with constraints if `held`, with events, corners and switches if they have any."""
    watched, sided = now.events is not None, bool(now.quantities)
    return compiled(name, now.settings or Settings(), held, watched, cornered(now), sided)


def of_time(now: Routines) -> bool:
    """Whether rates, or inputs that are expressions, depend explicitly on time, and may be undefined after the end of a motion."""
    program = now.rates.program
    told = {k for k, symbol in enumerate(program.inputs) if symbol is time}
    read = any(told.intersection(program.arguments(i)) for i in now.rates.routine.body)
    return read or any(node is time for f in now.drives if isinstance(f, Formula) for node in postorder([f.expr]))


SOLVERS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
"""Solvers of SciPy."""
AUTO = "auto"
METHODS = (AUTO, *INTEGRATORS, *SOLVERS, CVODE)
_WIDE, _NARROW, _LOOSE, _BENT = "gauss16", "vern9", "tsitpap8", "dop853"
"""The methods of "auto" in machine code. `_WIDE`: rates in lanes. `_NARROW`: few lanes, library calls lane by lane, or ends of slip,
beyond which nodes of collocation would lie. `_LOOSE`: the same at loose tolerances if rates do not depend on time, as one stage lies
beyond the step. `_BENT`: possible corners, which error estimates of collocation do not detect, and that of `_LOOSE` detects late."""
_TIGHT = 1e-9
"""The relative tolerance at and below which `_NARROW` takes no more evaluations than `_LOOSE`."""
STIFF = "radau9"
"""The method in machine code for stiff equations."""
_LANES = 4

_NEEDS: tuple[tuple[Callable[[Equations, Sequence[Expr]], bool], Callable[[Integrator], bool], str], ...] = (
    (lambda eom, laws: is_constrained(eom), lambda by: by.holds, "constraints or Euler parameters must be satisfied"),
    (has_jumps, lambda by: by.watches, "loads or inputs jump"),
    (unfit, lambda by: False, "loads or inputs jump by tables of steps, or jump in equations with choices of pivots"),
    (lambda eom, laws: bool(eom.events), lambda by: by.watches, "events are watched"),
)
"""Requirements of equations between two steps: whether they apply, whether an integrator meets them, and their text."""
_IN_PYTHON: tuple[tuple[Callable[[Stepper, Sequence[Any], Integrator], bool], str], ...] = (
    (lambda stepper, drives, by: bool(unheld(stepper)), "constraints have corners or lose rank, or W has false poles"),
    (lambda stepper, drives, by: asked(drives) and not by.driven, "inputs are functions of time or state in Python"),
    (
        # J is evaluated as products with vectors, which omit the derivatives of inputs
        lambda stepper, drives, by: following(drives) and by.implicit and is_long(stepper.now),
        "inputs of a large system depend on its state",
    ),
)
"""Further requirements of a motion: whether an integrator leaves them to Python, and their text."""


def needs(eom: Equations, by: Integrator, laws: Sequence[Expr] = ()) -> list[str]:
    """The requirements of equations, and of the `laws` of inputs, that an integrator does not meet, as texts."""
    return [text for wanted, done, text in _NEEDS if wanted(eom, laws) and not done(by)]


def _left(stepper: Stepper, drives: Sequence[Any], by: Integrator) -> list[str]:
    """All requirements of a motion that an integrator leaves to Python, as texts."""
    return needs(stepper.eom, by, stepper.now.laws) + [text for holds, text in _IN_PYTHON if holds(stepper, drives, by)]


def chosen(method: str, stepper: Stepper, drives: Sequence[Any], rtol: float, max_step: float) -> str:
    """The name of the method that integrates a motion for which the user asked for `method`.

    Raises
    ------
    SimulationError
        if it is in machine code and does not meet the requirements of the motion; if it has fixed steps and `max_step` is not given
    """
    native = _native(stepper, drives, rtol) if method == AUTO else method
    if native not in INTEGRATORS:
        return native
    reasons = _left(stepper, drives, INTEGRATORS[native])
    if reasons and method == AUTO:
        return STEPPED
    if reasons:
        raise SimulationError(
            f'Expected a motion that runs in machine code for method="{method}", got one in which {" and ".join(reasons)}. Use '
            f'method="{AUTO}", which integrates such motions by SciPy\'s DOP853.'
        )
    if INTEGRATORS[native].fixed and not math.isfinite(max_step):
        raise SimulationError(
            f'Expected max_step=, the fixed step length of method="{native}", got none. Give the length in s.'
        )
    return native


def implicit(stepper: Stepper, drives: Sequence[Any]) -> str:
    """The method that continues a motion with "auto" if the equations are stiff."""
    return SLOW if _left(stepper, drives, INTEGRATORS[STIFF]) else STIFF


def _native(stepper: Stepper, drives: Sequence[Any], rtol: float) -> str:
    settings = stepper.now.rates.settings
    own = operations(stepper.now)
    bent = any(isinstance(f, HeldInput) or (isinstance(f, Formula) and not f.of_state and not f.smooth) for f in drives)
    if any(op in CORNERS or isinstance(op, Piecewise) for op in own) or asked(drives) or bent:
        return _BENT
    if any(isinstance(e, SlipEnd) for e in stepper.eom.events):
        return _NARROW
    if own.isdisjoint(LIBRARY) and has_lanes(settings):
        return _WIDE
    return _NARROW if rtol <= _TIGHT or of_time(stepper.now) else _LOOSE


def side_by_side(method: str) -> str:
    """The method for many instances in lanes if "auto" takes `method` for one: an explicit one instead of collocation."""
    return _NARROW if method == _WIDE else method


def has_lanes(settings: Settings) -> bool:
    """Whether the processor's vectors have enough lanes for code in lanes to be faster."""
    return target(settings.cpu, settings.features).lanes >= _LANES


def check_method(method: Any) -> str:
    """The name of a method, checked."""
    if not isinstance(method, str) or method not in METHODS:
        raise SimulationError(f"Expected method to be one of {none_of(METHODS, method)}")
    if method == CVODE:
        check_installed()
    return str(method)
