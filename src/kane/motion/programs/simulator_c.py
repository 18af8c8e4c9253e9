# SPDX-License-Identifier: BSD-3-Clause
"""A motion as one file of C99: the equations, the kernel of an integrator, and a program that prints the trajectory.

Of the features of `simulate`, it supports discontinuities at known times and pulses; motions with unsupported ones are refused.
"""

import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from importlib.resources import files
from typing import cast

import numpy as np

from kane import expect
from kane.equations.compiled import Compiled, ports
from kane.equations.equations import Equations
from kane.errors import ProgramError
from kane.expr.node import ZERO, Expr
from kane.model.contacts import Modes
from kane.motion.hybrid.contact_tables import MODES
from kane.motion.inputs.breakpoints import MOST, PLACES, SHARE, ULPS, Clock, Discontinuity
from kane.motion.programs.contacts_c import contact_pieces
from kane.motion.programs.program_modes import TasksOf, check_events, modes_of
from kane.motion.programs.simulator_parts import (
    TAKES,
    Pieces,
    SimulatorPart,
    checked,
    constraints,
    motion_program,
    only_read,
    parts_of,
    stepping_kernel,
    turning,
)
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import timed
from kane.motion.steppers.context import SIZE, ReturnCode, Slot
from kane.motion.steppers.crossings import EventKind
from kane.motion.steppers.held import POORER
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.arrays import Array
from kane.numeric.scale import EPS, LEAPS, ROUNDED_TERMS, SAME_TIME, UNUSABLE
from kane.program.emit.c import emit_c
from kane.program.emit.c_kernels import emit_kernel_c
from kane.program.emit.identifiers import c_number
from kane.program.from_expressions import Bundle, Task
from kane.program.kernel.language import Callee, Kernel

_ARGUMENTS = {
    "n": "N",
    "limit": "m->limit",
    "samples": "m->samples - 1",
    "driven": "0",
    "breakpoints": "0",
    "held_marks": "m->marks",
    "times": "&m->times[1]",
    "rows": "&m->rows[N]",
    **{name: f"m->{name}" for name in ("s", "y", "lag", "work", "p", "r", "h")},
}
"""C expressions for the kernel arguments that are not tables."""
SETTINGS = ("rtol", "atol", "max_step")
"""Settings of the integrator that a program takes by their names, as it does values of the system."""


def emit_simulator(
    compiled: Compiled, method: str = "dop853", period: float | None = None, modes: Sequence[Modes] = ()
) -> str:
    """Generate a C99 program that simulates: `cc -O2 model.c -o model -lm; ./model END SAMPLES name=value …` prints time and state.

    Its steps are those of `simulate` with this method and the settings of `compiled`, bit for bit without `contract`, up to the
    point where `simulate` calls Python for other dependent speeds. Events are reported on standard error; one that sets the state
    has two rows, before and after. With the `period` (s) of a sampled controller, the program calls a function `<name>_control(t, x,
    inputs)` in another C file for the inputs. Arguments name=value are initial values of the state, constant inputs, parameters that
    differ from their defaults, and rtol, atol and max_step. With contacts, the program has these `modes`, by default all modes if
    there are few.

    Apart from `main`, the code does not allocate, recurse, print or loop without a bound; `<NAME>_NO_MAIN` omits `main`. It follows
    rules of MISRA C:2012 (`docs/howto/emitted_c.md`).

    Raises
    ------
    ProgramError
        if the equations have loads that switch by tables of steps, constraints and a W with poles that the motion does not have, or
        events whose actions require Python, or if the method is unknown
    """
    return assembled(compiled, method, period, modes=modes)


