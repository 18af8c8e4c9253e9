# SPDX-License-Identifier: BSD-3-Clause
"""A motion as one file of C99: the equations, an integrator's kernel, and a program that prints the trajectory.

Of what `simulate` looks after, times at which rates turn and pulses of time are looked after there too; what is not is refused.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from importlib.resources import files
from itertools import combinations
from typing import NamedTuple, cast

import numpy as np

from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.compiled import Compiled, ports, program, rate_names
from kane.equations.equations import Equations, repartition
from kane.errors import KaneError, ProgramError
from kane.expr.node import ZERO, Expr
from kane.motion.constraint_kernels import holding, structure
from kane.motion.hybrid.automaton import tables
from kane.motion.hybrid.event_routines import bundles
from kane.motion.inputs.breakpoints import MOST, PLACES, SHARE, ULPS, Clock, Turning
from kane.motion.inputs.smooth import pieces_prescribed
from kane.motion.methods import needs
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Given, has_jumps, timed, watched
from kane.motion.steppers.context import SIZE, ReturnCode, Slot
from kane.motion.steppers.crossings import KINDS, Kind
from kane.motion.steppers.held import POORER, regularity_kernel
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.scale import BETTER, LEAPS, POOR, UNUSABLE
from kane.program.emit.c import emit_c, emit_kernel_c
from kane.program.emit.names import c_number, c_string
from kane.program.from_expressions import Bundle, Task
from kane.program.kernel.language import Callee, Kernel

_CHOICES = 6
"""So many choices of dependent speeds a program has at most."""
METHODS = tuple(name for name, i in INTEGRATORS.items() if i.width == 1 and not i.implicit)
"""Those that a program in C runs: by one state at a time."""
_ARGUMENTS = {
    "n": "N",
    "limit": "1000000000",
    "samples": "samples - 1",
    "driven": "0",
    "breakpoints": "0",
    "held_marks": "marks",
    "times": "times + 1",
    "rows": "rows + N",
}
"""What the arguments of a kernel are that are not the array of their name."""


def emit_simulator(compiled: Compiled, method: str = "dop853", period: float | None = None) -> str:
    """C99 of a program that simulates: `cc -O2 model.c -o model -lm; ./model END SAMPLES name=value …` prints time and state.

    Events are noted on the standard error; one that sets the state has two rows, before and after. Constraints are held; where other
    dependent speeds follow better, these lead on. With the `period` (s) of a sampled controller the program asks a function
    `<name>_control(t, x, inputs)`, of another file in C, for the inputs. Values are those of the state at the start, of inputs,
    constant, and of parameters that are other than their defaults, by name; rtol, atol and max_step too.

    Raises
    ------
    ProgramError
        if the equations have constraints, loads that switch or events that act through Python, which a motion has to look after, or
        there is no such method
    """
    if period is not None and not 0 < period < math.inf:
        raise ProgramError(f"Expected a period above zero (s) of a sampled controller, got {period!r}.")
    if method not in METHODS:
        raise ProgramError(f"Expected an integrator among {', '.join(METHODS)} for a program in C, got {method!r}.")
    eom, integrator, name = cast(Equations, compiled.equations), INTEGRATORS[method], compiled.name
    clock, parts = timed(eom), [*_events(eom), *_constraints(eom)]
    wrong = (
        needs(eom, integrator)
        + ["loads or inputs jump"] * has_jumps(eom)
        + [text for part in parts for text in part.undecided]
    )
    wrong += [f"{one.quantity} turns rates at times that no line gives" for one in clock.turning if one.slope is None]
    wrong += [f"{piece} prescribes a motion, which may jump" for piece in pieces_prescribed(eom)]
    if wrong:
        raise ProgramError(
            f"Expected a motion that a program in C can look after, got one in which {' and '.join(wrong)}. Emit the equations alone, "
            "and take an integrator that does; or simulate here."
        )
    asked = {"held": is_constrained(eom), "watched": bool(eom.events)}
    kernel = integrator.kernel(**{what: True for what, so in asked.items() if so})
    texts = {part.name: part for part in parts}
    events, constraints = texts.get("events"), texts.get("constraints")
    replaced = {
        "@CONSTRAINTS@": _template("simulator_constraints.c") if constraints else "",
        "@REPORT@": _template("simulator_events.c") if events else _REPORT,
        "@KERNEL@": "\n".join(
            f"static {emit_kernel_c(k)}" for k in (kernel, *(k for part in parts for k in part.kernels))
        ),
        "@TABLES@": "\n".join(_tables(part, name) for part in parts),
        "@BEGIN@": "".join(f"if (!begin_{part.name}(y, p, r, h)) return 2;\n    " for part in parts).rstrip(),
        "@GOES_ON@": "goes_on(s, y, p, r, h)" if constraints else "0",
        "@RATES@": "rates_of[at_choice](t, x, p, r, h, out);" if constraints else f"{name}_rhs(t, x, p, r, h, out);",
        "@REGULARITY@": _call(regularity_kernel(), parts) if constraints else "",
        **{f"@{what}@": c_number(x) for what, x in _SHARES.items()},
        "@NAME@": name,
        "@CAPS@": name.upper(),
        "@METHOD@": method,
        "@FIXED@": str(int(integrator.fixed)),
        "@CALL@": _call(kernel, parts),
        "@WORK@": str(integrator.work(1)),
        "@SIZE@": str(SIZE),
        "@ARGUMENTS@": str(len(kernel.arguments)),
        "@PLACES@": "\n".join(f"    AT_{slot.name} = {int(slot)}," for slot in Slot),
        **{f"@{code.name}@": str(int(code)) for code in ReturnCode},
        **_clock(clock, name),
    }
    every = c_number(period or math.inf)
    ask = f"if ((double)asked * {every} <= s[AT_TIME]) {name}_control((double)asked++ * {every}, y, r);"
    replaced |= {
        "@CONTROL@": _CONTROL if period else "",
        "@ASK@": f"int64_t asked = 1;\n    {name}_control(0, y, r);" if period else "",
        "@ASK_AGAIN@": ask if period else "",
        "@PERIOD@": every,
    }
    text = _template("simulator.c").replace("@CONTROL@", replaced.pop("@CONTROL@"))
    for mark, by in replaced.items():
        text = text.replace(mark, by)
    return f"{_equations(compiled, clock, parts)}\n{text}"


_REPORT = """static void report(double *s, const double *times, const double *rows, int64_t *printed)
{
    for (; *printed <= (int64_t)s[AT_SAMPLE]; ++*printed) print_row(times[*printed], rows + *printed * N);
}"""
_CONTROL = """/* The sampled controller, in another file: it writes the inputs that hold from time t on, by the state x. */
extern void @NAME@_control(double t, const double *x, double *inputs);
"""
_SHARES = {"POORER": POORER, "BETTER": BETTER, "QUIET": 1 / POOR, "UNUSABLE": 1 / UNUSABLE}
_TAKES = "double t, double *x, double *p, double *r, double *h, double *out"


class Part(NamedTuple):
    """What a program looks after besides steps: tables, the routines that a kernel calls by their arguments' names, texts.

    Tables of two axes have a row for each choice of dependent speeds. `hoisted` are what routines take as h: copies of one
    array, as arguments of kernels do not overlap.
    """

    name: str
    given: Given
    tasks: Sequence[Task]
    routines: Mapping[str, str]
    hoisted: Sequence[str]
    lines: Sequence[str]
    undecided: Sequence[str] = ()
    kernels: Sequence[Kernel] = ()


def _events(eom: Equations) -> list[Part]:
    """Events, and those that Python would have to decide, in words."""
    if not eom.events:
        return []
    given = tables(eom, len(eom.state))
    kinds = given["kinds"].reshape(-1, KINDS)[:, 0]
    asked = [e for e, kind in zip(eom.events, kinds, strict=True) if kind >= Kind.ASKED and e.then is not None]
    made = [watched, *bundles(eom)]
    names = ", ".join(c_string(e.name) for e in eom.events)
    return [
        Part(
            "events",
            given | {name: np.zeros(len(eom.events)) for name in ("seen", "largest")},
            [make(eom).task for make in made],
            dict(zip(("watch", "glance", "tendency", "act"), (make(eom).name for make in made), strict=False)),
            ("hw", "hg", "ht", "ha"),
            [
                f"enum {{ EVENTS = {len(eom.events)}, KINDS = {KINDS} }};",
                f"static const char *const at_names[] = {{{names}}};",
            ],
            [f"the event {e.name!r} asks for more than numbers tell" for e in asked],
        )
    ]


def _constraints(eom: Equations) -> list[Part]:
    """Constraints, with all choices of dependent speeds where these are few."""
    if not is_constrained(eom):
        return []
    choices = _choices(eom)
    given, *others = (structure(one, len(eom.state)) for one in choices)
    for name in ("held_entry_at", "held_chosen_at", "held_dependent"):
        given[name] = np.array([given[name], *(other[name] for other in others)])
    tasks = [holding(eom).task]
    for k, one in enumerate(choices):
        roots = without_unknowns(one.solved, one.right_hand_side)
        tasks.append(Task(f"rates_{k}", roots, (len(roots),), rate_names(one.derived)))
    rows = [c.name for c in eom.derived.constraints.constraints]
    return [
        Part(
            "constraints",
            given,
            tasks,
            {"constraints": "holding", **{f"rates_{k}": f"rates_{k}" for k in range(len(choices))}},
            ("held_h",),
            [
                f"enum {{ CHOICES = {len(choices)}, CLOSURES = {given['held_closures']}, ROWS = {given['held_rows']}, "
                f"BRANCHES = {given['held_branches']}, ENTRIES = {given['held_entries']}, "
                f"COORDINATES = {len(eom.coordinates)} }};",
                "static int at_choice;",
                f"static const char *const at_constraints[] = {{{', '.join(map(c_string, rows))}}};",
            ],
            [f"{text}" for text in ([] if eom.solved.twin is None else ["W has poles that the motion has not"])],
            [regularity_kernel()],
        )
    ]


def _choices(eom: Equations) -> list[Equations]:
    """The equations with all dependent speeds of the same rows, theirs first; they alone, where these are many."""
    if eom.embedding is None:
        return [eom]
    own = eom.embedding.partition
    others = [c for c in combinations(range(len(eom.speeds)), len(own.dependent)) if set(c) != set(own.dependent)]
    found = [eom]
    if len(others) < _CHOICES:
        for columns in others:
            with suppress(KaneError):
                found.append(eom.numeric().value(repartition, replace(own, dependent=columns)))
    return found


def _template(name: str) -> str:
    return files("kane.motion").joinpath(name).read_text(encoding="utf-8")


def _call(kernel: Kernel, parts: Sequence[Part]) -> str:
    """The kernel called with what there is."""
    given: dict[str, str] = {**_ARGUMENTS, **{a: a for a in ("s", "y", "lag", "work", "p", "r", "h")}}
    none = (
        "at_none" if (alone := kernel.name == "regularity") else "none"
    )  # which reads nothing of the motion but s and y
    if alone:
        given = {a: what for a, what in given.items() if a not in ("lag", "times", "rows", "work", "held_marks")}
        given |= {"s": "there", "samples": "0"}
    for part in parts:
        given |= {a: str(what) if isinstance(what, int) else f"at_{a}" for a, what in part.given.items()}
        given |= {a: f"at_{a}[at_choice]" for a, what in part.given.items() if getattr(what, "ndim", 0) == 2}
        given |= {a: f"at_{a}" for a in part.hoisted} | {a: f"run_{a}" for a in part.routines}
    given = {a.name: "rates" for a in kernel.arguments if isinstance(a, Callee)} | given
    return f"{kernel.name}({', '.join(given.get(a.name, f'{none}[{k}]') for k, a in enumerate(kernel.arguments))})"


def _tables(part: Part, name: str) -> str:
    """The tables of a part, room for what is noted, and its routines as kernels call them."""
    lines = list(part.lines)
    for array, what in part.given.items():
        if isinstance(what, np.ndarray):
            rows = [", ".join(map(c_number, row.tolist())) for row in np.atleast_2d(what)]
            size = "".join(f"[{n}]" for n in what.shape)
            values = (
                f" = {{{', '.join(f'{{{row}}}' for row in rows) if what.ndim > 1 else rows[0]}}}" if what.any() else ""
            )
            lines.append(f"static double at_{array}{size}{values};")
    lines.append(f"static double {', '.join(f'at_{h}[{name.upper()}_HOISTED + 1]' for h in part.hoisted)};")
    for routine, own in part.routines.items():
        lines.append(f"static void run_{routine}({_TAKES})\n{{\n    {name}_{own}(t, x, p, r, h, out);\n}}")
    rates = [f"run_{routine}" for routine in part.routines if routine.startswith("rates_")]
    if rates:
        lines.append(f"static void (*const rates_of[])({_TAKES}) = {{{', '.join(rates)}}};")
    return "\n".join(lines)


def _equations(compiled: Compiled, clock: Clock, parts: Sequence[Part]) -> str:
    """The equations, what the parts evaluate, and the clock's quantities, their slopes and pulses, where there are some."""
    solved, contract = compiled.equations.solved, compiled.settings.contract
    slopes = [ZERO if one.slope is None else one.slope for one in clock.turning]
    roots: list[Expr] = [*(one.quantity for one in clock.turning), *slopes, *clock.pulses]
    more = [task for part in parts for task in part.tasks]
    if roots:
        more.append(Bundle("clock", ports(solved.derived), tuple, {"clock": roots}).task)
    optimize = contract and compiled.settings.optimize
    own = program(solved, ["rhs"], more=more, name=compiled.name, reciprocals=contract, optimize=optimize)
    return emit_c(own, contract=contract, version=version("kane"))


def _clock(clock: Clock, name: str) -> dict[str, str]:
    """What the program looks for at which times rates turn, or may be a pulse."""
    return {
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


def _levels(turning: Sequence[Turning]) -> str:
    """The tables of levels."""
    lines, rows = [], []
    for k, one in enumerate(turning):
        lines.append(f"static const double levels_{k}[] = {{{', '.join(map(c_number, one.data.ends.tolist()))}}};")
        start, period = one.data.period or (0.0, 0.0)
        rows.append(f"{{levels_{k}, {c_number(start)}, {c_number(period)}, {len(one.data.ends)}, {one.most}}}")
    return "\n".join([*lines, f"static const turning turnings[] = {{{', '.join([*rows, '{0, 0, 0, 0, 0}'])}}};"])
