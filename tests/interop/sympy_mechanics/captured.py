# SPDX-License-Identifier: BSD-3-Clause
"""Models of SymPy's own tests: these run, and every KanesMethod and LagrangesMethod that makes equations meanwhile is imported."""

import importlib
import inspect
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import sympy.physics.mechanics as me
from sympy.physics.mechanics import functions, kane, lagrange

import kane as kn


class Captured(NamedTuple):
    """An import: where the model stands, what it became, or the error that names why not."""

    place: str
    imported: Any
    error: Exception | None


@contextmanager
def capturing(found: list[Captured], place: list[str], *modules: Any) -> Iterator[None]:
    """Import every method that makes its equations; of Lagrangians it is noted of what frame and bodies they were made."""
    lagrangians: dict[Any, tuple[Any, list[Any]]] = {}
    busy: list[bool] = []

    def note(method: Any, **stated: Any) -> None:
        if busy:
            return
        busy.append(True)
        try:
            found.append(Captured(place[0], kn.from_sympy_mechanics(method, **stated), None))
        except kn.KaneError as error:
            found.append(Captured(place[0], None, error))
        finally:
            busy.clear()

    def by_kane(self: Any, bodies: Any = None, loads: Any = None) -> Any:
        made = kanes_equations(self, bodies, loads)
        note(self)
        return made

    def by_lagrange(self: Any) -> Any:
        made = lagranges_equations(self)
        frame, bodies = lagrangians.get(self._L[0], (None, None))
        note(self, bodies=self._bodies or bodies, **({"frame": frame} if frame else {}))
        return made

    def lagrangian(frame: Any, *bodies: Any) -> Any:
        whole = plain(frame, *bodies)
        lagrangians[whole] = (frame, list(bodies))
        return whole

    kanes_equations, lagranges_equations = (
        kane.KanesMethod.kanes_equations,
        lagrange.LagrangesMethod.form_lagranges_equations,
    )
    plain, holders = functions.Lagrangian, [m for m in (functions, me, *modules) if hasattr(m, "Lagrangian")]
    kane.KanesMethod.kanes_equations, lagrange.LagrangesMethod.form_lagranges_equations = by_kane, by_lagrange
    for holder in holders:
        holder.Lagrangian = lagrangian
    try:
        yield
    finally:
        kane.KanesMethod.kanes_equations = kanes_equations
        lagrange.LagrangesMethod.form_lagranges_equations = lagranges_equations
        for holder in holders:
            holder.Lagrangian = plain


def models_of(name: str, without: tuple[str, ...] = ()) -> list[Captured]:
    """The models of one module of SymPy's tests; a test that fails by itself keeps those it had made before."""
    module = importlib.import_module(f"sympy.physics.mechanics.tests.{name}")
    found: list[Captured] = []
    place = [""]
    with capturing(found, place, module), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for title, test in _tests(module):
            if title not in without:
                place[0] = f"{name}.{title}"
                test()
    return found


def _tests(module: Any) -> Iterator[tuple[str, Any]]:
    for title, own in list(vars(module).items()):
        if title.startswith("test") and inspect.isfunction(own):
            yield title, own
        elif title.startswith("Test") and inspect.isclass(own):
            for name, method in vars(own).items():
                plain = inspect.isfunction(method) and list(inspect.signature(method).parameters) == ["self"]
                if name.startswith("test") and plain:
                    yield f"{title}.{name}", lambda own=own, name=name: _set_up(own(), name)


def _set_up(case: Any, name: str) -> None:
    for title in dir(case):
        prepare = getattr(getattr(case, title), "__wrapped__", None)
        if title.startswith("_") and title.endswith("setup") and prepare is not None:
            prepare(case)
    getattr(case, name)()
