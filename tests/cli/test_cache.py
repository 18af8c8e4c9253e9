# SPDX-License-Identifier: BSD-3-Clause
"""`kane cache`."""

import numpy as np
import pytest
from typer.testing import CliRunner

import kane as kn
from kane.cli import app
from kane.gallery.pendulums import system as chain
from kane.program import machine


def invoke(*words):
    result = CliRunner().invoke(app, ["cache", *words])
    assert result.exit_code == 0, result.output
    return " ".join(result.output.split())


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("KANE_CACHE", str(tmp_path / "objects"))
    return tmp_path / "objects"


def test_info_and_clear(folder):
    assert "0 entries, 0.0 MiB of at most 256 MiB" in invoke("info")
    kn.derive(chain(2)).compile()
    assert len(list(folder.iterdir())) == 1
    assert str(folder) in invoke("info").replace(" ", "")
    assert "1 entry" in invoke("info")
    assert invoke("clear").startswith("Removed 1 entry")
    assert list(folder.iterdir()) == []
    assert invoke("clear").startswith("Removed 0 entries")


def test_second_compilation_reads_the_first(folder, monkeypatch):
    eom = kn.derive(chain(2))
    x = np.array([0.1, 0.2, 0.3, 0.4])
    first = eom.compile().rhs(0.0, x)

    def refuse(*_):
        raise AssertionError("compiled again")

    monkeypatch.setattr(machine, "object_code", refuse)
    assert np.array_equal(eom.compile().rhs(0.0, x), first)
    with pytest.raises(AssertionError, match="compiled again"):
        eom.compile(cache=False)


def test_cache_turned_off(folder, monkeypatch):
    monkeypatch.setenv("KANE_CACHE", "off")
    kn.derive(chain(2)).compile()
    assert not folder.exists()
    assert "The cache is off" in invoke("info")
    assert invoke("clear").startswith("Removed 0 entries")
