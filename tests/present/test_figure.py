# SPDX-License-Identifier: BSD-3-Clause
"""`plot`: what is drawn are the motion's values, called by their names and units."""

from __future__ import annotations

import re

import numpy as np
import pytest
from matplotlib.figure import Figure

import kane as kn
from kane.gallery import rolling_disk


@pytest.fixture(scope="module")
def disk():
    return rolling_disk.model()


@pytest.fixture(scope="module")
def sol(disk):
    return kn.simulate(
        kn.derive(disk.system), (0, 0.5), q=[0, 0.1, 0, 0, 0], u=[0, 2, 25, 2, 0], parameters={disk.mu: 0.1}, samples=31
    )


def lines(ax, t=None):
    """What is drawn, by its names; at the times `t`, which must be among those of the line."""
    found = {line.get_label(): line.get_xydata() for line in ax.lines if len(line.get_xdata())}
    if t is None:
        return {name: xy[:, 1] for name, xy in found.items()}
    assert all(np.isin(t, xy[:, 0]).all() for xy in found.values())
    return {name: xy[np.searchsorted(xy[:, 0], t), 1] for name, xy in found.items()}


def names(ax):
    """The names written beside the ends of lines."""
    return [text.get_text() for text in ax.texts]


def notes(ax):
    """What the legend says."""
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_everything(sol):
    figure = kn.plot(sol)
    assert [a.get_ylabel() for a in figure.axes] == [
        "coordinates [rad]",
        "coordinates [m]",
        "speeds [rad/s]",
        "speeds [m/s]",
        "$N_{z}$ [N]",
        "energy [J]",
    ]
    assert figure.axes[-1].get_xlabel() == "t [s]"
    assert list(lines(figure.axes[1])) == ["$q_{4}$", "$q_{5}$"]
    eom = sol.equations
    drawn = {re.sub(r"[${}_]", "", name): y for a in figure.axes[:4] for name, y in lines(a, sol.t).items()}
    for symbol, values in zip((*eom.coordinates, *eom.speeds), sol.states.T, strict=True):
        assert np.array_equal(drawn[symbol.name], values)
    energies = lines(figure.axes[-1], sol.t)
    assert list(energies) == ["K", "V", "E = K + V", "E − ∫P dt"]
    assert np.array_equal(energies["E = K + V"], sol.energy)
    assert np.ptp(energies["E − ∫P dt"]) < 1e-7


def test_quantities_of_one_unit_share_a_panel(disk, sol):
    figure = kn.plot(sol, "q1", disk.normal, disk.q[1], {"slip": disk.slip}, 2 * disk.normal)
    assert [a.get_ylabel() for a in figure.axes] == ["[rad]", "[N]", "[m/s]"]
    angles, forces, slip = (lines(a, sol.t) for a in figure.axes)
    assert list(angles) == ["$q_{1}$", "$q_{2}$"]
    assert list(forces) == ["$N_{z}$", "2*N_z"]
    assert np.array_equal(forces["2*N_z"], 2 * sol[disk.normal])
    assert list(slip) == ["slip · N.x", "slip · N.y"]
    assert np.array_equal(np.array(list(slip.values())).T, sol[disk.slip][:, :2])
    assert names(figure.axes[2]) == list(slip)
    assert notes(figure.axes[2]) == ["slip · N.z = 0"]
    listed = kn.plot(sol, ["q1", disk.normal], [disk.q[1], {"slip": disk.slip}, 2 * disk.normal])
    assert [list(lines(a, sol.t)) for a in listed.axes] == [list(lines(a, sol.t)) for a in figure.axes]


def test_a_quantity_of_no_sensible_unit_is_drawn_without_one(disk, sol):
    odd = disk.q[0] + disk.u[3]
    figure = kn.plot(sol, odd, {"phase": disk.q[0] * disk.q[3]})
    assert [a.get_ylabel() for a in figure.axes] == ["q1 + u4", "phase [m]"]
    assert np.array_equal(lines(figure.axes[0], sol.t)["q1 + u4"], sol[odd])


def test_a_long_expression_stands_above_its_panel(sol):
    (a,) = kn.plot(sol, sol.equations.energy).axes
    assert a.get_ylabel() == "[J]"
    (label,) = (text.get_text() for text in a.get_legend().get_texts())
    assert len(label) == 48
    assert label.endswith("…")


def test_on_axes_of_one_s_own(sol):
    own = Figure()
    ax = own.subplots()
    assert kn.plot(sol, "q4", "u4", ax=ax) is own
    assert ax.get_ylabel() == "[m, m/s]"
    assert np.array_equal(lines(ax, sol.t)["$u_{4}$"], sol["u4"])


@pytest.mark.slow
@pytest.mark.parametrize(("ending", "magic"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_files_are_of_their_kind_and_the_same_each_time(sol, tmp_path, ending, magic):
    files = [tmp_path / folder / f"motion.{ending}" for folder in "ab"]
    for file in files:
        kn.plot(sol, "q4", "q5", path=file)
    assert files[0].read_bytes().startswith(magic)
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_notebook_shows_it(sol):
    assert kn.plot(sol, "q4")._repr_png_().startswith(b"\x89PNG")


def test_what_cannot_be_drawn(sol, tmp_path):
    with pytest.raises(kn.ArgumentError, match=r"ends in \.png, \.svg, \.pdf, got '.*motion\.doc'"):
        kn.plot(sol, path=tmp_path / "motion.doc")
    with pytest.raises(kn.ValueMissingError, match=r"Expected one of q1, .*, got 'q9'"):
        kn.plot(sol, "q9")


def test_what_draws_nothing_is_refused(sol):
    with pytest.raises(kn.ArgumentError, match="Expected quantities to plot"):
        kn.plot(sol, {})
    with pytest.raises(kn.ArgumentError, match=r"Expected quantities to plot"):
        kn.plot(sol, {}, ax=Figure().subplots())
    with pytest.raises(kn.ArgumentError, match="Expected ax= as axes of matplotlib, got 3"):
        kn.plot(sol, ax=3)
