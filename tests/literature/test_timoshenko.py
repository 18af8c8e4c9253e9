# SPDX-License-Identifier: BSD-3-Clause
"""Beams that shear, and whose sections have inertia of rotation: frequencies against characteristic equations (Huang 1961)."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples
from tests.oracles import timoshenko
from tests.systems.beams import frequencies, spinning

R = 0.05
S = R * np.sqrt(2.6 / 0.85)
"""Of a rectangular section with ν = 0.3 and k_s = 0.85."""
CANTILEVER = np.array([3.516015268536, 22.034491565])


def of_beam(count: int, r: float, s: float, **more: Any) -> np.ndarray:
    """Frequencies with this many functions of bending and as many of shear, of unit length, mass and EI."""
    given = {"modes": kn.mode_shapes("polynomials", count), "shear_modes": kn.mode_shapes("rod polynomials", count)}
    found: np.ndarray = frequencies(spinning(**{**given, **more}, shear=1 / s**2, rotary=r**2)[1])()
    return found


@pytest.mark.slow
@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
def test_cantilever(form: str) -> None:
    count = 10 if form == "linearized" else 3
    found = of_beam(count, R, S, form=form)
    few = 3 if form == "linearized" else 1
    np.testing.assert_allclose(found[:few], timoshenko.cantilever(R, S, few), rtol=1e-8 if few > 1 else 1e-3)


def test_default_functions_of_shear() -> None:
    """They are as good as those of bending."""
    found = frequencies(spinning(modes=kn.mode_shapes("polynomials", 8), shear=1 / S**2, rotary=R**2)[1])()
    np.testing.assert_allclose(found[:2], timoshenko.cantilever(R, S, 2), rtol=1e-8)


UNIT = st.floats(-6, 6).map(lambda k: 10.0**k)


@examples(0.03)
@given(st.floats(0.005, 0.1), st.floats(1, 3), st.sampled_from([0.0, 0.1, 5.0]), st.tuples(UNIT, UNIT, UNIT))
def test_any_cantilever_in_any_units(r: float, ratio: float, tip: float, units: tuple[float, float, float]) -> None:
    """Sections, masses at the tip, and units of length, mass and time at random; functions of shear by default."""
    length, mass, time = units
    EI, s = mass * length**3 / time**2, ratio * r
    beam, system = spinning(
        modes=kn.mode_shapes("polynomials", 7),
        length=length,
        mass_per_length=mass / length,
        EI=EI,
        shear=EI / (s * length) ** 2,
        rotary=mass * length * r**2,
    )
    bodies = [beam, kn.Particle("body", beam.point_at(1), tip * mass)] if tip else [beam]
    found = frequencies(system.replace(bodies=bodies))() * time
    np.testing.assert_allclose(found[:2], timoshenko.cantilever(r, s, 2, tip), rtol=1e-6)


def test_simply_supported() -> None:
    """Sines are the modes: exact with as many as are asked for."""
    sines = kn.mode_shapes("pinned", 3)
    found = of_beam(3, R, S, modes=sines, shear_modes=sines, support="pinned")
    np.testing.assert_allclose(found[:3], timoshenko.simply_supported(R, S, 3), rtol=1e-10)


@pytest.mark.slow
def test_nothing_locks_as_the_stiffness_of_shear_grows() -> None:
    """With s → 0 the frequency of Rayleigh's beam is approached with s², with r → 0 that of Euler's and Bernoulli's with r²."""
    rayleigh = frequencies(spinning(modes=kn.mode_shapes("polynomials", 6), rotary=R**2)[1])()[0]
    off = [1 - of_beam(6, R, s)[0] / rayleigh for s in (0.02, 0.01, 0.005)]
    np.testing.assert_allclose(np.divide(off[:-1], off[1:]), 4.0, rtol=0.01)
    thin = [
        1 - frequencies(spinning(modes=kn.mode_shapes("polynomials", 8), rotary=r**2)[1])()[:2] / CANTILEVER
        for r in (0.04, 0.02, 0.01)
    ]
    np.testing.assert_allclose(np.divide(thin[:-1], thin[1:])[-1], 4.0, rtol=0.05)
