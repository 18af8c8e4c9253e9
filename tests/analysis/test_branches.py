# SPDX-License-Identifier: BSD-3-Clause
"""Branches of a closure: the nearest to the guesses, all that there are, and none that its closures do not mean."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kane as kn
from tests.dynamics.constraints.test_branches import EIGHT, TURNS, closed, meant
from tests.model.joints.test_closures import CLOSED, O
from tests.systems.four_bar import BAR, EOM

q1, q2, q3 = BAR.q
QUICK = "slider"
KINDS = [k if k in QUICK else pytest.param(k, marks=pytest.mark.slow) for k in CLOSED]
TURNED = "on the intended branch of the closures, got 'G' with its (axis|frame|thread) turned by (120|180)°"


def orientation(found, body):
    e = np.array([found.q[q] for q in body.coordinates[:4]])
    return Rotation.from_quat(np.roll(e, -1)).as_matrix()


@pytest.mark.parametrize("kind", KINDS)
def test_a_start_on_another_branch_is_refused_and_the_cure_works(kind):
    body, system = closed(kind)
    eom = kn.derive(system)
    for turn in EIGHT if kind in ("slider", "weld") else TURNS[::3]:
        q = dict(zip(body.coordinates, [*np.roll(Rotation.from_matrix(turn).as_quat(), 1), 0, 0, 0], strict=True))
        rows = np.array(eom.evaluate([c.expr for c in system.constraints], q=q), dtype=float)
        guesses = {s: kn.guess(v) for s, v in q.items()}
        if np.abs(rows).max() < 1e-12 and meant(kind, turn):
            found = kn.assemble(eom, q=q)
            assert found.q == pytest.approx(q)
        elif np.abs(rows).max() < 1e-12:
            with pytest.raises(kn.SimulationError, match=f"{TURNED}.* The intended branch contains .*kn.guess"):
                kn.assemble(eom, q=q)
            with pytest.raises(kn.SimulationError, match=TURNED):
                kn.simulate(eom, (0, 1), q=q, u=[0] * len(eom.speeds))
        found = kn.assemble(eom, q=guesses)
        assert found.residual < 1e-12
        place = [found.q[s] for s in body.coordinates[4:]]
        if kind in ("slider", "weld", "pin", "planar"):
            assert meant(kind, orientation(found, body)), (turn, place)


@pytest.mark.parametrize("kind", ["slider", pytest.param("weld", marks=pytest.mark.slow)])
def test_inverse_dynamics_asks_for_the_branch_too(kind):
    body, system = closed(kind)
    eom = kn.derive(system)
    run = kn.inverse(eom, [u.dt for u in eom.speeds])
    states = [dict(zip(body.coordinates, [*quaternion(turn), 0.0, 0.0, 0.0], strict=True)) for turn in EIGHT]
    rest, closing = dict.fromkeys(eom.independent_speeds, 0.0), [c.expr for c in system.constraints]
    right, *wrong = [q for q in states if np.abs(np.array(eom.evaluate(closing, q=q), dtype=float)).max() < 1e-12]
    assert wrong
    assert np.isfinite(list(run(q=right, u=rest).values())).all()
    for q in wrong:
        with pytest.raises(kn.SimulationError, match=f"{TURNED}. kn.assemble finds"):
            run(q=q, u=rest)
        with pytest.raises(kn.SimulationError, match=f"{TURNED} at index 1"):
            run(q={s: [v, q[s]] for s, v in right.items()}, u=rest)


def quaternion(turn):
    return np.roll(Rotation.from_matrix(turn).as_quat(), 1)


def ends(q):
    """The complex numbers at the ends of the links of the four-bar."""
    return np.cumsum([length * np.exp(1j * q[k]) for length, k in zip((0.4, 1.0, 0.8), BAR.q, strict=True)])


def test_both_branches_of_a_four_bar():
    """The joint between coupler and rocker lies where two circles meet: mirrored about the line through their centres."""
    up, down = kn.assemble(EOM, q={q1: 0.5, q2: kn.guess(0.8), q3: kn.guess(-1.5)}, all_branches=True)
    assert up.q == pytest.approx(kn.assemble(EOM, q={q1: 0.5, q2: kn.guess(0.8), q3: kn.guess(-1.5)}).q)
    (crank, joint, tip), (_, other, same) = ends(up.q), ends(down.q)
    assert tip == pytest.approx(1.1)
    assert same == pytest.approx(1.1)
    along = (tip - crank) / abs(tip - crank)
    assert other - crank == pytest.approx(along**2 * np.conj(joint - crank))
    assert up.branch.startswith("the nearest of 2 branches; next: q2 = ")
    assert "branch 2 of 2; nearest: q2 = " in down.branch
    assert "2 branches" in repr(up)


@pytest.mark.parametrize("turns", [-2, 1, 3])
def test_angles_are_those_nearest_to_the_guess_and_count_once(turns):
    near = {q1: 0.5, q2: kn.guess(0.8 + turns * 2 * np.pi), q3: kn.guess(-1.5)}
    found, _ = kn.assemble(EOM, q=near, all_branches=True)
    assert abs(found.q[q2] - near[q2].value) < np.pi
    assert ends(found.q)[2] == pytest.approx(1.1)


def test_all_branches_want_values_that_leave_nothing_free():
    with pytest.raises(kn.ValueMissingError, match=r"got 1 too few: q1, q2, q3 can still vary\. Give 1 of them\.$"):
        kn.assemble(EOM, q={q: kn.guess(0.4) for q in BAR.q}, all_branches=True)


def test_parts_that_reach_only_another_orientation_are_told_so():
    body, system = closed("weld")
    eom = kn.derive(system)
    *turn, x, y, z = body.coordinates
    half = {turn[0]: 0.0, turn[1]: 1.0, x: 0.0, y: 0.0, z: 0.0}
    with pytest.raises(
        kn.SimulationError, match=r"got only others from \d+ starts, the nearest 'G' with its frame turned"
    ):
        kn.assemble(eom, q=half)


@pytest.mark.slow
def test_operating_points_are_on_the_branch_that_is_meant():
    """A body on a slider that a spring holds: trimmed, linearized and analysed where it is meant to be."""
    body, system = closed("slider")
    spring = kn.Force(body.point, -3.0 * body.point.position(O), name="spring")
    eom = kn.derive(system.replace(loads=[spring]))
    third = dict(zip(body.coordinates, [*np.roll(Rotation.from_matrix(EIGHT[5]).as_quat(), 1), 0, 0, 0], strict=True))
    with pytest.raises(kn.SimulationError, match=TURNED):
        kn.linearize(eom, q=third, u=[0] * len(eom.speeds))
    with pytest.raises(kn.SimulationError, match=TURNED):
        kn.equilibrium(eom, q={q: kn.guess(v) for q, v in third.items()})
    found = kn.equilibrium(eom, q={q: kn.guess(v) for q, v in kn.assemble(eom, q=nearly(body)).q.items()})
    assert [found.q[q] for q in body.coordinates] == pytest.approx([1, 0, 0, 0, 0, 0, 0], abs=1e-9)


def nearly(body):
    """Guesses not far from where the closure means the body to be."""
    return {q: kn.guess(v) for q, v in zip(body.coordinates, (0.9, 0.2, -0.1, 0.3, 0.1, 0.2, -0.1), strict=True)}
