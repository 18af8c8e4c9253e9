# SPDX-License-Identifier: BSD-3-Clause
"""The root locus shows every eigenvalue of the branch, where it grows, and where the branch turns."""

import numpy as np
import pytest

import kane as kn
from tests.simulate.test_continuation import driven_pendulum


@pytest.fixture(scope="module")
def branch():
    return kn.continuation(driven_pendulum(), "tau", [0, 5, 9, 12], q={"q1": kn.guess(0)}, u={"u1": 0})


def test_what_is_drawn(branch, tmp_path):
    figure = kn.root_locus(branch, tmp_path / "locus.svg")
    above, below, plane = figure.axes[:3]
    assert (below.get_xlabel(), plane.get_xlabel(), plane.get_ylabel()) == ("$\\tau$ [N·m]", "Re λ [1/s]", "Im λ [1/s]")
    curves = [line.get_ydata() for line in below.lines if len(line.get_ydata()) == len(branch)]
    np.testing.assert_array_equal(np.array(curves).T, branch.eigenvalues.imag)
    assert [t.get_text() for t in above.get_legend().get_texts()] == ["turning point", "unstable"]
    grows = np.array([line.get_ydata() for line in above.lines if line.get_linewidth() == 2.2]).T
    np.testing.assert_array_equal(np.nansum(grows > 0, axis=1), (branch.eigenvalues.real > 1e-6).sum(axis=1))
    assert (tmp_path / "locus.svg").read_text().lstrip().startswith("<?xml")


def test_something_else_than_a_branch():
    with pytest.raises(kn.SimulationError, match=r"a branch from kn\.continuation, got list"):
        kn.root_locus([1, 2])
