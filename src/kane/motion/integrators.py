# SPDX-License-Identifier: BSD-3-Clause
"""Integrators as records of their options, which `simulate` and `prepare` take as `method=`.

A record is equivalent to the name of a method and keywords; `options` are these keywords.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from kane.errors import Attributes, SimulationError
from kane.motion.methods import AUTO
from kane.motion.solvers.cvode import CVODE


@dataclass(frozen=True, slots=True)
class _Named(Attributes):
    """A record of options of the integrator that `method=name` names."""

    name: ClassVar[str] = ""

    @property
    def options(self) -> dict[str, Any]:
        """The options that are given, by the keywords of `simulate`."""
        given = {f.name: getattr(self, f.name) for f in fields(self)}
        return {"max_step" if name == "step" else name: value for name, value in given.items() if value is not None}


@dataclass(frozen=True, slots=True, kw_only=True)
class AdaptiveStep(_Named):
    """Options of an integrator with adaptive steps; None stands for the default of `kn.simulate`.

    Attributes
    ----------
    rtol, atol : relative and absolute tolerance of the error of a step, the latter in the units of coordinates and speeds
    max_step : the largest step (s)
    first_step : the length of the first step (s)
    """

    rtol: float | None = None
    atol: float | None = None
    max_step: float | None = None
    first_step: float | None = None


@dataclass(frozen=True, slots=True)
class FixedStep(_Named):
    """Options of an integrator with a fixed step size.

    Attributes
    ----------
    step : the step size (s)
    """

    step: float


class Auto(AdaptiveStep):
    """The integrator is chosen for the motion: one in machine code where possible, and an implicit one for stiff equations."""

    __slots__ = ()
    name = AUTO


class Gauss16(AdaptiveStep):
    """Gauss collocation with eight stages, order 16; all stages are evaluated together in vector instructions.

    Source: Hairer, Lubich & Wanner, *Geometric Numerical Integration*, 2nd ed. 2006, sec. II.1.3.
    """

    __slots__ = ()
    name = "gauss16"


class Dop853(AdaptiveStep):
    """The explicit Runge–Kutta method of order 8 by Dormand and Prince in machine code, with dense output of order 7.

    Source: Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, 2nd ed. 1993, sec. II.5, II.6.
    """

    __slots__ = ()
    name = "dop853"


class Tsitpap8(AdaptiveStep):
    """The explicit Runge–Kutta method of order 8 by Tsitouras and Papakostas, efficient at loose tolerances.

    Source: Tsitouras & Papakostas, *Cheap error estimation for Runge–Kutta methods*, SIAM J. Sci. Comput. 20 (1999) 2067–2088.
    """

    __slots__ = ()
    name = "tsitpap8"


class Vern9(AdaptiveStep):
    """The explicit Runge–Kutta method of order 9 by Verner, with dense output of order 8.

    Source: Verner, *Numerically optimal Runge–Kutta pairs with interpolants*, Numerical Algorithms 53 (2010) 383–396.
    """

    __slots__ = ()
    name = "vern9"


class Tsit5(AdaptiveStep):
    """The explicit Runge–Kutta method of order 5 by Tsitouras.

    Source: Tsitouras, *Runge–Kutta pairs of order 5(4) satisfying only the first column simplifying assumption*, Computers &
    Mathematics with Applications 62 (2011), sec. 3.2.
    """

    __slots__ = ()
    name = "tsit5"


class Radau9(AdaptiveStep):
    """Radau IIA collocation with five stages, order 9, for stiff equations, with exact derivatives.

    Source: Hairer & Wanner, *Solving Ordinary Differential Equations II*, 2nd ed. 1996, sec. IV.8.
    """

    __slots__ = ()
    name = "radau9"


class Rk4(FixedStep):
    """The classical explicit Runge–Kutta method, order 4, with a fixed step size.

    Source: Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, 2nd ed. 1993, sec. II.1.
    """

    __slots__ = ()
    name = "rk4"


class Midpoint(FixedStep):
    """The implicit midpoint rule, order 2 and symplectic, with a fixed step size.

    Source: Hairer, Lubich & Wanner, *Geometric Numerical Integration*, 2nd ed. 2006, sec. II.1.3.
    """

    __slots__ = ()
    name = "midpoint"


class ScipyRK23(AdaptiveStep):
    """SciPy's RK23, stepped from Python."""

    __slots__ = ()
    name = "RK23"


class ScipyRK45(AdaptiveStep):
    """SciPy's RK45, stepped from Python."""

    __slots__ = ()
    name = "RK45"


class ScipyDOP853(AdaptiveStep):
    """SciPy's DOP853, stepped from Python."""

    __slots__ = ()
    name = "DOP853"


class ScipyRadau(AdaptiveStep):
    """SciPy's Radau, for stiff equations, stepped from Python."""

    __slots__ = ()
    name = "Radau"


class ScipyBDF(AdaptiveStep):
    """SciPy's BDF, for stiff equations, stepped from Python."""

    __slots__ = ()
    name = "BDF"


class Lsoda(AdaptiveStep):
    """SciPy's LSODA, which switches between methods for stiff and nonstiff equations, stepped from Python."""

    __slots__ = ()
    name = "LSODA"


class Cvode(AdaptiveStep):
    """CVODE of SUNDIALS, backward differentiation of order 1 to 5 for stiff equations (`pip install 'kane[stiff]'`)."""

    __slots__ = ()
    name = CVODE


def spelled(given: Mapping[str, Any]) -> dict[str, Any]:
    """Options of a motion, with a record as `method` replaced by a name and keywords.

    Raises
    ------
    SimulationError
        if an option is given both in the record and as a keyword
    """
    own = dict(given)
    record = own["method"]
    if not isinstance(record, _Named):
        return own
    twice = [name for name in record.options if own[name] is not None]
    if twice:
        raise SimulationError(
            f"Expected {' and '.join(f'{name}=' for name in twice)} in method={record!r} or beside it, got both. Leave one out."
        )
    return own | record.options | {"method": record.name}
