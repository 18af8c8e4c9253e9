# SPDX-License-Identifier: BSD-3-Clause
"""The documentation builds without a warning, and its pages ask nothing of the network."""

import re
import subprocess
import sys

import pytest

from tests.docs.snippets import ROOT

_LOADED = re.compile(r"""<(?:script|img|iframe)[^>]*\ssrc=["']([^"']+)|<link[^>]*rel="stylesheet"[^>]*href="([^"]+)""")

_SUMMARY = re.compile(
    r'<tr class="row-(?:odd|even)"><td><p><a class="reference internal".*?</td>\s*<td><p>(.*?)</p></td>', re.DOTALL
)


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("html")
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "sphinx",
            "-W",
            "-q",
            "-b",
            "html",
            "-d",
            str(folder / "trees"),
            "docs",
            str(folder / "html"),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    made = {p.relative_to(folder / "html").as_posix(): p for p in (folder / "html").rglob("*.html")}
    return {name: page for name, page in made.items() if not name.startswith("_static/")}


@pytest.mark.slow
def test_pages_load_only_their_own_files(pages):
    loaded = {
        (name, found)
        for name, page in pages.items()
        for pair in _LOADED.findall(page.read_text(encoding="utf-8"))
        for found in pair
        if found
    }
    assert loaded
    for name, found in loaded:
        assert not re.match(r"\w+:|//", found), (name, found)
        assert (pages[name].parent / found.partition("?")[0]).is_file(), (name, found)


@pytest.mark.slow
def test_summaries_of_names_are_whole(pages):
    """A summary is a sentence: none ends at the point of an abbreviation, with a bracket open."""
    own = sorted(name for name in pages if name.startswith("api/") and name != "api/index.html")
    rows = [row for name in own for row in _SUMMARY.findall(pages[name].read_text(encoding="utf-8"))]
    assert len(rows) > 300
    assert [row for row in rows if row.count("(") != row.count(")") or not row.endswith(".")] == []


@pytest.mark.slow
def test_formulas_are_handed_to_katex(pages):
    text = pages["theory/solving.html"].read_text(encoding="utf-8")
    assert re.search(r'<div class="tex">\s*y = L\^\{-1\} f', text)
    assert "MathJax" not in text
    assert all(f"{name}.js" in text for name in ("katex.min", "formulas"))
