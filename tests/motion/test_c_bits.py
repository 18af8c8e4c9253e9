# SPDX-License-Identifier: BSD-3-Clause
"""Programs in C give the motions of `simulate` bit by bit, where no a·b + c is contracted."""

import os
import warnings

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from kane.motion import emit_simulator
from tests.motion.emitted import CONTROLLER, EXACT, MODELS, PERIOD, SANITIZED, bits, compiled, control, emitted, rows
from tests.systems.draft_kinds import drafted
from tests.systems.drafts import built

TOLERANCES = {"rtol": 1e-9, "atol": 1e-9}
RANDOM = 100 if os.environ.get("KANE_FULL") else 4


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
