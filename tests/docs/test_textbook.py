# SPDX-License-Identifier: BSD-3-Clause
"""The page on the textbook: what it names is there, under the name it gives."""

from __future__ import annotations

import re

import pytest

import kane as kn
from tests.docs.snippets import ROOT

PAGE = (ROOT / "docs" / "textbook.md").read_text(encoding="utf-8")
ROWS = [line for line in PAGE.splitlines() if line.startswith("| ") and not line.startswith("| section")]
KINDS = {
    "kn": kn,
    "eom": kn.Equations,
    "sol": kn.Solution,
    "R": kn.Rotation,
    **dict.fromkeys(("A", "B", "N", "C"), kn.Frame),
    **dict.fromkeys(("P", "Q", "O"), kn.Point),
    "v": kn.Vector,
}
"""What the letters on the page stand for."""


def named():
    """Letter and attribute of every name on the page."""
    for row in ROWS:
        for code in re.findall(r"`([^`]+)`", row):
            yield from re.findall(r"\b(kn|eom|sol|[A-Zv])\.(\w+)", code)


def test_names_on_the_page_are_there():
    found = sorted({(letter, name) for letter, name in named() if letter in KINDS})
    assert len(found) > 60
    unit = {"x", "y", "z"}
    missing = [f"{letter}.{name}" for letter, name in found if not (hasattr(KINDS[letter], name) or name in unit)]
    assert not missing


@pytest.mark.parametrize("row", [r for r in ROWS if "`kn." in r or "`eom." in r], ids=lambda r: r[:40])
def test_functions_have_docstrings(row):
    for letter, name in re.findall(r"`(kn|eom)\.(\w+)", row):
        assert (getattr(KINDS[letter], name).__doc__ or "").strip(), name
