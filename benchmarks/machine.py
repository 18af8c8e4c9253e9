# SPDX-License-Identifier: BSD-3-Clause
"""What was measured on: processor, compiler, versions."""

import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = (
    "kane",
    "numpy",
    "llvmlite",
    "casadi",
    "heyoka",
    "pin",
    "mujoco",
    "sympy",
    "pydy",
    "Cython",
    "exudyn",
    "scipy",
    "numba",
    "jax",
    "diffrax",
)


def processor() -> str:
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def compiler(cc: str) -> str:
    """The first line of the compiler's --version."""
    return subprocess.run([cc, "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]


def versions() -> dict[str, str]:
    """Versions of the packages that are installed, Python's too."""
    found = {"Python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
