# SPDX-License-Identifier: BSD-3-Clause
"""Which method runs a motion: in machine code where nothing has to be asked of Python between two steps.

What a motion asks for, and no kernel gives yet, is a row of a table: such motions are stepped by SciPy's solvers.

A kernel is called with the state, the right-hand side, inputs, events and samples.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from kane.dynamics.poles import SlipEnd
from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.equations import Equations
from kane.errors import SimulationError, none_of
from kane.expr.node import Expr, postorder
from kane.expr.ops import OPS, Op
from kane.expr.piecewise import Piecewise
from kane.expr.symbols import time
from kane.motion.constraint_kernels import unheld
from kane.motion.hybrid.automaton import automaton
from kane.motion.hybrid.events import Fresh
from kane.motion.hybrid.sides import on_one_side, unfit
from kane.motion.inputs.expressions import CORNERS, Formula, HeldInput, Law, LawInput, driving
from kane.motion.inputs.functions import asked, constant, following, follows, law_of
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Given, Routines, derivatives, exact, has_jumps, is_long
from kane.motion.solvers.cvode import CVODE, check_installed
from kane.motion.solvers.stepping import IMPLICIT as SLOW
from kane.motion.solvers.stepping import STEPPED
from kane.motion.steppers.context import Slot
from kane.motion.steppers.table import INTEGRATORS, Integrator, compiled
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array
from kane.program.emit.llvm_printer import LIBRARY
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import CompiledKernel, Hook, aligned, doubles, entry, hoist_entry, hoisted, wide_entry
from kane.program.native.machine import Settings, target

JUMPING = CORNERS | {OPS["floor"], OPS["atan2"]}


_known: WeakKeyDictionary[CompiledRoutine, frozenset[Op]] = WeakKeyDictionary()


def operations(now: Routines) -> frozenset[Op]:
    """Those of the rates, and of the inputs that follow from the state, between two switches that a kernel decides."""
    laws = [f.expr for f in now.drives if isinstance(f, Formula) and f.of_state]
    if has_jumps(now.eom, now.laws):
        return now.eom.numeric(now.settings).value(_on_one_side, *laws)
    if now.rates not in _known:
        _known[now.rates] = frozenset(now.rates.program.op(i) for i in now.rates.routine.body)
    return _known[now.rates] | {node.op for node in postorder(laws)}


def _on_one_side(eom: Equations, *laws: Expr) -> frozenset[Op]:
    return frozenset(node.op for node in postorder(on_one_side(eom, laws)))


def cornered(now: Routines) -> bool:
    """Whether the rates, or inputs that follow from the state, hold what bends or jumps."""
    return any(op in JUMPING or isinstance(op, Piecewise) for op in operations(now))


def kernel_of(name: str, now: Routines, held: bool = False) -> CompiledKernel:
    """The kernel of a method that motions of these equations need."""
    watched, sided = now.events is not None, bool(now.quantities)
    return compiled(name, now.settings or Settings(), held, watched, cornered(now), sided)


def of_time(now: Routines) -> bool:
    """Whether rates, or inputs that are expressions, depend on time by itself: they may have no value behind the end of a motion."""
    program = now.rates.program
    told = {k for k, symbol in enumerate(program.inputs) if symbol is time}
    read = any(told.intersection(program.arguments(i)) for i in now.rates.routine.body)
    return read or any(node is time for f in now.drives if isinstance(f, Formula) for node in postorder([f.expr]))


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
    own = operations(stepper.now)
    bent = any(isinstance(f, HeldInput) or (isinstance(f, Formula) and not f.of_state and not f.smooth) for f in drives)
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


# What a kernel is called with ----------------------------------------------------------------------------------------


Fill = Callable[[float, Array, Array], None]
"""It writes the inputs at a time and state."""


def filling(now: Routines) -> Fill:
    """What writes the inputs, in as little time as Python leaves beside the user's functions."""
    laws: dict[Law, list[tuple[int, int]]] = {}
    others: list[tuple[int, Callable[[Any], Any]]] = []
    written = any(isinstance(f, Formula) for f in now.drives)
    for k, f in enumerate(list[Any](now.drives)):
        if isinstance(f, LawInput):
            laws.setdefault(f.law, []).append((k, f.place))
        elif not isinstance(f, Formula):
            others.append((k, f))
    each = list(laws.items())
    law = law_of(now.laid, now.eom.inputs, functions=True) if written else None
    routine = now.routine(driving, *law.values).flat if law else None
    numbers = law.numbers if law else ()

    def fill(t: float, x: Array, r: Array) -> None:
        for law, places in each:
            answer = law.at(t, x)
            for k, place in places:
                r[k] = answer[place]
        for k, f in others:
            r[k] = f(t)
        if routine is not None:
            r[:] = routine(t, x, np.append(now.p, numbers), r)

    return fill


def by_kind(eom: Equations) -> dict[str, Array | int]:
    """`pairs`: the (i, j) of coordinates i whose rate is the speed at place j of the state; `free`: the places of the others."""
    place: dict[Expr, int] = {u: len(eom.coordinates) + k for k, u in enumerate(eom.speeds)}
    roots = without_unknowns(eom.solved, eom.right_hand_side)
    pairs = [(i, place[root]) for i, root in enumerate(roots[: len(eom.coordinates)]) if root in place]
    paired = {i for i, _ in pairs}
    free = [i for i in range(len(roots)) if i not in paired]
    # one more, so that no array is empty
    arrays = {"pairs": np.array([*pairs, (0, 0)], dtype=float).reshape(-1), "free": np.array([*free, 0], dtype=float)}
    return {**arrays, "pair_count": len(pairs), "free_count": len(free)}


