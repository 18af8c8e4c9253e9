# SPDX-License-Identifier: BSD-3-Clause
"""A reader of reports: what the page would load, its formulas, sections and tables."""

from __future__ import annotations

import re
from html.parser import HTMLParser

LOADING = {
    "src",
    "href",
    "xlink:href",
    "srcset",
    "data",
    "action",
    "poster",
    "formaction",
    "background",
    "cite",
    "manifest",
}
VOID = {"meta", "link", "br", "img", "hr", "input", "base", "col", "source"}


class Page(HTMLParser):
    """Parsed HTML; `loads` holds every address that is not within the page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.tags: list[str] = []
        self.sections: list[str] = []
        self.math: dict[str, list[str]] = {}
        self.rows: list[list[str]] = []
        self.identifiers: list[str] = []
        self.references: list[str] = []
        self._styles: list[str] = []
        self._open: list[tuple[str, str]] = []
        self.feed(text)
        self.close()
        for style in self._styles:
            self.loads += [
                u for u in re.findall(r"url\(\s*['\"]?([^)'\"]*)", style) if not u.startswith(("data:", "#"))
            ]
            self.loads += re.findall(r"@import[^;]*", style)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {k: v or "" for k, v in attrs}
        self.tags.append(tag)
        if "id" in values:
            self.identifiers.append(values["id"])
        for name, value in values.items():
            if name in LOADING:
                (self.references if value.startswith("#") else self.loads).append(value)
            if name == "style" or "url(" in value:
                self._styles.append(value)
                self.references += re.findall(r"url\((#[^)]*)\)", value)
        if tag == "section":
            self.sections.append(values["id"])
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th") and self.rows:
            self.rows[-1].append("")
        if tag == "span" and "math" in values.get("class", "").split():
            self.math.setdefault(self.sections[-1] if self.sections else "", []).append("")
        if tag not in VOID:
            self._open.append((tag, values.get("class", "")))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self._open.pop()

    def handle_endtag(self, tag: str) -> None:
        opened, _ = self._open.pop()
        assert opened == tag, f"<{opened}> closed by </{tag}>"

    def handle_data(self, data: str) -> None:
        tag, kind = self._open[-1] if self._open else ("", "")
        if tag == "style":
            self._styles.append(data)
        if tag == "span" and "math" in kind.split():
            self.math[self.sections[-1] if self.sections else ""][-1] += data
        if self.rows and self.rows[-1] and any(t in ("td", "th") for t, _ in self._open):
            self.rows[-1][-1] += data
