# SPDX-License-Identifier: BSD-3-Clause
"""A beam as a chain of rigid rods with torsion springs, by recursion, converges to `Beam` at order 2."""

import numpy as np
import pytest

import kane as kn
from tests.systems.beam_chains import chain
from tests.systems.beams import spinning

SHAPES = kn.mode_shapes("polynomials", 8)
FEW = (10, 20, 40)
SPIN = 4.0


def linear(eom: kn.Equations, tip: np.ndarray, spin: float) -> np.ndarray:
    """The first three frequencies about the straight beam that spins, and the deflection of the tip by a unit force there.

    There u̇ = −S q + b F, as velocities across the axis have accelerations along it alone; the matrix by central differences.
    """
    n, small = len(eom.coordinates), 1e-7
    rhs, values = eom.compile().rhs, {"Omega": spin}
    states = np.zeros((2 * n, 2 * n))
    states[:n, :n], states[n:, :n] = small * np.eye(n), -small * np.eye(n)
    moved = rhs(0.0, states, values)[:, n:]
    stiffness = -(moved[:n] - moved[n:]).T / (2 * small)
    pulled = rhs(0.0, np.zeros(2 * n), {**values, "F": small})[n:] / small
    frequencies = np.sqrt(np.sort(np.linalg.eigvals(stiffness).real)[:3])
    return np.array([*frequencies, tip @ np.linalg.solve(stiffness, pulled)])


def of_chain(links: int, spin: float, flap: bool) -> np.ndarray:
    eom = kn.derive(chain(links, flap=flap)[0])
    assert eom.route != "classical"
    return linear(eom, 1 - (np.arange(links) + 0.5) / links, spin)


def of_beam(spin: float, flap: bool) -> np.ndarray:
    beam, system = spinning(flap=flap, modes=SHAPES)
    push = kn.Force(beam.point_at(1), kn.parameter("F", 0.0, "N") * beam.deformation.bending[0].along)
    return linear(kn.derive(system.replace(loads=[push])), SHAPES.at(1.0), spin)


@pytest.mark.slow
@pytest.mark.parametrize(("spin", "flap"), [(0.0, False), (SPIN, False), (SPIN, True)])
def test_frequencies_and_statics(spin: float, flap: bool) -> None:
    """Twice the links, a quarter of the error: of the first frequencies at rest and spinning, and of the tip's deflection."""
    exact = of_beam(spin, flap)
    errors = np.array([np.abs(of_chain(n, spin, flap) / exact - 1) for n in FEW])
    np.testing.assert_allclose(errors[:-1] / errors[1:], 4.0, rtol=0.1)
    assert errors[-1].max() < 0.005


@pytest.mark.slow
def test_a_hundred_links() -> None:
    exact = of_beam(SPIN, False)
    errors = np.array([np.abs(of_chain(n, SPIN, False) / exact - 1) for n in (40, 100)])
    np.testing.assert_allclose(np.log(errors[0] / errors[1]) / np.log(2.5), 2.0, atol=0.05)
    assert errors[1].max() < 1e-3


def lag(system: kn.System, tip: kn.Expr, t: np.ndarray) -> np.ndarray:
    zero = {"q": dict.fromkeys(system.coordinates, 0.0), "u": dict.fromkeys(system.speeds, 0.0)}
    found: np.ndarray = kn.simulate(kn.derive(system), (0, t[-1]), samples=t, rtol=1e-9, atol=1e-12, **zero)[tip]
    return found


@pytest.mark.slow
def test_spin_up() -> None:
    """On a hub that is brought to a slow spin: the largest difference of the tip's lag over the largest lag."""
    T, t = kn.parameter("T", 2.0, "s"), np.linspace(0, 3, 31)
    turns = 2 * kn.pi * kn.time / T
    angle = kn.parameter("a", 0.02, "rad/s^2") * (kn.time**2 / 2 + (T / (2 * kn.pi)) ** 2 * (kn.cos(turns) - 1))
    beam, system = spinning(angle=angle, modes=SHAPES)
    exact = lag(system, beam.point_at(1).position(beam.root).dot(beam.frame.y), t)
    errors = []
    for n in FEW[:2]:
        system, tip, A = chain(n, angle=angle)
        errors.append(np.abs(lag(system, tip.position(tip.root()).dot(A.y), t) - exact).max() / np.abs(exact).max())
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.1)
    assert errors[1] < 0.01
