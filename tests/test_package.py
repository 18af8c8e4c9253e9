# SPDX-License-Identifier: BSD-3-Clause
"""What users install: the wheel and the source distribution, built by the back end that pyproject.toml names."""

import logging
import subprocess
import sys
import tarfile
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest

import kane as kn

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-d", str(folder)], cwd=ROOT, check=True, capture_output=True
    )
    (wheel,), (source,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return wheel, source


def test_wheel_holds_the_whole_package_and_nothing_else(built):
    with zipfile.ZipFile(built[0]) as archive:
        names = set(archive.namelist())
    package = ROOT / "src"
    wanted = {
        path.relative_to(package).as_posix()
        for path in (package / "kane").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert wanted <= names
    assert {"kane/py.typed", "kane/present/assets/katex.min.js"} <= names
    assert all(name.startswith(("kane/", "kane-")) for name in names)


def test_wheel_says_what_it_is(built):
    with zipfile.ZipFile(built[0]) as archive:
        (path,) = (name for name in archive.namelist() if name.endswith("METADATA"))
        metadata = Parser().parsestr(archive.read(path).decode())
    assert (metadata["Name"], metadata["Version"]) == ("kane", kn.__version__)
    assert metadata["License-Expression"] == "BSD-3-Clause"
    assert metadata["Requires-Python"] == ">=3.11"
    assert {r.split(">")[0] for r in metadata.get_all("Requires-Dist")} >= {"numpy", "scipy", "llvmlite", "sympy"}
    assert built[0].name.endswith("-py3-none-any.whl")


def test_source_distribution_holds_what_its_tests_need(built):
    with tarfile.open(built[1]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {
        "src/kane/__init__.py",
        "tests/conftest.py",
        "benchmarks/limits.json",
        "Makefile",
        "LICENSE",
        "README.md",
    } <= names
    assert not [name for name in names if "__pycache__" in name or name.startswith("docs/_build")]


def test_every_source_names_its_licence():
    files = [p for folder in ("src", "tests", "benchmarks", "examples") for p in (ROOT / folder).rglob("*.py")]
    assert len(files) > 200
    silent = [
        str(p.relative_to(ROOT))
        for p in files
        if "SPDX-License-Identifier: BSD-3-Clause" not in p.read_text("utf-8")[:200]
    ]
    assert silent == []


def test_logging_is_silent_unless_asked():
    assert any(isinstance(h, logging.NullHandler) for h in logging.getLogger("kane").handlers)
