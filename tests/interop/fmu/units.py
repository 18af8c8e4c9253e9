# SPDX-License-Identifier: BSD-3-Clause
"""Units as their sources tell to build them, and masters that run them."""

import ctypes
import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from scipy.integrate import solve_ivp

import kane as kn
from kane.gallery import load, pendulums
from tests.motion.emitted import ball
from tests.peer import require
from tests.program.programs import compiler

TIGHT = 1e-11
STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")


def start_of(eom, module=None):
    """Start values by keyword: those of the gallery, or some that meet the constraints."""
    given = dict(getattr(module, "START", None) or {})
    if not given:
        near = {"q": eom.coordinates, "u": eom.speeds}
        given = {kind: {s.name: kn.guess(0.3 + 0.01 * k) for k, s in enumerate(some)} for kind, some in near.items()}
        found = kn.assemble(eom, **given) if eom.constraints.constraints or eom.system.euler_parameters else None
        given = {k: {s: g.value for s, g in some.items()} for k, some in given.items()}
        given = given if found is None else {"q": found.q, "u": found.u}
    if eom.inputs:
        given.setdefault("inputs", {r.name: 0.1 for r in eom.inputs})
    return given


MODELS = {
    "ball": (ball, {"q": {"y": 1.0}, "u": {"v": 0.1}}),
    "ten_rods": (lambda: pendulums.system(10), None),
}


def model(name):
    """Equations and start values of a system of the gallery, or of those here."""
    if name in MODELS:
        make, given = MODELS[name]
        eom = kn.derive(make())
        return eom, given or start_of(eom)
    module = load(name)
    eom = kn.derive(module.system(force=True) if name == "pendulum_on_cart" else module.system())
    return eom, start_of(eom, module)


def written(folder, name, eom, given, *options, **more):
    """A unit of which the sources alone were written, then compiled as `buildDescription.xml` says, without an optimizer."""
    more = {"tolerance": TIGHT, "method": "tsit5"} | more
    unit = kn.exchange.to_fmu(eom, folder / f"{name}.fmu", binary=False, **more, **given)
    assert unit.binary == ""
    whole = Path(folder, f"{name}_sources")
    with zipfile.ZipFile(unit.path) as archive:
        archive.extractall(whole)
    place = f"binaries/linux64/{name}.so"
    source, libraries = f"{name}.c", ["m"]
    if unit.version == "3.0":
        place = f"binaries/x86_64-linux/{name}.so"
        built = ET.parse(whole / "sources/buildDescription.xml").getroot()
        (file,) = built.iter("SourceFile")
        source, libraries = file.get("name"), [one.get("name") for one in built.iter("Library")]
    binary = whole / f"{name}.so"
    own = ["-fPIC", "-shared", *STRICT, *(options or ["-O0"])]
    done = subprocess.run(
        [compiler(), *own, whole / "sources" / source, "-o", binary, *(f"-l{one}" for one in libraries)],
        capture_output=True,
        text=True,
        check=False,
        env={"PATH": "/usr/bin:/bin"},
    )
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(unit.path, "a") as archive:
        archive.write(binary, place)
    return unit


def instantiated(folder, unit, purpose):
    """An instance behind the functions of FMI 3, and the value references by name."""
    fmpy = require("fmpy")
    kinds = require("fmpy.fmi3")
    description = fmpy.read_model_description(str(unit.path))
    inside = fmpy.extract(str(unit.path), unzipdir=str(folder))
    kind = kinds.FMU3Model if purpose == "ModelExchange" else kinds.FMU3Slave
    one = kind(guid=description.guid, unzipDirectory=inside, modelIdentifier=unit.path.stem, instanceName="one")
    one.instantiate()
    return one, {v.name: v.valueReference for v in description.modelVariables}


def integrated(folder, unit, end, samples, inputs, parameters):
    """States and outputs by SciPy's integrator around the functions of FMI 3, with inputs of time."""
    one, at = instantiated(folder, unit, "ModelExchange")
    one.setFloat64([at[name] for name in parameters], list(parameters.values()))
    one.enterInitializationMode(stopTime=end)
    one.exitInitializationMode()
    one.enterContinuousTimeMode()
    n = len(unit.states)
    x, dx = (ctypes.c_double * n)(), (ctypes.c_double * n)()

    def rates(t, y):
        one.setTime(t)
        one.setFloat64([at[name] for name in inputs], [f(t) for f in inputs.values()])
        x[:] = y
        one.setContinuousStates(x, n)
        one.getContinuousStateDerivatives(dx, n)
        return list(dx)

    times, first = np.linspace(0, end, samples), one.getFloat64([at[s] for s in unit.states])
    rows = solve_ivp(rates, (0, end), first, "DOP853", times, rtol=1e-12, atol=1e-12).y.T
    put = []
    for t, row in zip(times, rows, strict=True):
        rates(t, row)
        put.append(one.getFloat64([at[name] for name in unit.outputs]))
    one.freeInstance()
    return rows, np.array(put)


def states_of(rows, eom):
    """The states that fmpy recorded, row by row."""
    return np.array([rows[s.name] for s in eom.state]).T


def reference(eom, end, samples, given, **more):
    """The motion that `kn.simulate` has."""
    return kn.simulate(eom, (0, end), rtol=1e-12, atol=1e-12, samples=samples, **{**given, **more})


def far(found, expected):
    """The largest difference over the largest value, which is 1 at least."""
    return np.abs(found - expected).max() / max(1.0, np.abs(expected).max())
