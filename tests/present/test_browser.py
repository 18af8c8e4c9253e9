# SPDX-License-Identifier: BSD-3-Clause
"""Reports in a browser: nothing to complain of, every formula typeset, nothing wider than its page, legible, operable, printable."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import kane as kn
from kane.cli import model_of
from tests.present.browser import begun, chromium, visit
from tests.present.page import Page

pytestmark = pytest.mark.slow

CONTRAST = (Path(__file__).parent / "contrast.js").read_text(encoding="utf-8")
WIDTHS = (1280, 390)
PAPER = 688
"""A4 less margins of 14 mm, in pixels of CSS."""
OPEN_ALL = "document.querySelectorAll('details').forEach(d => d.open = true); typesetWaiting()"
WIDER = """[...document.querySelectorAll('.formula, .scroll')].filter(e => e.checkVisibility() && e.scrollWidth > e.clientWidth + 1)
    .map(e => e.textContent.slice(0, 60))"""
VISIBLE_Z = "[data-of]:visible"


@dataclass(frozen=True, eq=False)
class Opened:
    """A report in the browser: its source, its page, and what the browser complained of."""

    text: str
    view: Any
    complaints: list[str]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("reports")


OPENED = (
    "slider_crank", "pendulum", "spinning_top", "whipple_bicycle", "four_bar", "bricard", "pure_rolling_disk", "snakeboard",
    "rotating_beam", "flexible_arm", "muscle_arm",
)  # fmt: skip
"""Short and long ones, with constraints, reactions, beams, further states; the rolling disk's is looked at besides."""


@pytest.fixture(scope="module", params=OPENED)
def opened(request: pytest.FixtureRequest, browser: Any, reports: Path) -> Iterator[Opened]:
    yield from opening(request.param, browser, reports)


@pytest.fixture(scope="module")
def disk(browser: Any, reports: Path) -> Iterator[Opened]:
    yield from opening("rolling_disk", browser, reports)


@cache
def report(name: str, folder: Path) -> Path:
    """The report of a system of the gallery, with a motion; written once."""
    found = model_of(name)
    eom = kn.derive(found.system)
    sol = kn.simulate(eom, (0.0, 0.2), samples=21, **found.start) if found.start else None
    return kn.report(eom, folder / f"{name}.html", solution=sol, title=found.title, sources=found.sources)


def _of_driver(text: str) -> bool:
    """Whether the browser's GL driver says that a canvas was read back, as pictures and prints do."""
    return "GL Driver Message" in text


def opening(name: str, browser: Any, folder: Path) -> Iterator[Opened]:
    path = report(name, folder)
    complaints: list[str] = []
    context = browser.new_context(viewport={"width": WIDTHS[0], "height": 900}, offline=True)
    view = context.new_page()
    view.on("console", lambda said: complaints.extend([f"{said.type}: {said.text}"] * (not _of_driver(said.text))))
    view.on("pageerror", lambda error: complaints.append(str(error)))
    view.on("requestfailed", lambda request: complaints.append(f"not loaded: {request.url:.80}"))
    view.on(
        "request", lambda request: complaints.extend([request.url] * (not request.url.startswith(("file:", "data:"))))
    )
    visit(view, path)
    yield Opened(path.read_text(encoding="utf-8"), view, complaints)
    context.close()


def test_every_formula_is_typeset(opened: Opened) -> None:
    written = sum(map(len, Page(opened.text).math.values()))
    assert written > 20
    opened.view.evaluate("typesetWaiting()")
    assert opened.view.locator(".math").count() == written
    assert opened.view.locator(".math > .katex, .math > .katex-display").count() == written
    assert opened.view.locator(".katex-error").count() == 0
    assert opened.complaints == []


def test_symbols_point_at_each_other(disk: Opened) -> None:
    """What is pointed at, or has the focus, is marked in the sketch and at sliders; a letter of another symbol is not."""
    view, marked = (
        disk.view,
        "[...document.querySelectorAll('.same')].map((e) => [e.tagName, e.textContent.replace(/[\\u200b\\s]/g, '')])",
    )
    view.hover('text[data-s~="q2"]:visible')
    found = view.evaluate(marked)
    assert {text for _, text in found} == {"q2"}
    assert {tag for tag, _ in found} == {"text", "SPAN"}
    view.locator("label.slider input").first.focus()
    assert sorted({(tag, text) for tag, text in view.evaluate(marked)}) == [("SPAN", "R"), ("text", "R")]
    view.hover("h1")
    assert view.evaluate(marked) == []


