# SPDX-License-Identifier: BSD-3-Clause
"""What is zero is told by the terms that cancel in it: the same verdicts and the same answers in any units."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples

SI = (1.0, 1.0, 1.0)
"""How many of its units metre, kilogram and second are."""
UNITS = st.tuples(*[st.floats(-6, 6).map(lambda e: 10.0**e)] * 3)


def pushed(force=1000.0, mass=1e12, units=SI):
    """A particle on a line that a force pushes, and nothing else."""
    metre, kilogram, second = units
    N = kn.Frame("N")
    P = kn.Point("O", fixed_in=N).at("P", kn.coordinate("x") * N.x)
    m, F = kn.parameter("m", mass * kilogram), kn.parameter("F", force * kilogram * metre / second**2)
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, m)], speeds="rates", loads=[kn.Force(P, F * N.x)]))


MU, DAY = 3.986004418e14, 86164.0905
RATE = 2 * np.pi / DAY
RADIUS = (MU / RATE**2) ** (1 / 3)


def satellite(units=SI):
    """A satellite in the plane of the equator, in polar coordinates."""
    metre, kilogram, second = units
    N = kn.Frame("N")
    r, theta = kn.coordinate("r"), kn.coordinate("theta")
    A = N.rotate("A", theta, N.z)
    P = kn.Point("O", fixed_in=N).at("P", r * A.x)
    m, mu = kn.parameter("m", 1000.0 * kilogram), kn.parameter("mu", MU * metre**3 / second**2)
    pull = kn.Force(P, -mu * m / r**2 * A.x)
    return kn.derive(kn.System(N, bodies=[kn.Particle("p", P, m)], speeds="rates", loads=[pull]))


def is_steady(error, units=SI, eom=None):
    metre, _, second = units
    try:
        kn.linearize(eom or satellite(units), q=[RADIUS * metre, 0.3], u=[0.0, RATE * (1 + error) / second])
    except kn.SimulationError:
        return False
    return True


@pytest.mark.parametrize("force", [1000.0, 1e-9])
def test_a_force_that_nothing_balances_is_no_equilibrium(force):
    """1000 N on 10¹² kg make 10⁻⁹ m/s², which is small beside nothing here."""
    with pytest.raises(kn.SimulationError, match=r"the residuals are u_x' = 1e-"):
        kn.equilibrium(pushed(force), q={"x": kn.guess(0.3)})
    assert kn.equilibrium(pushed(0.0), q={"x": 0.3})["x"] == 0.3


def test_a_geostationary_satellite_is_steady_at_its_own_rate_alone():
    eom = satellite()
    assert [is_steady(e, eom=eom) for e in (0.0, 1e-12, 1e-10, 1e-7, 1e-5, -1e-5, 1e-3)] == [True] * 3 + [False] * 4
    point = kn.trim(eom, q={"r": kn.guess(4e7), "theta": 0}, u={"u_r": 0, "u_theta": RATE})
    assert point["r"] == pytest.approx(RADIUS, rel=1e-12)
    slow = kn.linearize(eom, **point.arguments).eigenvalues
    np.testing.assert_allclose(np.sort(np.abs(slow)), [0, 0, RATE, RATE], rtol=1e-9, atol=1e-9 * RATE)


@examples(0.1, 3)
@given(UNITS)
def test_these_verdicts_are_the_same_in_any_units(units):
    with pytest.raises(kn.SimulationError, match="the residuals are u_x'"):
        kn.equilibrium(pushed(units=units), q={"x": kn.guess(0.3 * units[0])})
    eom = satellite(units)
    assert [is_steady(e, units, eom) for e in (0.0, 1e-10, 1e-6)] == [True, True, False]


def hung(units=SI):
    """Two masses on springs below each other, beside them a pendulum that a torsion spring turns: three equilibria."""
    metre, kilogram, second = units
    newton = kilogram * metre / second**2
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, a = kn.coordinate("x"), kn.coordinate("y"), kn.coordinate("a")
    k, m, l = (
        kn.parameter("k", 40.0 * newton / metre),
        kn.parameter("m", 0.7 * kilogram),
        kn.parameter("l", 0.3 * metre),
    )
    g, c = kn.parameter("g", 9.81 * metre / second**2), kn.parameter("c", 0.9 * newton * metre)
    A = N.rotate("A", a, N.z)
    P, Q, R = O.at("P", -x * N.y), O.at("Q", -y * N.y), O.at("R", l * A.y)
    loads = [kn.gravity(-g * N.y), kn.Force(P, k * (x - (y - x)) * N.y), kn.Force(Q, k * (y - x) * N.y)]
    bodies = [kn.Particle(n, at, m) for n, at in (("p", P), ("q", Q), ("r", R))]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=[*loads, kn.Torque(A, -c * a * N.z)]))


@pytest.mark.slow
@examples(0.1, 3)
@given(UNITS)
def test_equilibria_and_their_frequencies_are_the_same_in_any_units(units):
    metre, _, second = units
    eom, fall = hung(units), 0.7 * 9.81 / 40.0 * metre
    point = kn.equilibrium(eom, q={"x": kn.guess(0), "y": kn.guess(2.0 * metre), "a": kn.guess(1.2)})
    assert [point["x"], point["y"]] == pytest.approx([2 * fall, 3 * fall], rel=1e-12)
    assert 0.9 * point["a"] == pytest.approx(0.7 * 9.81 * 0.3 * np.sin(point["a"]), rel=1e-12)
    found = np.sort(np.abs(kn.linearize(eom, **point.arguments).eigenvalues.imag))[::2] * second
    stiffness = (0.9 - 0.7 * 9.81 * 0.3 * np.cos(point["a"])) / (0.7 * 0.09)
    chain = 40.0 / 0.7 * np.array([(3 - np.sqrt(5)) / 2, (3 + np.sqrt(5)) / 2])
    np.testing.assert_allclose(found, np.sort(np.sqrt([stiffness, *chain])), rtol=1e-9)


@examples(0.1, 3)
@given(UNITS)
def test_what_rests_at_zero_where_nothing_has_a_size(units):
    """Springs without weights rest at zero, which no number that is not zero is near."""
    metre, kilogram, second = units
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinate("x"), kn.coordinate("y")
    k, m = kn.parameter("k", 40.0 * kilogram / second**2), kn.parameter("m", 0.7 * kilogram)
    P, Q = O.at("P", x * N.x), O.at("Q", y * N.x)
    loads = [kn.Force(P, -k * (2 * x - y) * N.x), kn.Force(Q, k * (x - y) * N.x)]
    bodies = [kn.Particle("p", P, m), kn.Particle("q", Q, m)]
    eom = kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads))
    point = kn.equilibrium(eom, q={"x": kn.guess(0.1 * metre), "y": kn.guess(-0.3 * metre)})
    assert kn.linearize(eom, **point.arguments).A.shape == (4, 4)
    with pytest.raises(kn.SimulationError, match="these accelerations are not zero: u_x'"):
        kn.linearize(eom, q=[1e-9 * metre, 0.0], u=[0.0, 0.0])
