# SPDX-License-Identifier: BSD-3-Clause
"""The names that a package offers, imported when they are first used (PEP 562)."""

import gc
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any


@contextmanager
def _uncollected() -> Iterator[None]:
    """The collector waits: modules leave no cycles to be found, and hundreds of them would be gone through again and again."""
    on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if on:
            gc.enable()


class Offered:  # no dataclass: `import kane` would take twice as long
    """The `__getattr__` of a package: `places` gives of each name its module, relative to the package, and its name there.

    That is "" for a module itself.
    """

    __slots__ = ("package", "places")

    def __init__(self, package: str, places: Mapping[str, tuple[str, str]]) -> None:
        self.package = package
        self.places = places

    def __call__(self, name: str) -> Any:
        """Import a name, and keep it in the package."""
        if name not in self.places:
            from kane.errors import MissingAttributeError

            raise MissingAttributeError(import_module(self.package), name)
        module, inside = self.places[name]
        with _uncollected():
            value = import_module(module, self.package)
        value = getattr(value, inside) if inside else value
        import_module(self.package).__dict__[name] = value
        return value


def offered(package: str, names: Mapping[str, str]) -> Offered:
    """What a package offers: by the path of a module, the names there, separated by spaces.

    Paths are relative to the package, ".units.table" to the one that it is in. "" or a path with "." behind stands for modules.
    Without names it is a family, which has imported what it offers. `dir` shows `__all__` alone, where there is one.
    """
    own = vars(import_module(package))
    own["__dir__"] = lambda: sorted(own.get("__all__", own))
    places = dict[str, tuple[str, str]]()
    for path, listed in names.items():
        for name in listed.split():
            modules = not path or path.endswith(".")
            places[name] = (f".{path}{name}", "") if modules else (f".{path}", name)
    return Offered(package, places)
