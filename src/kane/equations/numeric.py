# SPDX-License-Identifier: BSD-3-Clause
"""What is compiled, or derived anew, of equations of motion: each when it is first needed, and kept with the equations."""

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from kane.equations.handle import Handle
from kane.program.build import build_program
from kane.program.bundle import Bundle
from kane.program.native.compiled_routine import BundleRoutine, CompiledRoutine
from kane.program.native.machine import Settings, build_library

E = TypeVar("E")
R = TypeVar("R")
T = TypeVar("T")


class Numeric(Generic[E]):
    """Routines of `equations` with one kind of `settings`, each named by the function that says what it computes.

    It must not hold the object that keeps it, so that both are forgotten together: `equations` is another one of the same parts.
    """

    def __init__(self, equations: E, settings: Settings) -> None:
        self.equations, self.settings = equations, settings
        self._values: dict[tuple[Any, ...], Any] = {}
        self._routines: dict[tuple[Any, ...], BundleRoutine[Any]] = {}

    def value(self, make: Callable[..., T], *arguments: Any) -> T:
        """make(equations, *arguments), made once."""
        key = (make, *arguments)
        if key not in self._values:
            self._values[key] = make(self.equations, *arguments)
        value: T = self._values[key]
        return value

    def routine(self, make: Callable[..., Bundle[R]], *arguments: Any) -> BundleRoutine[R]:
        """The routine of the bundle make(equations, *arguments), compiled once."""
        key = (make, *arguments)
        if key not in self._routines:
            self._compile([key])
        return self._routines[key]

    def compile(self, *makes: Callable[..., Bundle[Any]]) -> None:
        """Compile the bundles make(equations) as one module, those that are not yet: quicker than one by one, and the same code."""
        self._compile([(make,) for make in makes if (make,) not in self._routines])

    def _compile(self, keys: list[tuple[Any, ...]]) -> None:
        bundles = [make(self.equations, *arguments) for make, *arguments in keys]
        contract = self.settings.contract
        optimize = contract and self.settings.optimize
        programs = [build_program("model", b.ports, [b.task], contract, optimize=optimize) for b in bundles]
        library = build_library(programs, self.settings) if programs else None
        for key, bundle, program in zip(keys, bundles, programs, strict=True):
            kind = Handle if [port.name for port in bundle.ports] == ["t", "x", "p", "r"] else CompiledRoutine
            flat = kind(program, bundle.name, self.settings, None, "ignore", library)
            self._routines[key] = BundleRoutine(bundle, flat)
