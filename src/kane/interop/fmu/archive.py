# SPDX-License-Identifier: BSD-3-Clause
"""`kn.exchange.to_fmu`: export of equations as a functional mock-up unit, an archive, with its description, that simulators import."""

import platform
import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version as version_of
from os import PathLike
from pathlib import Path
from typing import Any, Unpack
from xml.etree import ElementTree as ET  # only written, never parsed

import numpy as np

from kane import expect
from kane.analysis.assembly import assemble
from kane.analysis.state_checks import start_state
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations, check_equations, repartition
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, Attributes, KaneError, ProgramError
from kane.expr.symbols import rate
from kane.interop.fmu.source import FmuContent, UnitStart, source, unit_content
from kane.motion.programs.simulator_parts import METHODS
from kane.motion.projection import constraint_numbers, is_constrained
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steps import better
from kane.numeric.sampling import finite_number, named_values
from kane.program.emit.identifiers import identifier, is_free_in_c
from kane.progress import working
from kane.units.rules import parse, unit_of
from kane.whole import exchange, path_of

VERSIONS = ("3.0", "2.0")
"""Supported versions of FMI."""
ADAPTIVE = tuple(m for m in METHODS if not INTEGRATORS[m].fixed)
"""The adaptive integrators, which co-simulation uses."""
_COMPILERS = ("cc", "gcc", "clang")
_OPTIONS = ("-std=c99", "-O2", "-fno-math-errno", "-fPIC", "-shared", "-fvisibility=hidden")
_EPOCH = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class FMU(Attributes):
    """A unit that was written: its `path`, its instantiation `token`, the names of its variables, and the `binary` in it.

    `binary` is "" if no C compiler was found: only importers that compile the sources run such a unit.
    """

    path: Path
    version: str
    token: str
    states: tuple[str, ...]
    parameters: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    binary: str


@by_keyword
def to_fmu(
    eom: Equations,
    path: str | PathLike[str],
    state: State | None = None,
    *,
    outputs: Mapping[str, Any] | None = None,
    version: str = "3.0",
    name: str | None = None,
    title: str = "",
    method: str = "dop853",
    tolerance: float = 1e-9,
    binary: bool = True,
    **values: Unpack[StateValues],
) -> FMU:
    """Write the equations as a functional mock-up unit (FMU), for model exchange and co-simulation; it needs no Python.

    The archive contains one C file with the equations, their derivatives and an integrator, the model description, and, if there is
    a C compiler, the library for this machine. Coordinates and speeds are states and outputs, parameters are tunable, inputs are
    inputs. Events are event indicators in model exchange; co-simulation steps to their times. Projection keeps the constraints
    satisfied. If contacts change modes, the unit is for co-simulation only, and contains all modes.

    Parameters
    ----------
    eom : Equations
    path : of the archive, `name.fmu`
    state, q, u, states, parameters, inputs, t : the start values, as in `kn.simulate`; start values of inputs are numbers, 0 by
        default
    outputs : expressions, vectors, matrices by name that become outputs besides the state: reactions, energies, positions
    version : of FMI, "3.0" or "2.0"
    name : the model identifier; by default the file name in letters, digits and _, prefixed with "model_" if C reserves it
    title : a description
    method : the integrator of co-simulation, an adaptive one of those of `kane emit --with-integrator`
    tolerance : relative and absolute tolerance of co-simulation, unless the importer sets one
    binary : whether to compile the library

    Raises
    ------
    ProgramError
        if a C program cannot simulate the motion: discontinuous loads, contacts with many modes, events that act through Python
    ArgumentError
        if an option is not admissible, or two variables have one name
    ValueMissingError
        if a start value or parameter is missing

    Examples
    --------
    >>> unit = kn.exchange.to_fmu(eom, "pendulum.fmu", q={"theta": 0.5}, u={"omega": 0})
    """
    check_equations(eom)
    place = path_of(path, 'kn.exchange.to_fmu(eom, "model.fmu")')
    expect.one_of(version, VERSIONS, "a version of FMI")
    expect.one_of(method, ADAPTIVE, "an adaptive integrator for co-simulation")
    expect.instance(title, str, "title= a text", error=ArgumentError)
    named = unit_name(place.stem) if name is None else name
    _check_name(place, named, tolerance)
    start = _start(eom, state_of(state, **values), tolerance)
    whole = unit_content(_determined(eom, start), named, method, start, outputs)
    rows = variables(whole)
    with working("Writing a functional mock-up unit"):
        text, token = source(whole, version)
        tool = f"kane {version_of('kane')}"
        counts = len(eom.state), len(whole.events), bool(whole.modes)
        model = UnitModel(named, title or named, token, tool, start, *counts)
        sources = {"modelDescription.xml": described(model, rows, version), f"sources/{named}.c": text}
        if version == "3.0":
            sources["sources/buildDescription.xml"] = built(named, version)
        library = _library(named, text) if binary else b""
        inside = _binary_name(named, version) if library else ""
        exchange(place, lambda file: _zip(file, sources, inside, library), own=zipfile.is_zipfile)
    names = {kind: tuple(s.name for s in getattr(eom, kind)) for kind in ("parameters", "inputs")}
    put = tuple(whole.put.labels) if whole.put else ()
    return FMU(
        place, version, token, tuple(s.name for s in eom.state), names["parameters"], names["inputs"], put, inside
    )


