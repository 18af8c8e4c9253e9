# SPDX-License-Identifier: BSD-3-Clause
"""Units as their sources tell to build them, and masters that run them."""

import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

import kane as kn
from kane.gallery import load
from tests.motion.emitted import ball
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


def ten_rods():
    """A chain of ten rods, in one plane."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    speeds, bodies, frame, at = {}, [], N, O
    for k in range(10):
        q, u = kn.coordinate(f"q{k}"), kn.speed(f"u{k}")
        speeds[u] = q.dt
        frame = N.rotate(f"B{k}", q, N.z)
        bodies.append(kn.RigidBody(f"rod{k}", frame, at.at(f"C{k}", 0.5 * frame.x), 1.0, kn.inertia(frame, 0, 0, 1 / 12)))
        at = at.at(f"P{k}", frame.x)
    return kn.System(N, bodies=bodies, speeds=speeds, loads=[kn.gravity(-9.81 * N.y)])


MODELS = {
    "ball": (ball, {"q": {"y": 1.0}, "u": {"v": 0.1}}),
    "ten_rods": (ten_rods, None),
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


def states_of(rows, eom):
    """The states that fmpy recorded, row by row."""
    return np.array([rows[s.name] for s in eom.state]).T


def reference(eom, end, samples, given, **more):
    """The motion that `kn.simulate` has."""
    return kn.simulate(eom, (0, end), rtol=1e-12, atol=1e-12, samples=samples, **{**given, **more})


def far(found, expected):
    """The largest difference over the largest value, which is 1 at least."""
    return np.abs(found - expected).max() / max(1.0, np.abs(expected).max())
