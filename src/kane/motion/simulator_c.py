# SPDX-License-Identifier: BSD-3-Clause
"""A motion as one file of C99: the equations, an integrator's kernel, and a program that prints the trajectory.

Of what `simulate` does beside, nothing is in it: constraints are not kept, and events are not watched.
"""

from importlib.resources import files

from kane.equations.compiled import Compiled
from kane.errors import ProgramError
from kane.motion.steppers.outline import SIZE, At, Back
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.switches import switches
from kane.program.emit.kernel_c import emit_kernel_c

METHODS = tuple(name for name, i in INTEGRATORS.items() if i.width == 1 and not i.implicit)
"""Those that a program in C runs: by one state at a time."""
_ARGUMENTS = {
    "n": "N",
    "limit": "1000000000",
    "samples": "samples - 1",
    "driven": "0",
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
    eom = compiled.equations
    asked = {
        "constraints": eom.solved.embedding is not None,
        "events": bool(getattr(eom, "events", ())),
        "loads that switch": bool(switches(eom)),  # type: ignore[arg-type]
    }
    wrong = [what for what, there in asked.items() if there]
    if wrong:
        raise ProgramError(
            f"Expected equations whose motion has nothing to be looked after between steps, got some with {' and '.join(wrong)}. Emit "
            "the equations alone, and take an integrator that does; or simulate here."
        )
    integrator = INTEGRATORS[method]
    kernel = integrator.kernel()
    name = compiled.name
    own = {"s", "y", "lag", "work", "p", "r", "h"}
    given = [_ARGUMENTS.get(a.name, a.name if a.name in own else f"none[{k}]") for k, a in enumerate(kernel.arguments)]
    places = {f"AT_{at.name}": str(int(at)) for at in At}
    replaced = {
        "@NAME@": name,
        "@CAPS@": name.upper(),
        "@METHOD@": method,
        "@FIXED@": str(int(integrator.fixed)),
        "@CALL@": f"{method}({', '.join(given)})",
        "@WORK@": str(integrator.work(1)),
        "@SIZE@": str(SIZE),
        "@ARGUMENTS@": str(len(given)),
        "@PLACES@": "\n".join(f"    {place} = {value}," for place, value in places.items()),
        "@END@": str(int(Back.END)),
    }
    program = files("kane.motion").joinpath("simulator.c").read_text(encoding="utf-8")
    for mark, text in replaced.items():
        program = program.replace(mark, text)
    return "\n".join([compiled.emit("c", "rhs"), f"static {emit_kernel_c(kernel)}", program])
