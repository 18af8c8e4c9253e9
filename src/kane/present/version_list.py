# SPDX-License-Identifier: BSD-3-Clause
"""What a report of a fault should say: versions, machine, cache."""

import platform
import sys
from importlib.metadata import PackageNotFoundError, version

from kane.program.native import machine, store

_PACKAGES = ("kane", "numpy", "scipy", "llvmlite", "sympy", "matplotlib", "rich", "typer", "jinja2", "platformdirs")


def versions() -> dict[str, str]:
    """Versions of kane, of Python and of what kane is built on; the processor that code is compiled for; the cache."""
    packages = {name: _version(name) for name in _PACKAGES}
    packages["llvmlite"] = ", ".join(part.removeprefix("llvmlite ") for part in machine.versions())
    here = machine.host()
    place = store.folder()
    return {
        **packages,
        "Python": sys.version.split()[0],
        "system": platform.platform(),
        "processor": f"{here.cpu} ({here.triple}), {here.lanes} lanes of double",
        "cache": "off" if place is None else str(place),
    }


def show_versions() -> None:
    """Print `versions()`, a line each: paste it into a report of a fault."""
    rows = versions()
    width = max(map(len, rows))
    for name, value in rows.items():
        print(f"{name:{width}}  {value}")


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