def unit_name(stem: str) -> str:
    """The model identifier for a file name: the name itself if C permits it."""
    found = (x for x in (stem, identifier(stem), identifier(f"model {stem}")) if _is_free(x))
    return next(found, "model")


def _is_free(name: Any) -> bool:
    return isinstance(name, str) and name.isidentifier() and name.isascii() and is_free_in_c(name)


def _check_name(path: Path, name: str, tolerance: float) -> None:
    if path.suffix != ".fmu":
        raise ArgumentError(f"Expected a path that ends in .fmu, got {path}.")
    if not _is_free(name):
        raise ArgumentError(
            f"Expected a model identifier of letters, digits and _ that C has no other use for, got {name!r}. Pass name=."
        )
    if not (expect.is_number(tolerance) and 0 < tolerance < 1):
        raise ArgumentError(f"Expected a tolerance between 0 and 1, got {tolerance!r}.")


def _start(eom: Equations, given: State, tolerance: float) -> UnitStart:
    """The start values as in `simulate`, with dependent values solved for."""
    parameters = parameter_values(eom.system, given.parameters)
    inputs = named_values("inputs", eom.inputs, given.inputs)
    r = {s: finite_number("start value", s.name, inputs.get(s, 0.0)) for s in eom.inputs}
    t = finite_number("value", "t", given.t)
    q, u = given.q, given.u
    if eom.constraints.constraints:
        found = assemble(eom, q=q, u=u, parameters=parameters, inputs=r, t=t)
        q, u = found.q, found.u
    whole = start_state(eom, q, u, given.states)
    p = np.array([parameters[s] for s in eom.parameters], dtype=float)
    return UnitStart(whole, p, np.array([*r.values()], dtype=float), t, float(tolerance))


def _determined(eom: Equations, start: UnitStart) -> Equations:
    """The equations with dependent speeds that the others determine at the start."""
    if eom.embedding is None:
        return eom
    found = eom.numeric().routine(constraint_numbers)(start.time, start.state, start.parameters, start.inputs)
    other = better(found.a, eom.embedding.partition, np.abs(found.a), may_grow=False)
    return eom if other is None else eom.numeric().value(repartition, other)


def _binary_name(name: str, version: str) -> str:
    """The path in the archive of the library for this machine, "" if the standard defines none."""
    machine = {"x86_64": "x86_64", "AMD64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}.get(
        platform.machine(), ""
    )
    system = {"Linux": "linux", "Darwin": "darwin"}.get(platform.system(), "")
    if not (machine and system):
        return ""
    ending = "so" if system == "linux" else "dylib"
    if version == "3.0":
        return f"binaries/{machine}-{system}/{name}.{ending}"
    return f"binaries/{system}64/{name}.{ending}" if machine == "x86_64" else ""


def _library(name: str, text: str) -> bytes:
    """The shared library, compiled by the C compiler of this machine; empty if there is no compiler."""
    found = next((c for c in map(shutil.which, _COMPILERS) if c), None)
    if found is None or not _binary_name(name, "3.0"):
        return b""
    with tempfile.TemporaryDirectory() as folder:
        file, library = Path(folder, f"{name}.c"), Path(folder, f"{name}.so")
        file.write_text(text, encoding="utf-8")
        done = subprocess.run(
            [found, *_OPTIONS, str(file), "-o", str(library), "-lm"], capture_output=True, text=True, check=False
        )
        if done.returncode:
            wrong = [line for line in done.stderr.splitlines() if "error" in line] or ["no message"]
            raise ProgramError(
                f"Expected {found} to compile the unit, got: {wrong[0]}. Pass binary=False to write its sources alone."
            )
        return library.read_bytes()


