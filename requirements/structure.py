# SPDX-License-Identifier: BSD-3-Clause
"""What `make check` asks beside ruff and import-linter: sizes of functions and packages, what tests import, names that recur.

A package has a budget of lines and a folder one of modules, `requirements/budget.json`: who adds cuts elsewhere first, or says why in
the commit that raises it. `--write` lowers the budgets to what is there.

Tests reach the library by its public names or by what a package offers in its `__init__`, so that modules can move behind it.
"""

import ast
import json
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src"
BUDGET = Path(__file__).with_name("budget.json")
LONGEST = 60
"""Lines of a function, its docstring apart."""
MODULES = 20
"""Modules of a folder besides `__init__`, unless the budget names it."""
STEP = 50
"""Budgets of lines are multiples of this."""
PATTERNS = {
    "": "a family of public names is called as the module that it gathers them from",
    "cli": "a command is called as the function that it runs",
    "interop/autolev": "a format has a module for each part of a model, called as that of the model",
    "interop/python_source": "the same",
    "interop/robots": "the same",
    "interop/sympy_mechanics": "the same",
}
"""Folders of which modules may be called as one elsewhere, and why."""
TABLES = "table"
"""What the module is called, in any package, of which the rows are what it offers by name."""


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


def lines() -> dict[str, int]:
    """Lines of each package, and of the modules beside them."""
    found: dict[str, int] = {}
    for path in sorted((SOURCE / "kane").rglob("*.py")):
        first = path.relative_to(SOURCE / "kane").parts[0]
        name = first if path.parent != SOURCE / "kane" else "modules at the top"
        found[name] = found.get(name, 0) + len(path.read_text(encoding="utf-8").splitlines())
    return found


def modules() -> dict[str, int]:
    """Modules of each folder."""
    folders = [
        folder for folder in (SOURCE / "kane").rglob("*") if folder.is_dir() and (folder / "__init__.py").is_file()
    ]
    return {str(folder.relative_to(SOURCE)): len([*folder.glob("*.py")]) - 1 for folder in sorted(folders)}


def over_budget() -> Iterator[str]:
    """Packages with more lines, and folders with more modules, than they may have."""
    budget = json.loads(BUDGET.read_text(encoding="utf-8"))
    for name, count in lines().items():
        if count > budget["lines"].get(name, 0):
            yield f"{name}: {count} lines, at most {budget['lines'].get(name, 0)}"
    for name, count in modules().items():
        if count > budget["modules"].get(name, MODULES):
            yield f"{name}: {count} modules, at most {budget['modules'].get(name, MODULES)}"


def lowered_budget() -> dict[str, dict[str, int]]:
    """The budget that what is there needs, nowhere above the present one."""
    old = json.loads(BUDGET.read_text(encoding="utf-8"))
    needed = {name: -(-count // STEP) * STEP for name, count in lines().items()}
    return {
        "lines": {name: min(count, old["lines"].get(name, count)) for name, count in needed.items()},
        "modules": {name: count for name, count in modules().items() if count > MODULES},
    }


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


def shadowed_names() -> Iterator[str]:
    """Names that a package offers lazily and that one of its modules has, too: once that is imported, it takes the name's place."""
    for path in sorted((ROOT / "src/kane").rglob("__init__.py")):
        if path.parent == ROOT / "src/kane":
            continue  # tests/test_api.py asks kane itself
        tables = [n for n in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(n, ast.Dict)]
        pairs = [pair for table in tables for pair in zip(table.keys, table.values, strict=True)]
        texts = [
            v.value for k, v in pairs if isinstance(k, ast.Constant) and k.value and isinstance(v, ast.Constant)
        ]  # "" is for modules
        modules = {p.stem for p in path.parent.iterdir()}
        for name in sorted(modules.intersection(" ".join(map(str, texts)).split())):
            yield f"{path.relative_to(ROOT)}: {name}"


def repeated_names() -> Iterator[str]:
    """Names of classes and of modules that stand for two things, those of `PATTERNS` apart."""
    places: dict[str, list[str]] = {}
    for path in sorted((SOURCE / "kane").rglob("*.py")):
        place = path.relative_to(SOURCE / "kane")
        folder = place.parent.as_posix().removeprefix(".")
        if folder not in PATTERNS and path.stem not in ("__init__", TABLES):
            places.setdefault(f"module {path.stem}", []).append(str(place))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                places.setdefault(f"class {node.name}", []).append(f"{place}:{node.lineno}")
    return (f"{name}: {', '.join(found)}" for name, found in sorted(places.items()) if len(found) > 1)


CHECKS = {
    "Names that stand for two things": repeated_names,
    "Names of packages that are names of their modules": shadowed_names,
    f"Functions of more than {LONGEST} lines, docstring apart": long_functions,
    "Over the budget": over_budget,
    "Imports in tests of modules within a package": deep_imports,
}


def main() -> int:
    """Print what is found; 1 if there is any. With --write, lower the budgets before."""
    if "--write" in sys.argv[1:]:
        BUDGET.write_text(json.dumps(lowered_budget(), indent=1) + "\n", encoding="utf-8")
    found = {title: list(check()) for title, check in CHECKS.items()}
    for title, lines in found.items():
        if lines:
            print(f"{title}:\n  " + "\n  ".join(lines))
    return int(any(found.values()))


if __name__ == "__main__":
    sys.exit(main())
