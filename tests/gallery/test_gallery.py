# SPDX-License-Identifier: BSD-3-Clause
"""The table of the gallery, and what every module in it has."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import kane as kn
import kane.gallery
from kane.gallery import GALLERY, choose, load


def test_every_module_with_a_system_is_in_the_table() -> None:
    folder = Path(kane.gallery.__file__).parent
    assert {p.stem for p in folder.rglob("*.py") if "\ndef system(" in p.read_text("utf-8")} == set(GALLERY)
    assert all(path.startswith("kane.gallery.") and path.endswith(f".{name}") for name, path in GALLERY.items())
    assert all(getattr(kane.gallery, name) is load(name) for name in GALLERY)


@pytest.mark.parametrize("name", GALLERY)
def test_title_sources_and_system(name: str) -> None:
    module = load(name)
    assert module.TITLE
    assert "\n" not in module.TITLE
    assert module.SOURCES
    assert all(isinstance(s, str) for s in module.SOURCES)
    system = module.system()
    assert isinstance(system, kn.System)
    assert all(p.default is not None and p.description for p in system.parameters)


@pytest.mark.parametrize("name", [n for n in GALLERY if hasattr(load(n), "SPEEDS")])
def test_choices_of_speeds(name: str) -> None:
    module = load(name)
    assert len(module.SPEEDS) >= 3
    assert module.SPEEDS[0] == inspect.signature(module.system).parameters["speeds"].default
    systems = [module.system(speeds=s) for s in module.SPEEDS]
    # Other speeds are other definitions of the same coordinates.
    for system in systems:
        assert all(a is b for a, b in zip(system.coordinates, systems[0].coordinates, strict=True))
    definitions = {tuple(str(d) for d in system.speeds.values()) for system in systems}
    assert len(definitions) == len(systems)
    with pytest.raises(kn.ModelError, match=", ".join(module.SPEEDS)):
        module.system(speeds="none")


def test_unknown_name() -> None:
    with pytest.raises(kn.ModelError, match="spinning_top"):
        load("rolling_stone")


def test_choose() -> None:
    assert choose({"own": {}}, "rates") == "rates"
    assert choose({"rates": {1: 2}, "own": {}}, "rates") == {1: 2}
    with pytest.raises(kn.ModelError, match="one of rates, own, got 'other'"):
        choose({"own": {}}, "other")


@pytest.mark.slow
def test_it_is_imported_only_when_asked_for() -> None:
    code = (
        "import sys, kane; assert not [m for m in sys.modules if m.startswith('kane.gallery')]; "
        "import kane.gallery; assert not [m for m in sys.modules if m.startswith('kane.gallery.')]"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
