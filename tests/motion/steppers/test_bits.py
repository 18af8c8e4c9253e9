# SPDX-License-Identifier: BSD-3-Clause
"""Every integrator gives the same bits through NumPy, machine code and C."""

from types import SimpleNamespace

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulums
from kane.motion import (
    INTEGRATORS,
    KernelConstraints,
    ReturnCode,
    Slot,
    Stepper,
    actions,
    automaton,
    glance,
    holding,
    tendency,
)
from tests.motion.steppers.runs import arguments, languages
from tests.program.kernel.kernels import EXACT, agree
from tests.systems import four_bar


@pytest.fixture(scope="module")
def pendulum():
    return kn.derive(pendulums.system(2))


@pytest.mark.parametrize(
    "name", [pytest.param(i.name, marks=[pytest.mark.slow] * i.implicit) for i in INTEGRATORS.values()]
)
def test_every_language_gives_the_same_bits(name, pendulum, tmp_path):
    """A double pendulum for a few steps and what is taken again, sampled."""
    longest = 0.04 if INTEGRATORS[name].fixed else 0.3
    given, routine = arguments(
        pendulum, EXACT, name, [1.0, 2.0, 0.5, 0.0], 9.0, longest, 1e-9, np.linspace(0.1, 9, 400)
    )
    limit = 6 if INTEGRATORS[name].width == 1 else 3
    kernel = INTEGRATORS[name].kernel()
    assert agree(kernel, languages(given, routine) | {"limit": limit}, tmp_path / "k.c") == ReturnCode.LIMIT


@pytest.mark.parametrize("name", ["gauss16", "dop853", "midpoint", pytest.param("radau9", marks=pytest.mark.slow)])
def test_breakpoints_are_passed_with_the_same_bits(name, pendulum, tmp_path):
    """To the end past two of them: steps end at these, and a first step is chosen beyond the first one."""
    given, routine = arguments(pendulum, EXACT, name, [1.0, 2.0, 0.5, 0.0], 0.1, 0.04, 1e-9, np.linspace(0.1, 0.5, 30))
    pauses = np.array([0.1 + 1e-15, 0.3, 0.0, 0.3 + 1e-15, 0.5, 0.0, 0.0])
    passed = given | {"breakpoints": len(pauses) // 3, "pauses": np.append(pauses, 0.0)}
    assert agree(INTEGRATORS[name].kernel(), languages(passed, routine), tmp_path / "k.c") == ReturnCode.END


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gauss16", "dop853"])
def test_constraints_are_held_with_the_same_bits(name, tmp_path):
    """A few steps of a four-bar linkage, sampled."""
    x = np.array([*four_bar.state()["q"].values(), *four_bar.state()["u"].values()])
    given, routine = arguments(four_bar.EOM, EXACT, name, x, 9.0, 0.05, 1e-9, np.linspace(0.01, 0.2, 30))
    stepper = Stepper(four_bar.EOM, np.zeros(0), (), EXACT)
    stepper.keep(0.0, given["y"])
    kernel = SimpleNamespace(given=given, now=stepper.now, integrator=INTEGRATORS[name])
    held = KernelConstraints(stepper, kernel, 0.0, given["y"])
    held.begin(given["s"])
    code = held.given.pop("constraints")
    numbers = four_bar.EOM.numeric(EXACT).routine(holding).flat
    count = len(numbers.routine.results)

    def constraints(t, x, p, r, h, out):
        out[:count] = numbers(float(t), x[:6], p[:0], None)

    given = languages(given | held.given, routine) | {"held_marks": np.zeros(31), "limit": 2}
    given["constraints"] = {"numpy": constraints, "llvm": code, "c": code.library.address(code.symbol)}
    kernel = INTEGRATORS[name].kernel(held=True)
    assert agree(kernel, given, tmp_path / "k.c") == ReturnCode.LIMIT


def nothing_hoisted(code):
    """What hoists in each language where nothing follows from parameters alone."""
    return {"numpy": lambda p, h: None, "llvm": code, "c": code.library.address(code.symbol)}


def bouncing():
    """A spring's motion with a wall, a level that is noted both ways, and a speed that ends the motion on the way back."""
    N = kn.Frame("N")
    q, v = kn.coordinate("q"), kn.speed("v")
    place = kn.Point("O", fixed_in=N).at("P", q * N.x)
    events = [
        kn.Event("level", q**3 + kn.sin(q) / 4, terminal=False),
        kn.Event("wall", q + 0.5, direction=-1, then={v: -0.9 * v}),
        kn.Event("slow", v - 0.2, direction=-1),
    ]
    body, spring = kn.Particle("P", place, 1), kn.Force(place, -q * N.x)
    return kn.derive(kn.System(N, bodies=[body], loads=[spring], speeds={v: q.dt}, events=events))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gauss16", "tsit5", "tsitpap8", "radau9"])
def test_events_are_decided_with_the_same_bits(name, tmp_path):
    """Passages found, located, noted; the state changed, and the motion gone on from; its end: in each language alike."""
    eom = bouncing()
    given, routine = arguments(eom, EXACT, name, [1.0, 0.1], 9.0, 0.4, 1e-9, np.linspace(0.1, 9, 40))
    given["s"][Slot.SPAN] = 9.0
    stepper = Stepper(eom, np.zeros(0), (), EXACT)
    wide = INTEGRATORS[name].width > 1
    told = automaton(stepper.now, 0.0, np.array([1.0, 0.1, 0.0]), {}, wide=wide)
    codes = {what: told.pop(what) for what in ("watch", "glance", "tendency", "act")}
    numeric = eom.numeric(EXACT)
    routines = {
        "watch": stepper.now.events,
        **{f.__name__: numeric.routine(f).flat for f in (glance, tendency, actions)},
    }
    routines["act"] = routines.pop("actions")

    def narrow(of):
        def call(t, x, p, r, h, out):
            found = of(float(t), x[:2], p[:0], None)
            out[: len(found)] = found

        return call

    def look(t, x, p, r, h, out):
        states = x[:16].reshape(2, 8).T.copy()
        values = [routines["watch"](float(s), y, p[:0], None) for s, y in zip(t, states, strict=False)]
        out[:24] = np.array(values).T.reshape(-1)

    given = languages(given | told, routine)
    given |= {what: nothing_hoisted(code) for what, code in told.items() if what.startswith("hoist_")}
    given |= {what: nothing_hoisted(told["hoist_hw"]) for what in ("hoist_h", "hoist_hd", "hoist_hj")}
    for what, code in codes.items():
        own = look if wide and what == "watch" else narrow(routines[what])
        given[what] = {"numpy": own, "llvm": code, "c": code.library.address(code.symbol)}
    assert agree(INTEGRATORS[name].kernel(watched=True), given, tmp_path / "k.c") == ReturnCode.EVENT
