# SPDX-License-Identifier: BSD-3-Clause
"""Events and constraints of a motion as parts of a program in another language: tables, routines and texts."""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, lru_cache
from typing import Any, NamedTuple, cast

import numpy as np

from kane.equations.compiled import Compiled, program
from kane.equations.equations import Equations, repartition
from kane.errors import KaneError, ProgramError
from kane.expr.node import Expr
from kane.expr.piecewise import side_symbol
from kane.motion.constraint_kernels import alike, among, choices, holding, structure
from kane.motion.hybrid.automaton import actions, glance, tables, tendency, values_set, watched
from kane.motion.inputs.breakpoints import Discontinuity
from kane.motion.inputs.smooth import pieces_prescribed
from kane.motion.methods import needs
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Given, has_jumps, quantities, rates, sided, timed
from kane.motion.steppers.crossings import KINDS, EventKind
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.arrays import Array
from kane.program.emit.identifiers import c_string
from kane.program.from_expressions import Bundle, Task
from kane.program.kernel.language import Kernel
from kane.program.program import Program

METHODS = tuple(name for name, i in INTEGRATORS.items() if i.width == 1 and not i.implicit)
"""The integrators available in generated programs: explicit ones that step one state at a time."""
TAKES = "double t, const double *x, const double *p, const double *r, const double *h, double *out"
"""The parameters of a routine in C."""


class SimulatorPart(NamedTuple):
    """A feature of a motion besides stepping: tables, tasks, the routines that a kernel calls by argument name, and texts.

    `hoisted` are the names of h in calls of routines: copies of one array, since arguments of kernels must not overlap. `shown` is
    text that only `main` needs, `undecided` are the reasons why a program cannot decide the motion.
    """

    name: str
    given: Given
    tasks: Sequence[Task]
    routines: Mapping[str, str]
    hoisted: Sequence[str]
    lines: Sequence[str]
    shown: str
    undecided: Sequence[str] = ()


class Pieces(NamedTuple):
    """The parts of a program in C: equations, kernels, constant tables, writable arrays, lines before them, text for `main`, marks."""

    equations: str
    printed: str
    constant: Mapping[str, Array | str]
    changing: Mapping[str, Array | str]
    lines: Sequence[str]
    shown: str
    marks: Mapping[str, str]


def checked(
    compiled: Compiled, method: str, what: str, untold: Callable[[Discontinuity], str], switching: bool = False
) -> None:
    """Checks that a program in another language, which messages call `what`, can run the motion.

    `untold` returns the reason why it cannot find the times of a discontinuity; with `switching` loads may jump.

    Raises
    ------
    ProgramError
        if it cannot, or the method is unknown
    """
    if method not in METHODS:
        raise ProgramError(f"Expected an integrator among {', '.join(METHODS)} for {what}, got {method!r}.")
    eom = cast(Equations, compiled.equations)
    wrong = (
        needs(eom, INTEGRATORS[method])
        + ["loads or inputs jump"] * (has_jumps(eom) and not switching)
        + [text for part in parts_of(eom) for text in part.undecided]
        + [text for one in timed(eom).turning if (text := untold(one))]
        + [f"{piece} prescribes a motion, which may jump" for piece in pieces_prescribed(eom)]
    )
    if wrong:
        raise ProgramError(
            f"Expected a motion that {what} supports, got one in which {' and '.join(wrong)}. Emit only the equations and use "
            "another integrator, or use kn.simulate."
        )


@cache
def stepping_kernel(method: str, held: bool = False, watched: bool = False, sided: bool = False) -> Kernel:
    """The kernel of a method, for motions with constraints (`held`), events (`watched`) or switching surfaces (`sided`)."""
    asked = {"held": held, "watched": watched, "sided": sided}
    return INTEGRATORS[method].kernel(**{what: True for what, so in asked.items() if so})


def only_read(array: str, printed: str) -> bool:
    """Whether the printed C functions only read an array."""
    return array not in _written(printed)


@lru_cache(maxsize=2)
def _written(printed: str) -> frozenset[str]:
    """The arrays that C functions write to; cached, since the text may have a million characters."""
    return frozenset(re.findall(r"(?<!const )double \*(\w+)[,)]", printed))


def turning(eom: Equations) -> tuple[Expr, ...]:
    """The switching quantities that the kernel decides; their sides follow the parameters in p."""
    return quantities(eom) if has_jumps(eom) else ()


def _task(eom: Equations, make: Callable[..., Bundle[Any]], *more: Expr) -> Task:
    """The task of a bundle, evaluated on given sides of the switching surfaces."""
    count = len(turning(eom))
    return (sided(eom, count, make, *more) if count else make(eom, *more)).task


def parts_of(eom: Equations) -> list[SimulatorPart]:
    """The parts for events and constraints."""
    return [*events(eom), *constraints(eom)]


