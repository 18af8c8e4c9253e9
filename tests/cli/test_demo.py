# SPDX-License-Identifier: BSD-3-Clause
"""The `kane` command: the demo prints what it computed, writes the report, and fails where a check fails."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import kane as kn
from kane import Check
from kane.cli import app, demo
from kane.gallery.rolling import rolling_disk, rolling_disk_check
from tests.present.page import Page


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    out = tmp_path_factory.mktemp("out")
    result = CliRunner().invoke(app, ["demo", "--out", str(out)])
    assert result.exit_code == 0, result.output
    return result.output, out / "rolling_disk" / "report.html"


@pytest.mark.slow
def test_every_step_is_printed(ran: tuple[str, Path]) -> None:
    output, _ = ran
    assert re.findall(r"^Step (\d)\.", output, re.MULTILINE) == list("1234567")
    assert "w_C        = u1 B.x + u2 B.y + u3 B.z" in output


def test_figures_are_the_computed_ones(ran: tuple[str, Path]) -> None:
    output, report = ran
    found = rolling_disk_check.checks()
    rows = Page(report.read_text(encoding="utf-8")).rows
    for check in found:
        assert str(check) in output
        assert [check.name, f"{check.figure:.1e}", f"{check.limit:.0e}", "passed"] in rows
    assert f"{len(found) + 1} of {len(found) + 1} checks passed" in output


def test_report_is_written_where_it_says(ran: tuple[str, Path]) -> None:
    output, report = ran
    assert output.splitlines()[-1] == f"Report: {report}"
    page = Page(report.read_text(encoding="utf-8"))
    assert page.loads == []
    assert page.sections[9:] == ["why", "operations", "checks", "motion", "sources"]


def test_another_inertia_is_noticed() -> None:
    """The checks can fail: against a disk of another inertia they do, and only those that concern it."""
    found = {c.name: c for c in rolling_disk_check.checks(axial=0.51)}
    for name in (
        "accelerations of the centre",
        "angular acceleration",
        "normal force",
        "dE/dt less the power of friction",
    ):
        assert not found[name].passed
        assert found[name].figure > 1e-6
    assert found["dE/dt less the power derived"].passed
    assert found["invariance under the choice of speeds"].passed


def test_another_model_is_noticed() -> None:
    ring = rolling_disk.model(inertia=lambda C, m, R: kn.ring(C, m, R, axis=C.z))
    found = rolling_disk_check.checks(ring, kn.derive(ring.system))
    assert not any(c.passed for c in found if "power derived" not in c.name)


@pytest.mark.slow
def test_a_failed_check_is_the_exit_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(demo, "checks", lambda disk, eom: rolling_disk_check.checks(disk, eom, diametral=0.26))
    result = CliRunner().invoke(app, ["demo", "--out", str(tmp_path)])
    assert result.exit_code == 1
    assert "FAIL  accelerations of the centre" in result.output
    assert (tmp_path / "rolling_disk" / "report.html").is_file()


def test_a_figure_that_is_no_number_fails() -> None:
    assert not Check("x", float("nan"), 1.0).passed
    assert Check("x", 1.0, 1.0).passed


def test_version() -> None:
    result = CliRunner().invoke(app, ["--version"])
    assert result.exit_code == 0
    assert result.output.strip() == f"kane {kn.__version__}"


@pytest.mark.slow
def test_main_without_warnings() -> None:
    code = "import sys; sys.argv = ['kane', '--version']; from kane.cli import main; main()"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
