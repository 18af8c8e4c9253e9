# SPDX-License-Identifier: BSD-3-Clause
"""Plots: which there are, what is drawn, and that drawing leaves nothing behind."""

from __future__ import annotations

import re
import subprocess
import sys

import matplotlib as mpl
import pytest

import kane as kn
from kane.gallery.pendulums import system as chain
from kane.present import plots
from tests.present.disk import moved


@pytest.mark.slow
def test_each_plot_is_there_once() -> None:
    assert [p.name for p in plots(moved())] == ["paths", "coordinates", "speeds", "reactions", "energy"]


def test_no_reactions_no_plot_and_the_plane_is_the_moving_one() -> None:
    sol = kn.simulate(kn.derive(chain(2)), (0.0, 0.2), q=[0.5, 0.2], u=[0.0, 0.0], samples=11)
    found = {p.name: p for p in plots(sol)}
    assert list(found) == ["paths", "coordinates", "speeds", "energy"]


@pytest.mark.parametrize("up", [0, 1, 2])
def test_what_falls_is_drawn_falling(up) -> None:
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    h = kn.coordinate("h", "m")
    axis = (N.x, N.y, N.z)[up]
    ball = kn.Particle("ball", O.at("P", h * axis), 1)
    eom = kn.derive(kn.System(N, bodies=[ball], speeds="rates", loads=[kn.gravity(-9.81 * axis)]))
    found = plots(kn.simulate(eom, (0, 1), q=[0], u=[0], samples=3))
    (drawn,) = (p.figure.axes[0] for p in found if p.name == "paths")
    assert drawn.get_ylabel().count(f"_{'xyz'[up]}$") == 1
    (shown,) = (p for p in found if p.name == "speeds")
    assert shown.figure.axes[0].get_ylabel().endswith("[m/s]")


def test_a_system_at_rest_has_no_paths() -> None:
    sol = kn.simulate(kn.derive(chain(1)), (0.0, 0.2), q=[0.0], u=[0.0], samples=5)
    assert "paths" not in [p.name for p in plots(sol)]


@pytest.mark.slow
def test_many_coordinates_share_panels() -> None:
    sol = kn.simulate(kn.derive(chain(8)), (0.0, 0.05), q=[0.1] * 8, u=[0.0] * 8, samples=5)
    shown = next(p for p in plots(sol) if p.name == "coordinates")
    assert shown.svg.count("<clipPath") < len(sol.equations.coordinates)
    assert shown.svg.count("var(--series-6)") >= 1


@pytest.mark.slow
def test_settings_and_identifiers_are_left_alone() -> None:
    before = dict(mpl.rcParams)
    first, second = (plots(moved()) for _ in range(2))
    assert dict(mpl.rcParams) == before
    assert [p.svg for p in first] == [p.svg for p in second]
    names = [i for p in first for i in re.findall(r'\bid="([^"]+)"', p.svg)]
    assert len(names) == len(set(names))


@pytest.mark.slow
def test_drawing_is_loaded_only_when_needed() -> None:
    code = "import sys, kane, kane.present.report; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-W", "error", "-c", code], check=False).returncode == 0


def test_what_rounding_leaves_does_not_fill_a_panel():
    import matplotlib.pyplot as plt

    from kane.present import level
    from tests.present.disk import moved

    solution = moved()
    figure, axes = plt.subplots()
    axes.plot(solution.t, 1e-32 * solution.t)
    level(axes, [1e-32 * solution.t], solution)
    assert axes.get_ylim() == (-solution.atol, solution.atol)
    before = (axes.set_ylim(-1, 1), axes.get_ylim())[1]
    level(axes, [1e-32 * solution.t, solution.t], solution)
    assert axes.get_ylim() == before
    plt.close(figure)
