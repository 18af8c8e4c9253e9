# SPDX-License-Identifier: BSD-3-Clause
"""The command as a process: Ctrl-C, completion, warnings, and the words on stderr when something takes long."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings

import pytest
import typer

from kane.cli import guarded
from kane.errors import KaneWarning
from tests.cli.command import SPRING, written
from tests.present.page import Page

pytestmark = pytest.mark.slow


def process(*words, cwd, **environment):
    """The command in a process of its own, warnings being errors."""
    code = "import sys; sys.argv[0] = 'kane'; from kane.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code, *words],
        cwd=cwd,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


@pytest.mark.slow  # what each part does is tested without a process of its own
def test_new_then_report(tmp_path):
    assert process("new", "x.py", cwd=tmp_path).returncode == 0
    done = process("report", "x.py", "--t1", "1", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1] == "Report: x.html"
    page = Page((tmp_path / "x.html").read_text(encoding="utf-8"))
    assert page.loads == []
    assert "motion" in page.sections


def test_interrupt(tmp_path):
    heeding = "signal.signal(signal.SIGINT, signal.default_int_handler)"  # a shell's background jobs do not
    written(tmp_path, f"import os, signal, time\n{heeding}\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(30)\n")
    done = process("check", "model.py", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "Interrupted.\n")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_a_disk_that_is_full(tmp_path):
    code = "import sys; sys.argv = ['kane', 'gallery']; from kane.cli import main; main()"
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=60,
            check=False,
        )
    assert (done.returncode, done.stderr) == (1, "error: Expected to write, got No space left on device.\n")


def test_errors_of_the_user_s_file(tmp_path):
    written(tmp_path, SPRING.replace("x * N.x", "z * N.x"))
    done = process("simulate", "model.py", cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "NameError: name 'z' is not defined"
    assert done.stderr.count("  File") == 1


def test_completion(tmp_path):
    told = {"_KANE_COMPLETE": "complete_bash", "COMP_WORDS": "kane check spin", "COMP_CWORD": "2"}
    assert process(cwd=tmp_path, **told).stdout.split() == ["spinning_top"]
    told |= {"COMP_WORDS": "kane si", "COMP_CWORD": "1"}
    assert process(cwd=tmp_path, **told).stdout.split() == ["simulate"]


def test_warnings_are_one_line(capsys):
    with guarded():
        warnings.warn("Something doubtful.", KaneWarning, stacklevel=1)
    assert capsys.readouterr().err == "warning: Something doubtful.\n"


def test_other_warnings_are_left_alone():
    with pytest.raises(DeprecationWarning, match="old"), guarded():  # in these tests warnings are errors
        warnings.warn("old", DeprecationWarning, stacklevel=1)


def test_a_fault_of_kane_is_not_hidden():
    with pytest.raises(RuntimeError, match="inner"), guarded():
        raise RuntimeError("inner")
    with pytest.raises(typer.Exit), guarded():
        raise typer.Exit(0)
