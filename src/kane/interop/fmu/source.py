# SPDX-License-Identifier: BSD-3-Clause
"""The C source file of a functional mock-up unit: the simulator without `main`, and the functions of FMI."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from importlib.resources import files
from typing import Any, cast

from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.compiled import Compiled, output_bundle
from kane.equations.equations import Equations
from kane.errors import ProgramError
from kane.expr.differentiation import tangent
from kane.expr.node import ONE
from kane.model.contact_modes import in_mode
from kane.model.declarations import Event
from kane.motion.constraint_kernels import choices, holding, structure
from kane.motion.hybrid.automaton import tendency, values_set
from kane.motion.programs.program_modes import ModeOfProgram, modes_of
from kane.motion.programs.simulator_c import assembled
from kane.motion.projection import is_constrained
from kane.motion.steppers.crossings import LEAVES
from kane.numeric.arrays import Array
from kane.numeric.scale import LATER
from kane.program.emit.identifiers import c_number, c_string
from kane.program.from_expressions import Task

DRIFT = 1e-9
"""Violation of a constraint, relative to its terms, beyond which the state from an importer's integrator is projected."""


@dataclass(frozen=True, slots=True, eq=False)
class UnitStart:
    """The start of a unit: state (q, u, a), parameters, inputs, time and the tolerance of co-simulation."""

    state: Array
    parameters: Array
    inputs: Array
    time: float
    tolerance: float


@dataclass(frozen=True, slots=True, eq=False)
class FmuContent:
    """The content of a unit: equations, integrator, start, outputs by name and the task that computes them, modes of contacts."""

    compiled: Compiled
    method: str
    start: UnitStart
    outputs: Mapping[str, Any]
    put: Task | None
    modes: Sequence[ModeOfProgram]

    @property
    def equations(self) -> Equations:
        """The equations of motion."""
        return cast(Equations, self.compiled.equations)

    @property
    def events(self) -> Sequence[Event]:
        """The events with indicators; none if there are contact modes."""
        return () if self.modes else self.equations.events


def unit_content(
    eom: Equations, name: str, method: str, start: UnitStart, outputs: Mapping[str, Any] | None
) -> FmuContent:
    """The content of a unit; if contacts change modes, with all modes."""
    if not eom.system.modes_change:
        compiled = eom.compile(name=name, outputs=outputs)
        return FmuContent(compiled, method, start, {}, compiled.bundle.task if compiled.bundle else None, [])
    compiled = eom.compile(name=name)
    modes = modes_of(compiled, method, what="a unit", contract=compiled.settings.contract)
    return FmuContent(compiled, method, start, outputs or {}, _put_in(eom, modes[0], outputs or {}), modes)


def _put_in(eom: Equations, mode: ModeOfProgram, outputs: Mapping[str, Any]) -> Task | None:
    """The task that computes the outputs in a mode of contacts."""
    bundle = output_bundle(mode.equations.solved, outputs, partial(in_mode, eom.system.contacts, mode.modes))
    return bundle.task if bundle else None


def source(unit: FmuContent, version: str) -> tuple[str, str]:
    """The C source and the instantiation token, a digest of the source."""
    eom, compiled, ending = unit.equations, unit.compiled, _ending(unit, version)
    if unit.modes:
        wanted = [mode.modes for mode in unit.modes]
        puts = partial(_tasks_of, unit) if unit.put else None
        return _named(assembled(compiled, unit.method, ending=ending, modes=wanted, tasks_of=puts), compiled.name)
    _check_actions(eom)
    tasks = [*([unit.put] if unit.put else []), *_output_slopes(compiled)]
    tasks += [tendency(eom).task] * (bool(eom.events) and not values_set(eom))
    routines = ["jac", *(["jac_inputs"] if eom.inputs else [])]
    return _named(assembled(compiled, unit.method, routines=routines, tasks=tasks, ending=ending), compiled.name)


def _tasks_of(unit: FmuContent, mode: ModeOfProgram) -> list[Task]:
    return [task for task in [_put_in(unit.equations, mode, unit.outputs)] if task]


def _named(text: str, name: str) -> tuple[str, str]:
    """The C source with its token, and the token."""
    text = _head(text, name)
    token = sha256(text.encode()).hexdigest()[:32]
    token = "-".join((token[:8], token[8:12], token[12:16], token[16:20], token[20:]))
    return text.replace("@TOKEN@", token), token


def _check_actions(eom: Equations) -> None:
    """Raises unless events set only states of a system without constraints, which an importer lets a unit set."""
    wrong = {
        eom.events[k].name for k, place, _ in values_set(eom) if is_constrained(eom) or not 0 <= place < len(eom.state)
    }
    if wrong:
        raise ProgramError(
            f"Expected events that set only states, of a system without constraints, in a unit, got {', '.join(sorted(wrong))}: "
            "parameters are set by the importer, and constraints would change further states. Leave them out, or use kn.simulate."
        )


