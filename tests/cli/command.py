# SPDX-License-Identifier: BSD-3-Clause
"""Running the `kane` command in this process, and model files for it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from kane.cli import app

HEAD = """import kane as kn

def system():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y = kn.coordinates("x, y", "m", "position")
    m = kn.parameter("m", 2.0, "kg", "mass")
    k = kn.parameter("k", None, "N/m", "stiffness")
    P = O.at("P", x * N.x + y * N.y)
"""
SPRING = HEAD + (
    "    return kn.System(N, bodies=[kn.Particle('bob', P, m)], speeds='rates', loads=[kn.linear_spring(P, O, k)])\n"
)


def kane(*words: Any, code: int = 0) -> Any:
    """Run the command, which must leave with `code` and without a traceback of its own."""
    result = CliRunner().invoke(app, [str(w) for w in words])
    assert result.exit_code == code, (result.output, result.exception)
    assert result.exception is None or isinstance(result.exception, SystemExit)
    return result


def line(text: str) -> str:
    """The text with its lines joined: where they break depends on the length of names."""
    return " ".join(text.split())


def from_json(*words: Any, code: int = 0) -> Any:
    """What the command prints on stdout, which must be JSON and nothing else."""
    return json.loads(kane(*words, "--json", code=code).stdout)


def written(folder: Path, text: str, name: str = "model.py") -> Path:
    """A model file."""
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file
