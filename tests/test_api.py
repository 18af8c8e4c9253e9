# SPDX-License-Identifier: BSD-3-Clause
"""The public list: it resolves, it is complete, and importing it is cheap."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import kane as kn


def test_each_name_is_listed_once_and_resolves():
    assert len(set(kn.__all__)) == len(kn.__all__)
    missing = [name for name in (*kn.__all__, *kn.__getattr__.places) if getattr(kn, name, None) is None]
    assert missing == []


def test_the_list_is_complete():
    """Whatever of the package's own can be reached as kn.name without an underscore is in the list, modules apart."""
    reachable = {
        name
        for name, value in vars(kn).items()
        if not name.startswith("_")
        and not inspect.ismodule(value)
        and getattr(value, "__module__", "").startswith("kane")
    }
    assert reachable - {*kn.__all__, *kn.__getattr__.places} == set()


def test_dir_shows_the_list():
    assert dir(kn) == sorted(kn.__all__)


def test_what_is_not_there():
    with pytest.raises(AttributeError, match=r"attribute of module kane, got 'coordinat'\. Did you mean coordinate"):
        _ = kn.coordinat  # type: ignore[attr-defined]


def test_every_function_and_class_is_documented():
    bare = [n for n in kn.__getattr__.places if callable(getattr(kn, n)) and not (getattr(kn, n).__doc__ or "").strip()]
    assert bare == []


def test_errors_are_one_family():
    for name in kn.errors.__all__:
        value = getattr(kn, name)
        if inspect.isclass(value) and issubclass(value, Exception) and not issubclass(value, Warning):
            assert issubclass(value, kn.KaneError), name


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()


@pytest.mark.slow
def test_importing_loads_nothing_heavy():
    code = "import kane, sys; print(*[m for m in sys.modules])"
    loaded = set(run(code))
    assert {"numpy", "scipy", "llvmlite", "sympy", "matplotlib", "jinja2", "rich", "typer"} & loaded == set()
    assert {m for m in loaded if m.startswith("kane")} == {"kane", "kane.lazy_imports"}


def test_a_name_loads_what_it_needs():
    """Modules of the package that are there for the first steps of a model; motions and analyses come when they are asked for."""
    code = "import kane as kn, sys; kn.{}; print(*[m for m in sys.modules if m.startswith(('kane', 'scipy', 'sympy', 'llvmlite'))])"
    most = {"Frame": 45, "System": 90, "derive": 300}
    for name, count in most.items():
        loaded = set(run(code.format(name)))
        assert len(loaded) <= count, name
        assert not {
            m
            for m in loaded
            if m.startswith(("kane.motion", "kane.analysis", "kane.present", "scipy", "sympy", "llvmlite"))
        }


FAMILIES = (
    "analysis",
    "attitude",
    "beams",
    "cycles",
    "exchange",
    "fitting",
    "errors",
    "expr",
    "figures",
    "integrators",
    "joints",
    "loads",
    "solids",
)


def test_names_are_imported_for_type_checkers_from_where_they_come():
    """What `from … import …` says to type checkers is what the table says at run time; `*` stands for a family's own list."""
    said = dict[str, str]()
    for node in ast.walk(ast.parse(Path(kn.__file__).read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("kane."):
            said |= {a.name: node.module for a in node.names if a.name not in ("*", "offered")}
    families = {name: getattr(kn, family) for family in FAMILIES for name in getattr(kn, family).__all__}
    places = kn.__getattr__.places
    assert set(places) == {*said, *families, *FAMILIES}
    assert {name: f"kane{places[name][0]}" for name in said} == said
    for name, family in families.items():
        assert getattr(family, name) is getattr(kn, name), name


@pytest.mark.parametrize(
    ("family", "name", "meant"),
    [("solids", "disk", "thin_disk"), ("joints", "hinge", "pin"), ("loads", "sprng", "linear_spring")],
)
def test_misspelt_names_of_families(family, name, meant):
    with pytest.raises(
        AttributeError, match=f"Expected an attribute of module kane.{family}, got '{name}'. Did you mean {meant}"
    ):
        getattr(getattr(kn, family), name)


def test_families_list_each_name_once():
    """A name stands in one family; `dir` shows what it lists."""
    names = [name for family in FAMILIES for name in getattr(kn, family).__all__]
    assert len(set(names)) == len(names)
    assert all(set(getattr(kn, family).__all__) <= set(dir(getattr(kn, family))) for family in FAMILIES)
    assert len(kn.__all__) <= 120


@pytest.mark.slow
def test_names_mean_the_same_whatever_was_imported_before():
    """A submodule of the same name must not take a function's place."""
    names = ("simulate", "report", "to_sympy", "from_sympy", "Solution")
    code = (
        "import importlib, kane, pkgutil\n"
        "for m in pkgutil.walk_packages(kane.__path__, 'kane.'):\n"
        "    if not m.name.endswith('__main__'): importlib.import_module(m.name)\n"
        f"for name in {names}: print(name, callable(getattr(kane, name)), type(getattr(kane, name)).__name__)\n"
        "names = kane.__all__; from kane import *; print(*[n for n in names if n not in globals()])"
    )
    words = run(code)
    assert words[::3] == list(names)
    assert words[1::3] == ["True"] * len(names)
    assert set(words[2::3]) <= {"function", "type"}, words


@pytest.mark.slow
def test_packages_offer_what_they_say_whatever_was_imported_before():
    code = (
        "import importlib, kane, pkgutil, sys, types\n"
        "for m in pkgutil.walk_packages(kane.__path__, 'kane.'):\n"
        "    if not m.name.endswith('__main__'): importlib.import_module(m.name)\n"
        "offers = [m.__getattr__ for m in list(sys.modules.values()) if hasattr(m, '__path__') and m.__name__.startswith('kane.')\n"
        "          and '__getattr__' in vars(m)]\n"
        "print(len(offers))\n"
        "for o in offers:\n"
        "    for name, (path, inside) in o.places.items():\n"
        "        module = importlib.import_module(path, o.package)\n"
        "        right = getattr(module, inside) if inside else module\n"
        "        if getattr(sys.modules[o.package], name) is not right: print(o.package, name)\n"
    )
    count, *wrong = run(code)
    assert int(count) > 10
    assert wrong == []


@pytest.mark.slow
def test_deriving_loads_nothing_heavy():
    code = (
        "import sys; from kane.gallery import rolling_disk; import kane as kn\n"
        "eom = kn.derive(rolling_disk.system()); str(eom.steps)\n"
        "print(*sys.modules)"
    )
    assert {"sympy", "matplotlib", "scipy.integrate"} & set(run(code)) == set()