def assembled(
    compiled: Compiled,
    method: str,
    period: float | None = None,
    *,
    routines: Sequence[str] = (),
    tasks: Sequence[Task] = (),
    ending: str | None = None,
    modes: Sequence[Modes] = (),
    tasks_of: TasksOf | None = None,
) -> str:
    """The file of `emit_simulator`; with an `ending` in place of `main`, and further routines and tasks that it requires.

    With contact modes, the further tasks are `tasks_of` each mode. Marks such as @NAME@ are replaced in the ending too; its variable
    for the motion must be called m.
    """
    _check_period(period)
    eom = cast(Equations, compiled.equations)
    if ending is None:
        _check_names(eom)
    if eom.system.modes_change:
        return _filled_in(compiled, method, period, _contacts(compiled, method, modes, tasks_of), ending)
    checked(compiled, method, "a program in C", _untold, switching=ending is None)
    clock, parts = timed(eom), parts_of(eom)
    pieces = _pieces(compiled, method, clock, parts)._replace(
        equations=_equations(compiled, clock, parts, (routines, tasks))
    )
    return _filled_in(compiled, method, period, pieces, ending)


def _pieces(compiled: Compiled, method: str, clock: Clock, parts: Sequence[SimulatorPart]) -> Pieces:
    """The parts of a program for a motion without contact modes."""
    eom, name = cast(Equations, compiled.equations), compiled.name
    held, sides = is_constrained(eom), bool(turning(eom))
    watched = sides or bool(eom.events)
    kernel = stepping_kernel(method, held, watched, sides)
    own = {"rhs": f"{name}_rates"} | {a: f"{name}_{own}" for part in parts for a, own in part.routines.items()}
    called = {a.name: own.get(a.name, "nothing") for a in kernel.arguments if isinstance(a, Callee)}
    called["rhs"] = "rates" if held else called["rhs"]
    called |= {a: f"{name}_hoist" for a in called if a.startswith("hoist_")}
    printed = emit_kernel_c(kernel, called, "static ")
    arrays = _arrays(kernel, parts)
    marks = {
        "@CONSTRAINTS@": _template("constraints") if held else "",
        "@GOES_ON@": _template("looks") if held else "",
        "@OPEN@": _template("open") if held else "",
        "@EVENTS@": _template("events") if watched else "",
        "@REPORT@": _template("report") if watched else _REPORT,
        "@BEGIN@": _begun(parts),
        "@SAY_BEGIN@": "\n    ".join(_SAY_BEGIN[part.name] for part in parts),
        "@GO_ON@": _template("go_on"),
        "@FIRST_ROW@": "print_row(0.0, m->y);\n    ",
        "@LOOKS@": f"{_HELD_LOOKS if held else ''}@CAPS@_UNDECIDED",
        "@FORGET@": "at_held_log[0] = 0.0;" if held else "",
        "@SAY_CHANGES@": _SAY_CHANGES if held else "",
        "@CALL@": _call(kernel, parts),
        "@CODES@": _CODES[0],
        **dict.fromkeys(("@SAY_UNKNOWN@", "@OWN_FIELDS@"), ""),
        **_clock(clock),
    }
    lines = [_NOTHING] * ("nothing" in called.values()) + [line for part in parts for line in part.lines]
    changing = {a: what for a, what in arrays.items() if isinstance(what, str) or not only_read(a, printed)}
    constant = {a: what for a, what in arrays.items() if a not in changing}
    return Pieces("", printed, constant, changing, lines, "".join(f"{part.shown}\n" for part in parts), marks)


