# SPDX-License-Identifier: BSD-3-Clause
"""The first screen of reports: terms that balance, and motions that the page runs to the bits of Python's."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.cli import model_of
from kane.gallery.pendulums import system as chain
from kane.present import screen_of, terms
from kane.write import symbol_latex
from tests.present.browser import chromium, visit
from tests.present.test_animation import GL, until

BALANCED = (
    "double_pendulum",
    "four_bar",
    "rolling_disk",
    "whipple_bicycle",
    "slider_crank",
    "flexible_pendulum",
    "skidding_disk",
)


def simulated(name, end=1.0, **options):
    model = model_of(name)
    return kn.simulate(kn.derive(model.system), (0, end), **model.start, **options)


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in BALANCED[:3] else pytest.mark.slow) for n in BALANCED]
)
def test_terms_of_an_equation_balance(name):
    """Σ (F̃_r + F̃*_r) = 0 along the motion, beside the largest term."""
    sol = simulated(name, samples=21)
    rows: dict[str, list[kn.Expr]] = {}
    for q in terms(sol.equations):
        rows.setdefault(q.group, []).append(q.expr)
    assert len(rows) == len(sol.equations.independent_speeds)
    for own in rows.values():
        values = np.array([np.broadcast_to(v, sol.t.shape) for v in sol[own]])
        assert np.abs(values.sum(axis=0)).max() <= 1e-12 * np.abs(values).max()


def test_rows_that_do_most_work_are_unfolded():
    """Of a chain of 8 whose last rod alone moves at first, the five rows at its end."""
    sol = kn.simulate(kn.derive(chain(8)), (0.0, 0.05), q=[0.0] * 8, u=[0.0] * 7 + [3.0], samples=21)
    screen = screen_of(sol)
    assert len(screen.rows) == 5
    by_speed = {symbol_latex(u): u for u in sol.equations.independent_speeds}
    work = {}
    for row in (*screen.rows, *screen.folded):
        u = by_speed[row.label]
        work[row.label] = max(np.abs(sol[q.expr] * sol[u]).max() for _, q in row.terms)
    assert min(work[r.label] for r in screen.rows) >= max(work[r.label] for r in screen.folded)
    assert screen.rows[0].label != symbol_latex(sol.equations.speeds[0])


def test_what_a_page_does_not_run():
    assert "begin at t = 0" in screen_of(_later()).still


def _later():
    model = model_of("pendulum")
    return kn.simulate(kn.derive(model.system), (1.0, 2.0), **model.start)


@pytest.mark.parametrize(
    ("name", "widths"),
    [
        ("double_pendulum", [1280]),
        pytest.param("double_pendulum", [390], marks=pytest.mark.slow),
        pytest.param("four_bar", [1280, 390], marks=pytest.mark.slow),
        pytest.param("rolling_disk", [1280, 390], marks=pytest.mark.slow),
    ],
)
def test_the_page_runs_the_motion_to_the_same_bits(name, widths, tmp_path):
    """Sliders change parameters; what the page then runs is what `simulate` gives by the same stepper without contraction."""
    sol = simulated(name, 1.0)
    kn.report(sol.equations, tmp_path / "report.html", solution=sol)
    with chromium(*GL) as browser:
        for width in widths:
            page = browser.new_page(viewport={"width": width, "height": 900}, reduced_motion="reduce")
            said: list[str] = []
            page.on("console", lambda m, said=said: said.append(m.text))
            page.on("pageerror", lambda e, said=said: said.append(str(e)))
            page.on(
                "request", lambda r, said=said: said.append(r.url) if not r.url.startswith(("file:", "data:")) else None
            )
            visit(page, tmp_path / "report.html")
            until(page, "!!document.querySelector('.first').first")
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            page.locator('.slider input[data-name="g"]').press("ArrowRight")
            until(page, "!!document.querySelector('.first').first.motion")
            first = "document.querySelector('.first').first"
            g, end = page.evaluate(f"[{first}.parameters.g, {first}.viewer.sources[0].end]")
            assert (
                g
                != dict(sol.parameters)[
                    sol.equations.system.parameters[[p.name for p in sol.equations.parameters].index("g")]
                ]
            )
            shown = np.reshape(page.evaluate(f"Array.from({first}.motion.states)"), (-1, sol.states.shape[1] + 1))
            model = model_of(name)
            start = {**model.start, "parameters": {**model.start.get("parameters", {}), "g": g}}
            start |= {"q": dict(zip([q.name for q in sol.equations.coordinates], sol.q[0], strict=True))}
            start |= {"u": dict(zip([u.name for u in sol.equations.speeds], sol.u[0], strict=True))}
            settings = kn.Settings(contract=False)
            again = kn.simulate(
                sol.equations, (0, float(sol.t[-1])), samples=601, method="dop853", settings=settings, **start
            )
            assert len(shown) == len(again.t)
            np.testing.assert_array_equal(shown[:, :-1], again.states)
            assert end == again.t[-1]
            bars = page.evaluate("[...document.querySelectorAll('.term output')].map((o) => o.textContent)")
            assert len(bars) >= 2
            assert all(bars)
            assert said == []


def test_labels_of_axes_are_whole(tmp_path):
    """The kinetic energy of a car and a small deflection are numbers with exponents: their labels stand inside of the plots."""
    N, x, y = kn.Frame("N"), kn.coordinate("x", "m"), kn.coordinate("y", "m")
    P = kn.Point("O", fixed_in=N).at("P", x * N.x + y * N.y)
    m, k = kn.parameter("m", 1200.0, "kg"), kn.parameter("k", 12000.0, "N/m")
    system = kn.System(N, bodies=[kn.Particle("car", P, m)], speeds="rates", loads=[kn.Force(P, -k * x * N.x)])
    sol = kn.simulate(kn.derive(system), (0, 2), q={x: 2e-4, y: 0}, u={"u_x": 0, "u_y": 10}, samples=101)
    kn.report(sol.equations, tmp_path / "report.html", solution=sol)
    with chromium(*GL) as browser:
        page = browser.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
        visit(page, tmp_path / "report.html")
        until(page, "!!document.querySelector('.first').first")
        labels = page.evaluate(
            "[...document.querySelectorAll('.first svg text[text-anchor=end]')].map((x) => [x.textContent, x.getBBox().x])"
        )
    assert any("e" in text for text, _ in labels)
    assert [text for text, left in labels if left < 0] == []


@pytest.mark.slow
def test_the_page_goes_from_mode_to_mode(tmp_path):
    """A mass that sticks and slips: bits, what is read in each mode, and the strip of modes are those of the motion by Python."""
    sol = simulated("mass_on_belt", 4.0)
    kn.report(sol.equations, tmp_path / "report.html", solution=sol)
    settings = kn.Settings(contract=False)
    with chromium(*GL) as browser:
        page = browser.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
        said: list[str] = []
        page.on("console", lambda m: said.append(m.text))
        page.on("pageerror", lambda e: said.append(str(e)))
        visit(page, tmp_path / "report.html")
        until(page, "!!document.querySelector('.first').first")
        page.locator('.slider input[data-name="k"]').press("ArrowRight")
        first = "document.querySelector('.first').first"
        until(page, f"!!{first}.motion")
        k, code = page.evaluate(f"[{first}.parameters.k, {first}.motion.code]")
        start = {**model_of("mass_on_belt").start, "parameters": {"k": k}}
        given = {"samples": 601, "method": "dop853", "settings": settings, **start}
        for _ in range(2):  # the second time its kernels know the modes
            again = kn.simulate(sol.equations, (0, 4.0), **given)
        shown = np.reshape(page.evaluate(f"Array.from({first}.motion.states)"), (601, -1))
        times = np.array(page.evaluate(f"Array.from({first}.motion.times)"))
        at = [i for i, t in enumerate(again.t) if t in times and np.count_nonzero(again.t == t) == 1]
        assert code == "END"
        assert len(at) > 590
        np.testing.assert_array_equal(shown[np.searchsorted(times, again.t[at]), :-1], again.states[at])
        modes = page.evaluate(f"{first}.motion.modes.map(({{t, words}}) => [t, words[0]])")
        assert modes == [[t, words["belt"]] for t, words in again.mode_history]
        assert page.locator(".modes .strip").get_attribute("style").count("%") == 2 * len(modes)
        screen = screen_of(sol)
        exprs = [q.expr for row in screen.rows for _, q in row.terms]
        wanted = np.array([np.broadcast_to(v, again.t.shape) for v in again[exprs]])[:, at]
        rows = np.reshape(page.evaluate(f"Array.from({first}.viewer.sources[0].rows)"), (601, -1))
        numbers = [n for row in screen.rows for n, _ in row.terms]
        found = rows[:, page.evaluate(f"{first}.begin") + np.array(numbers)][np.searchsorted(times, again.t[at])]
        np.testing.assert_allclose(found.T, wanted, rtol=1e-12, atol=1e-12)
        assert said == []


def test_a_report_derives_the_mode_in_which_a_motion_begins(tmp_path):
    sol = simulated("skidding_disk", 0.2)
    text = kn.report(sol.equations, tmp_path / "report.md", solution=sol).read_text(encoding="utf-8")
    assert "Derived here is the mode in which the motion begins: ground slip." in text
    assert r"\mu_{k}" in text.split("Generalized active forces")[1].split("Generalized inertia forces")[0]


@pytest.mark.parametrize("name", ["mass_on_belt", "newtons_cradle"])
def test_a_mode_in_which_nothing_moves_or_nothing_acts_is_reported(name, tmp_path):
    """As of a mass that sticks to a belt, or free balls: the chapter on other methods leaves out what is zero throughout."""
    sol = simulated(name, 0.05)
    for ending in (".tex", ".md"):
        text = kn.report(sol.equations, tmp_path / f"report{ending}", solution=sol).read_text(encoding="utf-8")
        assert "Kane's method" in text
