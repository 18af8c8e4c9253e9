# SPDX-License-Identifier: BSD-3-Clause
"""Spatial chains and trees of general pins that constraints of every kind close: u̇ and λ, and how operations and work grow."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from benchmarks.random_trees import random_links, random_tree
from tests.examples import examples
from tests.oracles.compare import tolerance
from tests.oracles.loops import joints
from tests.oracles.loops.equations import solve
from tests.oracles.loops.jets import constant
from tests.oracles.loops.records import GROUND, Body, Mark, Pose, Twist, marks_at
from tests.oracles.tree import rotation
from tests.systems.closed_states import speeds
from tests.systems.held_chains import HOLDS, closed_at, held_chain, held_tree

POWER = 1.3
"""By which power of the number of links the work of a derivation may grow."""
LIMBS = (-1, 0, 1, 2, 3, 4, 2, 6, 7, 8, 2, 10, 11, 12, 13)
"""A trunk of three links, and on the last of them limbs of three, four and five."""


def calls(work):
    """How many Python functions are called: what no clock and no load of the machine changes."""
    count = 0

    def counted(_frame, event, _arg):
        nonlocal count
        count += event == "call"

    sys.setprofile(counted)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


def check_growth(hold, few, many):
    """Near where the loops close: how many steps close them from elsewhere is a matter of chance.

    The second derivation is counted, while the first one holds its nodes: which nodes the table keeps of what was derived before, and
    when it is swept, depends on the tests that ran.
    """
    work, operations = {}, {}
    for n in (few, many):
        system = held_chain(n, hold)
        near = closed_at(system, 1)
        eom = kn.derive(system, near=near)
        work[n] = calls(lambda system=system, near=near: kn.derive(system, near=near))
        operations[n] = eom.operations.total
    assert work[many] <= work[few] * (many / few) ** POWER
    assert operations[many] <= 1.1 * operations[few] * many / few


@pytest.mark.slow
def test_growth_of_a_chain_whose_tip_is_held_at_a_distance():
    check_growth("distance", 15, 30)


@pytest.mark.slow
@pytest.mark.parametrize("hold", HOLDS)
def test_growth(hold):
    check_growth(hold, 16, 32)


@pytest.mark.parametrize("n", [12, 30])
def test_a_distance_takes_little_more_than_the_open_chain(n):
    open_, held = (kn.derive(s).operations.total for s in (random_tree(range(-1, n - 1), 1), held_chain(n, "distance")))
    assert held <= 1.75 * open_


@pytest.mark.slow
def test_no_row_of_a_long_chain_is_taken_for_rounding():
    """Bounds on rounding of terms taken for independent ones double with each link; five rows must be left of a pin's."""
    for n in (50, 100):
        assert len(kn.derive(held_chain(n, "pin")).dependent_speeds) == 5


def difference(system, seed, routes=("recursive",)):
    """Of u̇ and λ from those of the classical route, beside the largest, at random angles; the condition number of A there."""
    usual, *others = (kn.derive(system, route=route) for route in ("classical", *routes))
    rng = np.random.default_rng(seed)
    q = rng.uniform(-3, 3, len(usual.coordinates))
    u, share = speeds(usual, q, rng, {kn.time: 0.3})
    wanted, *found = (
        np.array(e.evaluate([*e.accelerations, *e.multipliers.values()], q=q, u=u, t=0.3)) for e in (usual, *others)
    )
    return max(float(np.abs(x - wanted).max() / np.abs(wanted).max()) for x in found), 1 / share


LONG = ("distance", "driven distance", "coincident with a link", "ball", "weld")
"""Holds of which a chain of 14 links is derived by the classical route, which takes ten seconds."""


@pytest.mark.slow
@pytest.mark.parametrize("hold", HOLDS)
def test_as_the_classical_route(hold):
    """From 13 links on sums of vectors are added up from frame to frame."""
    for n in (7, 14) if hold in LONG else (7,):
        if n > 2 * len(held_chain(n, hold).constraints):
            worst, condition = difference(held_chain(n, hold), 1, ("recursive", "composite"))
            assert worst <= tolerance(1e-9, condition**2)


