# SPDX-License-Identifier: BSD-3-Clause
"""Programs in C give the motions of `simulate` bit by bit, where no a·b + c is contracted."""

import math
import os
import subprocess
import warnings

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from kane.motion import emit_simulator
from tests.motion.emitted import CONTROLLER, EXACT, MODELS, PERIOD, SANITIZED, bits, compiled, control, emitted, rows
from tests.motion.test_time_breaks import FIRST, KINDS, SECOND, S, pushed_twice, wheel
from tests.systems.draft_kinds import drafted
from tests.systems.drafts import built

TOLERANCES = {"rtol": 1e-9, "atol": 1e-9}
RANDOM = {"": 4, "rest": 50}.get(os.environ.get("KANE_FULL", ""), 100)


def _four_bar(eom):
    start = kn.assemble(eom, **load("four_bar").START)
    return (0, 3), {"q": start.q, "u": start.u}


STARTS = {
    "four_bar": _four_bar,
    "disk": lambda eom: ((0, 9), {"q": [0, 0, 0.3, 1.2, 0.1], "u": [1.0, -0.5, 3.0, 0.5, 0.2]}),
    "cart": lambda eom: (
        (0, 3),
        {"q": [0.1, 0.2], "u": [0, 0], "inputs": {"F": kn.sampled(control, period=PERIOD)}},
    ),
    "ball": lambda eom: ((0, 9), {"q": [1], "u": [0.5]}),
}


def values(eom, sol, inputs=()):
    """What a program is given to begin where a motion began."""
    state = dict(zip((s.name for s in eom.state), sol.states[0], strict=True))
    return state | {s.name: x for s, x in sol.parameters.items()} | dict(inputs)


def agree(sol, table):
    """Times and states are the same bits."""
    expected = np.column_stack([sol.t, sol.states])
    assert table.shape == expected.shape
    assert np.array_equal(bits(table), bits(expected))


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_the_motion_is_that_of_simulate(tmp_path, name):
    """A mechanism that goes over to other dependent speeds, a slide, a sampled controller, bounces; under the sanitizers."""
    eom, text = emitted(name)
    program = compiled(tmp_path, name, text, *SANITIZED, control=CONTROLLER if name == "cart" else "")
    span, given = STARTS[name](eom)
    sol = kn.simulate(eom, span, samples=301, method=MODELS[name][1], settings=EXACT, **TOLERANCES, **given)
    agree(sol, rows(program, float(span[1]), 301, values(eom, sol)))
    if name == "four_bar":
        assert any(e.name.startswith("dependent speeds") for e, _ in sol.events)
    if name == "disk":
        assert sol.event.name == "onset of rolling (friction)"
    if name == "ball":
        assert len(sol.jumps) == 4


@pytest.mark.parametrize("method", ["dop853", "tsit5"])
def test_the_motion_of_a_driven_pendulum_is_that_of_simulate(tmp_path, method):
    """The work of the loads is among the states whose errors bound the step: without it steps would be others."""
    eom = kn.derive(MODELS["cart"][0]())
    program = compiled(tmp_path, "cart", emit_simulator(eom.compile(name="cart", contract=False), method), "-O1")
    given = {"q": [0.1, 1.0], "u": [0, 2.0], "inputs": {"F": 0.5}}
    sol = kn.simulate(eom, (0, 3), samples=31, method=method, settings=EXACT, **TOLERANCES, **given)
    agree(sol, rows(program, 3.0, 31, values(eom, sol, [("F", 0.5)])))


