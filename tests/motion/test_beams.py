# SPDX-License-Identifier: BSD-3-Clause
"""Beams along a motion: what is said of those that spin too fast for what they are declared with."""

from __future__ import annotations

import warnings
from typing import Any

import pytest

import kane as kn
from tests.oracles.rotating_beam import elastica
from tests.peer import require
from tests.systems.beams import spinning


def said(spin: float, **more: Any) -> list[type[Warning]]:
    """The categories of the warnings of a short motion at a spin."""
    _, system = spinning(**more)
    zero = {"q": dict.fromkeys(system.coordinates, 0.0), "u": dict.fromkeys(system.speeds, 0.0)}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        kn.simulate(kn.derive(system), (0, 0.1), samples=3, parameters={"Omega": spin}, **zero)
    return [w.category for w in caught]


def test_premature_linearization() -> None:
    """Beyond the first frequency at rest, 3.516 rad/s, and not below it."""
    assert said(3.4, stiffening=False) == []
    assert said(3.6, stiffening=False) == [kn.StiffeningWarning]
    assert said(3.6) == []


def test_a_shaft_that_spins_about_its_axis_says_nothing() -> None:
    N = kn.Frame("N")
    A = N.rotate("A", 50 * kn.time, N.x)
    beam = kn.Beam(
        "shaft",
        kn.Point("O", fixed_in=N),
        frame=A,
        axis=A.x,
        length=1.0,
        mass_per_length=1.0,
        EI=1.0,
        modes=1,
        stiffening=False,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kn.simulate(kn.derive(kn.System(N, bodies=[beam])), (0, 0.01), q=[0.0], u=[0.0], samples=3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("modes", "spin", "enough"), [(1, 4, True), (1, 12, False), (3, 12, True), (2, 30, False), (4, 30, True)]
)
def test_too_few_modes(modes: int, spin: float, enough: bool) -> None:
    """One clamped-free mode has the first flapwise frequency at γ = 12, 13.170, as 13.572."""
    assert said(spin, modes=modes) == ([] if enough else [kn.ModesWarning])


@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
@pytest.mark.parametrize(("deflection", "fits"), [(0.1, True), (0.2, False)])
def test_large_deflections(form: str, deflection: float, fits: bool) -> None:
    """One function has the slope 2.75 q/L at the tip."""
    _, system = spinning(modes=1, form=form)
    eom = kn.derive(system)
    assert kn.prepare(eom, (0, 0.01)).in_one_call
    for _ in range(3):  # by what is kept of the equations, too
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            kn.simulate(eom, (0, 0.01), q=[deflection], u=[0.0], samples=3)
        assert [str(w.message).endswith("Divide the beam into several.") for w in caught] == ([] if fits else [True])


def test_large_deflections_of_one_of_many() -> None:
    require("xarray")
    _, system = spinning(modes=1)
    runs = kn.simulate_many(kn.derive(system), (0, 0.01), q=[[0.1], [0.2]], u=[0.0], samples=3, lanes=True)
    assert ["Divide the beam into several." in text for text in runs.warning.values] == [False, True]


@pytest.mark.parametrize(
    ("count", "off"), [(1, 0.2420), (2, 0.02853), pytest.param(4, 0.003345, marks=pytest.mark.slow)]
)
def test_a_beam_divided_follows_the_elastica(count: int, off: float) -> None:
    """F L²/EI = 1.6 at the tip, normal to the straight cantilever: one beam bends 24 % too far, two 3 %, four 0.3 %."""
    N = kn.Frame("N")
    end, frame, beams = kn.Point("O", fixed_in=N), N, []
    for k in range(count):
        beam = kn.Beam(
            f"b{k}",
            end,
            frame=frame,
            axis=frame.x,
            along=frame.y,
            length=1 / count,
            mass_per_length=1.0,
            EI=1.0,
            modes=kn.mode_shapes("polynomials", 2),
        )
        beams.append(beam)
        end, frame = beam.point_at(1), beam.frame_at(1)
    eom = kn.derive(kn.System(N, bodies=beams, loads=[kn.Force(end, 1.6 * N.y)]))
    point = kn.equilibrium(eom)
    deflection = eom.evaluate(end.position(beams[0].root).dot(N.y), **point.arguments)
    assert deflection / elastica(1.6) - 1 == pytest.approx(off, rel=0.01)


@pytest.mark.parametrize(
    ("parameter", "what"),
    [("L_beam", "length"), ("rhoA_beam", "mass_per_length"), ("EI_beam", "EI"), ("EA_beam", "EA"), ("GJ_beam", "GJ")],
)
@pytest.mark.parametrize("value", [0.0, -1.0])
def test_values_that_are_not_above_zero(parameter: str, what: str, value: float) -> None:
    """What the declaration refuses is refused of the values of a motion, too."""
    _, system = spinning(modes=1, EA=10.0, stretch=1, GJ=1.0, torsion=1, polar=0.1)
    with pytest.raises(kn.SimulationError, match=f"Expected {what} of beam above zero, got {parameter} = {value:g} at"):
        kn.simulate(kn.derive(system), (0, 0.1), q=[0.0] * 3, u=[0.0] * 3, samples=3, parameters={parameter: value})
