# SPDX-License-Identifier: BSD-3-Clause
"""CVODE of SUNDIALS (the extra `stiff`), with the interface of SciPy's solvers.

Backward differentiation formulas of order 1 to 5 with variable steps: Hindmarsh, A. C. and others (2005), SUNDIALS: suite of
nonlinear and differential/algebraic equation solvers, ACM TOMS 31, 363–396, sec. 2. The Jacobian J is exact; for large sparse systems
only its nonzero entries are passed.
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from kane.errors import SimulationError
from kane.numeric.arrays import Array, Mask


def initial_step(
    rate: Callable[[float, Array], Array], tolerances: tuple[float, float], t: float, y: Array, end: float
) -> float:
    """The length of the first step, up to `end`, for a method of order 2; `tolerances` are the relative and the absolute one."""
    rtol, atol = tolerances
    scale, now = atol + np.abs(y) * rtol, rate(t, y)
    size, speed = np.abs(y / scale).max(), np.abs(now / scale).max()
    tried = min(0.01 * size / speed if min(size, speed) > 1e-5 else 1e-6, end - t)
    change = np.abs((rate(t + tried, y + tried * now) - now) / scale).max() / tried
    most = max(speed, change)
    step = (0.01 / most) ** (1 / 2) if most > 1e-15 else max(1e-6, tried * 1e-3)
    return float(min(100 * tried, step, end - t)) if np.isfinite(step) else float(tried)


CVODE = "cvode"
"""The name of the method in `simulate`."""
_ORDER = 5
_SHARES = (1 - np.cos(np.pi * np.arange(_ORDER + 1) / _ORDER)) / 2
"""Shares of a step at which its polynomial is evaluated; the last one is the end, from which the solver continues."""
_POWERS = np.linalg.inv(np.vander(_SHARES, increasing=True))
_LARGE, _SPARSE = 500, 0.05
"""Number of states from which on, and density up to which, J is sparse; smaller matrices are factorized faster as dense ones."""
_LEAST = 4
"""Spacings of numbers near t below which a step counts as none."""


def check_installed() -> None:
    """Check that the package is installed.

    Raises
    ------
    SimulationError
        if it is not
    """
    try:
        import sksundae.cvode  # noqa: F401
    except ImportError as error:
        raise SimulationError(
            f"Expected the package scikit-sundae for method={CVODE!r}, got none. Install it, pip install 'kane[stiff]', or "
            'use method="radau9", which is for stiff equations too and needs no package.'
        ) from error


class Polynomial:
    """The interpolant of a step: `polynomial(t)` is the state (n) at a time, or the states (n × k) at k times."""

    __slots__ = ("_coefficients", "_length", "_start")

    def __init__(self, start: float, end: float, states: Array) -> None:
        self._start, self._length = start, end - start
        self._coefficients = _POWERS @ states

    def __call__(self, t: Any) -> Array:
        """The states at t."""
        theta = (np.asarray(t, dtype=float) - self._start) / self._length
        return np.asarray(np.polynomial.polynomial.polyval(theta, self._coefficients), dtype=np.float64)


class CvodeSolver:
    """CVODE between t and t_bound, with the attributes and methods of SciPy's solvers that a motion uses.

    `pattern` (n × n) marks the entries of J that may be nonzero; without it all may be.
    """

    def __init__(
        self,
        fun: Callable[[float, Array], Array],
        t0: float,
        y0: Array,
        t_bound: float,
        *,
        first_step: float | None,
        rtol: float,
        atol: float,
        max_step: float,
        jac: Callable[[float, Array], Array],
        pattern: Mask | None = None,
    ) -> None:
        from sksundae import cvode

        self.t, self.t_old, self.y, self.t_bound = t0, t0, np.array(y0), t_bound
        self.status, self.nfev = "running", 0

        def rates(t: float, y: Array, out: Array) -> None:
            self.nfev += 1
            out[:] = fun(float(t), y)

        def entries(t: float, y: Array, _: Array, out: Array) -> None:
            found = jac(float(t), np.array(y))
            out[:] = found if at is None else found[at]

        # CVODE's own first step is too short to leave the threshold of an event at the start
        first = first_step or min(initial_step(fun, (rtol, atol), t0, self.y, t_bound), max_step)
        self.nfev += 2
        at: Any = None
        sparse: dict[str, Any] = {}
        if (
            pattern is not None and len(pattern) >= _LARGE
        ):  # with the diagonal, which the Newton matrix of a step contains
            whole = pattern | np.eye(len(pattern), dtype=bool)
            if whole.mean() <= _SPARSE:  # by columns, as the solver stores entries
                at, sparse = np.nonzero(whole.T)[::-1], {"linsolver": "sparse", "sparsity": whole}
        length = {} if max_step == np.inf else {"max_step": max_step}
        with warnings.catch_warnings():  # it warns that a pattern is not used for differences
            warnings.simplefilter("ignore", UserWarning)
            self._solver: Any = cvode.CVODE(
                rates, jacfn=entries, rtol=rtol, atol=atol, first_step=first, **length, **sparse
            )
        self._solver.init_step(t0, self.y)

    def step(self) -> str | None:
        """Take one step; returns an error message if it fails, else None."""
        try:
            found = self._solver.step(self.t_bound, method="onestep", tstop=self.t_bound)
        except SimulationError:  # from the functions that it calls, which name the place
            raise
        except RuntimeError as error:
            return self._failed(str(error))
        if not found.success:
            return self._failed(found.message)
        self.t_old, self.t, self.y = self.t, float(found.t), np.array(found.y)
        if self.t >= self.t_bound:
            self.status = "finished"
        elif self.t - self.t_old <= _LEAST * np.spacing(abs(self.t)):
            return self._failed("steps are shorter than the spacing of floating-point numbers")
        return None

    def _failed(self, message: str) -> str:
        self.status = "failed"
        return message.rstrip(".")

    def dense_output(self) -> Polynomial:
        """The interpolant of the last step."""
        times = self.t_old + _SHARES * (self.t - self.t_old)
        times[-1] = self.t
        # the end must be evaluated last: the solver continues from there
        return Polynomial(self.t_old, self.t, np.array([self._solver.step(float(t), method="normal").y for t in times]))