def motion_program(
    compiled: Compiled,
    parts: Sequence[SimulatorPart],
    more: Sequence[Task] = (),
    contract: bool | None = None,
    routines: Sequence[str] = (),
) -> Program:
    """The program of "rates" (without constraints), tasks of the parts and `more`, and routines of the equations by name."""
    eom, settings = cast(Equations, compiled.equations), compiled.settings
    contract = settings.contract if contract is None else contract
    own = [] if is_constrained(eom) else [replace(_task(eom, rates), name="rates")]
    beside = tuple(map(side_symbol, range(len(turning(eom)))))
    tasks = [*own, *(task for part in parts for task in part.tasks), *more]
    optimize = contract and settings.optimize
    return program(
        eom.solved, routines, more=tasks, beside=beside, name=compiled.name, reciprocals=contract, optimize=optimize
    )


def events(eom: Equations) -> list[SimulatorPart]:
    """Events and switching surfaces, with messages for those that Python would have to decide."""
    turns = turning(eom)
    if not eom.events and not turns:
        return []
    given, count = tables(eom, len(eom.state) + 1, len(turns)), len(eom.events) + len(turns)
    kinds = given["kinds"].reshape(-1, KINDS)[:, 0]
    asked = [e for e, kind in zip(eom.events, kinds, strict=False) if kind >= EventKind.ASKED and e.then is not None]
    acting = [_task(eom, make) for make in (tendency, actions)] if values_set(eom) else []
    made = [_task(eom, watched, *turns), _task(eom, glance, *turns), *acting]
    names = ", ".join(c_string(e.name) for e in eom.events) or '""'
    return [
        SimulatorPart(
            "events",
            given | {name: np.zeros(count) for name in ("seen", "largest")} | {"sides_at": len(eom.parameters)},
            made,
            dict(zip(("watch", "glance", "tendency", "act"), (task.name for task in made), strict=False)),
            ("hw", "hg", "ht", "ha"),
            [
                f"enum {{ EVENTS = {len(eom.events)}, SEEN = {count}, KINDS = {KINDS}, LEAVING = {len(given['leaves'])} }};"
            ],
            f"static const char *const at_names[] = {{{names}}};",
            [f"the event {e.name!r} needs decisions that numbers alone do not determine" for e in asked],
        )
    ]


def constraints(eom: Equations) -> list[SimulatorPart]:
    """Constraints, with all choices of dependent speeds if there are few."""
    if not is_constrained(eom):
        return []
    found = _choices(eom)
    given = structure(eom, len(eom.state) + 1)
    place = len(eom.parameters) + len(turning(eom))
    given |= among([one.embedding.partition for one in found if one.embedding], place)
    given["held_ready"][:] = 1.0
    tasks = [holding(eom).task, *(replace(_task(one, rates), name=f"rates_{k}") for k, one in enumerate(found))]
    rows = [c.name for c in eom.derived.constraints.constraints]
    return [
        SimulatorPart(
            "constraints",
            given,
            tasks,
            {"constraints": "holding"},
            ("held_h",),
            [
                f"enum {{ CLOSURES = {given['held_closures']}, ROWS = {given['held_rows']}, "
                f"BRANCHES = {given['held_branches']}, ENTRIES = {given['held_entries']}, SPEEDS = {len(eom.speeds)}, "
                f"COORDINATES = {len(eom.coordinates)} }};",
                *dispatched([f"@NAME@_rates_{k}" for k in range(len(found))], "@CAPS@_PARAMETERS"),
            ],
            f"static const char *const at_constraints[] = {{{', '.join(map(c_string, [*rows, '']))}}};",
            [] if eom.solved.twin is None else ["W has false poles"],
        )
    ]


def _choices(eom: Equations) -> list[Equations]:
    """The equations with each choice of dependent speeds for the same rows, the current one first; only it, if there are many."""
    found = [eom]
    for choice in choices(eom)[1:]:
        with suppress(KaneError):
            found.append(eom.numeric().value(repartition, choice))
    switches = list(map(id, turning(eom)))
    return [one for one in found if one is eom or (alike(eom, one) and list(map(id, turning(one))) == switches)]


def dispatched(rates: Sequence[str], place: str, name: str = "rates") -> list[str]:
    """The C function of the rates, which selects by the choice of dependent speeds, stored in p after the parameters."""
    call = "        {0}(t, x, p, r, h, out);\n        break;"
    cases = [f"    case {k}:\n{call.format(one)}" for k, one in enumerate(rates[:-1])]
    cases.append(f"    default:\n{call.format(rates[-1])}")
    body = cases if len(rates) > 1 else [f"    {rates[0]}(t, x, p, r, h, out);"]
    if len(rates) > 1:
        body = [f"    switch ((int)p[{place}]) {{", *body, "    }"]
    return [f"static void {name}({TAKES})", "{", *body, "}", ""]
