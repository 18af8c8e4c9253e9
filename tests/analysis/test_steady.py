# SPDX-License-Identifier: BSD-3-Clause
"""What speeds depend on is read off numbers in which rounding leaves traces; these count for nothing."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.analysis import dependence
from tests.systems.turning_disk import disk


@pytest.mark.parametrize("noise", [0.0, 1e-15, 1e-14])
def test_rounding_makes_no_coordinate_matter(noise):
    """x' = u, and u' holds x by rounding alone: balanced with the chain that leads back, both would be the root of it."""
    assert dependence(np.array([[0.0, 1.0], [noise, 0.0]]), 1).tolist() == [False, True]
    assert dependence(np.array([[0.0, 1.0, 0.0], [noise, 0.0, -2.0], [0.0, 1.0, 0.0]]), 1).tolist() == [
        False,
        True,
        True,
    ]


def test_units_make_no_coordinate_cyclic():
    """A spring of 1 N/m in Mm, Mg and hours, or in mm: what holds x is small beside the rest, and is no rounding."""
    for small in (1.0, 1e-6, 1e-9):
        assert dependence(np.array([[0.0, 1.0], [-small, 0.0]]), 1).all()


CHOICES = [(), (1, 3), (1, 4), (2, 3), (2, 4), (3, 4)]
"""Dependent speeds of the disk by place: all that its rolling gives."""
NAMES = ("yaw", "lean", "spin", "x", "y")


def upright(eom, spin):
    q = dict(zip(NAMES, (0.3, 0.0, spin, 0.0, 0.0), strict=True))
    return kn.assemble(eom, q=q, rates={"yaw": 0.0, "lean": 0.0, "spin": 5.0})


@pytest.mark.slow
@pytest.mark.parametrize("dependent", CHOICES)
def test_an_upright_disk_is_steady_whatever_its_dependent_speeds(dependent):
    """Those of its contact turn with it and change, or turn back; the others do not. It leans and yaws with ω² = 12/5 Ω² − 4/5 g/R."""
    eom = kn.derive(disk(dependent))
    for spin in (0.0, 0.2, np.pi / 2, 2.2, 3.0):
        state = upright(eom, spin)
        linear = kn.linearize(eom, q=state.q, u=state.u)
        found = np.sort(np.abs(np.linalg.eigvals(linear.A).imag))[-2:]
        np.testing.assert_allclose(found, np.sqrt(12 / 5 * 25 - 4 / 5 * 9.81 / 0.3), rtol=1e-9)
        assert set(linear.cyclic) == {"yaw", "spin", "x", "y"}
        assert linear.states[-3:] == ("u1", "u2", "u3")


@pytest.mark.slow
@pytest.mark.parametrize("dependent", CHOICES)
def test_a_steady_circle_is_found_whatever_the_dependent_speeds(dependent):
    """The same circle, which the spin and the place of the contact do not change."""
    circles = []
    for choice in (dependent, (3, 4)):
        eom = kn.derive(disk(choice))
        near = {"u1": kn.guess(0.0), "u2": kn.guess(0.5), "u3": 5.0, "u4": kn.guess(-1.0), "u5": kn.guess(0.1)}
        point = kn.trim(eom, q=dict(zip(NAMES, (0.3, 0.1, 0.2, 0.0, 0.0), strict=True)), u=near)
        circles.append(list(point.u.values()))
    np.testing.assert_allclose(circles[0], circles[1], atol=1e-9)
    assert abs(circles[0][1]) > 0.1


def test_independent_speeds_that_change_are_told_which_would_not():
    eom = kn.derive(disk())
    state = upright(eom, 0.2)
    with pytest.raises(
        kn.SimulationError,
        match=r"With independent speeds u1, u2, u3 it is a steady motion: name these in independent=, or leave it out",
    ):
        kn.linearize(eom, q=state.q, u=state.u, independent=["u1", "u2", "u5"])
    linear = kn.linearize(eom, q=state.q, u=state.u, independent=["u1", "u2", "u3"])
    np.testing.assert_allclose(linear.rates[-3:], 0, atol=1e-9)
