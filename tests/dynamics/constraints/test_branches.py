# SPDX-License-Identifier: BSD-3-Clause
"""Which orientations a closure means: those its joint reaches, and none of the others at which its equations vanish."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kane as kn
from kane.dynamics import branches, configurations, manifold
from tests.model.joints.kinds import AXIS, KINDS, rigid
from tests.model.joints.test_closures import CLOSED, N, O

ALONG = np.array(AXIS)
ACROSS = np.cross(ALONG, [1.0, 0, 0]) / np.linalg.norm(np.cross(ALONG, [1.0, 0, 0]))
OBLIQUE = np.column_stack([ACROSS, np.cross(ALONG, ACROSS), ALONG])
HALVES = [np.diag(d) for d in ((1.0, 1, 1), (1.0, -1, -1), (-1, 1.0, -1), (-1, -1, 1.0))]
CYCLE = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
EIGHT = [*HALVES, *(h @ CYCLE for h in HALVES)]
"""Where y·z′ = z·x′ = x·y′ = 0: at no turn, at half turns about an axis, and at four third turns."""
TURNS = [*EIGHT, *(OBLIQUE @ turn @ OBLIQUE.T for turn in EIGHT)]


def meant(kind, turn):
    """Whether the tree joint reaches this orientation where the points coincide."""
    if kind in ("ball", "universal"):
        return True
    if kind in ("slider", "weld"):
        return np.allclose(turn, np.eye(3))
    axis = {"planar": np.array([0.0, 1, 0]), "cylindrical": np.array([0.0, 0, 1])}.get(kind, ALONG)
    return np.allclose(turn @ axis, axis) and (kind != "screw" or np.allclose(turn, np.eye(3)))


def closed(kind):
    """A free body closed to the ground."""
    body = kn.free("J", O, N, child="B")
    solid = rigid("b", body.frame, body.point, 1, kn.inertia(body.frame, 1, 2, 2.5))
    return body, kn.System(
        N, bodies=[solid], joints=[body], holonomic=KINDS[kind].close("G", O, N, body.point, body.frame)
    )


@pytest.mark.parametrize("kind", CLOSED)
def test_orientations_at_which_the_equations_vanish_are_told_apart(kind):
    body, system = closed(kind)
    values = {s: s.default for s in system.parameters}
    angles = manifold(system).at(values).turned
    seen = set()
    for turn in TURNS:
        q = [*np.roll(Rotation.from_matrix(turn).as_quat(), 1), 0, 0, 0]
        at = dict(zip(body.coordinates, q, strict=True)) | values
        rows = [float(kn.evaluate(c.expr, at)) for c in system.constraints]
        if np.abs(rows).max() < 1e-12:
            seen.add(meant(kind, turn))
            assert (angles(np.array(q)).max(initial=0) == 0) == meant(kind, turn), turn
    assert seen == ({True} if kind in ("ball", "universal") else {True, False})


def test_by_how_much_it_is_turned():
    _, system = closed("weld")
    (branch,) = branches(system)
    assert (branch.name, branch.what) == ("G", "frame")
    starts = [[*np.roll(Rotation.from_matrix(turn).as_quat(), 1), 0, 0, 0] for turn in EIGHT]
    half, third = np.pi, 2 * np.pi / 3
    expected = [0, *3 * [half], *4 * [third]]
    np.testing.assert_allclose(manifold(system).at({}).turned(np.array(starts))[:, 0], expected, atol=1e-12)


def test_some_rows_of_a_closure_alone_say_nothing_of_its_orientation():
    """One tilt of a pin is a universal joint: its axis may come round to the other side."""
    _, system = closed("pin")
    some = system.replace(holonomic=[c for c in system.constraints if not c.name.endswith("tilt2")])
    for angle, away in ((0.0, 0), (2.5, 0), (np.pi, np.pi)):
        turn = np.roll(Rotation.from_rotvec(angle * OBLIQUE[:, 0]).as_quat(), 1)
        a, b = (manifold(x).at({}).turned(np.array([*turn, 0, 0, 0])) for x in (system, some))
        assert (*a, *b) == pytest.approx((away, away))


@pytest.mark.parametrize("kind", ["slider", "weld", "pin", "screw", "planar"])
def test_the_configuration_that_choices_are_made_at_is_on_the_branch_that_is_meant(kind):
    _, system = closed(kind)
    for seed in range(6):
        found = configurations(system, [c.expr for c in system.constraints], seed=seed)
        assert not found.missed
        values = {s: v for s, v in found.values.items() if s not in set(system.coordinates)}
        q = np.array([found.values[x] for x in system.coordinates]).T
        assert not manifold(system).at(values).turned(q).any()
