# SPDX-License-Identifier: BSD-3-Clause
"""Steady rotation of beams: what is said of those that spin too fast for what they are declared with."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Polynomial

import kane as kn
from kane.gallery import load
from tests.systems.beams import spinning


def said(do: Callable[[kn.Equations, dict[str, Any]], object], **more: Any) -> list[warnings.WarningMessage]:
    """The warnings of a question to the equations at the straight beam."""
    _, system = spinning(**more)
    zero: dict[str, Any] = {"q": dict.fromkeys(system.coordinates, 0.0), "u": dict.fromkeys(system.speeds, 0.0)}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        do(kn.derive(system), zero)
    return caught


def linearized(spin: float, **more: Any) -> list[type[Warning]]:
    found = said(lambda eom, zero: kn.linearize(eom, **zero, parameters={"Omega": spin}), flap=True, **more)
    assert all(w.filename == __file__ for w in found)
    return [w.category for w in found]


@pytest.mark.parametrize(("spin", "warned"), [(3.4, False), (3.6, True)])
def test_linearized_without_stiffening(spin: float, warned: bool) -> None:
    assert linearized(spin, stiffening=False, modes=1) == ([kn.StiffeningWarning] if warned else [])
    assert linearized(spin, modes=2) == []


@pytest.mark.parametrize(("modes", "spin", "enough"), [(1, 4, True), (1, 12, False), (3, 12, True)])
def test_too_few_modes(modes: int, spin: float, enough: bool) -> None:
    assert linearized(spin, modes=modes) == ([] if enough else [kn.ModesWarning])


@pytest.mark.parametrize("share", [Polynomial([1.0, -0.5]), np.poly1d([-0.5, 1.0]), lambda x: 1 - 0.5 * x])
def test_a_taper_may_be_a_polynomial_of_numpy(share: Any) -> None:
    """Which has no hash: frequencies of a beam are kept for the next time."""
    tapers = {name: kn.tapered(1.0, share) for name in ("mass_per_length", "EI")}
    for spin, found in ((2.0, []), (6.0, [kn.StiffeningWarning])):
        assert linearized(spin, stiffening=False, modes=2, **tapers) == found


def test_a_branch_is_warned_of_once_at_its_fastest_point() -> None:
    def follow(eom: kn.Equations, zero: dict[str, Any]) -> object:
        free = {q: kn.guess(0.0) for q in zero["q"]}
        return kn.continuation(eom, "Omega", [0.0, 6.0, 12.0], q=free, u=zero["u"])

    (only,) = said(follow, flap=True, modes=1)
    assert only.category is kn.ModesWarning
    assert "up to 12 rad/s" in str(only.message)
    assert only.filename == __file__
    assert [w.category for w in said(follow, flap=True, modes=1, stiffening=False)] == [kn.StiffeningWarning]
    assert said(follow, flap=True, modes=4) == []


@pytest.mark.parametrize("name", ["flexible_slider_crank", "flexible_four_bar"])
@pytest.mark.parametrize("ask", [kn.trim, kn.linearize])
def test_a_beam_bent_beyond_its_equations(name, ask):
    """A speed alone has a negative kinetic energy there: no failure of numbers, but a named error."""
    eom = kn.derive(load(name).system())
    q = {x: kn.guess(6.0 if x.name.startswith("v") else 1.0) for x in eom.coordinates}
    with pytest.raises(kn.SimulationError, match=r"kinetic energy ≥ 0|satisfies the constraints"):
        ask(eom, q=q, u=dict.fromkeys(eom.independent_speeds, 0.0) if ask is kn.linearize else None)
