# SPDX-License-Identifier: BSD-3-Clause
"""Sketches in a browser: the boxes of its letters do not overlap nor leave the paper, no page overflows, light and dark."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import pytest

import kane as kn
from kane.gallery import GALLERY, load
from kane.present import DARK, LIGHT, NARROW, WIDE
from tests.present.browser import chromium

pytestmark = pytest.mark.slow

BOXES = """() => [...document.querySelectorAll('svg text')].map(t => {
    const b = t.getBBox(); return [b.x, b.y, b.x + b.width, b.y + b.height, t.textContent]})"""
PAINT = """() => [...document.querySelectorAll('svg text')].map(t => {
    const s = getComputedStyle(t); return [s.paintOrder, s.stroke, parseFloat(s.strokeWidth)]})"""
SCROLL = "document.documentElement.scrollWidth"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.mark.parametrize(("page", "width", "scheme"), [(1280, WIDE, "light"), (390, NARROW, "dark")])
def test_letters_do_not_overlap(browser: Any, page: int, width: int, scheme: str) -> None:
    """Over all of the gallery; a line of text is taller than its letters by a third."""
    complaints: list[str] = []
    context = browser.new_context(viewport={"width": page, "height": 900}, color_scheme=scheme, offline=True)
    view = context.new_page()
    view.on("console", lambda said: complaints.append(said.text))
    view.on("pageerror", lambda error: complaints.append(str(error)))
    view.on("request", lambda request: complaints.append(request.url))
    wrong: list[str] = []
    for name in GALLERY:
        module = load(name)
        system = module.system()
        sketch = kn.sketch(system, width=width, shapes=module.shapes(system) if hasattr(module, "shapes") else ())
        view.set_content(f"<!doctype html><body style='margin:16px'>{sketch.svg}</body>")
        boxes = view.evaluate(BOXES)
        assert len(boxes) == len(sketch.labels)
        for x, y, right, bottom, text in boxes:
            if x < 0 or y < 0 or right > sketch.width or bottom > sketch.height:
                wrong.append(f"{name}: {text} leaves the paper")
        for a, b in combinations(boxes, 2):
            trim = 0.16 * min(a[3] - a[1], b[3] - b[1])
            if a[0] < b[2] and b[0] < a[2] and a[1] + trim < b[3] - trim and b[1] + trim < a[3] - trim:
                wrong.append(f"{name}: {a[4]} and {b[4]}")
        for order, stroke, wide in view.evaluate(PAINT):
            assert order.startswith("stroke")
            assert wide >= 3
            card = (LIGHT if scheme == "light" else DARK)["card"]
            assert stroke == "rgb({}, {}, {})".format(*(int(card[k : k + 2], 16) for k in (1, 3, 5)))
        assert view.evaluate(SCROLL) <= page, name
    assert wrong == []
    assert complaints == []
    context.close()