def _zip(file: Path, sources: Mapping[str, str], binary: str, library: bytes) -> None:
    """Writes the archive; the same content gives the same bytes."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        files: dict[str, str | bytes] = dict(sources)
        for name, content in (files | ({binary: library} if binary else {})).items():
            info = zipfile.ZipInfo(name, _EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = (0o755 if name == binary else 0o644) << 16
            archive.writestr(info, content)


_NEVER = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML does not permit."""


@dataclass(frozen=True, slots=True)
class UnitVariable:
    """A variable of the description; its value reference is its index. `state` is the index of the state that it differentiates."""

    name: str
    causality: str
    variability: str
    initial: str = ""
    start: float | None = None
    unit: str = ""
    description: str = ""
    state: int | None = None


def variables(whole: FmuContent) -> list[UnitVariable]:
    """Time, states, their derivatives, parameters, inputs, outputs, event indicators, in the order of the C file."""
    eom, start = whole.equations, whole.start
    held = is_constrained(eom) and not whole.modes
    result = [UnitVariable("time", "independent", "continuous", unit="s", description="time")]
    initial = "approx" if held else "exact"
    for s, x in zip(eom.state, start.state.tolist(), strict=True):
        result.append(UnitVariable(s.name, "output", "continuous", initial, x, s.unit, s.description))
    for k, s in enumerate(eom.state):
        unit = rate(s).unit if s.unit else ""
        result.append(UnitVariable(f"der({s.name})", "local", "continuous", "calculated", None, unit, "", k + 1))
    for s, x in zip(eom.parameters, start.parameters.tolist(), strict=True):
        result.append(UnitVariable(s.name, "parameter", "tunable", "exact", x, s.unit, s.description))
    for s, x in zip(eom.inputs, start.inputs.tolist(), strict=True):
        result.append(UnitVariable(s.name, "input", "continuous", "", x, s.unit, s.description))
    result += _outputs(whole)
    for e in whole.events:
        result.append(
            UnitVariable(f"event({e.name})", "local", "continuous", "calculated", description=f"zero at: {e.name}")
        )
    names = [v.name for v in result]
    cure = "Name outputs, states, parameters and inputs differently; `time` is taken."
    expect.different(names, "different names of all variables of the unit", cure, error=ArgumentError)
    return result


def _outputs(whole: FmuContent) -> list[UnitVariable]:
    task = whole.put
    if task is None:
        return []
    rows = []
    for name, root in zip(task.labels, task.roots, strict=True):
        unit = ""
        with suppress(KaneError):
            unit = unit_of(root)
        rows.append(UnitVariable(name, "output", "continuous", "calculated", unit=unit))
    return rows


# ------------------------------------------------------------------------------------------------------------- units


def _units(parent: ET.Element, rows: Sequence[UnitVariable]) -> None:
    """Adds definitions of the variables' units: powers of SI units, and the factor."""
    names = sorted({v.unit for v in rows if v.unit})
    if not names:
        return
    group = ET.SubElement(parent, "UnitDefinitions")
    for name in names:
        one = ET.SubElement(group, "Unit", name=name)
        unit = parse(name)
        if any(e != int(e) for e in unit.exponents):
            continue  # FMI has integer exponents only
        powers = {s: str(e) for s, e in zip(("kg", "m", "s", "A", "K", "mol", "cd"), unit.exponents, strict=True) if e}
        if re.fullmatch(r"(rad|deg)(/.*)?", name):
            powers["rad"] = "1"
        if unit.scale != 1:
            powers["factor"] = repr(float(unit.scale))
        ET.SubElement(one, "BaseUnit", powers)


# -------------------------------------------------------------------------------------------------------- documents


@dataclass(frozen=True, slots=True)
class UnitModel:
    """The properties of the unit as a whole."""

    identifier: str
    title: str
    token: str
    tool: str
    start: UnitStart
    states: int
    events: int
    steps_alone: bool


_CATEGORIES = {
    "logEvents": "Events, with their times.",
    "logStatusWarning": "Warnings.",
    "logStatusDiscard": "Values that are not finite.",
    "logStatusError": "Errors.",
}
_OWN = {"canGetAndSetFMU{0}": "true", "canSerializeFMU{0}": "true", "providesDirectionalDerivative{1}": "true"}


