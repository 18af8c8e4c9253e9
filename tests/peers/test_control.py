# SPDX-License-Identifier: BSD-3-Clause
"""A linearized system as python-control's StateSpace."""

import pytest

import kane as kn
from kane.gallery import pendulums
from tests.peer import require
from tests.systems import steady as systems


@pytest.fixture
def control():
    """Imported when a test begins: with what it plots with it takes a second."""
    return require("control")


def test_state_space(control):
    eom = systems.cart()
    linear = kn.linearize(eom, q=[0, 0], u=[0, 0], outputs={"angle": eom.coordinates[1]})
    made = linear.state_space()
    assert isinstance(made, control.StateSpace)
    assert made.state_labels == ["q1", "q2", "u1", "u2"]
    assert (made.input_labels, made.output_labels) == (["F"], ["angle"])
    s = 1.3j
    M, m, l, g = 2.0, 0.5, 0.7, 9.81
    assert made(s) == pytest.approx(-1 / (M * l) / (s**2 + (M + m) * g / (M * l)), rel=1e-12)


@pytest.mark.usefixtures("control")
def test_vectors_among_outputs():
    """The signals of control have no `.` in their names."""
    system = pendulums.system(2)
    tip = system.bodies[-1].parts()[0].mass_center
    linear = kn.linearize(kn.derive(system), q=0, u=0, outputs={"tip": tip.velocity(system.inertial)})
    assert linear.state_space().output_labels == ["tip_x", "tip_y", "tip_z"]
