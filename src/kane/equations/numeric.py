# SPDX-License-Identifier: BSD-3-Clause
"""What is compiled, or derived anew, of equations of motion: each when it is first needed, and kept with the equations."""

from collections import OrderedDict
from collections.abc import Callable
from threading import Lock
from typing import Any, Generic, TypeVar

from kane.equations.compiled import Handle
from kane.program.build import Bundle, build_program
from kane.program.native.compiled_routine import BundleRoutine, CompiledRoutine
from kane.program.native.machine import Settings, build_library

E = TypeVar("E")
R = TypeVar("R")
T = TypeVar("T")


_MOST = 64
"""How many of those for arguments are kept: laws, outputs, sides of switches. A routine takes some 0.2 MB."""


class Kept(Generic[T]):
    """What was made, by (function, *arguments): all without arguments, and of those with some the last `_MOST` that were asked for."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._alone: dict[tuple[Any, ...], T] = {}
        self._latest: OrderedDict[tuple[Any, ...], T] = OrderedDict()

    def get(self, key: tuple[Any, ...]) -> T | None:
        """The entry of that key, None where there is none."""
        if len(key) == 1:
            return self._alone.get(key)
        with self._lock:
            if key in self._latest:
                self._latest.move_to_end(key)
            return self._latest.get(key)

    def put(self, key: tuple[Any, ...], value: T) -> None:
        """Keep an entry; the one that was not asked for the longest goes."""
        if len(key) == 1:
            self._alone[key] = value
            return
        with self._lock:
            self._latest[key] = value
            if len(self._latest) > _MOST:
                self._latest.popitem(last=False)


class Numeric(Generic[E]):
    """Routines of `equations` with one kind of `settings`, each named by the function that says what it computes.

    It must not hold the object that keeps it, so that both are forgotten together: `equations` is another one of the same parts.
    """

    def __init__(self, equations: E, settings: Settings) -> None:
        self.equations, self.settings = equations, settings
        self._values, self._routines = Kept[tuple[Any]](), Kept[BundleRoutine[Any]]()

    def value(self, make: Callable[..., T], *arguments: Any) -> T:
        """make(equations, *arguments), made once."""
        key = (make, *arguments)
        found = self._values.get(key)
        if found is None:
            found = (make(self.equations, *arguments),)
            self._values.put(key, found)
        value: T = found[0]
        return value

    def routine(self, make: Callable[..., Bundle[R]], *arguments: Any) -> BundleRoutine[R]:
        """The routine of the bundle make(equations, *arguments), compiled once."""
        key = (make, *arguments)
        routine = self._routines.get(key)
        return self._compile([key])[0] if routine is None else routine

    def compile(self, *makes: Callable[..., Bundle[Any]]) -> None:
        """Compile the bundles make(equations) as one module, those that are not yet: quicker than one by one, and the same code."""
        self._compile([(make,) for make in makes if self._routines.get((make,)) is None])

    def _compile(self, keys: list[tuple[Any, ...]]) -> list[BundleRoutine[Any]]:
        bundles = [make(self.equations, *arguments) for make, *arguments in keys]
        contract = self.settings.contract
        optimize = contract and self.settings.optimize
        programs = [build_program("model", b.ports, [b.task], contract, optimize=optimize) for b in bundles]
        library = build_library(programs, self.settings) if programs else None
        made = []
        for key, bundle, program in zip(keys, bundles, programs, strict=True):
            kind = Handle if [port.name for port in bundle.ports] == ["t", "x", "p", "r"] else CompiledRoutine
            flat = kind(program, bundle.name, self.settings, None, "ignore", library)
            made.append(BundleRoutine(bundle, flat))
            self._routines.put(key, made[-1])
        return made
