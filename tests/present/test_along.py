# SPDX-License-Identifier: BSD-3-Clause
"""Checks of a motion: they pass for a right one and fail for one whose states, equations or speeds are not right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kane as kn
from kane import Check
from kane.gallery import free_body, skidding_disk
from kane.present import motion_checks
from tests.present.disk import moved
from tests.systems import quick_return
from tests.systems.four_bar import N
from tests.systems.parallelogram import Parallelogram

ENERGY, POWER, RESIDUAL, MASS, KINEMATICAL = range(5)


def test_a_right_motion_passes() -> None:
    found = motion_checks(moved())
    assert len(found) == 5
    assert all(c.passed for c in found), [str(c) for c in found]
    assert all(c.figure < 1e-12 for c in (found[POWER], found[RESIDUAL]))


def test_figures_of_the_matrices_are_theirs() -> None:
    solution = moved()
    eom = solution.equations
    state = {"q": solution.q.T, "u": solution.u.T, "parameters": solution.parameters}
    mass = np.array([[np.broadcast_to(x, len(solution)) for x in row] for row in _values(eom, eom.mass_matrix, state)])
    mass = np.moveaxis(mass, -1, 0)
    scale = np.sqrt(np.einsum("nii->ni", mass))
    expected = np.linalg.cond(mass / scale[:, :, None] / scale[:, None, :]).max()
    assert motion_checks(solution)[MASS].figure == pytest.approx(expected, rel=1e-9)


def _values(eom, matrix, state):
    return [eom.evaluate(list(row), **state) for row in matrix.rows]


def test_a_motion_at_rest_passes() -> None:
    eom = kn.derive(free_body.system())
    sol = kn.simulate(eom, (0, 1), q=[1, 0, 0, 0, 0, 0, 0], u=[0.0] * 6, samples=5)
    assert all(c.passed for c in motion_checks(sol))


def test_a_motion_with_contacts_is_checked_in_its_modes() -> None:
    sol = kn.simulate(kn.derive(skidding_disk.system()), (0, 3), **skidding_disk.START)
    assert len(sol.mode_history) > 1
    assert all(c.passed for c in motion_checks(sol)), [str(c) for c in motion_checks(sol)]
    np.testing.assert_allclose(sol.power, sol[sol.equations.time_derivative(sol.equations.energy)], atol=1e-9)
    found = {eom: replace(eom, solved=replace(eom.solved, accelerations=_off(eom))) for eom in set(sol.samples)}
    wrong = motion_checks(replace(sol, samples=tuple(found[eom] for eom in sol.samples)))
    assert not wrong[RESIDUAL].passed


def _off(eom):
    return tuple(a + 0.001 for a in eom.accelerations)


def test_energy_that_is_not_kept_fails() -> None:
    solution = moved()
    lossy = replace(solution, work=solution.work + np.linspace(0, 0.1, len(solution)))
    assert [c.passed for c in motion_checks(lossy)] == [False, True, True, True, True]


def test_a_wrong_solution_of_the_equations_fails() -> None:
    solution = moved()
    eom = solution.equations
    wrong = replace(eom, solved=replace(eom.solved, accelerations=tuple(1.001 * a for a in eom.accelerations)))
    found = motion_checks(replace(solution, equations=wrong))
    assert not found[RESIDUAL].passed
    assert not found[POWER].passed
    assert found[RESIDUAL].figure > 1e-5


def test_a_mass_matrix_that_is_not_definite_fails() -> None:
    solution = moved()
    eom = solution.equations
    rows = [list(row) for row in eom.mass_matrix.rows]
    rows[0][0] = -rows[0][0]
    wrong = replace(eom)
    vars(wrong)["mass_matrix"] = kn.Matrix(rows)
    (found,) = [c for c in motion_checks(replace(solution, equations=wrong)) if "definite" in c.name]
    assert not found.passed
    assert "eigenvalues -" in found.detail


def test_a_check_of_the_energy_that_is_there_already_is_not_repeated() -> None:
    solution = moved()
    known = Check("energy", 0.0, 1.0, str(solution.energy_check))
    assert len(motion_checks(solution, [known])) == 4


def test_what_the_constraints_exert_measures_a_row_without_mass() -> None:
    """F_r and F*_r of a block without mass are zero: what is left there is small beside the constraints' forces."""
    solution = kn.simulate(quick_return.QUICK, (0, 2), samples=41, **quick_return.START)
    found = motion_checks(solution)
    assert all(c.passed for c in found), [str(c) for c in found]
    assert found[RESIDUAL].figure < 1e-12


@pytest.mark.slow
def test_the_reactions_equations_are_those_of_each_sample() -> None:
    """They hold the dependent speeds eliminated: with those of the start their matrix is as bad as its pivot is small."""
    block, crank, _ = quick_return.QUICK.speeds
    first = kn.derive(quick_return.QUICK.system.replace(dependent_speeds=[crank, block]))
    solution = kn.simulate(first, (0, 2), samples=41, **quick_return.START)
    assert len({s.dependent_speeds for s in solution.samples}) > 1
    expected = []
    for k, eom in enumerate(solution.samples):
        matrix = eom.evaluate(eom.solved.reaction_matrix, q=solution.q[k], u=solution.u[k])
        expected.append(np.linalg.cond(np.asarray(matrix, dtype=float)))
    (check,) = [c for c in motion_checks(solution) if c.name.startswith("condition number of the reactions")]
    assert check.figure == pytest.approx(max(expected), rel=1e-6)


def test_samples_where_rank_is_lost_are_left_out() -> None:
    """A parallelogram laid flat: its reactions have no value there, and everything else passes."""
    flat = Parallelogram()
    close = flat.closed()
    eom = flat.derive(close, loads=[kn.gravity(-9.81 * N.y)], reactions=[kn.reaction("T", constraint=close[0])])
    start = dict(zip(flat.q, (0.0, 0.0, np.pi), strict=True))
    solution = kn.simulate(eom, (0, 0.2), q=start, u=[1, 0, 1], samples=5)
    assert solution.lost.tolist() == [True, False, False, False, False]
    assert all(c.passed for c in motion_checks(solution)), [str(c) for c in motion_checks(solution)]