def _contacts(compiled: Compiled, method: str, wanted: Sequence[Modes], more: TasksOf | None) -> Pieces:
    """The parts of a program for a motion whose contacts change their modes."""
    check_events(eom := cast(Equations, compiled.equations))
    held = is_constrained(eom)
    options = {"contract": compiled.settings.contract}
    modes = modes_of(compiled, method, wanted, 0 if wanted else MODES, "a program in C", **options)
    stepped = any(is_constrained(mode.equations) for mode in modes)
    pieces = contact_pieces(compiled, method, modes, _headers(compiled), more)
    marks = {
        "@CONSTRAINTS@": f"{_template('looks') if stepped else ''}@OPEN@",
        "@LOOKS@": _LOOKS_AGAIN if stepped else "",
        "@OPEN@": _template("open").replace("at_held_h", "m->h") if held else "",
        "@EVENTS@": _template("contacts"),
        "@REPORT@": "".join(f"{part.shown}\n" for part in constraints(eom)) + _template("contacts_report"),
        "@BEGIN@": f"begin_contacts(m);\n    return {'begin_on_constraints(m)' if held else '@CAPS@_BEGUN'};",
        "@SAY_BEGIN@": _SAY_BEGIN["constraints"] if held else "",
        "@GO_ON@": _template("contacts_go_on"),
        "@CODES@": _CODES[1],
        "@SAY_UNKNOWN@": _SAY_UNKNOWN,
        "@OWN_FIELDS@": _OWN_FIELDS,
        **dict.fromkeys(("@FIRST_ROW@", "@SAY_CHANGES@"), ""),
        "@FORGET@": "at_held_log[0] = 0.0;",
        **_clock(Clock((), ())),
    }
    return pieces._replace(marks=marks | dict(pieces.marks), lines=[_NOTHING, *pieces.lines])


_CODES = (
    " /* no step is short enough, or a rate is not finite */",
    """, /* no step is short enough, or a rate is not finite */
    @CAPS@_UNKNOWN = 6 /* a mode of contacts follows, `at_next_modes`, that there is none of */""",
)
_SAY_UNKNOWN = """if (said == @CAPS@_UNKNOWN) {
        (void)fprintf(stderr, "The motion stopped at t = %.9g: the next mode of the contacts is not in the program", m->s[AT_TIME]);
        for (int64_t k = 0; k < CONTACTS; k++) {
            (void)fprintf(stderr, "%s %s: %s", (k > 0) ? "," : ":", at_contacts[k], at_words[k][(int64_t)at_next_modes[k]]);
        }
        (void)fprintf(stderr, ". Emit the program with this mode, or simulate the motion with kane.\\n");
    }
    """
_LOOKS_AGAIN = """if ((back == @BACK_TAKE@) && (at_calls[1] == @LOOK@.0)) {
        again = goes_on(m);
    }"""
_OWN_FIELDS = """    int64_t enter; /* how the kernel that leads from mode to mode is entered */
    int64_t at_once; /* modes after which a call ends */
    int64_t kept; /* the row of `at_records` that goes on, or -1 */
    bool goes_on; /* whether the first row is told of already, up to a pause */
"""


def _filled_in(compiled: Compiled, method: str, period: float | None, pieces: Pieces, ending: str | None) -> str:
    """The templates with the parts of a motion inserted."""
    replaced = {
        "@FIELDS@": "".join(f"    double at_{a}[{_length(what)}];\n" for a, what in pieces.changing.items()),
        "@FILL_TABLES@": _filled(pieces.changing),
        "@GO_ON@": pieces.marks["@GO_ON@"],
        **_sampled(period),
        **pieces.marks,
    }
    text = _template("") + (ending or _template("main").replace("@REPORT@", f"@SHOWN@{replaced.pop('@REPORT@')}"))
    for mark, by in replaced.items():
        text = text.replace(mark, by)
    for a in pieces.changing:
        text = re.sub(rf"(?<!double )\bat_{a}\b", f"m->at_{a}", text)
    tables = _tables(pieces.constant, pieces.changing, pieces.lines)
    filled = {"@TABLES@": tables, "@KERNEL@": pieces.printed, "@SHOWN@": pieces.shown}
    for mark, by in (filled | _numbers(compiled, method)).items():
        text = text.replace(mark, by)
    return f"{pieces.equations}\n{text}"


def _numbers(compiled: Compiled, method: str) -> dict[str, str]:
    """The replacements of marks for names and numbers."""
    integrator, state = INTEGRATORS[method], cast(Equations, compiled.equations).state
    return {
        **{f"@{what}@": c_number(x) for what, x in _SHARES.items()},
        "@NAME@": compiled.name,
        "@CAPS@": compiled.name.upper(),
        "@METHOD@": method,
        "@FIXED@": "true" if integrator.fixed else "false",
        "@WORK@": str(integrator.work(len(state) + 1)),
        "@SIZE@": str(SIZE),
        "@PLACES@": "\n".join(f"    AT_{slot.name} = {int(slot)}," for slot in Slot),
        "@ACTS@": str(int(EventKind.ACTS)),
        "@ASKED@": str(int(EventKind.ASKED)),
        **{f"@{code.name}@": str(int(code)) for code in ReturnCode},
    }


