# SPDX-License-Identifier: BSD-3-Clause
"""Which method runs a motion: in machine code where nothing has to be asked of Python between two steps.

What a motion asks for, and no kernel gives yet, is a row of a table: such motions are stepped by SciPy's solvers.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

from kane.dynamics.events import SlipEnd
from kane.equations.equations import Equations
from kane.errors import SimulationError, none_of
from kane.expr.node import Expr, postorder
from kane.expr.piecewise import Piecewise
from kane.motion.constraint_kernels import unheld
from kane.motion.corners import of_inputs, of_time, operations
from kane.motion.drives import asked, following
from kane.motion.feedback import HeldInput
from kane.motion.formulas import CORNERS, Formula
from kane.motion.implicit import is_long
from kane.motion.projection import is_constrained
from kane.motion.regimes import drives_on, has_jumps, on, quantities, rates_on, unfit
from kane.motion.steppers.table import INTEGRATORS, Integrator
from kane.motion.stepping import IMPLICIT as SLOW
from kane.motion.stepping import STEPPED
from kane.motion.steps import Stepper
from kane.motion.sundials import CVODE, check_installed
from kane.program.emit.llvm_forms import LIBRARY
from kane.program.native.machine_code import target

SOLVERS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
"""SciPy's."""
AUTO = "auto"
METHODS = (AUTO, *INTEGRATORS, *SOLVERS, CVODE)
_WIDE, _NARROW, _LOOSE, _BENT = "gauss16", "vern9", "tsitpap8", "dop853"
"""What it is in machine code: by rates on lanes; where the machine has few of them, the library is called lane by lane, or where slips
end, behind which the nodes of a step would lie; the same at loose tolerances, where no rate depends on time, as one stage lies behind
the step; where rates or inputs may have corners, which collocation's estimate does not see, and that of `_LOOSE` sees late."""
_TIGHT = 1e-9
"""The relative tolerance from which on `_NARROW` takes no more evaluations than `_LOOSE`."""
STIFF = "radau9"
"""What leads on in machine code where equations are stiff."""
_LANES = 4

_NEEDS: tuple[tuple[Callable[[Equations, Sequence[Expr]], bool], Callable[[Integrator], bool], str], ...] = (
    (lambda eom, laws: is_constrained(eom), lambda by: by.holds, "constraints or Euler parameters are kept"),
    (has_jumps, lambda by: by.watches, "loads or inputs jump"),
    (unfit, lambda by: False, "loads or inputs jump by tables of steps, or beside choices of pivots"),
    (lambda eom, laws: bool(eom.events), lambda by: by.watches, "events are watched"),
)
"""What equations want looked after between two steps, whether an integrator does, and in words."""
_IN_PYTHON: tuple[tuple[Callable[[Stepper, Sequence[Any], Integrator], bool], str], ...] = (
    (
        lambda stepper, drives, by: bool(unheld(stepper)),
        "constraints bend or lose rank, or W has poles that the motion has not",
    ),
    (lambda stepper, drives, by: asked(drives) and not by.driven, "inputs are functions of time or state in Python"),
    (
        lambda stepper, drives, by: following(drives) and _blind(stepper, by),
        "inputs follow from the state of a large system",
    ),
)
"""What a motion wants besides, in words, and whether an integrator leaves it to Python."""


def needs(eom: Equations, by: Integrator, laws: Sequence[Expr] = ()) -> list[str]:
    """What equations, and the laws of inputs, want looked after between two steps that an integrator does not, in words."""
    return [text for wanted, done, text in _NEEDS if wanted(eom, laws) and not done(by)]


def _left(stepper: Stepper, drives: Sequence[Any], by: Integrator) -> list[str]:
    """What an integrator leaves to Python, in words."""
    return needs(stepper.eom, by, stepper.now.laws) + [text for holds, text in _IN_PYTHON if holds(stepper, drives, by)]


def _blind(stepper: Stepper, by: Integrator) -> bool:
    """Whether derivatives are taken as products, which do not see what inputs change."""
    return by.implicit and is_long(stepper.now)


def chosen(method: str, stepper: Stepper, drives: Sequence[Any], rtol: float, max_step: float) -> str:
    """The method that runs.

    Raises
    ------
    SimulationError
        if it runs in machine code, and the motion asks for what only Python gives; if its steps are of one length that is not told
    """
    native = _native(stepper, drives, rtol) if method == AUTO else method
    if native not in INTEGRATORS:
        return native
    reasons = _left(stepper, drives, INTEGRATORS[native])
    if reasons and method == AUTO:
        return STEPPED
    if reasons:
        raise SimulationError(
            f'Expected a motion that runs in machine code for method="{method}", got one in which {" and ".join(reasons)}. Take '
            f'method="{AUTO}", which steps such motions by SciPy\'s DOP853.'
        )
    if INTEGRATORS[native].fixed and not math.isfinite(max_step):
        raise SimulationError(
            f'Expected the length of the steps of method="{native}", which does not choose it, got none. Give it as max_step=.'
        )
    return native


def implicit(stepper: Stepper, drives: Sequence[Any]) -> str:
    """The method that leads on where equations are stiff."""
    return SLOW if _left(stepper, drives, INTEGRATORS[STIFF]) else STIFF


def _native(stepper: Stepper, drives: Sequence[Any], rtol: float) -> str:
    settings = stepper.now.rates.settings
    eom, laws = stepper.eom, stepper.now.laws
    own = set(operations(stepper.now))
    if has_jumps(eom, laws):
        roots = rates_on(eom, *[1] * len(quantities(eom))).task.roots
        own = {node.op for node in postorder(roots)}
        every = quantities(eom, laws)
        drives = drives_on(tuple(drives), on(every, (1,) * len(every)))
    own |= of_inputs(drives)
    bent = any(isinstance(f, HeldInput) or (isinstance(f, Formula) and not f.smooth) for f in drives)
    if any(op in CORNERS or isinstance(op, Piecewise) for op in own) or asked(drives) or bent:
        return _BENT
    if any(isinstance(e, SlipEnd) for e in stepper.eom.events):
        return _NARROW
    if own.isdisjoint(LIBRARY) and target(settings.cpu, settings.features).lanes >= _LANES:
        return _WIDE
    return _NARROW if rtol <= _TIGHT or of_time(stepper.now) else _LOOSE


def check_method(method: Any) -> str:
    """A method by its name."""
    if method not in METHODS:
        raise SimulationError(f"Expected method to be one of {none_of(METHODS, method)}")
    if method == CVODE:
        check_installed()
    return str(method)
