# SPDX-License-Identifier: BSD-3-Clause
"""Models as programs in C, compiled by cc, and what they print."""

import subprocess

import numpy as np

import kane as kn
from kane.gallery import load, pendulum_on_cart, rolling_disk
from kane.motion import emit_simulator
from tests.program.programs import compiler

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")
SANITIZED = ("-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
EXACT = kn.Settings(contract=False)
PERIOD = 0.01
CONTROLLER = """
void cart_control(double t, const double *x, double *inputs);

void cart_control(double t, const double *x, double *inputs)
{
    (void)t;
    inputs[0] = 9.0 * x[1] + 2.0 * x[3] + 0.3 * x[0] + 0.6 * x[2];
}
"""


def control(t, x):
    """The law of `CONTROLLER`."""
    return 9.0 * x[1] + 2.0 * x[3] + 0.3 * x[0] + 0.6 * x[2]


def ball(braked=False):
    """Events that set the state, one that is noted, one that ends the motion; `braked`, friction switches, a parameter is set."""
    N = kn.Frame("N")
    y, v, e = kn.coordinate("y"), kn.speed("v"), kn.parameter("e", 0.8)
    events = [
        kn.Event("bounce", y, direction=-1, then={v: -e * v, e: 0.99 * e} if braked else {v: -e * v}),
        kn.Event("top", v, direction=-1, terminal=False),
        kn.Event("low", y + v**2 / 2 / 9.81 - 0.1, direction=-1),
    ]
    P = kn.Point("O", fixed_in=N).at("P", y * N.y)
    loads = [kn.gravity(-9.81 * N.y), *([kn.Force(P, -kn.sign(v) * N.y)] if braked else [])]
    return kn.System(N, bodies=[kn.Particle("ball", P, 2)], speeds={v: y.dt}, loads=loads, events=events)


MODELS = {
    "four_bar": (lambda: load("four_bar").system(), "dop853", None),
    "disk": (rolling_disk.system, "vern9", None),
    "cart": (lambda: pendulum_on_cart.system(force=True), "dop853", PERIOD),
    "ball": (lambda: ball(braked=True), "tsit5", None),
}
"""By name what makes a system, the method, and the period of a sampled controller."""
IN_MODES = {"belt": (lambda: load("mass_on_belt").system(), "rk4", None)}
"""The same of contacts that change their modes."""


def emitted(name):
    """The equations of a model, and its program without contraction."""
    make, method, period = {**MODELS, **IN_MODES}[name]
    eom = kn.derive(make())
    return eom, emit_simulator(eom.compile(name=name, contract=False), method, period)


def compiled(folder, name, text, *options, control=""):
    """A program, compiled with warnings as errors."""
    source, program = folder / f"{name}.c", folder / name
    source.write_text(text, encoding="utf-8")
    files = [source]
    if control:
        files.append(folder / "control.c")
        files[1].write_text(control, encoding="utf-8")
    done = subprocess.run(
        [compiler(), *STRICT, *options, *files, "-o", program, "-lm"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return program


def rows(program, end, samples, values, code=0):
    """The rows (t, state) that a program prints, with values by name."""
    given = [f"{name}={float(value)!r}" for name, value in values.items()]
    done = subprocess.run([program, repr(end), str(samples), *given], capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    return np.array([[float(x) for x in line.split(",")] for line in done.stdout.split()[1:]])


def bits(table):
    """Numbers as integers, so that equal ones are equal bit by bit."""
    return np.ascontiguousarray(table).view(np.int64)


def block():
    """The equations of a block on a table with friction, which an input pushes."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x")
    F = kn.input("F")
    P = O.at("P", x * N.x)
    place = kn.joints.point_on_plane("table", P, O, normal=N.y)
    normal = kn.reaction("N_y", at=P, along=N.y)
    loads = [kn.gravity(-9.81 * N.y), kn.Force(P, F * N.x)]
    contacts = [kn.contact(place, 0.2, static=0.3, normal=normal)]
    bodies = [kn.Particle("block", P, 2)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, contacts=contacts, coordinates=(x,)))
