# SPDX-License-Identifier: BSD-3-Clause
"""The table of integrators in machine code: a new one takes a file and a row here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

from kane.motion.steppers.gauss import STAGES, gauss_dense, gauss_end, gauss_kernel
from kane.motion.steppers.midpoint import ROWS, midpoint_kernel
from kane.numeric.arrays import Array
from kane.program.kernel.language import Kernel
from kane.program.native.entry import CompiledKernel
from kane.program.native.machine import Settings


@dataclass(frozen=True, slots=True)
class Integrator:
    """An integrator: its kernel, and the length of its array `work` for n components.

    It evaluates rates at `width` states at once, and detects events if it `watches`. If it is `driven`, inputs may be functions in
    Python, which it calls at each stage: no stage is beyond the end of the step, where they may jump or be undefined. A `fixed` one
    takes steps of size `max_step`. Options of the kernel: `held=True` for constraints, if it `holds` these; `watched=True` for
    events, and `sided=True` for switches too; `cornered=True`, if it `collocates`, for rates with corners, which its stages alone may
    miss; `queued=True`, if it `queues`, for many instances in lanes. An `implicit` one takes derivatives of the rates. For one that
    watches, `dense(given, h, start)` is the state along the computed step, and `end(n)` the index of its end in `work`.
    """

    name: str
    kernel: Callable[..., Kernel]
    work: Callable[[int], int]
    width: int = 1
    watches: bool = False
    driven: bool = False
    fixed: bool = False
    holds: bool = False
    implicit: bool = False
    collocates: bool = False
    queues: bool = False
    dense: Callable[[Mapping[str, Any], float, float], Callable[[Array], Array]] | None = None
    end: Callable[[int], int] | None = None


def _late(module: str, name: str) -> Callable[..., Any]:
    """A function of a stepper's module, imported at its first call since the import of coefficients takes time."""
    return lambda *args, **options: getattr(import_module(f"kane.motion.steppers.{module}"), name)(*args, **options)


def _explicit(name: str, driven: bool = True, fixed: bool = False) -> Integrator:
    """The integrator whose tableau is in the module of its name, in capitals; a `driven` one has no stage beyond the step."""

    def of_tableau(function: str) -> Callable[..., Any]:
        return lambda *args, **options: _late("explicit", function)(tableau(name), *args, **options)

    return Integrator(
        name,
        of_tableau("explicit_kernel"),
        of_tableau("explicit_work"),
        watches=True,
        driven=driven,
        fixed=fixed,
        holds=True,
        queues=True,
        dense=of_tableau("explicit_dense"),
        end=of_tableau("explicit_end"),
    )


def tableau(name: str) -> Any:
    """The `Tableau` of an explicit method."""
    return getattr(import_module(f"kane.motion.steppers.{name}"), name.upper())


GAUSS16 = Integrator(
    "gauss16",
    gauss_kernel,
    lambda n: (4 * n + 1) * STAGES + 3 * n,
    STAGES,
    watches=True,
    holds=True,
    collocates=True,
    dense=gauss_dense,
    end=gauss_end,
)
RADAU9 = Integrator(
    "radau9",
    _late("radau", "radau_kernel"),
    _late("radau", "radau_work"),
    watches=True,
    driven=True,
    holds=True,
    implicit=True,
    dense=_late("radau", "radau_dense"),
    end=_late("radau", "radau_end"),
)
MIDPOINT = Integrator("midpoint", midpoint_kernel, lambda n: ROWS * n, driven=True, fixed=True)
EXPLICIT = (
    _explicit("dop853"),
    _explicit("tsitpap8", driven=False),
    _explicit("vern9"),
    _explicit("tsit5"),
    _explicit("rk4", fixed=True),
)
"""The explicit Runge–Kutta methods."""
INTEGRATORS = {i.name: i for i in (GAUSS16, *EXPLICIT, MIDPOINT, RADAU9)}
"""All integrators, by their names as `method` of `simulate`."""


@cache
def compiled(
    name: str,
    settings: Settings,
    held: bool = False,
    watched: bool = False,
    cornered: bool = False,
    sided: bool = False,
) -> CompiledKernel:
    """A compiled integrator: one kernel for all models, with variants for constraints, events, switches, and corners."""
    asked = {"held": held, "watched": watched, "sided": sided, "cornered": cornered and INTEGRATORS[name].collocates}
    return CompiledKernel(INTEGRATORS[name].kernel(**{what: True for what, so in asked.items() if so}), settings)