@pytest.mark.slow
def test_dependent_speeds_change_more_often_than_is_noted_at_once(tmp_path):
    """A skate in speeds along fixed axes spins: other speeds follow after each quarter turn; also in a motion of one call."""
    N = kn.Frame("N")
    x, y, a = kn.coordinates("x y a")
    u, v, w = kn.speeds("u v w")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x + y * N.y)
    frame = N.rotate("B", a, N.z)
    body = kn.RigidBody("B", frame=frame, mass_center=P, mass=1, inertia=kn.rod(frame, 1, 1, axis=frame.x))
    blade = kn.cos(a) * v - kn.sin(a) * u
    speeds, loads = {u: x.dt, v: y.dt, w: a.dt}, [kn.Force(P, 0.3 * N.x)]
    eom = kn.derive(kn.System(N, bodies=[body], speeds=speeds, loads=loads, nonholonomic=[blade]))
    start = {
        "q": [0, 0, 0.1],
        "u": {u: 1.0, w: 4.0},
        "samples": 31,
        "method": "dop853",
        "settings": EXACT,
        **TOLERANCES,
    }
    sol, again = (kn.simulate(eom, (0, 30), **start) for _ in range(2))
    assert len(sol.segments) == len(again.segments) > 70
    assert np.array_equal(bits(sol.states), bits(again.states))
    text = emit_simulator(eom.compile(name="skate", contract=False), "dop853")
    agree(sol, rows(compiled(tmp_path, "skate", text, "-O1"), 30.0, 31, values(eom, sol)))


def test_motions_end_where_a_ball_bounces(tmp_path):
    """The end is the time of an impact but for rounding, to either side."""
    N = kn.Frame("N")
    y, v = kn.coordinate("y"), kn.speed("v")
    P = kn.Point("O", fixed_in=N).at("P", y * N.y)
    loads, events = [kn.gravity(-9.81 * N.y)], [kn.Event("bounce", y, direction=-1, then={v: -0.8 * v})]
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1)], speeds={v: y.dt}, loads=loads, events=events))
    text = emit_simulator(eom.compile(name="drop", contract=False), "dop853")
    program, bounced = compiled(tmp_path, "drop", text, "-O0"), 0
    for end in np.arange(1, 31) / 10:
        sol = kn.simulate(
            eom, (0, end), q=[9.81 * end**2 / 2], u=[0], samples=4, method="dop853", settings=EXACT, **TOLERANCES
        )
        agree(sol, rows(program, float(end), 4, values(eom, sol)))
        assert sol.status == "finished"
        assert sol.t[-1] == end
        bounced += len(sol.jumps)
        assert sol.u[-1, 0] == pytest.approx(-9.81 * end * (-0.8 if sol.jumps else 1), rel=1e-8)
    assert bounced > 0


LATER = """
#include <stdio.h>
#include <stdlib.h>
int main(int count, char **given)
{
    static @NAME@_motion m;
    int said = @CAPS@_LIMIT;
    (void)count;
    @NAME@_defaults(&m);
    m.start = strtod(given[1], NULL);
    for (int k = 0; k < @CAPS@_STATES; k++) {
        m.y[k] = strtod(given[3 + k], NULL);
    }
    for (int k = 0; k < @CAPS@_PARAMETERS; k++) {
        m.p[k] = strtod(given[3 + @CAPS@_STATES + k], NULL);
    }
    if (@NAME@_begin(&m, strtod(given[2], NULL), 11) != @CAPS@_BEGUN) {
        return 1;
    }
    while (said < @CAPS@_END) {
        said = @NAME@_go_on(&m);
    }
    for (int k = 0; k < 11; k++) {
        (void)printf("%s%.17g", (k > 0) ? "\\n" : "", m.times[k]);
        for (int j = 0; j < @CAPS@_STATES; j++) {
            (void)printf(",%.17g", m.rows[(k * N) + j]);
        }
    }
    return (said == @CAPS@_END) ? 0 : 1;
}
"""
"""A `main` that begins at another time: START END, the state, the parameters."""


