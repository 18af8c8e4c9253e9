# SPDX-License-Identifier: BSD-3-Clause
"""kn.show_versions."""

import numpy as np

import kane as kn
from kane.present import versions


def test_says_what_code_depends_on():
    rows = versions()
    assert rows["kane"] == kn.__version__
    assert rows["numpy"] == np.__version__
    assert ", LLVM " in rows["llvmlite"]
    assert "lanes of double" in rows["processor"]


def test_prints_a_line_each(capsys, monkeypatch):
    monkeypatch.setenv("KANE_CACHE", "off")
    kn.show_versions()
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(versions())
    assert lines[-1].split() == ["cache", "off"]
