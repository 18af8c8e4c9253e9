# SPDX-License-Identifier: BSD-3-Clause
"""The names that a package offers, imported when they are first used (PEP 562)."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def offered(package: str, names: Mapping[str, str]) -> Callable[[str], Any]:
    """The `__getattr__` of a package that offers `names`: those of each module, separated by spaces; "." offers modules themselves."""
    modules = {name: module for module, listed in names.items() for name in listed.split()}

    def get(name: str) -> Any:
        module = modules.get(name)
        if module is None:
            from kane.errors import MissingAttributeError

            raise MissingAttributeError(import_module(package), name)
        found = import_module(f"{package}.{module}")
        value = found if module.rpartition(".")[2] == name and not hasattr(found, name) else getattr(found, name)
        import_module(package).__dict__[name] = value
        return value

    return get
