# SPDX-License-Identifier: BSD-3-Clause
"""The names that a package offers, imported when they are first used (PEP 562)."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any


class Offered:  # no dataclass: `import kane` would take twice as long
    """The `__getattr__` of a package: `modules` says where each name is; a module may be offered by its own name."""

    __slots__ = ("modules", "package")

    def __init__(self, package: str, modules: Mapping[str, str]) -> None:
        self.package = package
        self.modules = modules

    def __call__(self, name: str) -> Any:
        """Import a name, and keep it in the package."""
        module = self.modules.get(name)
        if module is None:
            from kane.errors import MissingAttributeError

            raise MissingAttributeError(import_module(self.package), name)
        found = import_module(module)
        value = found if module.endswith(f".{name}") and not hasattr(found, name) else getattr(found, name)
        import_module(self.package).__dict__[name] = value
        return value


def offered(package: str, names: Mapping[str, str]) -> Offered:
    """What a package offers: names by their modules within the package, separated by spaces."""
    return Offered(
        package, {name: f"{package}.{module}" for module, listed in names.items() for name in listed.split()}
    )