def _head(text: str, name: str) -> str:
    """The simulator without `main`, with few samples."""
    caps = name.upper()
    return f"#define {caps}_NO_MAIN\n#define {caps}_SAMPLES 2 /* of one step */\n{text}"


def _output_slopes(compiled: Compiled) -> list[Task]:
    """∂outputs/∂(x, r), row by row."""
    if compiled.bundle is None:
        return []
    eom = cast(Equations, compiled.equations)
    roots = without_unknowns(eom.solved, compiled.bundle.task.roots)
    knowns = (*eom.state, *eom.inputs)
    slopes = [tangent(root, {s: ONE}, at_rest=True) for root in roots for s in knowns]
    labels = [f"d({k})/d({s.name})" for k in compiled.bundle.task.labels for s in knowns]
    return [Task("jac_outputs", slopes, (len(roots), len(knowns)), labels)]


def _ending(unit: FmuContent, version: str) -> str:
    """The functions of FMI and their helpers; placeholders shared with the simulator are replaced there."""
    eom, start = unit.equations, unit.start
    held, acting, stepped = is_constrained(eom) and not unit.modes, bool(values_set(eom)), bool(unit.modes)
    outputs = len(unit.put.roots) if unit.put else 0
    own = _template("held" if held else "free")
    watching = _template("acts" if acting else "still") if unit.events else ""
    aliases = _in_modes(bool(outputs)) if stepped else _aliases(held, bool(outputs), bool(eom.inputs))
    marks = {
        "@FMU_HELD@": aliases + own,
        "@FMU_ACTING@": watching + _looks(unit),
        "@OTHER_TYPES@": _others(version),
        "@CLOCKS@": _clocks() if version == "3.0" else "",
        "@EVENT_NAMES@": f"static const char *const at_names[] = {{{', '.join(c_string(e.name) for e in unit.events)}}};",
        "@EXCHANGES@": "false" if stepped else "true",
        "@AND_STEPS@": "co-simulation, which alone contacts go with, " if stepped else "",
        "@LIMIT_OF@": "1000" if stepped else "1",
        "@OUTPUTS@": str(outputs),
        "@INDICATORS@": str(len(unit.events)),
        "@ACTIONS@": str(len(values_set(eom))),
        "@LEAVES@": str(LEAVES),
        "@LATER@": c_number(LATER),
        "@STATE@": _listed(start.state),
        "@PARAMETERS@": _listed(start.parameters),
        "@INPUTS@": _listed(start.inputs),
        "@RTOL@": c_number(start.tolerance),
        "@ATOL@": c_number(start.tolerance),
        "@DRIFT@": c_number(DRIFT),
    }
    if held:
        given = structure(eom, len(eom.state) + 1)
        marks |= {
            "@CHOSEN@": str(given["held_chosen"]),
            "@CHOICES@": str(max(1, len(choices(eom)))),
            "@HOLDING@": str(max(1, len(holding(eom).task.roots))),
            "@TURNS@": str(given["held_turns"]),
            "@SPHERES@": str(given["held_spheres"]),
        }
    if stepped:
        marks["@EVENT_NAMES@"] = "@SHOWN@"
    text = _template("") + _template("motion") + _template(f"api{version[0]}")
    for mark, by in marks.items():
        text = text.replace(mark, by)
    prototypes = (f"{head};" for head in re.findall(r"^(EXPORTED [^{;]*\))\n\{", text, re.MULTILINE))
    return text.replace("@PROTOTYPES@", "\n".join(prototypes))


def _listed(values: Array) -> str:
    return "".join(f"{c_number(x)}, " for x in values.tolist())


def _template(name: str) -> str:
    return files("kane.interop.fmu").joinpath(f"fmu{'_' * bool(name)}{name}.c").read_text(encoding="utf-8")


_GIVEN = "t, m->y, m->p, m->r, m->h"
_HEADS = {
    "fmu_hoist": "void {}(@NAME@_motion *m)",
    "fmu_rates": "void {}(const @NAME@_motion *m, double t, double *out)",
    "fmu_outputs": "void {}(const @NAME@_motion *m, double t, double *out)",
    "fmu_jacobians": "bool {}(const @NAME@_motion *m, double t, double *jac, double *by_inputs, double *of_outputs)",
    "noted": "bool {}(unit *i, int said)",
    "settled": "bool {}(unit *i)",
}
"""The signatures of functions that the FMI functions call in every unit."""


def _functions(bodies: Mapping[str, Sequence[str]]) -> str:
    texts = []
    for name, body in bodies.items():
        lines = [f"    {line}" for line in body]
        texts += [f"static {_HEADS[name].format(name)}", "{", *lines, "}", ""]
    return "\n".join([*texts, ""])


