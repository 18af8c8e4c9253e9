# SPDX-License-Identifier: BSD-3-Clause
"""`modelDescription.xml` and `buildDescription.xml` of a functional mock-up unit: its variables with units and start values."""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from xml.etree import ElementTree as ET  # only written, never parsed

from kane import expect
from kane.errors import ArgumentError, KaneError
from kane.expr.symbols import rate
from kane.interop.fmu.source import FmuContent, UnitStart
from kane.motion.projection import is_constrained
from kane.units.rules import parse, unit_of

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
