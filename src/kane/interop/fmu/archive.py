# SPDX-License-Identifier: BSD-3-Clause
"""`kn.exchange.to_fmu`: export of equations as a functional mock-up unit, an archive that simulators import."""

import platform
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version as version_of
from os import PathLike
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from kane import expect
from kane.analysis.assembly import assemble
from kane.analysis.state_checks import start_state
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations, check_equations, repartition
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, Attributes, ProgramError
from kane.interop.fmu.description import UnitModel, built, described, variables
from kane.interop.fmu.source import UnitStart, source, unit_of
from kane.motion.programs.simulator_parts import METHODS
from kane.motion.projection import constraint_numbers
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steps import better
from kane.numeric.sampling import finite_number, named_values
from kane.program.emit.identifiers import identifier, is_free_in_c
from kane.progress import working
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

    Returns
    -------
    FMU

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
    whole = unit_of(_determined(eom, start), named, method, start, outputs)
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
