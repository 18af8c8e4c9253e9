# SPDX-License-Identifier: BSD-3-Clause
"""What reports carry inside them is what VERSIONS.json says, and loads nothing."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import pytest

import kane.present
from kane.present import asset

FOLDER = Path(kane.present.__path__[0]) / "assets"
VERSIONS: dict[str, Any] = json.loads(asset("VERSIONS.json"))


def test_every_asset_is_listed() -> None:
    listed = {name for entry in VERSIONS.values() for name in entry["sha256"]}
    assert {p.name for p in FOLDER.iterdir() if p.is_file()} == listed | {"VERSIONS.json"}


@pytest.mark.parametrize("name", [(k, f) for k, entry in VERSIONS.items() for f in entry["sha256"]], ids=lambda n: n[1])
def test_hash(name: tuple[str, str]) -> None:
    package, file = name
    assert hashlib.sha256((FOLDER / file).read_bytes()).hexdigest() == VERSIONS[package]["sha256"][file]


@pytest.mark.parametrize("package", list(VERSIONS))
def test_version_and_licence(package: str) -> None:
    entry = VERSIONS[package]
    assert re.fullmatch(r"\d+\.\d+\.\d+", entry["version"])
    assert set(entry["licence_files"]) <= set(entry["sha256"])
    assert entry["version"] in asset(f"{package}.min.js")


def test_styles_load_nothing() -> None:
    css = asset("katex.min.css")
    assert css.count("@font-face") == len(VERSIONS["katex"]["fonts"])
    assert all(u.startswith("data:font/woff2;base64,") for u in re.findall(r"url\(([^)]*)", css))
    assert "@import" not in css


def test_script_can_stand_in_a_page() -> None:
    script = asset("katex.min.js").lower()
    assert "</script" not in script
    assert "<!--" not in script
