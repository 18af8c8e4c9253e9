# SPDX-License-Identifier: BSD-3-Clause
"""What `make check` asks beside ruff's complexity and import-linter's rings: the length of functions, what tests import.

Tests reach the library by its public names or by what a package offers in its `__init__`, so that modules can move behind it.
"""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src"
LONGEST = 60
"""Lines of a function, its docstring apart."""


def long_functions() -> Iterator[str]:
    """Functions of more than `LONGEST` lines."""
    for path in sorted(SOURCE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                first = node.body[0]
                documented = ast.get_docstring(node) is not None
                described = (first.end_lineno or 0) - first.lineno + 1 if documented else 0
                length = (node.end_lineno or 0) - node.lineno + 1 - described
                if length > LONGEST:
                    yield f"{path.relative_to(SOURCE)}:{node.lineno}: {node.name} has {length} lines"


def deep_imports() -> Iterator[str]:
    """Imports of the tests that name a module within a package; systems of the gallery are each a module on purpose."""
    for path in sorted((ROOT / "tests").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            named = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module:
                named = [node.module]
            for name in named:
                package, _, module = name.removeprefix("kane.").partition(".")
                if name.startswith("kane.") and module and package != "gallery":
                    yield f"{path.relative_to(ROOT)}:{node.lineno}: {name}"


CHECKS = {
    f"Functions of more than {LONGEST} lines, docstring apart": long_functions,
    "Imports in tests of modules within a package": deep_imports,
}


def main() -> int:
    """Print what is found; 1 if there is any."""
    found = {title: list(check()) for title, check in CHECKS.items()}
    for title, lines in found.items():
        if lines:
            print(f"{title}:\n  " + "\n  ".join(lines))
    return int(any(found.values()))


if __name__ == "__main__":
    sys.exit(main())
