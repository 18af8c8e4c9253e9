# SPDX-License-Identifier: BSD-3-Clause
"""The contact modes of a generated program, their equations, and the tables for transitions between them."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NamedTuple, cast

import numpy as np

from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.equations.mode_equations import ContactModes, contact_numbers
from kane.errors import KaneError, ProgramError
from kane.model.contacts import ContactMode, Modes
from kane.motion.constraint_kernels import entries
from kane.motion.hybrid.contact_tables import MODES, code_of, of_modes, possible, put_mode, reach_of
from kane.motion.programs.simulator_parts import SimulatorPart, checked, constraints, motion_program, parts_of
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Given
from kane.numeric.arrays import Array
from kane.program.from_expressions import Task, build_program
from kane.program.program import Program


class ModeOfProgram(NamedTuple):
    """A contact mode, its compiled equations, and its events and constraints as parts of a program."""

    modes: Modes
    compiled: Compiled
    parts: Sequence[SimulatorPart]

    @property
    def equations(self) -> Equations:
        """The equations of the mode."""
        return cast(Equations, self.compiled.equations)


def modes_of(
    compiled: Compiled,
    method: str,
    wanted: Sequence[Modes] = (),
    most: int = MODES,
    what: str = "a module of WebAssembly",
    **options: Any,
) -> list[ModeOfProgram]:
    """The modes of a program, which messages call `what`: the `wanted` ones, and all possible ones if there are at most `most`.

    Modes from `ContactMode.ACROSS` on are left out. `options` are those of compilation, by default without contraction.

    Raises
    ------
    ProgramError
        if the program can run none of them
    """
    eom, said = cast(Equations, compiled.equations), ""
    every, found = possible(eom.system.contacts), list[ModeOfProgram]()
    for modes in dict.fromkeys([*wanted, *(every if len(every) <= most else ())]):
        if max(modes) >= ContactMode.ACROSS:
            said = said or "modes with redundant contacts of one rigid body"
            continue
        with suppress(KaneError):  # an impossible mode
            one = eom.numeric().value(ContactModes).equations(modes)
            mode = ModeOfProgram(modes, one.compile(**{"contract": False} | options), parts_of(one))
            try:
                checked(mode.compiled, method, what, lambda one: f"{one.quantity} switches rates")
            except ProgramError as error:
                said = said or str(error)
                continue
            if tuple(map(id, mode.equations.inputs)) == tuple(map(id, eom.inputs)):
                found.append(mode)
    if not found:
        many = f"{len(every)} modes of contacts, too many to include all" if len(every) > MODES else "none"
        if said.startswith("Expected"):
            raise ProgramError(said)
        raise ProgramError(f"Expected modes of contacts that {what} supports, got {said or many}.")
    return found[:MODES]


def check_events(eom: Equations) -> None:
    """Raises ProgramError if an event has an action, which programs with contacts do not support."""
    if any(e.then is not None for e in eom.system.events):
        raise ProgramError("Expected no event with an action beside contacts, got one. Use kn.simulate.")


TasksOf = Callable[[ModeOfProgram], Sequence[Task]]
"""Further tasks that a mode evaluates."""


def programs_of(
    compiled: Compiled,
    modes: Sequence[ModeOfProgram],
    contract: bool = False,
    more: TasksOf | None = None,
    starts: bool = False,
) -> tuple[Program, list[Program]]:
    """The program that evaluates the quantities by which modes are selected, and the program of each mode, with tasks `more`.

    With `starts`, for programs that start by themselves, the first also evaluates the constraints that hold in all modes.
    """
    numbers = contact_numbers(cast(Equations, compiled.equations))
    held = [part.tasks[0] for part in constraints(cast(Equations, compiled.equations))] * starts
    touch = build_program(compiled.name, numbers.ports, [numbers.task, *held], contract, optimize=False)
    tasks = [() if more is None else more(one) for one in modes]
    pairs = zip(modes, tasks, strict=True)
    return touch, [motion_program(one.compiled, one.parts, own, contract=contract) for one, own in pairs]


def tables_of(eom: Equations, modes: Sequence[ModeOfProgram], tables: Given) -> dict[str, Array]:
    """The arrays with a part for each mode, with their initial values."""
    own = of_modes(tables, len(modes))
    reaches = [_reach(one.equations) for one in modes]
    most = max(map(len, reaches)) + 1
    for m, one in enumerate(modes):
        put_mode(own, m, eom, one.equations)
        own["least"][m] = _padded(_least(one), tables["event_count"])
    own["held_reach"] = np.array([_padded(reach, most) for reach in reaches])
    return own | {"codes": np.array([code_of(one.modes) for one in modes])}


def parameters_from(touch: Program, modes: Sequence[ModeOfProgram], count: int) -> Array:
    """Indices of the parameters of each mode among those of all modes (modes × count); −1 for parameters that its contacts set."""
    place_of = {s: k for k, s in enumerate(touch.ports[2].symbols)}
    rows = [[float(place_of.get(s, -1)) for s in one.equations.parameters] for one in modes]
    return np.array([[*row, *[-1.0] * (count - len(row))] for row in rows])


def words(eom: Equations, modes: Modes) -> list[str]:
    """A word for the mode of each contact."""
    return [m.word(c) for m, c in zip(modes, eom.system.contacts, strict=True)]


def _padded(values: Array, count: int) -> Array:
    return np.append(values, np.zeros(count - len(values)))


def _least(mode: ModeOfProgram) -> Array:
    """The thresholds of the events of a mode."""
    return np.concatenate([np.zeros(0), *(part.given["least"] for part in mode.parts if "least" in part.given)])


def _reach(eom: Equations) -> Array:
    """The largest magnitudes, at the compared states, of the entries of A that are not identically zero."""
    if not is_constrained(eom):
        return np.zeros(0)
    rows, columns = np.array(entries(eom), dtype=int).reshape(-1, 2).T
    reach: Array = reach_of(eom)[rows, columns]
    return reach
