# SPDX-License-Identifier: BSD-3-Clause
"""`plot` of several motions, of y against x, of passages: what is drawn is the motion, what is nothing is not; energies; cycles."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

import kane as kn
from kane.gallery.contacts import bouncing_ball, mass_on_belt
from kane.gallery.walking import simplest_walker
from kane.present import COLOURS, asset, bend, size_of_terms, spread

A, B, OMEGA = 0.3, 0.2, 4.0
"""x = A cos Ωt, y = B sin Ωt of a mass on a spring, in a plane; z stays."""


@pytest.fixture(scope="module")
def eom():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, z = (kn.coordinate(name, "m") for name in "xyz")
    m, k = kn.parameter("m", 2.0, "kg"), kn.parameter("k", 2 * OMEGA**2, "N/m")
    P = O.at("P", x * N.x + y * N.y + z * N.z)
    bodies, loads = [kn.Particle("bob", P, m)], [kn.linear_spring(P, O, k)]
    return kn.derive(kn.System(N, bodies=bodies, speeds="rates", loads=loads, coordinates=(x, y, z)))


def moved(eom, size=1.0, samples=6):
    return kn.simulate(
        eom, (0, 2), q=[A * size, 0, 0], u=[0, B * OMEGA * size, 0], samples=samples, rtol=1e-11, atol=1e-12
    )


@pytest.fixture(scope="module")
def sol(eom):
    return moved(eom)


def drawn(ax):
    """Lines by their names: neither marks of ends nor what is noted only."""
    return {line.get_label(): line for line in ax.lines if len(line.get_xdata()) and line.get_label()[0] != "_"}


def notes(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


# Lines -----------------------------------------------------------------------------------------------------------------------


def test_few_samples_have_no_corners(sol):
    """Six samples of more than a turn: the line is the motion, here known in closed form."""
    (line,) = drawn(kn.plot(sol, "x").axes[0]).values()
    t, x = line.get_data()
    assert np.isin(sol.t, t).all()
    np.testing.assert_allclose(x, A * np.cos(OMEGA * t), atol=1e-8)
    np.testing.assert_allclose(x, sol.at(t)["x"], atol=1e-11)
    turns = np.abs(np.diff(x, 2)) / np.ptp(x)
    assert turns.max() < 0.006


def test_enough_samples_are_drawn_as_they_are(eom):
    fine = moved(eom, samples=401)
    (line,) = drawn(kn.plot(fine, "x").axes[0]).values()
    assert np.array_equal(line.get_data(), [fine.t, fine["x"]])


def test_what_bends_says_how_many_samples_are_wanted():
    """Of y = t² at any times: the middle of three lies (t₁ − t₀)(t₂ − t₁) beside the line; a straight line needs none."""
    t = np.array([0, 0.1, 0.4, 0.5, 0.5, 1.0])
    phase = np.array([0, 0, 0, 0, 1, 1])
    assert bend(t, phase, t**2) == pytest.approx(0.03)
    assert bend(t, phase, 3 * t + 1) < 1e-15
    assert bend(t, phase, np.where(t == 0.1, np.nan, t**2)) == 0
    assert bend(t, phase, np.full(6, np.nan)) == 0


def test_where_nothing_is_known_between_samples_are_dots(sol):
    (line,) = drawn(kn.plot(pickle.loads(pickle.dumps(sol)), "x").axes[0]).values()
    assert np.array_equal(line.get_xdata(), sol.t)
    assert line.get_marker() == "."


def test_y_against_x(sol):
    """An ellipse, its start ○ and its end ●; lengths to one scale."""
    figure = kn.plot(sol, ("x", "y"), ({"angle of phase": "x"}, "u_x"), "x")
    time, path, phase = figure.axes
    assert time.get_xlabel() == "t [s]"
    assert (path.get_xlabel(), path.get_ylabel(), path.get_aspect()) == ("$x$ [m]", "$y$ [m]", 1.0)
    assert (phase.get_xlabel(), phase.get_ylabel()) == ("angle of phase [m]", "$u_{x}$ [m/s]")
    (line,) = drawn(path).values()
    x, y = line.get_data()
    np.testing.assert_allclose((x / A) ** 2 + (y / B) ** 2, 1, atol=1e-8)
    assert np.hypot(*np.diff([x, y])).max() < 0.1 * A
    start, end = (line for line in path.lines if line.get_label() in ("_start", "_end"))
    assert np.array_equal(start.get_xydata()[0], [sol["x"][0], sol["y"][0]])
    assert np.array_equal(end.get_xydata()[0], [sol["x"][-1], sol["y"][-1]])


def test_several_paths_share_axes_by_a_mapping(sol):
    (ax,) = kn.plot(sol, {"place": ("x", "y"), "turned": ("y", "x")}).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("[m]", "[m]")
    place, turned = drawn(ax).values()
    assert np.array_equal(place.get_xdata(), turned.get_ydata())
    assert notes(ax) == ["place", "turned"]


def test_a_path_has_a_gap_where_the_motion_jumps():
    eom = kn.derive(bouncing_ball.system())
    sol = kn.simulate(eom, (0, 1.5), **bouncing_ball.START, samples=40)
    (q, *_), (u, *_) = eom.coordinates, eom.speeds
    (ax,) = kn.plot(sol, (q, u)).axes
    line = next(line for line in ax.lines if line.get_label() not in ("_start", "_end"))
    assert np.isnan(line.get_xdata()).sum() == len(np.flatnonzero(np.diff(sol.phase))) > 0


def test_what_contacts_do_stands_as_a_strip_below_the_plots():
    """It begins and ends where modes do: sticks to μ_s m g/(k v), then slips by the closed form."""
    sol = kn.simulate(kn.derive(mass_on_belt.system()), (0, 3), **mass_on_belt.START, samples=7)
    figure = kn.plot(sol, "x")
    above, strip = figure.axes
    spans = [
        (box.x0, box.x1, tuple(c.get_facecolor()[0]))
        for c in strip.collections
        for box in [c.get_datalim(strip.transData)]
    ]
    slip = 0.4 * 9.81 / 25 / 0.2
    stick = slip + (np.pi + 2 * np.arctan(0.2 / (5 * 0.2 * 9.81 / 25))) / 5
    expected = [0, slip, stick, stick + 2 * 0.2 * 9.81 / 25 / 0.2, 3]
    np.testing.assert_allclose([a for a, _, _ in spans], expected[:-1], rtol=0, atol=1e-7)
    np.testing.assert_allclose([b for _, b, _ in spans], expected[1:], rtol=0, atol=1e-7)
    assert len({c for *_, c in spans}) == 2
    assert spans[0][2] == spans[2][2]
    assert [t.get_text() for t in strip.get_legend().get_texts()] == ["stick", "slip"]
    assert [t.get_text() for t in strip.texts] == ["belt"]
    assert above.get_shared_x_axes().joined(above, strip)


# Several motions -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("labels", [("small", "large"), None])
def test_motions_are_compared(eom, labels):
    motions = [moved(eom, size, samples=401) for size in (1, 2)]
    ax, both = kn.plot(motions if labels is None else dict(zip(labels, motions, strict=True)), "x", ("x", "y")).axes
    lines = drawn(ax)
    assert list(lines) == list(labels or ("1", "2")) == ([text.get_text() for text in ax.texts] or notes(ax))
    assert ax.get_ylabel() == "$x$ [m]"
    assert [line.get_color() for line in lines.values()] == list(COLOURS[:2])
    assert all(np.array_equal(line.get_ydata(), m["x"]) for line, m in zip(lines.values(), motions, strict=True))
    assert notes(both) == list(labels or ("1", "2"))


def test_two_quantities_of_two_motions(eom):
    motions = {name: moved(eom, size, samples=401) for name, size in (("a", 1), ("b", 2))}
    lines = drawn(kn.plot(motions, "x", "y").axes[0])
    assert {name: (line.get_color(), line.get_linestyle()) for name, line in lines.items()} == {
        "$x$ · a": (COLOURS[0], "-"),
        "$y$ · a": (COLOURS[0], "--"),
        "$x$ · b": (COLOURS[1], "-"),
        "$y$ · b": (COLOURS[1], "--"),
    }


def test_passages_are_dots_beside_the_motion(eom, sol):
    x, y, _ = eom.coordinates
    points = kn.poincare(eom, section=kn.Event("up", y, direction=1), count=4, q=[A, 0.05, 0], u=[0, 1, 0])
    (ax,) = kn.plot({"motion": sol, "passages": points}, (x, eom.speeds[0])).axes
    line, dots = drawn(ax).values()
    assert (dots.get_linestyle(), dots.get_marker()) == ("None", ".")
    assert np.array_equal(dots.get_xdata(), points[x])
    assert line.get_linestyle() == "-"
    alone = drawn(kn.plot(points).axes[0])["$x$"]
    assert np.array_equal(alone.get_data(), [points.t, points[x]])


# What is not drawn, and apart ------------------------------------------------------------------------------------------------


def test_zero_and_noise_are_named_not_drawn(eom, sol):
    x, y, z = eom.coordinates
    noise = (x * x / A**2 + y * y / B**2) - (x / A) ** 2 - (y / B) ** 2
    figure = kn.plot(sol, x, z, {"still": noise})
    first = figure.axes[0]
    assert list(drawn(first)) == ["$x$"]
    assert notes(first) == ["$z$ = 0"]
    assert 0 < np.abs(sol[noise]).max() < 1e-14
    assert notes(figure.axes[1]) == ["still = 0 but for rounding"]
    assert not drawn(figure.axes[1])
    assert np.all(drawn(kn.plot(sol, (x, {"still": noise})).axes[0])["still"].get_ydata() == 0)


def test_small_is_not_noise(eom, sol):
    x, *_ = eom.coordinates
    (line,) = drawn(kn.plot(sol, {"small": 1e-15 * x}).axes[0]).values()
    np.testing.assert_allclose(line.get_ydata(), 1e-15 * A * np.cos(OMEGA * line.get_xdata()), atol=1e-22)


@given(st.floats(-10, 10), st.floats(-10, 10), st.floats(-10, 10))
def test_the_size_of_terms(a, b, c):
    p, q, r = (kn.parameter(name) for name in "pqr")
    size = size_of_terms((p - q) * (p + r) - p * q + kn.sin(r))
    expected = (abs(a) + abs(b)) * (abs(a) + abs(c)) + abs(a * b) + abs(np.sin(c))
    assert kn.evaluate(size, {p: a, q: b, r: c}) == pytest.approx(expected, abs=1e-300)


@pytest.mark.parametrize(("ratio", "axes"), [(900, 1), (1100, 2)])
def test_quantities_of_unlike_size_are_apart(eom, sol, ratio, axes):
    x, *_ = eom.coordinates
    figure = kn.plot(sol, {"large": ratio * x, "small": x})
    assert [list(drawn(a)) for a in figure.axes] == ([["large", "small"]] if axes == 1 else [["large"], ["small"]])


# Names, colours, errors ------------------------------------------------------------------------------------------------------


def test_names_stand_at_the_ends_of_lines(eom):
    fine = moved(eom, samples=401)
    (ax,) = kn.plot(fine, "x", "y").axes
    assert ax.get_legend() is None
    low, high = ax.get_ylim()
    for text in ax.texts:
        end = (fine[text.get_text().strip("$")][-1] - low) / (high - low)
        assert abs(text.xy[1] - end) < 0.2


def test_names_that_have_no_room_stand_above(eom):
    fine = moved(eom, samples=401)
    (ax,) = kn.plot(fine, *({f"line {k}": fine.equations.coordinates[0]} for k in range(6))).axes
    assert not ax.texts
    assert notes(ax) == [f"line {k}" for k in range(6)]


@given(st.lists(st.floats(0, 1), min_size=1, max_size=6))
def test_spread_places_keep_their_order_and_a_gap(wanted):
    wanted = np.array(wanted)
    places = spread(wanted, 0.1)
    assert np.all(np.diff(np.sort(places)) >= 0.1 - 1e-12)
    order = np.argsort(wanted, kind="stable")
    assert np.all(np.diff(places[order]) > 0)
    if np.all(np.diff(np.sort(wanted)) >= 0.1 + 1e-9):
        np.testing.assert_allclose(places, wanted, atol=1e-12)
    assert places.mean() == pytest.approx(wanted.mean())


def test_colours_are_those_of_the_report():
    css = asset("report.css", "templates")
    light = css[: css.index("prefers-color-scheme")]
    assert tuple(re.findall(r"--series-\d: (#[0-9a-f]{6})", light)) == COLOURS


def test_what_cannot_be_drawn(eom, sol):
    with pytest.raises(kn.ArgumentError, match=r"\(x, y\), two quantities to draw y against x"):
        kn.plot(sol, ("x", "y", "z"))
    with pytest.raises(kn.ArgumentError, match="a quantity with one value"):
        kn.plot(sol, ("x", eom.system.inertial.x))
    with pytest.raises(kn.ArgumentError, match="for 'b'"):
        kn.plot({"a": sol, "b": 3}, "x")
    with pytest.raises(kn.ArgumentError, match="at least one motion"):
        kn.plot([], "x")
    with pytest.raises(kn.ArgumentError, match=r"for one pair of axes, got both"):
        kn.plot(sol, "x", ("x", "y"), ax=Figure().subplots())


# Ready figures ---------------------------------------------------------------------------------------------------------------


def test_energy_balance(eom, sol, tmp_path):
    figure = kn.figures.energy_balance(sol, tmp_path / "energy.svg")
    energies, power, _ = figure.axes
    assert [a.get_ylabel() for a in figure.axes] == ["energy [J]", "power [W]", "E − E(0) − ∫P dt [J]"]
    lines = drawn(energies)
    t = lines["K"].get_xdata()
    speed = np.array([-A * OMEGA * np.sin(OMEGA * t), B * OMEGA * np.cos(OMEGA * t)])
    np.testing.assert_allclose(lines["K"].get_ydata(), (speed**2).sum(axis=0), atol=1e-7)
    assert notes(power) == ["P = 0", "dE/dt = 0"]
    assert (tmp_path / "energy.svg").read_text().lstrip().startswith("<?xml")
    with pytest.raises(kn.ArgumentError, match=r"a motion from kn\.simulate"):
        kn.figures.energy_balance(eom)


@pytest.mark.slow
def test_cycles_along_a_branch(tmp_path):
    eom = kn.derive(simplest_walker.system())
    gait = kn.limit_cycle(eom, section="strike", q=[0.2], u=[-0.2], states=[0.4, -0.016])
    branch = gait.follow("gamma", [0.012, 0.016])
    theta, period = kn.figures.cycle_figure(branch, "theta", path=tmp_path / "cycles.svg").axes
    (change,) = branch.changes
    assert (theta.get_ylabel(), period.get_ylabel(), period.get_xlabel()) == (
        "$\\theta$ [rad]",
        "T [s]",
        "$\\gamma$ [rad]",
    )
    stable, unstable = (line for line in period.lines if line.get_label() in ("stable", "unstable"))
    assert (stable.get_linestyle(), unstable.get_linestyle()) == ("-", "--")
    assert np.array_equal(stable.get_xdata(), [*branch.values[:2], change.value])
    assert np.array_equal(unstable.get_xdata(), [change.value, branch.values[2]])
    assert np.array_equal(stable.get_ydata()[:2], branch.periods[:2])
    greatest = max((line for line in theta.lines if line.get_label() == "stable"), key=lambda line: line.get_ydata()[0])
    assert greatest.get_ydata()[0] == pytest.approx(np.max(branch.cycles[0].solution["theta"]), abs=1e-6)
    assert notes(theta) == ["stable", "unstable", "flip"]


def test_something_else_than_a_branch():
    with pytest.raises(kn.SimulationError, match=r"a branch from cycle\.follow, got 3"):
        kn.figures.cycle_figure(3)
