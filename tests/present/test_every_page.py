# SPDX-License-Identifier: BSD-3-Clause
"""The reports of the whole gallery in a browser: silent, within the screen, legible, named, reached by keyboard, still on request,
by the rules of axe-core."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

import kane as kn
from kane.cli import model_of
from kane.gallery import GALLERY
from kane.model import deforming
from kane.present import DECLARED
from tests.peer import require
from tests.present.browser import chromium, visit
from tests.present.test_animation import GL, until
from tests.present.test_browser import CONTRAST, OPEN_ALL

QUICK = ("pendulum",)
OFTEN = (
    "rolling_disk", "four_bar", "whipple_bicycle", "flexible_arm", "skidding_disk", "andrews_squeezer", "snakeboard", "compass_gait",
    "free_body", "stacked_blocks", "muscle_arm",
)  # fmt: skip
"""One of each kind; the others take their time, and are asked for with all pages."""
FACES = ((1280, "light"), (390, "dark"))
NAMELESS = """[...document.querySelectorAll("button, input, select, canvas, [role=button], [role=img]")]
    .filter(e => e.checkVisibility() && !(e.getAttribute("aria-label") || e.textContent.trim() || (e.labels && e.labels.length)))
    .map(e => e.outerHTML.slice(0, 80))"""
"""Controls and pictures without a name."""
UNREACHED = """[...document.querySelectorAll(".formula, .scroll")]
    .filter(e => e.checkVisibility() && e.scrollWidth > e.clientWidth && e.tabIndex < 0 && !e.querySelector("[tabindex]"))
    .map(e => e.textContent.slice(0, 60))"""
"""Boxes that scroll sideways, where no key brings one."""
HEADERS = """[...document.querySelectorAll("th")].filter(e => e.querySelector(".math"))
    .filter(e => !e.querySelector(".math").getAttribute("aria-label")).length"""


@pytest.fixture(scope="module")
def browser() -> Any:
    with chromium(*GL) as found:
        yield found


# the snakeboard starts where its dependent speeds are singular: its terms there are NaN, of which it warns
def _marks(name: str) -> Any:
    return () if name in QUICK else pytest.mark.slow if name in OFTEN else pytest.mark.page


@pytest.mark.parametrize("name", [pytest.param(n, marks=_marks(n)) for n in GALLERY])
def test_a_report_of_the_gallery(name: str, browser: Any, tmp_path: Path) -> None:
    model = model_of(name)
    if not model.start:
        pytest.skip("has no motion")
    eom = kn.derive(model.system)
    sol = kn.simulate(eom, (0.0, 0.2), samples=21, **model.start)
    path = kn.report(eom, tmp_path / "report.html", solution=sol, shapes=model.shapes)
    assert path.stat().st_size < 1.5e6
    for width, scheme in FACES:
        look(browser, path, width, scheme, rules=name not in QUICK and scheme == "light")


def broken_rules(page: Any) -> list[str]:
    """What axe-core finds, contrasts apart, once formulas are their sources: over KaTeX's elements of long ones it takes minutes."""
    rules = files(require("axe_playwright_python")).joinpath("axe.min.js").read_text(encoding="utf-8")
    page.evaluate(
        # boxes can be reached as their buttons can
        "for (const box of document.querySelectorAll('.scroll:has([data-of]), .formula:has([data-of])')) box.tabIndex = 0;"
        "document.querySelectorAll('.katex').forEach((k) => k.replaceWith(k.querySelector('annotation').textContent))"
    )
    page.evaluate("new Promise(done => requestAnimationFrame(() => setTimeout(done)))")  # what scrolls now is seen to
    page.evaluate(rules)
    found: list[str] = page.evaluate(
        """async () => (await axe.run(document, { preload: false, resultTypes: ["violations"],
            rules: { "color-contrast": { enabled: false } } })).violations.map((v) => `${v.id}: ${v.nodes[0].html.slice(0, 80)}`)"""
    )
    return found


def look(browser: Any, path: Path, width: int, scheme: str, rules: bool) -> None:
    context = browser.new_context(
        viewport={"width": width, "height": 900}, reduced_motion="reduce", color_scheme=scheme, offline=True
    )
    page, said = context.new_page(), []
    page.on("console", lambda m: said.append(m.text))
    page.on("pageerror", lambda e: said.append(str(e)))
    page.on("request", lambda r: said.append(r.url) if not r.url.startswith(("file:", "data:", "blob:")) else None)
    visit(page, path)
    page.evaluate(OPEN_ALL)
    page.evaluate("new Promise(done => requestAnimationFrame(() => setTimeout(done)))")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(CONTRAST)["poor"] == []
    assert page.evaluate(NAMELESS) == []
    assert page.evaluate(UNREACHED) == []
    assert page.evaluate(HEADERS) == 0
    if page.locator(".first .kane-view").count():
        until(page, "!!document.querySelector('.first .kane-view').viewer")
        assert page.evaluate("document.querySelector('.first .kane-view').viewer.playing") is False
        slider = page.locator(".kane-view input[type=range]")
        slider.press("ArrowRight")
        assert float(slider.input_value()) > 0
    assert not rules or broken_rules(page) == []
    assert said == []
    context.close()


def test_a_plot_that_the_first_screen_has_is_not_drawn_again(tmp_path: Path) -> None:
    model = model_of("double_pendulum")
    sol = kn.simulate(kn.derive(model.system), (0.0, 0.2), samples=21, **model.start)
    text = kn.report(sol.equations, tmp_path / "report.html", solution=sol).read_text(encoding="utf-8")
    assert "<h3>Generalized coordinates</h3>" not in text
    assert "<h3>Energy and power</h3>" in text


@pytest.mark.parametrize("name", ["flexible_pendulum", "flap_lag_blade", "flexible_arm"])
def test_a_beam_is_one_body(name: str) -> None:
    """Its mass is the sum of what its parts have."""
    system = model_of(name).system
    rows = list(DECLARED["bodies"](system))
    assert len(rows) <= len(system.bodies)
    for beam in deforming(system.bodies):
        (row,) = [r for r in rows if r["body"] == beam.name]
        assert row["kind"] == "flexible body"
        point = {s: 0.7 + 0.1 * k for k, s in enumerate(sorted(kn.free_symbols([beam.mass]), key=lambda s: s.name))}
        mass, *parts = kn.evaluate([beam.mass, *(p.mass for p in beam.parts())], point)
        assert mass == pytest.approx(sum(parts), rel=1e-9)
        assert row["central inertia"] == beam.coordinates
