# SPDX-License-Identifier: BSD-3-Clause
"""The check that no list of expressions is searched: mypy with the project's plugin refuses each way to do so."""

from pathlib import Path

import pytest

from tests.peer import require

LINES = {
    "a in several": True,
    "a not in several": True,
    "a in (a, b)": True,
    "a in [a, b]": True,
    "(a, 1) in [(b, 1)]": True,
    "several == several": True,
    "listed.index(a)": True,
    "listed.count(a)": True,
    "listed.remove(a)": True,
    "a in by_name.values()": True,
    "a in set(several)": False,
    "a in values": False,
    "a in values.keys()": False,
    "a in symbols": False,
    "symbols.index(a)": False,
    "several in {several}": False,
    '"x" in ("x", "y")': False,
}
"""Expressions, and whether they compare what has no truth value."""
HEAD = """\
from kane.expr.node import Expr
from kane.expr.symbols import Symbols
def search(a: Expr, b: Expr, several: tuple[Expr, ...], listed: list[Expr], values: dict[Expr, int],
           by_name: dict[str, Expr], symbols: Symbols[Expr]) -> None:
"""


@pytest.mark.slow
def test_searching_a_list_of_expressions_is_a_type_error(tmp_path):
    api = require("mypy.api")
    package = tmp_path / "kane" / "expr"
    package.mkdir(parents=True)
    (package / "node.py").write_text("class Expr: ...\n")
    symbols = "from typing import TypeVar\nS = TypeVar('S')\nclass Symbols(tuple[S, ...]): ...\n"
    (package / "symbols.py").write_text(symbols)
    (tmp_path / "searching.py").write_text(HEAD + "".join(f"    {line}\n" for line in LINES))
    plugin = Path(__file__).parents[1] / "requirements" / "membership.py"
    (tmp_path / "mypy.ini").write_text(
        f"[mypy]\nplugins = {plugin}\nenable_error_code = deprecated\nmypy_path = {tmp_path}\n"
    )
    told, wrong, _ = api.run(
        [f"--config-file={tmp_path / 'mypy.ini'}", f"--cache-dir={tmp_path / 'cache'}", str(tmp_path / "searching.py")]
    )
    assert not wrong
    numbers = {int(line.split(":")[1]) for line in told.splitlines() if "Expected no comparison of expressions" in line}
    first = HEAD.count("\n") + 1
    assert [k + first in numbers for k in range(len(LINES))] == list(LINES.values()), told
