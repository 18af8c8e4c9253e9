# SPDX-License-Identifier: BSD-3-Clause
"""Rotating cantilevers: frequencies of Wright et al. (1982), and those of an independent collocation.

Wright, A. D., Smith, C. E., Thresher, R. W. and Wang, J. L. C. (1982), Vibration modes of centrifugally stiffened beams,
*J. Appl. Mech.* 49(1), 197-202: dimensionless flapwise frequencies, hub radius 0.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.oracles import rotating_beam
from tests.systems.beams import frequencies, spinning

AT_REST = (3.516015268, 22.034491564, 61.697214415, 120.901916065, 199.859530116)
FLAPWISE = {1: 3.6816, 2: 4.1373, 3: 4.7973, 6: 7.3604, 10: 11.2023, 12: 13.1702}


@pytest.mark.slow
@pytest.mark.parametrize("form", ["linearized", "nonlinear"])
def test_at_rest_by_legendre_polynomials(form: str) -> None:
    count = 10 if form == "linearized" else 3
    _, system = spinning(modes=kn.mode_shapes("legendre", count), form=form)
    few = 3 if form == "linearized" else 1
    tolerance = 1e-8 if form == "linearized" else 1e-3
    np.testing.assert_allclose(frequencies(system)()[:few], AT_REST[:few], rtol=tolerance)


@pytest.mark.slow
def test_at_rest_five_frequencies() -> None:
    _, system = spinning(modes=kn.mode_shapes("legendre", 15))
    np.testing.assert_allclose(frequencies(system)()[:5], AT_REST, rtol=1e-8)


@pytest.mark.slow
def test_flapwise_and_chordwise() -> None:
    """Every digit of the table; in the plane of rotation the square is less by γ², without stretch."""
    modes = kn.mode_shapes("polynomials", 12)
    flap, chord = (frequencies(spinning(flap=f, modes=modes)[1]) for f in (True, False))
    for gamma, expected in FLAPWISE.items():
        out = flap(Omega=gamma)
        assert round(float(out[0]), 4) == expected
        np.testing.assert_allclose(chord(Omega=gamma)[:3] ** 2, out[:3] ** 2 - gamma**2, rtol=1e-9)
        np.testing.assert_allclose(out[:3], rotating_beam.flapwise(gamma)[:3], rtol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("hub", [1.0, 5.0])
def test_hub_of_some_radius(hub: float) -> None:
    _, system = spinning(flap=True, modes=kn.mode_shapes("polynomials", 14), hub=hub)
    at = frequencies(system)
    for gamma in (2, 8):
        expected = rotating_beam.flapwise(gamma, hub)[:3]
        np.testing.assert_allclose(at(Omega=gamma)[:3], expected, rtol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("slenderness", [70, 700])
def test_stretch_and_bending_in_the_plane(slenderness: float) -> None:
    _, system = spinning(
        modes=kn.mode_shapes("polynomials", 12), EA=slenderness**2, stretch=kn.mode_shapes("rod polynomials", 9)
    )
    at = frequencies(system)
    for gamma in (3, 12):
        expected = rotating_beam.in_plane(gamma, 0.0, slenderness)[:3]
        np.testing.assert_allclose(at(Omega=gamma)[:3], expected, rtol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("gamma", [5.0, 40.0])
def test_a_beam_that_turns_about_its_middle(gamma: float) -> None:
    """Free at both ends, across the plane of rotation: it keeps heaving (0) and pitching (γ); its bending is that of Ritz's method."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    A = N.rotate("A", kn.parameter("Omega", gamma, "rad/s") * kn.time, N.z)
    heave = kn.slider("heave", O, A, axis=A.z)
    pitch = kn.pin("pitch", heave.point, heave.frame, axis=heave.frame.y)
    B = pitch.frame
    beam = kn.Beam(
        "beam", pitch.point.at("root", -0.5 * B.x), frame=B, axis=B.x, along=B.z, length=1.0, mass_per_length=1.0, EI=1.0, modes=5,
        support="free",
    )  # fmt: skip
    linear = kn.linearize(kn.derive(kn.System(N, bodies=[beam], joints=[heave, pitch])), q=[0.0] * 7, u=[0.0] * 7)
    found = np.sort(linear.eigenvalues.imag)[-6:]
    np.testing.assert_allclose(found[0], gamma, rtol=1e-9)
    np.testing.assert_allclose(found[1:3], rotating_beam.free_flapwise(gamma)[:2], rtol=3e-4)
