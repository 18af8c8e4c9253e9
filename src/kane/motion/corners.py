# SPDX-License-Identifier: BSD-3-Clause
"""Whether rates may bend or jump where no switch is watched, or have no value behind a step."""

from collections.abc import Iterable
from typing import Any
from weakref import WeakKeyDictionary

from kane.expr.node import postorder
from kane.expr.ops import OPS, Op
from kane.expr.piecewise import Piecewise
from kane.expr.symbols import time
from kane.motion.compiled_equations import Routines
from kane.motion.formulas import CORNERS, Formula
from kane.program.native.compiled_routine import CompiledRoutine

JUMPING = CORNERS | {OPS["floor"], OPS["atan2"]}


_known: WeakKeyDictionary[CompiledRoutine, frozenset[Op]] = WeakKeyDictionary()


def operations(now: Routines) -> frozenset[Op]:
    """Those of the rates, which are gone through once."""
    if now.rates not in _known:
        _known[now.rates] = frozenset(now.rates.program.op(i) for i in now.rates.routine.body)
    return _known[now.rates]


def of_inputs(drives: Iterable[Any]) -> set[Op]:
    """Those of the inputs that are expressions of the state."""
    return {node.op for f in drives if isinstance(f, Formula) and f.of_state for node in postorder([f.expr])}


def cornered(now: Routines) -> bool:
    """Whether the rates, or inputs that follow from the state, hold what bends or jumps."""
    return any(op in JUMPING or isinstance(op, Piecewise) for op in operations(now) | of_inputs(now.drives))


def of_time(now: Routines) -> bool:
    """Whether rates, or inputs that are expressions, depend on time by itself: they may have no value behind the end of a motion."""
    program = now.rates.program
    told = {k for k, symbol in enumerate(program.inputs) if symbol is time}
    read = any(told.intersection(program.arguments(i)) for i in now.rates.routine.body)
    return read or any(node is time for f in now.drives if isinstance(f, Formula) for node in postorder([f.expr]))
