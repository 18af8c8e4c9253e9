# SPDX-License-Identifier: BSD-3-Clause
"""What motions and analyses compile: how many modules, with which settings, kept how long."""

import gc
import weakref

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from kane.motion import constraint_numbers, rates, unembedded
from kane.program import host, machine

EXACT = kn.Settings(contract=False, cache=False)
FRESH = kn.Settings(cache=False)


def four_bar():
    return kn.derive(load("four_bar").system())


@pytest.fixture
def compiled(monkeypatch):
    """The modules that LLVM is given, each as its text and target."""
    modules = []

    def spied(text, on, symbols, cached=True):
        modules.append((text, on, cached))
        return compile_text(text, on, symbols, cached)

    compile_text = machine.compile_text
    monkeypatch.setattr("kane.program.native.machine.compile_text", spied)
    return modules


def motion(eom, settings=FRESH, end=0.1):
    at = kn.assemble(eom, q={eom.coordinates[0]: 0.3}, u={eom.speeds[0]: 1.0})
    return kn.simulate(eom, (0, end), q=at.q, u=at.u, samples=3, settings=settings)


@pytest.mark.slow
def test_a_motion_of_the_four_bar_compiles_once(compiled):
    """One module of its routines, and those of the steps and of the projection around them; one more when it is asked for again."""
    eom = four_bar()
    motion(eom)
    assert len(compiled) <= 3
    assert all(f"@{name}.call(" in compiled[0][0] for name in ("motion", "constraints"))
    before = len(compiled)
    motion(eom)  # prepared now: energies, constraints and pivots of its start and end are one routine
    assert len(compiled) <= before + 1
    before = len(compiled)
    motion(eom)
    assert len(compiled) == before


def test_a_linearization_compiles_one_module(compiled):
    top = kn.derive(load("pendulum_on_cart").system())
    for _ in range(2):
        kn.linearize(top, q=[0.0, 0.0], u=[0.0, 0.0], inputs=dict.fromkeys(top.inputs, 0.0), settings=FRESH)
    assert len(compiled) == 1


def test_routines_of_one_module_are_those_of_modules_of_their_own(compiled):
    together, alone = four_bar().numeric(FRESH), four_bar().numeric(FRESH)
    together.compile(rates, constraint_numbers, unembedded)
    x, p = np.array([0.3, 1.1, -0.8, 1.0, 0.2, -0.4]), np.array([s.default for s in together.equations.parameters])
    for make in (rates, constraint_numbers, unembedded):
        assert np.array_equal(together.routine(make).flat(0.0, x, p), alone.routine(make).flat(0.0, x, p))
    assert len(compiled) == 4
    for name, (text, _, _) in zip(("motion", "constraints", "unembedded"), compiled[1:], strict=True):
        assert _kernel(compiled[0][0], name) == _kernel(text, name)


def _kernel(text, name):
    return text[text.index(f"define void @{name}(") :].partition("\n}")[0]


@pytest.mark.slow
def test_settings_reach_the_code_of_motions_and_analyses(compiled):
    settings = kn.Settings(
        contract=False, cpu="generic", features="+sse4.2" * ("+sse4.2" in host().features), cache=False
    )
    eom = four_bar()
    sol = motion(eom, settings)
    rest = kn.equilibrium(eom, q={"q1": kn.guess(1.2)}, settings=settings)
    kn.linearize(eom, **rest.arguments, settings=settings)
    kn.trim(eom, q={"q1": kn.guess(1.2)}, u=dict.fromkeys(eom.speeds, 0.0), settings=settings)
    kn.inverse(eom, [u.dt for u in eom.speeds], settings=settings).along(sol)
    assert len(compiled) >= 3
    for text, on, cached in compiled:
        assert "contract" not in text
        assert on.cpu == "generic"
        assert ("+sse4.2" in on.features) == bool(settings.features)
        assert not cached
    before = len(compiled)
    motion(eom, kn.Settings(cache=False))
    assert any("contract" in text for text, _, _ in compiled[before:])
    assert all(on == host() for _, on, _ in compiled[before:])


@pytest.mark.slow
def test_other_dependent_speeds_keep_the_settings(compiled):
    """The slider-crank's crank turns through its dead centres."""
    eom = kn.derive(load("slider_crank").system())
    at = kn.assemble(eom, q={eom.coordinates[0]: 0.1}, u={eom.speeds[0]: 20.0})
    sol = kn.simulate(eom, (0, 1.0), q=at.q, u=at.u, settings=EXACT)
    changes = [e for e, _ in sol.events if "dependent speeds" in e.name]
    assert changes, "the motion changes no dependent speeds: the test says nothing"
    assert len(compiled) > 1
    assert not any("contract" in text for text, _, _ in compiled)
    assert not any("@constraints.call(" in text for text, _, _ in compiled[1:])


def test_settings_that_are_none():
    with pytest.raises(kn.ArgumentError, match=r"Expected kn.Settings\(…\) as settings, got 'generic'"):
        kn.simulate(four_bar(), (0, 1), q=[0, 0, 0], u=[0, 0, 0], settings="generic")


def test_one_object_for_each_settings():
    eom = four_bar()
    assert eom.numeric() is eom.numeric(kn.Settings())
    assert eom.numeric(EXACT) is not eom.numeric()
    assert eom.numeric().settings == kn.Settings()


@pytest.mark.slow
def test_what_is_compiled_goes_with_the_equations():
    eom = four_bar()
    motion(eom)
    library = weakref.ref(eom.numeric(FRESH).routine(rates).flat._library)
    there = weakref.ref(eom)
    gc.collect()
    gc.disable()
    try:
        del eom
        assert there() is None
        assert library() is None
    finally:
        gc.enable()
