# SPDX-License-Identifier: BSD-3-Clause
"""xarray variables with names, units and dimensions, and imports of optional packages."""

from collections.abc import Sequence
from typing import Any

from kane.numeric.arrays import Array

AXES = ("x", "y", "z")


def labelled(
    xarray: Any, name: str, values: Array, first: Sequence[str], unit: str, description: str, dims: Sequence[str] = ()
) -> Any:
    """An xarray Variable of values; its dimensions are `first`, then `dims`, by default "axis" of vectors or numbered names."""
    n = len(first)
    usual = ["axis"] if values.shape[n:] == (3,) else [f"{name}_{k}" for k in range(1, values.ndim - n + 1)]
    rest = dims or usual
    told = {"units": unit, "long_name": description or name}
    return xarray.Variable([*first, *rest], values, {k: v for k, v in told.items() if v})


def package(name: str, extra: str = "table") -> Any:
    """Imports an optional package, which an extra of the library installs.

    Raises
    ------
    ImportError
        if it is not there
    """
    from importlib import import_module

    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise ImportError(
            f"Expected the package {name}, got none. Install it, pip install 'kane[{extra}]'; sol.t, sol.q, sol.u and sol[…] need "
            "none."
        ) from error
