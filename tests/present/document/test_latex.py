# SPDX-License-Identifier: BSD-3-Clause
"""A report in LaTeX: pdflatex takes it without a complaint, lines are no wider than the page, each intermediate is defined once."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

import kane as kn
from kane.cli import model_of
from kane.gallery.pendulums import system as chain
from kane.present import math_latex, text_latex
from tests.present.disk import derived
from tests.present.document.test_markdown import check

QUICK = ("pendulum",)
SYSTEMS = (
    *QUICK, "rolling_disk", "four_bar", "whipple_bicycle", "flexible_arm", "skidding_disk", "snakeboard", "compass_gait", "free_body",
    "muscle_arm",
)  # fmt: skip
MOVED = ("rolling_disk", "compass_gait")
"""Those whose motion is reported as well."""
TOLERATED = 2.0
"""Points by which a line may be wider than the page."""


def compiled(path: Path) -> str:
    """What pdflatex says; the file's PDF is made. Skips where it is absent, but fails in CI."""
    if shutil.which("pdflatex") is None:
        assert not os.environ.get("CI"), "pdflatex is absent"
        pytest.skip("pdflatex is not installed")
    call = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", path.name]
    for _ in range(2):
        done = subprocess.run(call, cwd=path.parent, capture_output=True, check=False)
    said = done.stdout.decode("utf-8", "replace")
    assert done.returncode == 0, said[-2000:]
    return said


def complaints(said: str) -> list[str]:
    wide = [m[0] for m in re.finditer(r"Overfull \\hbox \(([\d.]+)pt too wide\).*", said) if float(m[1]) > TOLERATED]
    return wide + re.findall(r".*(?:Missing character|LaTeX Warning|mktexpk).*", said)


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in SYSTEMS])
def test_a_report_of_the_gallery_compiles(name: str, tmp_path: Path) -> None:
    model = model_of(name)
    eom = kn.derive(model.system)
    sol = kn.simulate(eom, (0.0, 0.2), samples=21, **model.start) if name in MOVED else None
    path = kn.report(eom, tmp_path / "report.tex", solution=sol, sources=model.sources, shapes=model.shapes)
    if sol is None:
        check(kn.report(eom, tmp_path / "report.md", sources=model.sources, shapes=model.shapes))
    assert complaints(compiled(path)) == []
    written = path.read_text(encoding="utf-8")
    assert written.isascii()
    defined = re.findall(r"& (?:\\fit\{)?(Z_\{\d+\}) =", written)
    assert len(defined) == len(set(defined))
    assert defined == [f"Z_{{{i}}}" for i in range(1, len(defined) + 1)]
    assert [int(n) for n in re.findall(r"\\section\{(\d)\. ", written)] == [1, 2, 3, 4, 5, 6, 7]
    assert all((tmp_path / f).is_file() for f in re.findall(r"\\includegraphics\[[^]]*\]\{([^}]*)\}", written))


def test_every_equation_of_the_solution_is_there(tmp_path: Path) -> None:
    _, eom = derived()
    written = kn.report(eom, tmp_path / "disk.tex").read_text(encoding="utf-8")
    solved = written[written.index(r"Solved for") :]
    for i in range(1, len(eom.speeds) + 1):
        assert rf"& \dot{{u}}_{{{i}}} = " in solved
    assert "& N_{z} = " in solved


def test_signs_beyond_ascii_are_commands() -> None:
    assert (
        text_latex("50% of Müller's μ ≤ Fᵣ – ½ m²") == r"""50\% of M\"{u}ller's $\mu $ $\le $ F$_{r}$ -- 1/2 m$^{2}$"""
    )
    assert math_latex("θ + 漢") == r"\theta  + \text{[U+6F22]}"


@pytest.mark.slow
@pytest.mark.parametrize("name", ['a"b&c<d>', "a\\b$c%{d}", "a#b^c~θ_größe"])
def test_any_name_compiles(name: str, tmp_path: Path) -> None:
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate(name, description=name)
    A = N.rotate(name, q, N.z)
    body = kn.RigidBody(name, frame=A, mass_center=O.at(name, A.x), mass=1, inertia=kn.solid_sphere(A, 1, 1))
    system = kn.System(
        N, bodies=[body], speeds={kn.speed("u"): q.dt}, loads=[kn.Force(body.mass_center, A.y, name=name)]
    )
    path = kn.report(kn.derive(system), tmp_path / "x.tex", title=name, sources=[name])
    assert complaints(compiled(path)) == []


def test_a_matrix_far_wider_than_the_page_is_written_by_entries(tmp_path: Path) -> None:
    written = kn.report(kn.derive(chain(5)), tmp_path / "chain.tex").read_text(encoding="utf-8")
    assert "with the entries on and above the diagonal" in written
    assert len(set(re.findall(r"& (?:\\fit\{)?(M_\{u_\{\d\}\\,u_\{\d\}\}) =", written))) == 15


def test_figures_lie_beside_and_foreign_files_stay(tmp_path: Path) -> None:
    """A report is replaced by one in the same format, a figure by a figure, nothing else."""
    (tmp_path / "disk-sketch.pdf").write_text("mine")
    with pytest.raises(kn.errors.ArgumentError, match="other contents"):
        kn.report(derived()[1], tmp_path / "disk.tex")
    assert (tmp_path / "disk-sketch.pdf").read_text() == "mine"
    assert not (tmp_path / "disk.tex").exists()
