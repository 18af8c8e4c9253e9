# SPDX-License-Identifier: BSD-3-Clause
"""A motion with contacts in C: the stepping kernels of a method, a table of contact modes, and the kernel of the hybrid automaton.

The kernels are those of `simulate`. Modes without constraints share one kernel, modes with constraints another; the table contains
the routines, numbers and offsets that differ.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import NamedTuple, cast

import numpy as np

from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.model.contacts import ContactMode
from kane.motion.hybrid.contact_automaton import AGAIN, Back, Record, automaton_kernel
from kane.motion.hybrid.contact_events import OPENS, SLIPPING
from kane.motion.hybrid.contact_tables import row_of, structure
from kane.motion.programs.program_modes import ModeOfProgram, TasksOf, parameters_from, programs_of, tables_of
from kane.motion.programs.simulator_parts import Pieces, constraints, dispatched, only_read, stepping_kernel
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Given
from kane.motion.steppers.crossings import LEAVES
from kane.motion.steppers.held import CHANGES
from kane.motion.steppers.watched import rooms
from kane.numeric.arrays import Array
from kane.program.emit.c import emit_c
from kane.program.emit.c_kernels import emit_kernel_c
from kane.program.emit.identifiers import c_number, c_string
from kane.program.kernel.language import Argument, ArrayOf, Callee, Integer, Kernel
from kane.program.kernel.rewriting import specialized
from kane.program.program import Program

ROWS = 128
"""Largest number of modes in one call, after which the records must be read; more than occur at one instant."""
_GIVEN = {
    **{name: f"m->{name}" for name in ("s", "y", "r")},
    "samples": "m->samples - 1",
    "limit": "m->limit",
    "times": "&m->times[1]",
    "rows": "&m->rows[N]",
    "held_marks": "m->marks",
    "enter": "m->enter",
    "at_once": "m->at_once",
    "work": "m->work",
    "lag": "m->lag",
}
"""C expressions for arguments that are common to all modes."""
_OF_MODES = {
    "p": "ps",
    "seen": "seen",
    "largest": "largest",
    "least": "least",
    "leaves": "leaves",
    "held_reach": "held_reach",
}
"""Arrays of the automaton with a part for each mode, by the argument name in the stepping kernel."""
_HOISTED = ("h", "hd", "hw", "hg", "ht", "ha", "held_h")
_VARYING = {"rhs": "rates", "watch": "events", "glance": "glance", "constraints": "holding"}
_RATE = "void (*{0})(double, const double *, const double *, const double *, const double *, double *)"


class _ModeRow(NamedTuple):
    """A mode as a row of the table: its numbers, the initial values of its arrays, and the names of its routines."""

    mode: ModeOfProgram
    held: bool
    integers: Mapping[str, int]
    arrays: Mapping[str, Array]
    routines: Mapping[str, str]


def contact_pieces(
    compiled: Compiled, method: str, modes: Sequence[ModeOfProgram], headers: str, more: TasksOf | None
) -> Pieces:
    """The parts of a program for equations whose contacts have these modes; `more` are further tasks evaluated in each mode."""
    eom, name, contract = cast(Equations, compiled.equations), compiled.name, compiled.settings.contract
    touch, programs = programs_of(compiled, modes, contract, more, starts=True)
    programs = [replace(one, name=f"{name}_m{k}") for k, one in enumerate(programs)]
    tables = structure(eom, ROWS)
    own = tables_of(eom, modes, tables)
    rows = [_row(k, one, p, tables["n"]) for k, (one, p) in enumerate(zip(modes, programs, strict=True))]
    kernels = {held: _kernel(rows, held, method) for held in dict.fromkeys(row.held for row in rows)}
    named = {f"hoist_{a}": f"{name}_hoist" for a in _HOISTED}
    texts = []
    for kernel in kernels.values():
        idle = {a.name: "nothing" for a in kernel.arguments if isinstance(a, Callee) and a.name not in _VARYING}
        texts.append(emit_kernel_c(kernel, idle | named, "static "))
    integers = {a: what for a, what in tables.items() if isinstance(what, int)}
    leads = specialized(automaton_kernel(), {**integers, "known": len(modes), "driven": 0, "alone": 1, "most": 2**53})
    calls = {"make": "make_mode", "hoist": "hoist_mode", "look": "look_mode", "touch": f"{name}_contacts"}
    leading = emit_kernel_c(leads, calls, "static ", ("m", f"{name}_motion *m"), tuple(calls)[:3])
    table = _Table(rows, "\n".join([*texts, leading]), more is not None)
    wanted = {_OF_MODES.get(a.name, a.name) for kernel in kernels.values() for a in kernel.arguments}
    wanted |= {"p_from", *(a.name for a in leads.arguments)}
    arrays = {a: what for a, what in _arrays(eom, tables, own, touch, modes).items() if a in wanted}
    constant = {a: what for a, what in arrays.items() if a not in ("p_from", "tolerances") and table.only_reads(a)} | {
        "p_from": arrays["p_from"]
    }
    changing: dict[str, Array | str] = {a: what for a, what in arrays.items() if a not in constant}
    always = constraints(eom)
    for part in always:
        changing["held_room"] = cast(Array, part.given["held_room"])
        constant["held_entry_at"] = cast(Array, part.given["held_entry_at"])
    constant = {a: what if len(what) else np.zeros(1) for a, what in constant.items()}
    changing = {a: what if len(what) else np.zeros(1) for a, what in changing.items()}
    changing |= {"own": table.first, "mode_h": np.zeros(max(len(p.kept) for p in programs) + 1)}
    parts = {to: own[to][0].size for to in _OF_MODES.values()}
    functions = [_stepped(kernel, table, constant, parts, name) for kernel in kernels.values()]
    call = ", ".join(["m", *(_at(a) for a in leads.arguments if not isinstance(a, Callee))])
    return Pieces(
        emit_c(touch, contract=contract, version=version("kane"), headers=headers, besides=programs),
        "\n".join([*texts, *functions, _chosen(name, list(kernels), parts), leading]),
        constant,
        changing,
        [_counts(tables, modes, parts), *(line for part in always for line in part.lines[:1]), *table.lines(kernels)],
        _shown(eom, modes),
        {
            "@CALL@": f"contacts({call})",
            "@OPENS@": str(OPENS),
            "@SLIPS@": str(SLIPPING),
            **{f"@BACK_{back.name}@": str(int(back)) for back in Back},
        },
    )


def _row(k: int, mode: ModeOfProgram, program: Program, n: int) -> _ModeRow:
    """The row of the kth mode."""
    given: Given = {}
    for part in mode.parts:
        given |= part.given
    routines = {
        a: f"{program.name}_{task}" for part in mode.parts for a, task in part.routines.items() if a in _VARYING
    }
    integers = {a: what for a, what in given.items() if isinstance(what, int)} | {"n": n, "driven": 0, "breakpoints": 0}
    arrays = {a: cast(Array, what) for a, what in given.items() if not isinstance(what, int) and a not in _OF_MODES}
    held = is_constrained(mode.equations)
    routines["outputs"] = f"{program.name}_outputs"
    routines["rhs"] = f"{program.name}_chosen" if held else f"{program.name}_rates"
    return _ModeRow(mode, held, integers, arrays, routines | {"hoist": f"{program.name}_hoist"})


def _kernel(rows: Sequence[_ModeRow], held: bool, method: str) -> Kernel:
    """The stepping kernel of the modes with or without constraints; integers equal in all of them are compiled in."""
    first, *others = (row for row in rows if row.held == held)
    watched = any(row.mode.equations.events for row in (first, *others))
    same = {a: x for a, x in first.integers.items() if all(row.integers.get(a) == x for row in others)}
    kernel = specialized(stepping_kernel(method, held, watched), same)
    return replace(kernel, name=f"{method}_{'held' if held else 'free'}")


def _arrays(
    eom: Equations, tables: Given, own: Mapping[str, Array], touch: Program, modes: Sequence[ModeOfProgram]
) -> dict[str, Array]:
    """The arrays that all modes share, with their initial values."""
    n, count = tables["n"], tables["event_count"]
    lengths = rooms(count, count, 0, n)
    return {
        **{a: cast(Array, what) for a, what in tables.items() if not isinstance(what, int) and a != "lag"},
        **{a: what.reshape(-1) for a, what in own.items()},
        "numbers": np.zeros(len(touch.routines[0].results) + 1),
        "held_log": np.zeros(2 * CHANGES + 3),
        "log": np.zeros(lengths["log"] + 2 * count),
        "jumps": np.zeros(lengths["jumps"] + 2 * count),
        "calls": np.zeros(3),
        "tolerances": np.zeros(3),
        "p_from": parameters_from(touch, modes, tables["p_count"]).reshape(-1),
    }


class _Table:
    """The table of modes: what differs between them, and the offsets of their writable arrays in one common array `first`."""

    def __init__(self, rows: Sequence[_ModeRow], printed: str, puts: bool) -> None:
        self.rows, self.printed, self.puts = rows, printed, puts
        self.names = list(dict.fromkeys(a for row in rows for a in row.arrays if a not in ("held_log", "log", "jumps")))
        self.places: list[dict[str, int]] = []
        found: list[Array] = []
        at = 0
        for row in rows:
            self.places.append({})
            for a in self.names:
                if a in row.arrays and not self.only_reads(a):
                    self.places[-1][a] = at
                    found.append(row.arrays[a])
                    at += len(found[-1])
        self.first = np.concatenate([*found, np.zeros(1)])

    def only_reads(self, array: str) -> bool:
        """Whether no kernel writes to an array."""
        return only_read(array, self.printed)

    def lines(self, kernels: Mapping[bool, Kernel]) -> list[str]:
        """The C text of the table, its arrays, and the rates of modes with several choices of dependent speeds."""
        wanted = {a.name for kernel in kernels.values() for a in kernel.arguments}
        integers = sorted(a.name for kernel in kernels.values() for a in kernel.arguments if isinstance(a, Integer))
        integers = [a for a in dict.fromkeys(integers) if a not in _GIVEN]
        routines = [*(a for a in _VARYING if a in wanted), *["outputs"] * self.puts]
        arrays = [a for a in self.names if a in wanted]
        kinds = {a: f"const double *{a}" if self.only_reads(a) else f"int64_t {a}" for a in arrays}
        fields = ["void (*hoist)(const double *, double *)", *map(_RATE.format, routines), "bool held"]
        fields += [*(f"int64_t {a}" for a in integers), *kinds.values()]
        lines, known, texts = [_NOTHING], dict[bytes, str](), []
        for k, row in enumerate(self.rows):
            if row.held:
                lines += _rates(row)
            own = [
                row.routines["hoist"],
                *(row.routines.get(a, "nothing") for a in routines),
                "true" if row.held else "false",
            ]
            own += [str(row.integers.get(a, 0)) for a in integers]
            for a in arrays:
                if not self.only_reads(a):
                    own.append(str(self.places[k].get(a, 0)))
                    continue
                values = row.arrays.get(a, np.zeros(1))
                if values.tobytes() not in known:
                    known[values.tobytes()] = f"{a}_{k}"
                    numbers = ", ".join(map(c_number, values.tolist() or [0.0]))
                    lines.append(f"static const double {a}_{k}[] = {{{numbers}}};")
                own.append(known[values.tobytes()])
            texts.append(f"    {{{', '.join(own)}}},")
        members = "\n".join(f"    {field};" for field in fields)
        record = f"{_TOLD}typedef struct {{\n{members}\n}} mode_row;"
        return [*lines, record, "static const mode_row mode_rows[KNOWN] = {", *texts, "};"]


def _rates(row: _ModeRow) -> list[str]:
    """The rates, dispatched by the choice of dependent speeds."""
    tasks = [task.name for part in row.mode.parts for task in part.tasks if task.name.startswith("rates_")]
    prefix = row.routines["hoist"].removesuffix("hoist")
    return dispatched([f"{prefix}{task}" for task in tasks], str(row.integers["held_choice_at"]), row.routines["rhs"])


def _at(a: Argument) -> str:
    """The C expression for an argument of the automaton kernel."""
    return {**_GIVEN, "p": "m->p", "h": "m->h"}.get(a.name, f"at_{a.name}")


def _stepped(kernel: Kernel, table: _Table, constant: Mapping[str, Array], parts: Mapping[str, int], name: str) -> str:
    """The C function that runs the stepping kernel in the kth mode."""

    def given(a: Argument) -> str:
        own = "" if _OF_MODES.get(a.name, a.name) in constant else "m->"
        if a.name in _GIVEN or isinstance(a, Callee):
            return _GIVEN.get(a.name, a.name)
        if a.name in _HOISTED:
            return "m->at_mode_h"
        if a.name in _OF_MODES:
            return f"&{own}at_{_OF_MODES[a.name]}[k * {parts[_OF_MODES[a.name]]}]"
        if a.name in ("log", "jumps", "held_log"):
            return f"{own}at_{a.name}"
        if a.name in table.names and isinstance(a, ArrayOf) and not table.only_reads(a.name):
            return f"&m->at_own[mode->{a.name}]"
        return f"mode->{a.name}" if a.name in table.names or not isinstance(a, ArrayOf) else "idle"

    own = [a for a in kernel.arguments if not isinstance(a, Callee) or a.name in _VARYING]
    return "\n".join(
        [
            f"static int64_t step_{kernel.name.rpartition('_')[2]}({name}_motion *m, int64_t k)",
            "{",
            "    const mode_row *const mode = &mode_rows[k];",
            *(f"    {_RATE.format(a.name)} = mode->{a.name};" for a in own if isinstance(a, Callee)),
            f"    return {kernel.name}({', '.join(map(given, own))});",
            "}",
            "",
        ]
    )


def _chosen(name: str, kinds: Sequence[bool], parts: Mapping[str, int]) -> str:
    """The C functions that the automaton kernel calls for the current mode."""
    steps = " : ".join(
        [
            *(["mode_rows[k].held ? step_held(m, k)"] * (len(kinds) > 1)),
            f"step_{'held' if kinds == [True] else 'free'}(m, k)",
        ]
    )
    return (
        _CHOSEN.replace("@STEP@", steps)
        .replace("@PARAMETERS_OF@", str(parts["ps"]))
        .replace("@MOTION@", f"{name}_motion")
    )


_CHOSEN = """/* Steps of the mode at hand, what is hoisted for it, the quantities of its events. */
static void make_mode(@MOTION@ *m, double *calls)
{
    const int64_t k = (int64_t)calls[0];
    calls[1] = (double)(@STEP@);
}

