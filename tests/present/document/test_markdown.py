# SPDX-License-Identifier: BSD-3-Clause
"""A report in Markdown: every formula and table is read as such, and figures lie beside it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import kane as kn
from tests.peer import require
from tests.present.disk import derived, moved

TITLE = "A *disk* of $5"


def parsed(text: str) -> Any:
    require("markdown_it")
    require("mdit_py_plugins")
    from markdown_it import MarkdownIt
    from mdit_py_plugins.dollarmath import dollarmath_plugin

    return MarkdownIt("commonmark").enable("table").use(dollarmath_plugin).parse(text)


def inner(tokens: Any) -> Iterator[Any]:
    return (x for t in tokens if t.type == "inline" for x in t.children)


def check(path: Path) -> Any:
    tokens = parsed(path.read_text(encoding="utf-8"))
    pieces = list(inner(tokens))
    assert not [x for x in pieces if x.type in ("em_open", "strong_open", "html_inline", "code_inline")]
    assert not [
        x.content for x in pieces if x.type == "text" and ("$" in x.content or "\\" in x.content) and x.content != TITLE
    ]
    kinds = [t.type for t in tokens]
    heads, rows = kinds.count("thead_open"), kinds.count("tr_open")
    assert heads == kinds.count("table_open")
    assert rows > 2 * heads
    for image in (x for x in pieces if x.type == "image"):
        assert (path.parent / image.attrs["src"]).is_file()
    for formula in (t.content for t in tokens if t.type == "math_block"):
        assert formula.count("{") == formula.count("}")
        assert formula.count(r"\begin") == formula.count(r"\end")
    return tokens


def test_the_disk_is_whole(tmp_path: Path) -> None:
    _, eom = derived()
    path = kn.report(eom, tmp_path / "disk.md", solution=moved(), title=TITLE, sources=["Kane & Levinson"])
    tokens = check(path)
    formulas = [t.content.strip() for t in tokens if t.type == "math_block"]
    assert r"{}^{N}\boldsymbol{\omega}^{C} = u_{1}\,\hat{b}_{x} + u_{2}\,\hat{b}_{y} + u_{3}\,\hat{b}_{z}" in formulas
    for i in range(1, 6):
        assert any(rf"\dot{{u}}_{{{i}}} = " in f for f in formulas)
    assert sum(x.type == "image" for x in inner(tokens)) == 6
    heads = [t.content for t in tokens if t.type == "inline"]
    assert r"A \*disk\* of \$5" in heads
    again = kn.report(eom, tmp_path / "disk.md", solution=moved(), format="markdown")
    assert again == path


def test_the_format_is_the_ending_or_said(tmp_path: Path) -> None:
    eom = derived()[1]
    with pytest.raises(kn.errors.ArgumentError, match=r"ends in \.html, \.htm, \.tex, \.md, \.markdown, got"):
        kn.report(eom, tmp_path / "disk.docx")
    with pytest.raises(kn.errors.ArgumentError, match=r"'html', 'latex', 'markdown', got 'latx'\. Did you mean"):
        kn.report(eom, tmp_path / "disk", format="latx")
    made = kn.report(eom, tmp_path / "disk", format="markdown").read_text(encoding="utf-8")
    assert made.startswith("<!-- A report of kane ")
    with pytest.raises(kn.errors.ArgumentError, match="other contents"):
        kn.report(eom, tmp_path / "disk", format="latex")
