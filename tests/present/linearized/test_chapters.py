# SPDX-License-Identifier: BSD-3-Clause
"""Chapters on small motions: figures by hand, alike in each format; what is no linearization of these equations is refused."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kane as kn
from tests.present.browser import chromium
from tests.present.document.test_latex import compiled, complaints
from tests.present.document.test_markdown import check
from tests.present.languages.test_pages import FORMULAS, SAME, Shown, given
from tests.present.page import Page
from tests.present.test_animation import GL
from tests.present.test_every_page import FACES, look
from tests.systems.steady import driven_pendulum, rolling_disk

CHAPTERS = ["point", "linearization", "eigenvalues", "loci"]


def masses() -> kn.Equations:
    """Two equal masses, three equal springs, a damper to the ground on each: x'' = −(c/m) x' − (k/m) K x, K of 1 and 3."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    (x, y), (u, v) = kn.coordinates("x y", unit="m"), kn.speeds("u v")
    k, c, F = kn.parameter("k", 100.0), kn.parameter("c", 0.4), kn.input("F", unit="N")
    P, Q = O.at("P", x * N.x), O.at("Q", y * N.x)
    loads = [
        kn.Force(P, (F - k * (2 * x - y) - c * u) * N.x, name="left"),
        kn.Force(Q, (-k * (2 * y - x) - c * v) * N.x, name="right"),
    ]
    bodies = [kn.Particle("A", P, 1.0), kn.Particle("B", Q, 1.0)]
    return kn.derive(kn.System(N, bodies=bodies, speeds={u: x.dt, v: y.dt}, loads=loads))


@pytest.fixture(scope="module")
def eom() -> kn.Equations:
    return masses()


def rows_of(path: Path) -> list[list[str]]:
    """The rows of all tables of a report in Markdown."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in lines]


def test_modes_are_those_by_hand(eom: kn.Equations, tmp_path: Path) -> None:
    """λ² + 0.4 λ + 100 = 0 in phase, λ² + 0.4 λ + 300 = 0 against it."""
    linear = kn.linearize(eom, q=[0, 0], u=[0, 0])
    path = kn.report(eom, tmp_path / "r.md", linearization=linear)
    check(path)
    text = path.read_text(encoding="utf-8")
    assert "An equilibrium: nothing moves." in text
    assert "Every mode decays: stable." in text
    modes = {row[-1]: row for row in rows_of(path) if "mathrm{i}" in row[0]}
    for square, other in ((100, "1"), (300, "-1")):
        (row,) = (r for m, r in modes.items() if re.fullmatch(rf"\$[xy]\\; 1,\\;\\; [xy]\\; {other}\$", m))
        _, size, frequency, damping, _ = row
        assert float(size) == pytest.approx(math.sqrt(square), rel=1e-4)
        assert float(frequency) == pytest.approx(math.sqrt(square - 0.04) / (2 * math.pi), rel=1e-4)
        assert float(damping) == pytest.approx(0.2 / math.sqrt(square), rel=1e-3)
    (a,) = re.findall(r"A = \\begin\{bmatrix\} (.*?) \\end", text)
    entries = [[float(x) for x in row.split("&")] for row in a.split(r"\\")]
    np.testing.assert_array_equal(entries, linear.A)


def test_modes_without_damping_stand_by_frequency(eom: kn.Equations, tmp_path: Path) -> None:
    """Rounding in their real parts orders nothing."""
    linear = kn.linearize(eom, q=[0, 0], u=[0, 0], parameters={"c": 0})
    path = kn.report(eom, tmp_path / "r.md", linearization=linear, why=False)
    assert [float(r[1]) for r in rows_of(path) if "mathrm{i}" in r[0]] == [10, pytest.approx(300**0.5, rel=1e-4)]
    assert "No mode grows; 2 neither grow nor decay." in path.read_text(encoding="utf-8")


def test_a_growing_mode_is_counted_and_a_state_between_said(eom: kn.Equations, tmp_path: Path) -> None:
    linear = kn.linearize(eom, q=[0.1, 0], u=[0, 0], steady=False, parameters={"c": -0.4})
    text = kn.report(eom, tmp_path / "r.md", linearization=linear).read_text(encoding="utf-8")
    assert "2 modes grow: unstable." in text
    assert (
        r"A state of a motion that is not steady: deviations are those from the motion through it, $\dot{u} = -20"
        in text
    )
    assert "| $c$ | -0.4 |" in text  # a parameter that is not at its default


@pytest.fixture(scope="module")
def disk() -> tuple[kn.Equations, dict[str, Any]]:
    """A disk that rolls round, upright ones of other spins, and the road's force."""
    eom = rolling_disk()
    turn = kn.trim(
        eom, q={"q1": 0, "q2": 0.3, "q3": 0, "q4": 0, "q5": 0}, u={"u3": kn.guess(8.0), "u1": 0, "u2": kn.guess(1.0)}
    )
    branch = kn.continuation(eom, "u3", [1, 2, 4, 8], q=[0, 0, 0, 0, 0], u={"u1": 0, "u2": 0})
    return eom, {"linearization": kn.linearize(eom, turn, outputs={"push": eom.reactions[0]}), "root_locus": branch}


