# SPDX-License-Identifier: BSD-3-Clause
"""Notes of a report: Markdown and formulas as written, figures in it, and nothing that runs or loads."""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure
from PIL import Image

import kane as kn
from kane.gallery import pendulum
from tests.present.page import Page

TEXT = r"""# Result

The *period* is $T = 2\pi\sqrt{l/g}$ for $a_1 < b_1$ and costs $5, not $6.

$$
\dot u_1 < 0
$$

| a | b |
|---|---|
| `$x$` | \$1 |

<script>alert(1)</script> <img src="http://x.example/a.png" onerror="alert(1)"> ![x](http://x.example/b.png) [bad](javascript:alert(1))
[site](https://x.example/a)
"""


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("notes")
    figure = Figure()
    figure.subplots().set_title('a "curve"')
    drawn = folder / "drawn.svg"
    drawn.write_text('<svg xmlns="http://www.w3.org/2000/svg" onload="alert(1)"><script>alert(2)</script></svg>')
    eom = kn.derive(pendulum.system())
    made = kn.report(eom, folder / "r.html", notes=[TEXT, figure, drawn], why=False)
    return made.read_text(encoding="utf-8")


def test_markdown_and_formulas(text: str) -> None:
    page = Page(text)
    assert "notes" in page.sections
    assert page.math["notes"] == [r"T = 2\pi\sqrt{l/g}", "a_1 < b_1", r"\dot u_1 < 0"]
    own = text[text.index('id="notes"') :]
    assert "<h3>Result</h3>" in own
    assert "<em>period</em>" in own
    assert "costs $5, not $6." in own
    assert "<td><code>$x$</code></td>" in own
    assert "<td>$1</td>" in own
    assert r'<span class="math display">\dot u_1 &lt; 0</span>' in own


def test_nothing_runs_and_nothing_is_loaded(text: str) -> None:
    own = text[text.index('id="notes"') : text.index("</section>", text.index('id="notes"'))]
    assert set(re.findall(r"<(script|iframe|object|svg|link|style)\b", own)) == set()
    assert not re.search(r"<[^>]*\son\w+=", own)
    assert 'href="javascript' not in own
    links = ["http://x.example/b.png", "https://x.example/a"]  # of what Markdown calls an image a link is left
    assert re.findall(r'href="([^"]*)', own) == links
    assert re.findall(r'src="([^",;]*)', own) == 2 * ["data:image/svg+xml"]
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy.startswith("default-src 'none'")
    assert policy.endswith("img-src data:")


def test_figures_are_pictures(text: str) -> None:
    pictures = re.findall(r'<img alt="([^"]*)" src="data:image/svg\+xml;base64,([^"]*)">', text)
    assert [alt for alt, _ in pictures] == ["a &#34;curve&#34;", "drawn"]
    assert all(b"<svg" in base64.b64decode(data) for _, data in pictures)


def test_what_is_no_note(tmp_path: Path) -> None:
    eom = kn.derive(pendulum.system())
    (tmp_path / "a.png").write_text("<html>")
    cases: list[tuple[Any, str]] = [
        ("# text", "notes= as a list"),
        ([3], "got 3 in it"),
        ([tmp_path / "none.svg"], "can be read"),
        ([tmp_path / "a.pdf"], "ends in .svg, .png"),
        ([tmp_path / "a.png"], "got something else"),
    ]
    for notes, said in cases:
        with pytest.raises(kn.errors.ArgumentError, match=said):
            kn.report(eom, tmp_path / "r.html", notes=notes, why=False)
    assert not (tmp_path / "r.html").exists()


def test_in_latex_and_markdown(tmp_path: Path) -> None:
    """Markdown stays as it is, and is read for LaTeX; figures and pictures lie beside, and are replaced when written anew."""
    figure, picture = Figure(), tmp_path / "given.png"
    figure.subplots().set_title("curve")
    Image.new("RGB", (4, 3)).save(picture)
    eom = kn.derive(pendulum.system())
    for _ in range(2):
        latex = kn.report(eom, tmp_path / "r.tex", notes=[TEXT, figure, picture], why=False).read_text("utf-8")
        markdown = kn.report(eom, tmp_path / "r.md", notes=[TEXT, figure, picture], why=False).read_text("utf-8")
    assert TEXT.strip() in markdown
    assert "![note3](r-note3.png)" in markdown
    for told in (
        r"subsection{Result}", r"The period is $T = 2\pi\sqrt{l/g}$ for $a_1 < b_1$ and costs \$5, not \$6.",
        r"\dot u_1 < 0", r"a & b \\ \hline", r"$<$script$>$alert(1)", "{r-note2.pdf}", "{r-note3.png}",
    ):  # fmt: skip
        assert told in latex, told
    assert {p.name for p in tmp_path.glob("r-note*")} == {"r-note2.pdf", "r-note2.svg", "r-note3.png"}
    (tmp_path / "given.svg").write_text("<svg/>", "utf-8")
    with pytest.raises(kn.ArgumentError, match=r"without \.svg files for LaTeX"):
        kn.report(eom, tmp_path / "r.tex", notes=[tmp_path / "given.svg"])