@pytest.mark.parametrize("name", ["road", "cart"])
def test_motions_begin_at_any_time(tmp_path, name):
    """Corners that are passed at times before, at and after zero; a controller is asked at periods from the start on."""
    eom = wheel(KINDS["max"][0]) if name == "road" else kn.derive(MODELS["cart"][0]())
    text = emit_simulator(eom.compile(name=name, contract=False), "tsit5", None if name == "road" else PERIOD)
    text += LATER.replace("@NAME@", name).replace("@CAPS@", name.upper())
    options = ("-O0", f"-D{name.upper()}_NO_MAIN")
    program = compiled(tmp_path, name, text, *options, control=CONTROLLER if name == "cart" else "")
    sampled = {"inputs": {"F": kn.sampled(control, period=PERIOD)}} if name == "cart" else {}
    for start in (0.0, -1.0, -0.37, 1.0, -1e3, 1e6):
        more = sampled or {"parameters": {S: 2 * start + 1}}
        q = np.full(len(eom.coordinates), 0.1)
        sol = kn.simulate(
            eom, (start, start + 1), q=q, u=0 * q, samples=11, method="tsit5", settings=EXACT, **TOLERANCES, **more
        )
        given = [start, start + 1, *sol.states[0], *(sol.parameters[p] for p in eom.parameters)]
        done = subprocess.run([program, *(repr(float(x)) for x in given)], capture_output=True, text=True, check=True)
        agree(sol, np.array([[float(x) for x in line.split(",")] for line in done.stdout.split()]))


def test_stops_with_hardly_a_number_between_them(tmp_path):
    """Also where the motion begins just before one."""
    eom = pushed_twice()
    text = emit_simulator(eom.compile(name="two", contract=False), "tsit5")
    text += LATER.replace("@NAME@", "two").replace("@CAPS@", "TWO")
    program = compiled(tmp_path, "two", text, "-O0", "-DTWO_NO_MAIN")
    near = math.ulp(0.7)
    for begin, apart in [(0.0, k) for k in range(10, 18)] + [(0.7 + k * near, 1e9) for k in range(-9, 3)]:
        values = {FIRST: 0.7, SECOND: 0.7 + apart * near}
        options = {"method": "tsit5", "settings": EXACT, "samples": 11, **TOLERANCES}
        sol = kn.simulate(eom, (begin, begin + 1), q=[0], u=[0], parameters=values, **options)
        given = [begin, begin + 1, 0.0, 0.0, *(values[p] for p in eom.parameters)]
        done = subprocess.run([program, *(repr(float(x)) for x in given)], capture_output=True, text=True, check=True)
        agree(sol, np.array([[float(x) for x in line.split(",")] for line in done.stdout.split()]))


def test_constraints_far_from_the_origin_of_time_come_to_an_end(tmp_path):
    """A crank and a rod of one length, through the position where both lie on each other: where steps are no shorter, it says so."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    a, x = kn.coordinates("a x")
    P, Q = O.at("P", N.rotate("A", a, N.z).x), O.at("Q", x * N.x)
    loop = (kn.cos(a) - x) ** 2 + kn.sin(a) ** 2 - 1
    bodies = [kn.Particle("p", P, 1), kn.Particle("q", Q, 1)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", holonomic=[loop]))
    text = emit_simulator(eom.compile(name="crank", contract=False), "dop853")
    text += LATER.replace("@NAME@", "crank").replace("@CAPS@", "CRANK")
    program = compiled(tmp_path, "crank", text, "-O0", "-DCRANK_NO_MAIN")
    start = kn.assemble(eom, q={"a": 1.2, "x": 2 * np.cos(1.2)}, u={"u_a": 1.0})
    for begin in (0.0, 1e5, 3e5):
        given = [begin, begin + 1, *start.q.values(), *start.u.values()]
        done = subprocess.run([program, *(repr(float(z)) for z in given)], capture_output=True, timeout=60)
        assert done.returncode in (0, 1)


@pytest.mark.grows
@pytest.mark.parametrize("first", range(0, RANDOM, 10))
def test_random_motions_are_those_of_simulate(tmp_path, first):
    """Open chains, loops, wheels and joints at random."""
    for seed in range(first, min(first + 10, RANDOM)):
        draft = drafted(seed)
        eom = kn.derive(built(draft))
        text = emit_simulator(eom.compile(name="model", contract=False), "tsit5")
        program = compiled(tmp_path, "model", text, "-O0")
        given = {"q": draft.q, "u": draft.u or None, "parameters": draft.values, "inputs": draft.forces or None}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sol = kn.simulate(eom, (0, 0.2), samples=11, method="tsit5", settings=EXACT, **TOLERANCES, **given)
        agree(sol, rows(program, 0.2, 11, values(eom, sol, draft.forces.items())))