def test_a_page_has_the_chapters_and_nothing_else_changes(disk: Any, tmp_path: Path) -> None:
    eom, options = disk
    page = Page(kn.report(eom, tmp_path / "r.html", **options).read_text(encoding="utf-8"))
    assert [s for s in page.sections if s in CHAPTERS] == CHAPTERS
    assert page.loads == []
    assert {f"#{c}" for c in CHAPTERS} <= set(page.references)
    # the road bears the weight, m g; the disk falls over below u3² = g/(3 R)
    assert ["N_{z}", "P", r"\hat{n}_{z}", f"{1.2 * 9.81:.6g}", "N"] in page.rows
    assert [float(row[0]) for row in page.rows if "a mode decays without swinging" in row] == [
        pytest.approx(math.sqrt(9.81 / (3 * 0.3)), rel=1e-6)
    ]
    assert any("A steady motion" in text for text in (tmp_path / "r.html").read_text("utf-8").splitlines())
    plain = Page(kn.report(eom, tmp_path / "p.html").read_text(encoding="utf-8"))
    assert [s for s in page.sections if s not in CHAPTERS] == plain.sections


def test_latex_compiles_and_figures_lie_beside(disk: Any, tmp_path: Path) -> None:
    eom, options = disk
    path = kn.report(eom, tmp_path / "r.tex", **options)
    assert complaints(compiled(path)) == []
    assert {"r-loci.pdf", "r-plane.pdf"} <= {p.name for p in tmp_path.iterdir()}


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), FACES)
def test_a_page_is_legible_and_within_the_screen(disk: Any, tmp_path: Path, width: int, scheme: str) -> None:
    eom, options = disk
    path = kn.report(eom, tmp_path / "r.html", why=False, **options)
    with chromium(*GL) as browser:
        look(browser, path, width, scheme, rules=scheme == "light")


def test_korean_chapters_say_the_same(disk: Any, tmp_path: Path) -> None:
    eom, options = disk
    english, korean = (
        Shown(kn.report(eom, tmp_path / f"{x}.html", language=x, title="R", why=False, **options).read_text("utf-8"))
        for x in ("en", "ko")
    )
    assert korean.numbers == english.numbers
    assert korean.plain_formulas == english.plain_formulas
    assert korean.words - given(eom, "R push rad Hz") - SAME - FORMULAS == set()


def test_others_are_refused(disk: Any, eom: kn.Equations, tmp_path: Path) -> None:
    with pytest.raises(kn.ArgumentError, match=r"linearization= as kn\.linearize.* of others"):
        kn.report(eom, tmp_path / "r.html", linearization=disk[1]["linearization"])
    with pytest.raises(kn.ArgumentError, match=r"root_locus= as kn\.analysis\.continuation.*, got 'u3'"):
        kn.report(eom, tmp_path / "r.html", root_locus="u3")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_branch_turns_back_where_it_is_said(tmp_path: Path) -> None:
    eom = driven_pendulum()
    branch = kn.continuation(eom, "tau", [0, 5, 9, 12], q={"q1": kn.guess(0)}, u={"u1": 0})
    text = kn.report(eom, tmp_path / "r.md", root_locus=branch).read_text(encoding="utf-8")
    said = re.search(r"The branch turns back at \$\\tau\$ = ([\d.]+) N·m", text)
    assert said is not None
    assert float(said[1]) == pytest.approx(branch.turning_points[0], rel=1e-4)
