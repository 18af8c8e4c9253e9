# SPDX-License-Identifier: BSD-3-Clause
"""The shape of the source, part of `make check`: no cycle among modules, no long function.

Imports for types and imports inside functions count, as a module that needs another one to be understood needs it.
"""

import ast
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp

SOURCE = Path(__file__).parents[1] / "src"
LONGEST = 60
"""Lines of a function, its docstring apart."""


def cycle() -> list[str]:
    """Modules that import each other in a ring; empty where there is none."""
    graph = grimp.build_graph("kane", cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


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
    """Print what is amiss; 1 if anything is."""
    ring, long = cycle(), list(long_functions())
    if ring:
        print("Modules import each other in a ring:\n  " + "\n  imports ".join(reversed(ring)))
    if long:
        print(f"Functions of more than {LONGEST} lines, docstring apart:\n  " + "\n  ".join(long))
    return int(bool(ring or long))


if __name__ == "__main__":
    sys.exit(main())