def _looks(unit: FmuContent) -> str:
    """The treatment of events: with indicators, of contacts, or none."""
    if unit.modes:
        return _template("unwatched") + _template("contacts")
    as_it_is = {"settled": [*_unused("i"), "return true;"]}
    if unit.events:
        return _template("watched") + _functions(as_it_is)
    return _template("unwatched") + _functions({"noted": [*_unused("i", "said"), "return false;"], **as_it_is})


def _aliases(held: bool, outputs: bool, inputs: bool) -> str:
    """The routines under the names that the functions of FMI use."""
    rates = "rates" if held else "@NAME@_rates"
    jac = [f"@NAME@_jac({_GIVEN}, jac);"]
    jac.append(f"@NAME@_jac_inputs({_GIVEN}, by_inputs);" if inputs else "(void)by_inputs;")
    jac.append(f"@NAME@_jac_outputs({_GIVEN}, of_outputs);" if outputs else "(void)of_outputs;")
    return _functions(
        {
            "fmu_hoist": ["hoist(m);"],
            "fmu_rates": [f"{rates}({_GIVEN}, out);"],
            "fmu_outputs": [f"@NAME@_outputs({_GIVEN}, out);"] if outputs else _unused("m", "t", "out"),
            "fmu_jacobians": [*jac, "return true;"],
        }
    )


def _in_modes(outputs: bool) -> str:
    """The routines of the current mode."""
    mode = "const mode_row *const at = &mode_rows[(int64_t)at_calls[0]];"
    own = "t, m->y, &at_ps[(int64_t)at_calls[0] * PARAMETERS_OF], m->r, at_mode_h, out"
    return _functions(
        {
            "fmu_hoist": ["hoist(m);", "spread(m);", "hoist_mode(m, at_calls);"],
            "fmu_rates": [mode, f"at->rhs({own});"],
            "fmu_outputs": [mode, f"at->outputs({own});"] if outputs else _unused("m", "t", "out"),
            "fmu_jacobians": [*_unused("m", "t", "jac", "by_inputs", "of_outputs"), "return false;"],
        }
    )


def _unused(*names: str) -> list[str]:
    return [f"(void){name};" for name in names]


_TYPES = {
    "3.0": (
        ("Float32", "float"), ("Int8", "int8_t"), ("UInt8", "uint8_t"), ("Int16", "int16_t"), ("UInt16", "uint16_t"),
        ("Int32", "int32_t"), ("UInt32", "uint32_t"), ("Int64", "int64_t"), ("UInt64", "uint64_t"), ("Boolean", "bool"),
        ("String", "char *"),
    ),
    "2.0": (("Integer", "int"), ("Boolean", "fmi2_boolean"), ("String", "char *")),
}  # fmt: skip
"""Types without variables, by version: in names of functions, and in C."""


def _others(version: str) -> str:
    """The functions for variables of other types."""
    fmi = f"fmi{version[0]}"
    counted = ", size_t numbers_given" if version == "3.0" else ""
    texts = []
    for what, kind in _TYPES[version]:
        got = "const char *" if kind == "char *" else f"{kind} "
        put = "const char *const " if kind == "char *" else f"const {kind} "
        for way, values in (("Get", got), ("Set", put)):
            takes = f"void *instance, const uint32_t references[], size_t count, {values}values[]{counted}"
            unused = ["references", "values", *(["numbers_given"] if counted else [])]
            texts.append(
                _function(f"{fmi}_status {fmi}{way}{what}({takes})", unused, "none_of((unit *)instance, count)")
            )
    return "\n".join(texts)


_CLOCKS = {
    "GetIntervalDecimal": "double intervals[], int qualifiers[]",
    "GetIntervalFraction": "uint64_t counters[], uint64_t resolutions[], int qualifiers[]",
    "GetShiftDecimal": "double shifts[]",
    "GetShiftFraction": "uint64_t counters[], uint64_t resolutions[]",
    "SetIntervalDecimal": "const double intervals[]",
    "SetIntervalFraction": "const uint64_t counters[], const uint64_t resolutions[]",
    "SetShiftDecimal": "const double shifts[]",
    "SetShiftFraction": "const uint64_t counters[], const uint64_t resolutions[]",
}
"""Functions for clocks, which units do not have."""


def _clocks() -> str:
    texts = []
    for what, takes in _CLOCKS.items():
        own = [one.split()[-1].removesuffix("[]") for one in takes.split(", ")]
        head = f"fmi3_status fmi3{what}(void *instance, const uint32_t references[], size_t count, {takes})"
        texts.append(_function(head, ["references", *own], "none_of((unit *)instance, count)"))
    return "\n".join(texts)


def _function(head: str, unused: Sequence[str], gives: str) -> str:
    body = (f"    {line}" for line in (*_unused(*unused), f"return {gives};"))
    return "\n".join([f"EXPORTED {head}", "{", *body, "}", ""])