@pytest.mark.parametrize(("width", "scheme"), [(WIDTHS[0], "light"), (WIDTHS[1], "dark")])
def test_fits_and_is_legible(opened: Opened, width: int, scheme: str) -> None:
    view = opened.view
    view.set_viewport_size({"width": width, "height": 900})
    view.emulate_media(color_scheme=scheme)
    view.evaluate(OPEN_ALL)
    assert view.evaluate("document.documentElement.scrollWidth") <= width
    found = view.evaluate(CONTRAST)
    assert found["poor"] == []
    assert found["looked"] >= 5
    dark = view.evaluate("getComputedStyle(document.body).backgroundColor.match(/\\d+/g).every(x => x < 60)")
    assert dark == (scheme == "dark")
    assert opened.complaints == []


def test_prints_whole_and_light(opened: Opened) -> None:
    view = opened.view
    view.set_viewport_size({"width": PAPER, "height": 970})
    view.evaluate("document.querySelectorAll('details').forEach(d => d.open = false)")
    view.emulate_media(media="print", color_scheme="dark")
    try:
        view.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert view.locator("details:not([open])").count() == view.evaluate(
            "[...document.querySelectorAll('details')].filter(d => d.dataset.lines > 80).length"
        )
        assert view.evaluate("document.documentElement.scrollWidth") <= PAPER
        assert view.evaluate(WIDER) == []
        assert view.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        assert view.evaluate(CONTRAST)["poor"] == []
        assert view.locator("button:visible").count() == 0
        view.evaluate("dispatchEvent(new Event('afterprint'))")
        assert view.locator("details[open]").count() == 0
        assert view.locator("[style*=zoom]").count() == 0
    finally:
        view.emulate_media(media="screen")


def test_nothing_hidden_can_be_focused(opened: Opened) -> None:
    assert opened.view.locator("[aria-hidden=true] [tabindex], [aria-hidden=true][tabindex]").count() == 0
    assert opened.view.locator("[role=button]:not([aria-label])").count() == 0


class TestIntermediates:
    @pytest.fixture
    def view(self, disk: Opened) -> Any:
        disk.view.set_viewport_size({"width": WIDTHS[0], "height": 900})
        disk.view.reload()
        begun(disk.view)
        return disk.view

    def test_a_click_shows_the_definition_and_another_hides_it(self, view: Any) -> None:
        z = view.locator(f"#step-5 .formula {VISIBLE_Z}[role=button]").last.element_handle()
        n = z.get_attribute("data-of")
        assert z.get_attribute("aria-expanded") == "false"
        z.click()
        shown = view.locator(f"#{z.get_attribute('aria-controls')}")
        assert z.get_attribute("aria-expanded") == "true"
        meant = view.evaluate('n => sources.get(document.querySelector(`#step-5 [data-z="Z_{${n}}"] > .math`))', n)
        assert meant.startswith(f"Z_{{{n}}} = ")
        assert shown.locator("annotation").text_content().replace("\\displaystyle ", "").startswith(f"Z_{{{n}}} =")
        z.click()
        assert z.get_attribute("aria-expanded") == "false"
        assert view.locator(".meaning").count() == 0

    @pytest.mark.parametrize("key", ["Enter", pytest.param(" ", marks=pytest.mark.slow)])
    def test_by_keyboard(self, view: Any, key: str) -> None:
        view.locator(f"#step-5 .formula {VISIBLE_Z}[role=button]").last.focus()
        view.keyboard.press(key)
        assert view.locator(".meaning .katex").count() == 1
        view.keyboard.press(key)
        assert view.locator(".meaning").count() == 0

    def test_definitions_within_definitions(self, view: Any) -> None:
        z = '#step-5 .formula [data-of="3"]:visible[role=button]'  # Z₃ = √(Z₁² + Z₂²)
        view.locator(z).last.click()
        view.locator(f".meaning {VISIBLE_Z}[role=button]").first.click()
        assert view.locator(".meaning .meaning .katex").count() == 1

    def test_in_a_table_of_terms_on_a_phone(self, view: Any) -> None:
        view.set_viewport_size({"width": WIDTHS[1], "height": 900})
        view.evaluate(OPEN_ALL)
        view.locator(f"#step-5 td {VISIBLE_Z}[role=button]").first.click()
        assert view.locator("#step-5 .scroll + .meanings .katex").count() == 1
        assert view.evaluate("document.documentElement.scrollWidth") <= WIDTHS[1]

    def test_what_is_copied(self, view: Any) -> None:
        view.evaluate("() => { navigator.clipboard.writeText = async text => { window.copied = text; }; }")
        view.locator("#step-5 button.copy").click()
        text = view.evaluate("window.copied")
        assert text.startswith("\\begin{align*}\n  Z_{1} &= ")
        assert "F_{u_{1}} &= -m g R \\sin q_{2} \\\\\n" in text
        assert "htmlData" not in text

    @pytest.mark.slow
    def test_as_a_file_for_the_printer(self, view: Any) -> None:
        assert view.pdf(format="A4").startswith(b"%PDF")
        assert view.locator("details[open]").count() < view.locator("details").count()
