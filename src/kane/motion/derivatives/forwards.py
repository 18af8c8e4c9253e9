# SPDX-License-Identifier: BSD-3-Clause
"""`Sensitivities`: the derivatives of a motion, and of expressions along it, at every sample."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.dynamics.readings.quantities import asked
from kane.equations.equations import Equations
from kane.errors import Attributes, ExpressionError
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol
from kane.motion.derivatives.pulling import Laws, slopes_with_laws
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array


def slopes_along(motion: Solution, expr: Expr, by: tuple[Parameter, ...]) -> Array:
    """∂expr/∂(x, p) at the samples of a motion (samples × n + k)."""
    laws = Laws(motion.inputs)

    def slopes(eom: Equations) -> list[Expr]:
        return slopes_with_laws(eom, expr, by, laws)[1:]

    return np.stack(motion.by_sample(slopes), axis=-1)


def differentiable(motion: Solution, what: Any) -> tuple[Sequence[Expr], tuple[int, ...]]:
    """The roots and the shape of the requested quantity; ExpressionError for a list of several."""
    wanted = asked(motion.equations.derived, what)
    if wanted.shape is None:
        raise ExpressionError(
            "Expected expressions of one kind in s[…], got a list of several kinds. Pass one kind at a time."
        )
    return wanted.roots, wanted.shape


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Attributes):
    """Derivatives ∂x/∂b of a motion with respect to parameters and initial values, at its samples.

    `s[expression]` are the derivatives along the motion with respect to all b: (n × k) of an expression or name, (n × 3 × k) of a
    vector. Where events change the state, two samples have the same time, and the derivatives before and after differ by the
    saltation matrix.

    Attributes
    ----------
    motion : Solution
    by : b (k): parameters, and coordinates, speeds or further states, which stand for their initial values
    states : ∂(q, u, a)/∂b (n × states × k)
    """

    motion: Solution
    by: tuple[Symbol, ...]
    states: Array

    @property
    def t(self) -> Array:
        """The times (n)."""
        return self.motion.t

    def __getitem__(self, what: Any) -> Array:
        motion, (roots, shape) = self.motion, differentiable(self.motion, what)
        found = np.array([self._of(e) for e in roots])
        return np.moveaxis(found, 0, 1).reshape(len(motion), *shape, len(self.by))

    def _of(self, expr: Expr) -> Array:
        """dexpr/db (n × k)."""
        motion, n = self.motion, self.states.shape[1]
        own = tuple(p for p in self.by if isinstance(p, Parameter))
        table = slopes_along(motion, expr, own)
        result: Array = np.einsum("tn,tnk->tk", table[:, :n], self.states)
        result[:, [k for k, s in enumerate(self.by) if isinstance(s, Parameter)]] += table[:, n:]
        return result

    def __repr__(self) -> str:
        return f"Sensitivities(of {self.states.shape[1]} states by {', '.join(s.name for s in self.by)}, {len(self.t)} samples)"