def _check_period(period: float | None) -> None:
    if period is not None and not (expect.is_number(period) and period > 0):
        raise ProgramError(f"Expected a period above zero (s) of a sampled controller, got {period!r}.")


def _check_names(eom: Equations) -> None:
    for one in (*eom.state, *eom.parameters, *eom.inputs):
        if str(one) in SETTINGS:
            raise ProgramError(
                f"Expected names other than those of the program's settings, {', '.join(SETTINGS)}, got {str(one)!r} of the system: "
                f"{one}=value could mean either. Give it another name."
            )


def _untold(one: Discontinuity) -> str:
    """The reason why the program cannot find the times of a discontinuity; "" if it can."""
    return f"{one.quantity} switches rates and is not a linear function of time" if one.slope is None else ""


_REPORT = """/* Writes the samples. */
static void report(const @NAME@_motion *m, int64_t *printed)
{
    int64_t k = *printed;
    for (; k <= (int64_t)m->s[AT_SAMPLE]; k++) {
        print_row(m->times[k], &m->rows[k * N]);
    }
    *printed = k;
}"""
_SAY_BEGIN = {
    "events": """if (begun == @CAPS@_ON_THRESHOLD) {
        (void)fprintf(stderr, "Expected a start beside the threshold of the event %s, got one on it.\\n", at_names[m->which]);
    }""",
    "constraints": """if (begun == @CAPS@_OPEN) {
        (void)fprintf(stderr, "Expected a start on the constraints, got a residual of %.3g in %s and of %.3g in its rate. "
                      "Assemble the state.\\n", m->left, at_constraints[m->which], m->rate);
    }""",
}
_SAY_CHANGES = """for (int64_t k = 0; k < (int64_t)at_held_log[0]; k++) {
            (void)fprintf(stderr, "other dependent speeds at t = %.17g\\n", at_held_log[(2 * k) + 1]);
        }"""
_HELD_LOOKS = "goes_on(m) ? @CAPS@_LIMIT : "
_SHARES = {
    "POORER": POORER,
    "UNUSABLE": 1 / UNUSABLE,
    "ROUNDED_TERMS": ROUNDED_TERMS,
    "SHORTEST": EPS**2,
    "TEN_ROUNDINGS": 10 * EPS,
    "SAME_TIME": SAME_TIME,
}
_NOTHING = f"""/* What the motion does not ask for. */
static void nothing({TAKES})
{{
    (void)t;
    (void)x;
    (void)p;
    (void)r;
    (void)h;
    (void)out;
}}
"""


def _begun(parts: Sequence[SimulatorPart]) -> str:
    """The checks of the parts at the start, one after the other."""
    if not parts:
        return "return @CAPS@_BEGUN;"
    first, *others = (f"begin_{part.name}(m)" for part in parts)
    more = [f"if (said == @CAPS@_BEGUN) {{\n        said = {one};\n    }}" for one in others]
    return "\n    ".join([f"int said = {first};", *more, "return said;"])


def _sampled(period: float | None) -> dict[str, str]:
    """The replacements of marks for a sampled controller."""
    marks = ("@CONTROL@", "@ASK@", "@ASK_AGAIN@", "@AIM_AT_CONTROL@", "@COMPLETE@")
    if period is None:
        return dict.fromkeys(marks, "") | {"@COMPLETE@": " && complete(@NAME@_inputs, @CAPS@_INPUTS, m->r)"}
    texts = (text.replace("@PERIOD@", c_number(float(period))) for text in (*_CONTROLLED, ""))
    return dict(zip(marks, texts, strict=True))