static void hoist_mode(@MOTION@ *m, const double *calls)
{
    const int64_t k = (int64_t)calls[0];
    mode_rows[k].hoist(&m->at_ps[k * @PARAMETERS_OF@], m->at_mode_h);
}

static void look_mode(const @MOTION@ *m, double t, const double *x, const double *r, const double *calls, double *out)
{
    const int64_t k = (int64_t)calls[0];
    mode_rows[k].glance(t, x, &m->at_ps[k * @PARAMETERS_OF@], r, m->at_mode_h, out);
}
"""
_TOLD = "\n/* Modes: routines, numbers, tables, places of what changes. */\n"
_NOTHING = "static const double idle[1] = {0.0};"


def _counts(tables: Given, modes: Sequence[ModeOfProgram], parts: Mapping[str, int]) -> str:
    """The enumeration of table sizes."""
    counts = {
        "KNOWN": len(modes),
        "CONTACTS": tables["contacts"],
        "EVENTS_OF": tables["event_count"],
        "LEAVING": LEAVES,
        "ENTERS": 2,
        "AT_ONCE": ROWS,
        "AGAIN": AGAIN,
        "PARAMETERS_OF": parts["ps"],
        "WIDTH": row_of(tables["contacts"], tables["dimension"], tables["n"]),
    }
    counts |= {"FIRST_STATE": counts["WIDTH"] - 2 * tables["n"], "LAST_STATE": counts["WIDTH"] - tables["n"]}
    counts |= {f"ROW_{row.name}": int(row) for row in Record}
    return f"enum {{ {', '.join(f'{a} = {x}' for a, x in counts.items())} }};"


def _shown(eom: Equations, modes: Sequence[ModeOfProgram]) -> str:
    """The C tables of names: of contacts, of their modes, and of events."""
    contacts = eom.system.contacts
    names = ", ".join(c_string(c.name) for c in contacts)
    words = ", ".join(f"{{{', '.join(c_string(m.word(c)) for m in ContactMode)}}}" for c in contacts)
    digits = ", ".join(f"{{{', '.join(str(int(m)) for m in one.modes)}}}" for one in modes)
    events = ", ".join(
        f"{{{', '.join([*(c_string(e.name) for e in one.equations.events), c_string('')])}}}" for one in modes
    )
    longest = max(len(one.equations.events) for one in modes) + 1
    return "\n".join(
        [
            f"static const char *const at_contacts[CONTACTS] = {{{names}}};",
            f"static const char *const at_words[CONTACTS][{len(ContactMode)}] = {{{words}}};",
            f"static const int at_digits[KNOWN][CONTACTS] = {{{digits}}};",
            f"static const char *const at_names[KNOWN][{longest}] = {{{events}}};",
        ]
    )
