# SPDX-License-Identifier: BSD-3-Clause
"""What users install: the wheel and the source distribution, built by the back end that pyproject.toml names."""

import ast
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


@pytest.mark.slow
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


SOURCES = sorted((ROOT / "src" / "kane").rglob("*.py"))


def calls(path):
    """Each call in a file: the name of the function, as it is written, and the call."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Call):
            yield ast.unparse(node.func), node


@pytest.mark.slow
def test_nothing_prints_but_the_command():
    """`show_versions` is asked to."""
    found = {
        p.relative_to(ROOT / "src" / "kane").as_posix() for p in SOURCES for name, _ in calls(p) if name == "print"
    }
    assert {place for place in found if not place.startswith("cli/")} == {"present/provenance.py"}


@pytest.mark.slow
def test_warnings_are_kane_s_and_point_at_the_caller():
    warned = [(p, call) for p in SOURCES for name, call in calls(p) if name.split(".")[-1] in ("warn", "warn_explicit")]
    own = [(p.name, ast.unparse(call)) for p, call in warned if ast.unparse(call.func) != "warn"]
    assert own == [("errors.py", "warnings.warn(message, category or KaneWarning, stacklevel=level)")]
    for path, call in warned:  # a category is one of what beams are doubted for
        assert [ast.unparse(x) for x in call.args[1:]] in ([], ["category"]) or path.name == "errors.py", path
        assert not call.keywords or path.name == "errors.py", path


def test_a_warning_names_the_line_that_called():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m")
    P = O.at("P", x * N.x)
    event = kn.Event("far", kn.log(x / kn.parameter("a", 1.0, "m")))
    eom = kn.derive(kn.System(N, bodies=[kn.Particle("p", P, 1.0)], speeds="rates", events=[event]))
    with pytest.warns(kn.KaneWarning) as caught:
        kn.simulate(eom, (0, 0.1), q=[0.0], u=[1.0])
    assert {w.filename for w in caught} == {__file__}


@pytest.mark.slow
def test_loggers_are_kane_s():
    """Every logger is below the one that is silent unless asked; nothing configures the root."""
    names = [
        ast.unparse(call.args[0]) if call.args else "root"
        for p in SOURCES
        for name, call in calls(p)
        if name in ("logging.getLogger", "logging.basicConfig")
    ]
    assert names
    assert set(names) <= {"'kane'", "__name__"}