class Arguments:
    """The arguments by name, as `given`, and the `hooks` through which Python is asked for inputs.

    `now` are the equations from time t on, s, y and `lag` what a kernel reads and writes; events are `fresh` where the motion is at
    their thresholds. The parameters of `now` are then those of the kernel, sides of switches among them.
    """

    def __init__(
        self,
        name: str,
        now: Routines,
        t: float,
        s: Array,
        y: Array,
        fresh: Fresh = MappingProxyType({}),
    ) -> None:
        p = np.append(now.p, now.numbers)
        now = replace(now, p=p[: len(now.p)])
        self.integrator, self.now, self.s, self.y = INTEGRATORS[name], now, s, y
        self.hooks: list[Hook] = []
        self.controlled = [(k, f) for k, f in enumerate(now.drives) if isinstance(f, HeldInput)]
        self.law = law_of(now.laid, now.eom.inputs)
        work, r = aligned(self.integrator.work(len(y))), now.inputs(t, y)
        h = hoisted(now.rates, t, y[: now.width], now.p, r)
        self.given: Given = {
            "n": len(y),
            "s": s,
            "y": y,
            "lag": np.zeros_like(y),
            "work": work,
            "p": p,
            "h": h,
            "hoist_h": hoist_entry(now.rates),
            "breakpoints": 0,
            "pauses": np.zeros(1),
            "control": entry(now.rates),
        }
        self.given |= self._driving(t)
        if now.events is not None:
            self.given |= automaton(now, t, y, fresh, self.integrator.width > 1)
        if self.integrator.implicit:
            self.given |= derivatives(now, t, y, self.law)
            if following(now.drives) and asked(now.drives):
                self.given["jac"] = self._slopes()
        if self.integrator.width == 1:
            self.given["rhs"] = entry(now.rates)
        else:
            self.given["rhs"] = wide_entry(now.rates, self.integrator.width)
            self.given |= now.eom.numeric(now.settings).value(by_kind)

    def _driving(self, t: float) -> Given:
        """r, and what gives it where an input is a function of time."""
        now, width = self.now, self.integrator.width
        single = np.append(now.inputs(t, self.y), 0.0)
        r = single if width == 1 else np.repeat(single, width)
        none, hoist = entry(now.rates), hoist_entry(now.rates)
        h = hoisted(now.rates, t, self.y[: now.width], now.p, r[: len(now.drives)])
        inputs: Given = {"r": r, "single_r": single, "driven": 0, "hd": h, "hoist_hd": hoist}
        if all(_held(f) for f in now.drives):
            return inputs | {"drive": none, "single_drive": none}
        given = self._formulas()
        if given is None:
            hook = self._hook(single)
            return inputs | {"driven": 1, "drive": hook if width == 1 else self._hook(r), "single_drive": hook}
        h = hoisted(given, t, self.y[: now.width], now.parameters(given), r[: len(now.drives)])
        own = entry(given)
        inputs |= {"driven": 2 if follows(now.drives) else 1, "hd": h, "hoist_hd": hoist_entry(given)}
        return inputs | {"drive": own if width == 1 else wide_entry(given, width), "single_drive": own}

    def hold(self) -> None:
        """What sampled controllers have given last."""
        width = self.integrator.width
        for k, one in self.controlled:
            value = one.now
            self.given["r"][k * width : (k + 1) * width] = value
            if width > 1:
                self.given["single_r"][k] = value

    def _formulas(self) -> CompiledRoutine | None:
        """The inputs as a routine, where all are expressions; those that are held stay as they are."""
        return None if self.law is None else self.now.routine(driving, *self.law.values).flat

    def _hook(self, r: Array) -> Hook:
        """What asks Python for the inputs and writes them to r."""
        s, width, fill, follow = self.s, self.now.width, filling(self.now), following(self.now.drives)
        here, own = self.y[:width], r[:-1]

        def drive(t: float, x: int, out: int) -> None:
            try:  # rounding may lead beyond the end
                fill(min(t, float(s[Slot.END])), doubles(x, width) if follow else here, own)
            except BaseException:
                own[:] = np.nan
                raise

        return self.hooked(drive)

    def _slopes(self) -> Hook:
        """What asks Python for J, of inputs that are its functions of the state."""
        s, width, j = self.s, self.now.width, exact(self.now)

        def slopes(t: float, x: int, out: int) -> None:
            found = doubles(out, (width + 1) * width)
            found[:] = 0.0
            found[:] = j(min(t, float(s[Slot.END])), np.append(doubles(x, width), 0.0))[:, :width].reshape(-1)

        return self.hooked(slopes)

    def hooked(self, function: Callable[[float, int, int], None]) -> Hook:
        """A function that a kernel calls; what it raises is kept for `check`."""
        self.hooks.append(Hook(function))
        return self.hooks[-1]

    def check(self) -> None:
        """What went wrong in an input is raised."""
        for hook in self.hooks:
            if hook.raised is not None:
                raise hook.raised


def _held(drive: Any) -> bool:
    """Whether an input is a number from one breakpoint to the next."""
    return constant(drive) is not None or isinstance(drive, HeldInput)
