# SPDX-License-Identifier: BSD-3-Clause
"""The texts that sources mark for translation: literals given to the markers in Python, and what Jinja finds in templates."""

import ast
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

from kane.present import environment

MARKERS = {"tr": 1, "N_": 1, "trn": 2, "page_table": None}
"""Their arguments, from the first on, that are texts."""
PRESENT = Path(str(files("kane.present")))


def in_python() -> Iterator[str]:
    """The texts of Python; of a count the text of one."""
    for path in PRESENT.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in MARKERS:
                given = node.args[: MARKERS[node.func.id]]
                texts = [a.value for a in given if isinstance(a, ast.Constant) and isinstance(a.value, str)]
                yield from filter(None, texts[:1] if node.func.id == "trn" else texts)


def in_templates() -> Iterator[str]:
    """The texts of templates; of a count the text of one."""
    made: Any = environment(trim_blocks=True, lstrip_blocks=True)
    for path in PRESENT.rglob("templates/*.html"):
        for _, _, text in made.extract_translations(path.read_text(encoding="utf-8")):
            yield text[0] if isinstance(text, tuple) else text
