# SPDX-License-Identifier: BSD-3-Clause
"""Configurations in any units: what misses a constraint, what is assembled, and what a motion keeps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples

METRES = [1.0, 1e-6, 1e6, 1e-9]
"""How many of its units a metre is."""


def ring(radius=None):
    """A bead on a ring in a vertical plane."""
    N = kn.Frame("N")
    x, y = kn.coordinates("x y")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x + y * N.y)
    a = kn.parameter("a", radius)
    held = kn.configuration_constraint("ring", x**2 + y**2 - a**2)
    return kn.derive(
        kn.System(
            N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", loads=[kn.gravity(-9.81 * N.y)], holonomic=[held]
        )
    )


@pytest.fixture(scope="module", params=[None, 1.0, 1e-6])
def any_ring(request):
    """One without a default, one with another default, and one with its own."""
    return ring(request.param)


@pytest.fixture(scope="module")
def metre_ring():
    return ring(1.0)


@pytest.mark.parametrize("metre", METRES)
def test_a_start_at_eleven_radii_misses_the_ring(any_ring, metre):
    for start in (11.0, 1.001, 0.0):
        with pytest.raises(kn.SimulationError, match="miss ring"):
            kn.assemble(any_ring, q={"x": start * metre, "y": 0.0}, parameters={"a": metre})
    kn.assemble(any_ring, q={"x": 0.6 * metre, "y": -0.8 * metre}, parameters={"a": metre})


@pytest.mark.parametrize("metre", METRES)
def test_no_analysis_takes_it(metre_ring, metre):
    q, given = [11.0 * metre, 0.0], {"a": metre}
    with pytest.raises(kn.SimulationError, match="miss ring"):
        kn.simulate(metre_ring, (0, 1), q=q, u=[0, 0], parameters=given)
    with pytest.raises(kn.SimulationError, match="miss ring"):
        kn.linearize(metre_ring, q=q, u=[0, 0], parameters=given)
    with pytest.raises(kn.SimulationError, match="miss ring"):
        kn.inverse(metre_ring, ["u_x'", "u_y'"])(q=q, u=[0, 0], parameters=given)
    kn.linearize(metre_ring, q=[0.0, -metre], u=[0, 0], parameters=given)


@pytest.mark.parametrize("metre", METRES)
def test_assembly_closes_the_same_in_any_units(any_ring, metre):
    """The nearest place on the ring is in the direction of the guess."""
    found = kn.assemble(any_ring, q={"x": kn.guess(11 * metre), "y": kn.guess(0.2 * metre)}, parameters={"a": metre})
    x, y = np.array(list(found.q.values())) / metre
    assert [x, y] == pytest.approx(np.array([11, 0.2]) / np.hypot(11, 0.2), abs=1e-8)
    assert x**2 + y**2 == pytest.approx(1, abs=1e-14)


@pytest.mark.parametrize("metre", METRES)
def test_a_motion_keeps_the_ring_in_any_units(metre_ring, metre):
    """From the side it falls through the bottom in the time of a pendulum at 90°, 1.18034 √(a/g) · π/2."""
    half = 1.18034059901609 * np.pi * np.sqrt(metre / 9.81)
    sol = kn.simulate(
        metre_ring, (0, half), q=[metre, 0.0], u=[0, 0], parameters={"a": metre}, atol=1e-9 * metre, samples=9
    )
    assert sol.status == "finished"
    np.testing.assert_allclose(np.hypot(*sol.q.T) / metre, 1, rtol=1e-12)
    np.testing.assert_allclose(sol.q[-1] / metre, [-1, 0], atol=1e-6)


@examples(0.1, 3)
@given(st.floats(-9, 9), st.floats(0.1, 0.9))
def test_a_crank_and_a_slide_close_the_same_in_any_units(exponent, angle):
    metre = 10.0**exponent
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, th, be = kn.coordinates("x th be")
    a, b = kn.parameter("a", metre), kn.parameter("b", 2.5 * metre)
    A, B = N.rotate("A", th, N.z), N.rotate("B", be, N.z)
    Q, S = O.at("Q", a * A.x), O.at("S", x * N.x)
    bodies = [kn.Particle("q", Q, 1.0), kn.Particle("s", S, 1.0)]
    pin = kn.coincident(Q.at("P", b * B.x), S, along=(N.x, N.y))
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", holonomic=pin))
    every = kn.assemble(eom, q={"th": angle, "be": kn.guess(0.2), "x": kn.guess(3 * metre)}, all_branches=True)
    far = [np.cos(angle) + s * np.sqrt(6.25 - np.sin(angle) ** 2) for s in (1, -1)]
    assert [found.q[x] / metre for found in every] == pytest.approx(far, rel=1e-13)
