# SPDX-License-Identifier: BSD-3-Clause
"""`Fit`: the result of a fit, with standard errors."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kane.equations.state import State
from kane.errors import Attributes
from kane.expr.node import Expr
from kane.expr.symbols import Symbol
from kane.motion.fitting.measured import Measurements
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array


class FittedRun(NamedTuple):
    """The result for one data set: estimates and standard errors of the unknowns, including its initial values."""

    values: Mapping[Symbol, float]
    errors: Mapping[Symbol, float]
    residuals: Mapping[str, Array]
    motion: Solution
    start: State
    data: Measurements


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Attributes):
    """The result of `kn.fitting.fit`: estimates of the unknowns, and the motion with them; of several sets of data, of the first.

    Attributes
    ----------
    values : {symbol: estimate} of the unknowns
    errors : {symbol: standard error}
    covariance : of the estimates (k × k), in the order of the unknowns, followed by the initial values of further sets
    sigma : {column: standard deviation of the measurements}, as given or estimated
    residuals : {column: measured values minus those of the motion (n)}, NaN for missing data
    motion : Solution
        the fitted motion, at the times of the data
    parameters : values of all parameters, for `kn.simulate(…, parameters=fit.parameters)`
    start : State
    gap : the largest discontinuity between segments, relative to the magnitude of a state; 0 for one segment
    steps : number of evaluations of the motion
    runs : values, errors, residuals, motion, start and data for each set of data
    """

    values: Mapping[Symbol, float]
    errors: Mapping[Symbol, float]
    covariance: Array
    sigma: Mapping[str, float]
    residuals: Mapping[str, Array]
    motion: Solution
    parameters: Mapping[Expr, float]
    start: State
    gap: float
    steps: int
    runs: tuple[FittedRun, ...]

    @property
    def correlation(self) -> Array:
        """The correlation matrix of the estimates (k × k)."""
        sizes = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(sizes, sizes))

    def __repr__(self) -> str:
        found = ", ".join(f"{s} = {v:.6g} ± {self.errors[s]:.2g}" for s, v in self.values.items())
        spread = ", ".join(f"{name} {s:.3g}" for name, s in self.sigma.items())
        return f"Fit({found}; σ {spread}; {self.steps} motions)"
