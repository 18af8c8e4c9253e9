# SPDX-License-Identifier: BSD-3-Clause
"""The one file of C of a functional mock-up unit: the simulator without `main`, and the functions of FMI around it."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from importlib.resources import files
from typing import cast

from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.errors import ProgramError
from kane.expr.differentiation import tangent
from kane.expr.node import ONE
from kane.motion.constraint_kernels import choices, holding, structure
from kane.motion.hybrid.event_routines import tendency, values_set
from kane.motion.programs.simulator_c import assembled
from kane.motion.programs.simulator_parts import TAKES
from kane.motion.projection import is_constrained
from kane.motion.steppers.crossings import LEAVES
from kane.numeric.arrays import Array
from kane.numeric.scale import LATER
from kane.program.emit.names import c_number, c_string
from kane.program.from_expressions import Task

DRIFT = 1e-9
"""Relative to the terms of a constraint: where an importer's integrator has left it by more, the state is moved back."""


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """What a unit begins with: the state (q, u, a), parameters, inputs, the time and the tolerance of co-simulation."""

    state: Array
    parameters: Array
    inputs: Array
    time: float
    tolerance: float


def source(compiled: Compiled, method: str, start: Start, version: str) -> tuple[str, str]:
    """The text and its token, which a unit is instantiated with: the digest of all the rest."""
    eom, name = cast(Equations, compiled.equations), compiled.name
    _check_actions(eom)
    tasks = [*([compiled.bundle.task] if compiled.bundle else []), *_output_slopes(compiled)]
    tasks += [tendency(eom).task] * (bool(eom.events) and not values_set(eom))
    ending = _ending(compiled, start, version)
    routines = ["jac", *(["jac_inputs"] if eom.inputs else [])]
    text = assembled(compiled, method, routines=routines, tasks=tasks, ending=ending)
    text = _head(text, name)
    token = sha256(text.encode()).hexdigest()[:32]
    token = "-".join((token[:8], token[8:12], token[12:16], token[16:20], token[20:]))
    return text.replace("@TOKEN@", token), token


def _check_actions(eom: Equations) -> None:
    """Events set what an importer may have changed, the state of systems without constraints, and nothing else."""
    wrong = {
        eom.events[k].name for k, place, _ in values_set(eom) if is_constrained(eom) or not 0 <= place < len(eom.state)
    }
    if wrong:
        raise ProgramError(
            f"Expected events that set the state of a system without constraints in a unit, got {', '.join(sorted(wrong))}, which ask "
            "for more: parameters are the importer's, and what depends on speeds would follow. Leave them out, or simulate here."
        )


def _head(text: str, name: str) -> str:
    """The simulator without `main`, its samples few."""
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


def _ending(compiled: Compiled, start: Start, version: str) -> str:
    """The functions of FMI with what they call; marks that the simulator has too are left to it."""
    eom = cast(Equations, compiled.equations)
    held, acting = is_constrained(eom), bool(values_set(eom))
    outputs = len(compiled.bundle.task.roots) if compiled.bundle else 0
    own = _template("held" if held else "free")
    watching = _template("acts" if acting else "still") if eom.events else ""
    marks = {
        "@FMU_HELD@": _aliases(held, bool(outputs), bool(eom.inputs)) + own,
        "@FMU_ACTING@": watching + _template("watched" if eom.events else "unwatched"),
        "@OTHER_TYPES@": _others(version),
        "@CLOCKS@": _clocks() if version == "3.0" else "",
        "@EVENT_NAMES@": f"static const char *const at_names[] = {{{', '.join(c_string(e.name) for e in eom.events)}}};",
        "@OUTPUTS@": str(outputs),
        "@INDICATORS@": str(len(eom.events)),
        "@ACTIONS@": str(len(values_set(eom))),
        "@LEAVES@": str(LEAVES),
        "@LATER@": c_number(LATER),
        "@STATE@": _listed(start.state),
        "@PARAMETERS@": _listed(start.parameters),
        "@INPUTS@": _listed(start.inputs),
        "@RTOL@": c_number(start.tolerance),
        "@ATOL@": c_number(start.tolerance),
        "@DRIFT@": c_number(DRIFT),
        **(_held_numbers(eom) if held else {}),
    }
    text = _template("") + _template("motion") + _template(f"api{version[0]}")
    for mark, by in marks.items():
        text = text.replace(mark, by)
    prototypes = (f"{head};" for head in re.findall(r"^(EXPORTED [^{;]*\))\n\{", text, re.MULTILINE))
    return text.replace("@PROTOTYPES@", "\n".join(prototypes))