_CONTROLLED = (
    """
/* The sampled controller, in another file: it writes the inputs that hold from time t on, by the state x. */
extern void @NAME@_control(double t, const double *x, double *inputs);
""",
    "@NAME@_control(m->start, m->y, m->r);",
    """const double instant = m->start + ((double)m->asked * @PERIOD@);
        if (m->s[AT_TIME] >= (instant - (@ULPS@.0 * spacing(instant)))) {
            @NAME@_control(instant, m->y, m->r);
            m->asked++;
        }""",
    """const double instant = m->start + ((double)m->asked * @PERIOD@);
    if ((instant > t) && (instant < stop)) {
        stop = instant;
    }""",
)


def _template(name: str) -> str:
    return files("kane.motion.programs").joinpath(f"simulator{'_' * bool(name)}{name}.c").read_text(encoding="utf-8")


def _call(kernel: Kernel, parts: Sequence[SimulatorPart]) -> str:
    """The call of the kernel with its arguments."""
    given: dict[str, str] = dict(_ARGUMENTS)
    for part in parts:
        given |= {a: str(what) if isinstance(what, int) else f"at_{a}" for a, what in part.given.items()}
    own = (a.name for a in kernel.arguments if not isinstance(a, Callee))
    return f"{kernel.name}({', '.join(given.get(a, f'at_{a}') for a in own)})"


def _arrays(kernel: Kernel, parts: Sequence[SimulatorPart]) -> dict[str, Array | str]:
    """The arrays of the parts that the kernel takes, copies of h, and placeholders for arrays that the motion does not need."""
    found: dict[str, Array | str] = {}
    for part in parts:
        found |= {a: what for a, what in part.given.items() if isinstance(what, np.ndarray)}
        found |= dict.fromkeys(part.hoisted, "@CAPS@_HOISTED + 1")
    known = {*_ARGUMENTS, *found, *(a for part in parts for a in part.given)}
    wanted = [a.name for a in kernel.arguments if not isinstance(a, Callee) and a.name not in known]
    hoists = {a.name for a in kernel.arguments if isinstance(a, Callee)}
    return found | {a: "@CAPS@_HOISTED + 1" if f"hoist_{a}" in hoists else np.zeros(1) for a in wanted}


def _length(what: Array | str) -> str:
    return what if isinstance(what, str) else str(len(what))


def _tables(constant: Mapping[str, Array | str], changing: Mapping[str, Array | str], own: Sequence[str]) -> str:
    """The lines of the motion, the constant tables, and nonzero initial values of writable ones."""
    lines = list(own)
    first = {f"first_{a}": what for a, what in changing.items() if _begins(what)}
    for name, what in ({f"at_{a}": what for a, what in constant.items()} | first).items():
        assert not isinstance(what, str)
        lines.append(f"static const double {name}[{len(what)}] = {{{', '.join(map(c_number, what.tolist()))}}};")
    return "\n".join([*lines, ""])


def _begins(what: Array | str) -> bool:
    return not isinstance(what, str) and bool(what.any())


def _filled(changing: Mapping[str, Array | str]) -> str:
    """The C functions that initialize the tables of a motion, and that compute and copy h."""
    loop = "    for (int64_t k = 0; k < ({0}); k++) {{\n        at_{1}[k] = {2};\n    }}"
    fills = [loop.format(_length(w), a, f"first_{a}[k]" if _begins(w) else "0.0") for a, w in changing.items()]
    copies = [loop.format(w, a, "m->h[k]") for a, w in changing.items() if isinstance(w, str)]
    return "\n".join(
        [
            "/* What a motion begins with besides its state. */",
            "static void fill_tables(@NAME@_motion *m)",
            "{",
            *(fills or ["    (void)m;"]),
            "}",
            "",
            "/* What follows from parameters alone, and copies of it: arrays that a kernel takes do not overlap. */",
            "static void hoist(@NAME@_motion *m)",
            "{",
            "    @NAME@_hoist(m->p, m->h);",
            *copies,
            "}",
            "",
        ]
    )


