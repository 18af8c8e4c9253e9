# SPDX-License-Identifier: BSD-3-Clause
"""The root locus shows every eigenvalue of the branch, where it grows, and where the branch turns."""

import numpy as np
import pytest

import kane as kn
from kane.present import through_meetings
from tests.systems.steady import driven_pendulum


@pytest.fixture(scope="module")
def branch():
    return kn.continuation(driven_pendulum(), "tau", [0, 5, 9, 12], q={"q1": kn.guess(0)}, u={"u1": 0})


@pytest.mark.slow
def test_what_is_drawn(branch, tmp_path):
    figure = kn.root_locus(branch, tmp_path / "locus.svg")
    above, below, plane = figure.axes[:3]
    assert (below.get_xlabel(), plane.get_xlabel(), plane.get_ylabel()) == ("$\\tau$ [N·m]", "Re λ [1/s]", "Im λ [1/s]")
    values, _, kept = through_meetings(branch.values, branch.eigenvalues)
    curves = [line.get_ydata() for line in below.lines if len(line.get_ydata()) == len(values)]
    np.testing.assert_array_equal(np.array(curves).T[kept], branch.eigenvalues.imag)
    assert [t.get_text() for t in above.get_legend().get_texts()] == ["turning point", "unstable"]
    grows = np.array([line.get_ydata() for line in above.lines if line.get_linewidth() == 2.2]).T
    np.testing.assert_array_equal(np.nansum(grows[kept] > 0, axis=1), (branch.eigenvalues.real > 1e-6).sum(axis=1))
    assert (tmp_path / "locus.svg").read_text().lstrip().startswith("<?xml")


def test_something_else_than_a_branch():
    with pytest.raises(kn.SimulationError, match=r"a branch from kn\.continuation or cycle\.follow, got list"):
        kn.root_locus([1, 2])


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("swapped", [False, True])
def test_lines_meet_on_the_real_axis(back, swapped):
    """λ² + 2 λ + c = 0: λ = -1 ± √(1 - c), drawn exactly between two points only, as D = 1 - c is linear in c."""
    c = np.array([4.0, 0.0] if back else [0.0, 4.0])
    half = np.sqrt(1 - c + 0j)
    half[1] *= -1 if swapped else 1
    values, drawn, kept = through_meetings(c, np.column_stack([-1 + half, -1 - half, [-3.0, -4.0]]))
    assert (values[kept] == c).all()
    assert kept == [0, len(values) - 1]
    np.testing.assert_allclose(drawn[:, :2] ** 2 + 2 * drawn[:, :2], -values[:, None] * [1, 1], atol=1e-13)
    np.testing.assert_allclose(drawn[:, 0] + drawn[:, 1], -2, atol=1e-13)
    np.testing.assert_allclose(drawn[:, 2], np.interp(values, sorted(c), [-3, -4][:: -1 if back else 1]), atol=1e-13)
    assert np.abs(drawn[:, 0] - drawn[:, 1]).min() < 1e-12  # they meet
    assert (
        np.minimum(np.abs(drawn.real[:, :2] + 1), np.abs(drawn.imag[:, :2])) < 1e-12
    ).all()  # none lies beside the axes


def test_where_none_meet_nothing_is_added():
    values, eigenvalues = np.arange(3.0), np.array([[1j, -1j, 2], [2j, -2j, 3], [2j, -2j, -3]])
    drawn_at, drawn, kept = through_meetings(values, eigenvalues)
    np.testing.assert_array_equal(drawn_at, values)
    np.testing.assert_array_equal(drawn, eigenvalues)
    assert kept == [0, 1, 2]
