# SPDX-License-Identifier: BSD-3-Clause
"""Files that reports carry inside them; assets/VERSIONS.json gives their versions, hashes and licences."""

from __future__ import annotations

from functools import cache
from importlib.resources import files


@cache
def asset(name: str) -> str:
    """Text of a file in present/assets."""
    return files("kane.present").joinpath("assets", name).read_text(encoding="utf-8")
