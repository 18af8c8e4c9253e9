# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of a motion: `Sensitivities` at every sample, `AdjointSensitivities` of functionals by any number of parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kane import expect, show
from kane.dynamics.readings.quantities import asked
from kane.equations.equations import Equations
from kane.errors import Attributes, ExpressionError, SimulationError
from kane.expr.node import ZERO, Expr, as_expr
from kane.expr.symbols import Parameter, Symbol
from kane.motion.derivatives.adjoint import Seeds
from kane.motion.derivatives.pulling import Integrand, Laws, slopes_with_laws
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


Back = Callable[[Seeds, int, Array], tuple[Array, float]]
"""(seeds, m, explicit ∂J/∂p (m × parameters)) ↦ total derivatives ∂J/∂b (m × k) of m functionals J, and ∫ L dt."""


@dataclass(frozen=True, eq=False, repr=False)
class AdjointSensitivities(Attributes):
    """Derivatives of a motion with respect to b by adjoint equations, at a cost that hardly depends on the number of b.

    `s[expression]` are the derivatives at all samples: (n × k) of an expression, (n × 3 × k) of a vector, as for `Sensitivities`.
    Each sample and component takes one backward integration, so that few samples are best; `s.cost(…)` takes a single one.

    Attributes
    ----------
    motion : Solution
    by : b (k): parameters, and coordinates, speeds or further states, which stand for their initial values
    """

    motion: Solution
    by: tuple[Symbol, ...]
    back: Back

    @property
    def t(self) -> Array:
        """The times (n)."""
        return self.motion.t

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters among b."""
        return tuple(s for s in self.by if isinstance(s, Parameter))

    @property
    def states(self) -> Array:
        """∂(q, u, a)/∂b at the samples (n × states × k)."""
        n = self.motion.states.shape[1]
        slopes = np.broadcast_to(np.eye(n, n + len(self.parameters)), (len(self.t), n, n + len(self.parameters)))
        return self._at_samples(slopes)

    def __getitem__(self, what: Any) -> Array:
        roots, shape = differentiable(self.motion, what)
        slopes = np.stack([slopes_along(self.motion, e, self.parameters) for e in roots], axis=1)
        return self._at_samples(slopes).reshape(len(self.t), *shape, len(self.by))

    def _at_samples(self, slopes: Array) -> Array:
        """d/db (samples × m × k) of m quantities with partial derivatives by (x, p) at each sample (samples × m × n + parameters)."""
        count, m, _ = slopes.shape
        n = self.motion.states.shape[1]
        rows = {k: np.zeros((count * m, n)) for k in range(count)}
        for k, seed in rows.items():
            seed[k * m : (k + 1) * m] = slopes[k, :, :n]
        own = slopes[:, :, n:].reshape(count * m, -1)
        return self.back(Seeds(rows, None), count * m, own)[0].reshape(count, m, -1)

    def cost(self, end: Any = 0, *, integral: Any = 0, samples: Mapping[Any, Any] | None = None) -> "Cost":
        """The cost J = e(x(T)) + ∫ L dt + Σ w·y(t_i), and its gradient with respect to all b.

        Parameters
        ----------
        end : e, an expression or name
        integral : L, an expression or name
        samples : {expression or name y: weights w (n) of its samples}

        Raises
        ------
        SimulationError
            if no term of J is given, or the number of weights differs from that of the samples
        """
        motion = self.motion
        e, integrand = (_one(motion, what) for what in (end, integral))
        table: dict[Expr, Array] = {}
        for what, weights in dict(samples or {}).items():
            w = np.asarray(expect.floats(weights, f"weights of the samples of {what}", error=SimulationError))
            expect.that(w.shape == motion.t.shape, f"{len(motion)} weights of samples", w.shape, error=SimulationError)
            table[_one(motion, what)] = w
        if e is not ZERO:
            table[e] = table.get(e, np.zeros(len(motion))) + np.eye(len(motion))[-1]
        if not table and integrand is ZERO:
            raise SimulationError("Expected something to differentiate, got neither end, integral= nor samples=.")
        more = Integrand(integrand, np.ones(1), motion.inputs) if integrand is not ZERO else None
        values, gradients = self.weighted([table], more)
        return Cost(float(values[0]), gradients[0])

    def weighted(
        self, numbers: Sequence[Mapping[Expr, Array]], integrand: Integrand | None = None
    ) -> tuple[Array, Array]:
        """Values (m) of Σ w·y(t_i) + factor ∫ L dt, and their gradients (m × k), by one backward integration.

        `numbers` holds a mapping {y: weights w of the samples} for each of the m values.
        """
        motion, own = self.motion, self.parameters
        n, count, parts = motion.states.shape[1], len(motion), dict.fromkeys(y for number in numbers for y in number)
        known = {y: (motion[y], slopes_along(motion, y, own)) for y in parts}
        values, slopes = np.zeros(len(numbers)), np.zeros((len(numbers), count, n + len(own)))
        for k, number in enumerate(numbers):
            for y, w in number.items():
                values[k] += w @ known[y][0]
                slopes[k] += w[:, None] * known[y][1]
        rows = {i: slopes[:, i, :n].copy() for i in np.flatnonzero(slopes[:, :, :n].any(axis=(0, 2))).tolist()}
        gradients, integral = self.back(Seeds(rows, integrand), len(numbers), slopes[:, :, n:].sum(axis=1))
        return values if integrand is None else values + integrand.factors * integral, gradients

    def __repr__(self) -> str:
        return f"AdjointSensitivities(by {', '.join(s.name for s in self.by)}, {len(self.t)} samples)"


class Cost(NamedTuple):
    """The `value` of a cost J, and its `gradient` ∂J/∂b (k)."""

    value: float
    gradient: Array

    def _repr_html_(self) -> str | None:
        return show.html(self)


def _one(motion: Solution, what: Any) -> Expr:
    """An expression, or the expression that a name denotes."""
    found = asked(motion.equations.derived, what) if isinstance(what, str) else None
    return as_expr(what) if found is None else found.roots[0]