@pytest.mark.slow
def test_random_chains_as_the_classical_route():
    @examples(0.03, 2)
    @given(st.sampled_from(sorted(HOLDS)), st.integers(13, 16), st.integers(0, 2**16))
    def check(hold, n, seed):
        worst, condition = difference(held_chain(n, hold, seed), seed)
        assert worst <= tolerance(1e-9, condition**2)

    check()


def redundant(system, parents, pairs, seed):
    """q̈ and λ at the closed configuration by Newton's and Euler's equations of free bodies, and kane's, at random rates.

    `pairs` are (end, other, law): the origin of the pin of link `end` to a place at 0.3 and 0.4 along the link's axes, on `other`; or
    to the origin itself, where the law is that of a ball.
    """
    eom = kn.derive(system, route="recursive")
    q = closed_at(system, seed)
    u, _ = speeds(eom, q, np.random.default_rng(seed), {kn.time: 0.0})
    _, links = random_links(parents, seed)
    poses, twists, pins, axes, origins = [], [], [], [], []
    ground = Pose(np.zeros(3), np.eye(3)), np.zeros(3), np.zeros(3), np.zeros(3)
    bodies = [Body(link.body.mass, link.body.inertia) for link in links]
    frames = []
    for link, angle, rate in zip(links, q, u, strict=True):
        base, v, w, _ = ground if link.parent < 0 else frames[link.parent]
        seat, at = base.R @ link.seat, base.R @ link.at
        R, axis = seat @ rotation(link.axis, angle), seat @ link.axis
        spin, velocity = w + rate * axis, v + np.cross(w, at)
        frames.append((Pose(base.r + at, R), velocity, spin, axis))
        center = R @ link.body.center
        poses.append(Pose(base.r + at + center, R))
        twists.append(Twist(velocity + np.cross(spin, center), spin))
        axes.append(axis)
        origins.append(base.r + at)
    for k, link in enumerate(links):
        ends = (link.parent if link.parent >= 0 else GROUND, k)
        pins.append(joints.Joint(ends, marks_at(poses, ends, origins[k], axes[k]), joints.pin))
    for end, other, law in pairs:
        here = origins[end]
        there = here if law is joints.ball else here + poses[end].R @ [0.3, 0.4, 0.0]
        on = Mark(there, np.eye(3)) if other == GROUND else marks_at(poses, (other,), there, axes[end])[0]
        pins.append(joints.Joint((other, end), (on, marks_at(poses, (end,), here, axes[end])[0]), law))
    solution = solve(bodies, pins, poses, twists, gravity=np.array([0.0, 0.0, -9.81]))
    assert solution.inconsistency <= 1e-8 * np.abs(solution.alpha).max()
    relative = [solution.alpha[k] - (solution.alpha[x.parent] if x.parent >= 0 else 0) for k, x in enumerate(links)]
    wanted = np.array([a @ b for a, b in zip(axes, relative, strict=True)])
    found = np.array(eom.evaluate([*eom.accelerations, *eom.multipliers.values()], q=q, u=u, t=0.0))
    return found, wanted, np.abs(solution.multipliers[5 * len(links) :]), solution.condition


ROD = joints.distance(constant(0.5))


@pytest.mark.parametrize(
    ("parents", "holds", "pairs"),
    [
        (range(-1, 15), [(-1, "distance")], [(15, GROUND, ROD)]),
        (range(-1, 15), [(-1, "distance to a link")], [(15, 7, ROD)]),
        (
            LIMBS,
            [(5, "distance"), (9, "distance"), (14, "ball")],
            [(5, GROUND, ROD), (9, GROUND, ROD), (14, GROUND, joints.ball)],
        ),
    ],
    ids=["distance", "distance to a link", "limbs"],
)
def test_by_redundant_coordinates(parents, holds, pairs):
    found, wanted, multipliers, condition = redundant(held_tree(parents, holds), parents, pairs, 1)
    n = len(wanted)
    assert np.abs(found[:n] - wanted).max() <= tolerance(1e-9, condition) * np.abs(wanted).max()
    rods = [k for k, (_, _, law) in enumerate(pairs) if law is not joints.ball]
    assert np.abs(found[n:])[rods] == pytest.approx(multipliers[rods], rel=tolerance(1e-8, condition))
