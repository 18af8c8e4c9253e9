# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of beams: mode shapes, deformed axes, Campbell diagrams show the numbers that they are made of."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import kane as kn
from tests.oracles import rotating_beam
from tests.systems.beams import spinning


def labels(axes: Any) -> list[str]:
    """What the legend says."""
    return [t.get_text() for t in axes.get_legend().get_texts()]


def test_mode_shapes(tmp_path) -> None:
    beam, _ = spinning(modes=3, EA=100.0, stretch=2)
    figure = kn.mode_figure(beam, tmp_path / "modes.svg")
    stretch, bend = figure.axes
    assert (stretch.get_ylabel(), bend.get_ylabel()) == ("stretch", "v")
    assert labels(bend) == ["v1_beam", "v2_beam", "v3_beam"]
    lines = [line for line in bend.lines if str(line.get_label()).startswith("v")]
    for line in lines:
        assert np.abs(line.get_ydata()).max() == pytest.approx(1)
    assert (tmp_path / "modes.svg").read_text().lstrip().startswith("<?xml")
    with pytest.raises(kn.ModelError, match=r"Expected a kn\.Beam, got 3"):
        kn.mode_figure(3)
    kn.mode_figure(beam, tmp_path / "modes.svg")  # its own is replaced
    (tmp_path / "other.svg").write_text("<svg/>")
    with pytest.raises(kn.ArgumentError, match=r"other\.svg"):
        kn.mode_figure(beam, tmp_path / "other.svg")
    assert (tmp_path / "other.svg").read_text() == "<svg/>"
    with pytest.raises(kn.ArgumentError, match=r"ends in \.png, \.svg, \.pdf"):
        kn.mode_figure(beam, tmp_path / "modes.eps")


def test_deformed_axis() -> None:
    beam, system = spinning(modes=2)
    eom = kn.derive(system)
    sol = kn.simulate(eom, (0, 1), q=[0.05, 0.0], u=[0.0, 0.0], samples=11, parameters={"Omega": 1.0})
    (axes,) = kn.beam_figure(beam, sol, [0.0, 0.5]).axes
    assert labels(axes) == ["t = 0 s", "t = 0.5 s"]
    for line, row in zip(axes.lines, (0, 5), strict=True):
        tip = sol[beam.point_at(1).position(beam.root).dot(beam.frame.y)][row]
        assert np.asarray(line.get_ydata())[-1] == pytest.approx(tip)
    many = kn.beam_figure(beam, sol, 11)
    axes, bar = many.axes  # a scale of colours: eleven names would hide the curves
    assert axes.get_legend() is None
    assert (bar.get_ylabel(), bar.get_ylim()) == ("t [s]", (0.0, 1.0))
    colours = {tuple(line.get_color()) for line in axes.lines}
    assert len(colours) == 11
    _, other = spinning(modes=1)
    alone = kn.simulate(kn.derive(other), (0, 0.1), q=[0.0], u=[0.0], samples=3)
    with pytest.raises(kn.SimulationError, match="a motion of a system with the beam beam"):
        kn.beam_figure(beam, alone)


def test_campbell_diagram() -> None:
    """The curves of a flap are those of an independent collocation."""
    _, system = spinning(flap=True, modes=kn.mode_shapes("polynomials", 6))
    zero = {"q": dict.fromkeys(system.coordinates, kn.guess(0.0)), "u": dict.fromkeys(system.speeds, 0.0)}
    branch = kn.continuation(kn.derive(system), "Omega", [0.0, 3.0, 6.0], **zero)
    np.testing.assert_allclose(branch.frequencies[-1, :2], rotating_beam.flapwise(6.0)[:2], rtol=1e-5)
    steep: Any = kn.campbell_diagram(branch, orders=(1, 20), count=2).axes[0]
    top = steep.get_ylim()[1]
    assert [t.xy for t in steep.texts] == [(6.0, 6.0), (top / 20, top)]  # where each ends, or leaves the picture
    assert all(t.get_annotation_clip() is False for t in steep.texts)
    (axes,) = kn.campbell_diagram(branch, orders=(1, 2), count=2).axes
    curves = np.array([line.get_ydata() for line in axes.lines[:2]]).T
    np.testing.assert_array_equal(curves, branch.frequencies[:, :2])
    assert [t.get_text() for t in axes.texts] == ["1 Ω", "2 Ω"]
    assert axes.get_ylabel() == "ω [rad/s]"
    with pytest.raises(kn.SimulationError, match=r"a branch from kn\.continuation or cycle\.follow, got int"):
        kn.campbell_diagram(3)


def test_times_of_a_beam_figure() -> None:
    """Times between samples are drawn, none is moved to another one; what is no time of the motion is refused."""
    beam, system = spinning(modes=2)
    start: Any = {"q": [0.05, 0.0], "u": [0.0, 0.0], "parameters": {"Omega": 1.0}}
    sol = kn.simulate(kn.derive(system), (0, 1), samples=3, **start)
    (axes,) = kn.beam_figure(beam, sol, [0.7, 0.2]).axes
    assert labels(axes) == ["t = 0.7 s", "t = 0.2 s"]
    tip = sol.at([0.2, 0.7])[beam.point_at(1).position(beam.root).dot(beam.frame.y)]
    np.testing.assert_allclose([np.asarray(line.get_ydata())[-1] for line in axes.lines], tip[::-1], rtol=1e-12)
    assert labels(kn.beam_figure(beam, sol, np.int64(2)).axes[0]) == ["t = 0 s", "t = 1 s"]  # type: ignore[arg-type]
    own, read = pickle.loads(pickle.dumps((beam, sol)))
    late = float(np.nextafter(1.0, 2.0))  # as 3 * 0.1 is later than 0.3
    assert labels(kn.beam_figure(beam, sol, [-1e-17, late]).axes[0]) == ["t = 0 s", "t = 1 s"]
    assert labels(kn.beam_figure(own, read, [0.6]).axes[0]) == ["t = 0.5 s"]  # it cannot be run again
    wrong: tuple[Any, ...] = (0, -1, True, 0.1, [], [-0.1], [2.0], [np.nan], "a", [[0.1]])
    for times in wrong:
        with pytest.raises(
            kn.SimulationError, match="Expected times= as times of the motion, from 0 to 1, or how many"
        ):
            kn.beam_figure(beam, sol, times)
    with pytest.raises(kn.SimulationError, match=r"Expected a motion from kn\.simulate, got 3"):
        kn.beam_figure(beam, 3)  # type: ignore[arg-type]


def test_campbell_diagram_of_a_spin_the_other_way() -> None:
    """Frequencies and lines k |Ω| know no sign."""
    _, system = spinning(flap=True, modes=2)
    zero = {"q": dict.fromkeys(system.coordinates, kn.guess(0.0)), "u": dict.fromkeys(system.speeds, 0.0)}
    branch = kn.continuation(kn.derive(system), "Omega", [0.0, -3.0, -6.0], **zero)
    axes: Any = kn.campbell_diagram(branch, orders=(1, 20), count=2).axes[0]
    np.testing.assert_array_equal([line.get_ydata() for line in axes.lines[2:]], np.outer((1, 20), (0, 3, 6)))
    top = axes.get_ylim()[1]
    assert [t.xy for t in axes.texts] == [(-6.0, 6.0), (-top / 20, top)]