def _held_numbers(eom: Equations) -> dict[str, str]:
    """Counts of the constraints."""
    given = structure(eom, len(eom.state) + 1)
    return {
        "@CHOSEN@": str(given["held_chosen"]),
        "@CHOICES@": str(max(1, len(choices(eom)))),
        "@HOLDING@": str(max(1, len(holding(eom).task.roots))),
        "@TURNS@": str(given["held_turns"]),
        "@SPHERES@": str(given["held_spheres"]),
    }


def _listed(values: Array) -> str:
    return "".join(f"{c_number(x)}, " for x in values.tolist())


def _template(name: str) -> str:
    return files("kane.interop.fmu").joinpath(f"fmu{'_' * bool(name)}{name}.c").read_text(encoding="utf-8")


_GIVEN = "t, x, p, r, h"


def _aliases(held: bool, outputs: bool, inputs: bool) -> str:
    """The routines as the functions of FMI call them, whether there are some or not."""
    rates = "rates" if held else "@NAME@_rates"
    put = f"    @NAME@_outputs({_GIVEN}, out);" if outputs else _unused("out")
    jac = [f"    @NAME@_jac({_GIVEN}, jac);"]
    jac.append(f"    @NAME@_jac_inputs({_GIVEN}, by_inputs);" if inputs else "    (void)by_inputs;")
    jac.append(f"    @NAME@_jac_outputs({_GIVEN}, of_outputs);" if outputs else "    (void)of_outputs;")
    takes = TAKES.replace("double *out", "double *jac, double *by_inputs, double *of_outputs")
    return "\n".join(
        [
            f"static void fmu_rates({TAKES})\n{{\n    {rates}({_GIVEN}, out);\n}}\n",
            f"static void fmu_outputs({TAKES})\n{{\n{put}\n}}\n",
            f"static void fmu_jacobians({takes})",
            "{",
            *jac,
            "}\n\n",
        ]
    )


def _unused(*more: str) -> str:
    return "\n".join(f"    (void){a};" for a in ("t", "x", "p", "r", "h", *more))


_TYPES = {
    "3.0": (
        ("Float32", "float"), ("Int8", "int8_t"), ("UInt8", "uint8_t"), ("Int16", "int16_t"), ("UInt16", "uint16_t"),
        ("Int32", "int32_t"), ("UInt32", "uint32_t"), ("Int64", "int64_t"), ("UInt64", "uint64_t"), ("Boolean", "bool"),
        ("String", "char *"),
    ),
    "2.0": (("Integer", "int"), ("Boolean", "fmi2_boolean"), ("String", "char *")),
}  # fmt: skip
"""Types of which there are no variables, by version: as functions name them, and in C."""


def _others(version: str) -> str:
    """The functions of variables of other types."""
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
"""Functions of clocks, of which there are none."""


def _clocks() -> str:
    texts = []
    for what, takes in _CLOCKS.items():
        own = [one.split()[-1].removesuffix("[]") for one in takes.split(", ")]
        head = f"fmi3_status fmi3{what}(void *instance, const uint32_t references[], size_t count, {takes})"
        texts.append(_function(head, ["references", *own], "none_of((unit *)instance, count)"))
    return "\n".join(texts)


def _function(head: str, unused: Sequence[str], gives: str) -> str:
    lines = [
        f"EXPORTED {head}",
        "{",
        *(f"    (void){a};" for a in unused),
        f"    return {gives};",
        "}",
        "",
    ]
    return "\n".join(lines)
