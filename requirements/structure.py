# SPDX-License-Identifier: BSD-3-Clause
"""The length of functions, part of `make check`; complexity is ruff's, rings of modules are import-linter's."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src"
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


def main() -> int:
    """Print the long functions; 1 if there are any."""
    found = list(long_functions())
    if found:
        print(f"Functions of more than {LONGEST} lines, docstring apart:\n  " + "\n  ".join(found))
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