def _purposes(root: ET.Element, model: UnitModel, version: str) -> None:
    """Adds the elements of model exchange and co-simulation."""
    three = version == "3.0"
    words = ("State", "s") if three else ("state", "")
    shared = {"modelIdentifier": model.identifier} | {k.format(*words): v for k, v in _OWN.items()}
    if model.steps_alone:
        shared.pop(f"providesDirectionalDerivative{words[1]}")
    elif three:
        shared["providesAdjointDerivatives"] = "true"
    exchange = shared | ({"needsCompletedIntegratorStep": "true"} if three else {})
    steps = shared | {"canHandleVariableCommunicationStepSize": "true"}
    if three:
        steps |= {"hasEventMode": "true", "mightReturnEarlyFromDoStep": "true"}
    purposes = (("ModelExchange", exchange), ("CoSimulation", steps))
    for tag, what in purposes[model.steps_alone :]:
        element = ET.SubElement(root, tag, what)
        if not three:
            sources = ET.SubElement(element, "SourceFiles")
            ET.SubElement(sources, "File", name=f"{model.identifier}.c")


def _begun(model: UnitModel, version: str) -> ET.Element:
    head = {
        "fmiVersion": version,
        "modelName": model.identifier,
        "description": model.title,
        "generationTool": model.tool,
    }
    head |= {"variableNamingConvention": "flat"}
    head |= {"instantiationToken" if version == "3.0" else "guid": model.token}
    if version == "2.0":
        head["numberOfEventIndicators"] = str(model.events)
    return ET.Element("fmiModelDescription", head)


def described(model: UnitModel, rows: Sequence[UnitVariable], version: str) -> str:
    """The text of `modelDescription.xml`."""
    root = _begun(model, version)
    _purposes(root, model, version)
    _units(root, rows)
    categories = ET.SubElement(root, "LogCategories")
    for name, text in _CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=text)
    told = {"startTime": repr(model.start.time), "tolerance": repr(model.start.tolerance)}
    ET.SubElement(root, "DefaultExperiment", told)
    _variables(root, rows, version)
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [k for k, v in enumerate(rows) if v.causality == "output"]
    derivatives = [k for k, v in enumerate(rows) if v.state is not None]
    events = range(len(rows) - model.events, len(rows))
    unknowns = [k for k, v in enumerate(rows) if v.initial in ("approx", "calculated") and k not in events]
    if version == "3.0":
        kinds = {
            "Output": outputs,
            "ContinuousStateDerivative": derivatives,
            "InitialUnknown": unknowns,
            "EventIndicator": events,
        }
        for tag, places in kinds.items():
            for k in places:
                ET.SubElement(structure, tag, valueReference=str(k))
    else:
        for tag, places in {"Outputs": outputs, "Derivatives": derivatives, "InitialUnknowns": unknowns}.items():
            if places:
                group = ET.SubElement(structure, tag)
                for k in places:
                    ET.SubElement(group, "Unknown", index=str(k + 1))
    return written(root)


def _variables(root: ET.Element, rows: Sequence[UnitVariable], version: str) -> None:
    group = ET.SubElement(root, "ModelVariables")
    for k, v in enumerate(rows):
        said = {"name": v.name, "valueReference": str(k), "causality": v.causality, "variability": v.variability}
        own = {"description": v.description, "unit": v.unit, "initial": v.initial}
        own = {key: text for key, text in own.items() if text}
        own |= {} if v.start is None else {"start": repr(v.start)}
        if version == "3.0":
            ET.SubElement(group, "Float64", said | own | ({} if v.state is None else {"derivative": str(v.state)}))
            continue
        said |= {key: own.pop(key) for key in ("initial", "description") if key in own}
        own |= {} if v.state is None else {"derivative": str(v.state + 1)}  # indices are counted from 1
        ET.SubElement(ET.SubElement(group, "ScalarVariable", said), "Real", own)


def built(identifier: str, version: str) -> str:
    """The text of `buildDescription.xml`: how to compile the source file."""
    root = ET.Element("fmiBuildDescription", fmiVersion=version)
    how = ET.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = ET.SubElement(how, "SourceFileSet", language="C99")
    ET.SubElement(files, "SourceFile", name=f"{identifier}.c")
    ET.SubElement(how, "Library", name="m", external="true")
    return written(root)


def written(root: ET.Element) -> str:
    """A document as text; ArgumentError for characters that XML does not permit."""
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    expect.none(
        sorted(map(repr, {*_NEVER.findall(text)})),
        "letters that XML has in names and descriptions",
        error=ArgumentError,
    )
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'
