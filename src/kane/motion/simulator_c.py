# SPDX-License-Identifier: BSD-3-Clause
"""A motion as one file of C99: the equations, an integrator's kernel, and a program that prints the trajectory.

Of what `simulate` looks after, times at which rates turn and pulses of time are looked after there too; what is not is refused.
"""

from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from importlib.resources import files
from typing import Any, cast

from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.equations.routines import ports, program
from kane.errors import ProgramError
from kane.expr.node import ZERO, Expr
from kane.motion.inputs.breakpoints import MOST, PLACES, SHARE, ULPS, Clock, Turning
from kane.motion.inputs.smooth import pieces_prescribed
from kane.motion.methods import needs
from kane.motion.right_hand_side import timed
from kane.motion.steppers.context import SIZE, ReturnCode, Slot
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.scale import LEAPS
from kane.program.emit.c import emit_c, emit_kernel_c
from kane.program.emit.names import c_number
from kane.program.from_expressions import Bundle

METHODS = tuple(name for name, i in INTEGRATORS.items() if i.width == 1 and not i.implicit)
"""Those that a program in C runs: by one state at a time."""
_ARGUMENTS = {
    "n": "N",
    "limit": "1000000000",
    "samples": "samples - 1",
    "driven": "0",
    "breakpoints": "0",
    "control": "rates",
    "events": "0",
    "watch": "rates",
    "rhs": "rates",
    "drive": "rates",
    "times": "times + 1",
    "rows": "rows + N",
}
"""What the arguments of a kernel are that are not the array of their name."""


def emit_simulator(compiled: Compiled, method: str = "dop853") -> str:
    """C99 of a program that simulates: `cc -O2 model.c -o model -lm; ./model END SAMPLES name=value …` prints time and state.

    Values are those of the state at the start, of inputs, constant, and of parameters that are other than their defaults, by name;
    rtol, atol and max_step too.

    Raises
    ------
    ProgramError
        if the equations have constraints, events or loads that switch, which a motion has to look after, or there is no such method
    """
    if method not in METHODS:
        raise ProgramError(f"Expected an integrator among {', '.join(METHODS)} for a program in C, got {method!r}.")
    eom, integrator, name = cast(Equations, compiled.equations), INTEGRATORS[method], compiled.name
    clock = timed(eom)
    wrong = needs(eom, replace(integrator, watches=False, holds=False))
    wrong += [f"{one.quantity} turns rates at times that no line gives" for one in clock.turning if one.slope is None]
    wrong += [f"{piece} prescribes a motion, which may jump" for piece in pieces_prescribed(eom)]
    if wrong:
        raise ProgramError(
            f"Expected a motion that a program in C can look after, got one in which {' and '.join(wrong)}. Emit the equations alone, "
            "and take an integrator that does; or simulate here."
        )
    kernel = integrator.kernel()
    own = {"s", "y", "lag", "work", "p", "r", "h"}
    given = [_ARGUMENTS.get(a.name, a.name if a.name in own else f"none[{k}]") for k, a in enumerate(kernel.arguments)]
    replaced = {
        "@KERNEL@": f"static {emit_kernel_c(kernel)}",
        "@NAME@": name,
        "@CAPS@": name.upper(),
        "@METHOD@": method,
        "@FIXED@": str(int(integrator.fixed)),
        "@CALL@": f"{method}({', '.join(given)})",
        "@WORK@": str(integrator.work(1)),
        "@SIZE@": str(SIZE),
        "@ARGUMENTS@": str(len(given)),
        "@PLACES@": "\n".join(f"    AT_{slot.name} = {int(slot)}," for slot in Slot),
        "@END@": str(int(ReturnCode.END)),
        "@TURNING@": str(len(clock.turning)),
        "@PULSES@": str(len(clock.pulses)),
        "@LOOKED_AT@": str(PLACES),
        "@MOST_PULSES@": str(MOST),
        "@RISEN@": c_number(LEAPS),
        "@SHARE@": c_number(SHARE),
        "@ULPS@": str(ULPS),
        "@LEVELS@": _levels(clock.turning),
        "@CLOCK@": f"{name}_clock(t, y, p, r, h, out);"
        if any(clock)
        else "(void)t, (void)y, (void)p, (void)r, (void)h, (void)out;",
    }
    text = files("kane.motion").joinpath("simulator.c").read_text(encoding="utf-8")
    for mark, by in replaced.items():
        text = text.replace(mark, by)
    return f"{_equations(compiled, clock)}\n{text}"


def _equations(compiled: Compiled, clock: Clock) -> str:
    """The equations, and the clock's quantities, their slopes and pulses, where there are some."""
    solved, contract = compiled.equations.solved, compiled.settings.contract
    slopes = [ZERO if one.slope is None else one.slope for one in clock.turning]
    roots: list[Expr] = [*(one.quantity for one in clock.turning), *slopes, *clock.pulses]
    more: Bundle[Any] | None = Bundle("clock", ports(solved.derived), tuple, {"clock": roots}) if roots else None
    optimize = contract and compiled.settings.optimize
    own = program(solved, ["rhs"], more, name=compiled.name, reciprocals=contract, optimize=optimize)
    return emit_c(own, contract=contract, version=version("kane"))


def _levels(turning: Sequence[Turning]) -> str:
    """The tables of levels."""
    lines, rows = [], []
    for k, one in enumerate(turning):
        lines.append(f"static const double levels_{k}[] = {{{', '.join(map(c_number, one.data.ends.tolist()))}}};")
        start, period = one.data.period or (0.0, 0.0)
        rows.append(f"{{levels_{k}, {c_number(start)}, {c_number(period)}, {len(one.data.ends)}, {one.most}}}")
    return "\n".join([*lines, f"static const turning turnings[] = {{{', '.join([*rows, '{0, 0, 0, 0, 0}'])}}};"])