def _equations(
    compiled: Compiled, clock: Clock, parts: Sequence[SimulatorPart], others: tuple[Sequence[str], Sequence[Task]]
) -> str:
    """The C code of the rates, the tasks of parts, `others`, and the clock's quantities with their slopes and pulses, if any."""
    eom, contract = cast(Equations, compiled.equations), compiled.settings.contract
    slopes = [ZERO if one.slope is None else one.slope for one in clock.turning]
    roots: list[Expr] = [*(one.quantity for one in clock.turning), *slopes, *clock.pulses]
    more = [*others[1], *([Bundle("clock", ports(eom.derived), tuple, {"clock": roots}).task] if roots else [])]
    made = motion_program(compiled, parts, more, routines=others[0])
    return emit_c(made, contract=contract, version=version("kane"), headers=_headers(compiled))


def _headers(compiled: Compiled) -> str:
    return _HEADERS.replace("@CAPS@", compiled.name.upper())


_HEADERS = """#include <stdbool.h>
#include <stdint.h>
#ifndef @CAPS@_NO_MAIN
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#endif
"""


def _clock(clock: Clock) -> dict[str, str]:
    """The replacements of marks for the search for discontinuities and pulses in time."""
    turning, pulses = bool(clock.turning), bool(clock.pulses)
    most = sum(one.most if one.data.period else min(one.most, len(one.data.ends)) for one in clock.turning)
    return {
        "@FIND_STOPS@": _template("stops") if any(clock) else "",
        "@STOPS_FOUND@": "find_stops(m);" if any(clock) else "",
        "@FIND_LEVELS@": _template("levels") if turning else "",
        "@FIND_PULSES@": _template("pulses") if pulses else "",
        "@STOPS_BY_LEVELS@": _NOW + (_BY_LEVELS if turning else ""),
        "@STOPS_BY_PULSES@": _BY_PULSES if pulses else "",
        "@TURNING@": str(len(clock.turning)),
        "@PULSES@": str(len(clock.pulses)),
        "@LOOKED_AT@": str(PLACES),
        "@MOST_PULSES@": str(MOST),
        "@STOPS@": str(most + 3 * MOST * len(clock.pulses)),
        "@RISEN@": c_number(LEAPS),
        "@SHARE@": c_number(SHARE),
        "@ULPS@": str(ULPS),
        "@LEVELS@": _levels(clock.turning),
    }


_NOW = """double now[(2 * TURNING) + PULSES];
    @NAME@_clock(m->start, m->y, m->p, m->r, m->h, now);
    """
_BY_LEVELS = """for (int64_t k = 0; k < TURNING; k++) {
        add_levels(m, &turnings[k], now[k], now[TURNING + k]);
    }"""
_BY_PULSES = """static double values[PULSES][PLACES];
    static double sorted[PLACES];
    const int64_t parts = PLACES - 1;
    const double step = (m->end - m->start) / (double)parts;
    for (int64_t i = 0; i < PLACES; i++) {
        @NAME@_clock((i == parts) ? m->end : (m->start + ((double)i * step)), m->y, m->p, m->r, m->h, now);
        for (int64_t k = 0; k < PULSES; k++) {
            values[k][i] = now[(2 * TURNING) + k];
        }
    }
    for (int64_t k = 0; k < PULSES; k++) {
        add_pulses(m, values[k], sorted);
    }"""


def _levels(turning: Sequence[Discontinuity]) -> str:
    """The C tables of levels."""
    if not turning:
        return ""
    lines, rows = [], []
    for k, one in enumerate(turning):
        lines.append(f"static const double levels_{k}[] = {{{', '.join(map(c_number, one.data.ends.tolist()))}}};")
        start, period = one.data.period or (0.0, 0.0)
        rows.append(f"{{levels_{k}, {c_number(start)}, {c_number(period)}, {len(one.data.ends)}, {one.most}}}")
    return "\n".join([_TURNING, *lines, f"static const turning turnings[TURNING] = {{{', '.join(rows)}}};"])


_TURNING = """typedef struct {
    const double *levels;
    double start;
    double period; /* a period of 0: levels do not come again */
    int64_t count;
    int64_t most;
} turning;"""
