# SPDX-License-Identifier: BSD-3-Clause
"""Weights of the end of a stretch of a motion, pulled back to its beginning: the reverse sweep over Runge and Kutta's steps.

A step from x has stages X_i = x + h Σ a_ij f(X_j), and ends at x + h Σ b_i f(X_i). Weights λ of its end are, backwards through the
stages, with ℓ_i = h b_i ∂L/∂x of an integrand L,

    w_i = h (b_i λ + Σ_j a_ji k_j),   k_i = J(X_i)ᵀ w_i + ℓ_i,   weights of x: λ + Σ k_i,   of p: Σ (∂f/∂p)ᵀ w_i + h b_i ∂L/∂p

(Hager 2000, Numer. Math. 87; Sanz-Serna 2016, SIAM Rev. 58). wᵀ ∂f/∂(x, p, r) is one routine, made by one sweep backwards through the
equations, and a kernel calls it from stage to stage. States at which steps begin are what is kept of a motion; stages are made anew,
for some steps at a time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.readings.quantities import without_unknowns
from kane.dynamics.slopes import backward
from kane.equations.compiled import along, ports
from kane.equations.equations import Equations
from kane.expr.differentiation import gradient, tangent
from kane.expr.evaluation import evaluate
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Parameter, Symbol, time
from kane.expr.visit import substituted
from kane.model.contact_modes import in_mode
from kane.motion.derivatives.transition import rates
from kane.motion.inputs.expressions import Formula
from kane.motion.right_hand_side import Routines, only
from kane.motion.steppers.vern9 import VERN9
from kane.numeric.arrays import Array
from kane.program.from_expressions import Bundle, Shaped
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Writer
from kane.program.native.entry import CompiledKernel, entry, hoisted
from kane.program.native.machine import Settings
from kane.program.program import Port

_S = VERN9.stages
_A = np.array([[*row, *[0.0] * (_S - len(row))] for row in ((), *VERN9.a)])
_B, _C = np.array(VERN9.b), np.array(VERN9.c)
_DOUBLES = 1 << 21
"""So many, at most, are kept of the stages of steps."""


def pulls(eom: Equations, *by: Symbol) -> Bundle[Array]:
    """wᵀ ∂(q̇, u̇, ȧ)/∂symbols, in one sweep backwards."""
    w = along("w", eom.state)
    t, x, *given = ports(eom.derived)
    own = (t, x, Port("w", w, noun="weight", nouns="weights"), *given)
    return Bundle("pulls", own, only, {"x": Shaped((len(by),), tuple(backward(eom.solved, by, w)))})


def pulling_kernel() -> Kernel:
    """Weights `lam` (rows × n) pulled back through steps: of parameters `own` gains (rows × p), of inputs `of_inputs` is written.

    `sized` gains the sizes of what `own` gains. `out` has what the routine gives: n, then p, then `inputs` numbers, which the laws of
    inputs carry on by `through` (stages × inputs × n). Of an integrand `source` (stages × n) is added where a row is `sourced`.
    """
    w = Writer("pull_back")
    rows, steps, stages, n, count, inputs, wide = map(
        w.number, ("rows", "steps", "stages", "n", "count", "inputs", "wide")
    )
    names = (
        "times", "x", "p", "r", "h", "lengths", "a", "b", "through", "source", "sourced", "w", "k", "out", "lam", "own", "sized",
        "of_inputs",
    )  # fmt: skip
    a = {name: w.array(name) for name in names}
    pull = w.callee("pull", "float", "array", "array", "array", "array", "array", "array")
    total, done = w.variable("total"), w.variable("done", INT)
    with w.count(rows) as row, w.count(steps) as back:
        step = steps - 1 - back
        h = a["lengths"][step]
        with w.count(stages) as later:
            i = stages - 1 - later
            at = step * stages + i
            with w.count(n) as j:
                total.put(a["b"][i] * a["lam"][row * n + j])
                with w.count(stages, i + 1) as m:
                    total.put(total.get() + a["a"][m * stages + i] * a["k"][m * n + j])
                a["w"][j] = h * total.get()
            pull(
                a["times"][at], a["x"].at(at * n), a["w"].at(0), a["p"].at(0), a["r"].at(at * wide), a["h"].at(0),
                a["out"].at(0),
            )  # fmt: skip
            with w.count(n) as j:
                total.put(a["out"][j] + a["sourced"][row] * a["source"][at * n + j])
                with w.count(inputs) as m:
                    total.put(total.get() + a["out"][n + count + m] * a["through"][(at * inputs + m) * n + j])
                a["k"][i * n + j] = total.get()
            with w.count(count) as j:
                a["own"][row * count + j] = a["own"][row * count + j] + a["out"][n + j]
                a["sized"][row * count + j] = a["sized"][row * count + j] + w.compute("abs", a["out"][n + j])
            with w.count(inputs) as m:
                a["of_inputs"][(row * steps * stages + at) * inputs + m] = a["out"][n + count + m]
        with w.count(n) as j, w.count(stages) as i:
            a["lam"][row * n + j] = a["lam"][row * n + j] + a["k"][i * n + j]
    done.put(rows)
    return w.finished(done)


@cache
def _compiled(settings: Settings) -> CompiledKernel:
    return CompiledKernel(pulling_kernel(), settings)


class Weights(NamedTuple):
    """∂J/∂x (m × n) and ∂J/∂p (m × k) of m numbers J at an instant, and what ∂J/∂p was added up of, in size."""

    x: Array
    p: Array
    sizes: Array


@dataclass(frozen=True, slots=True, eq=False)
class Integrand:
    """L of ∫ L dt: an expression, and which of m numbers J it adds to, with which factor (m)."""

    expr: Expr
    factors: Array
    inputs: Mapping[Any, Any]

    def slopes(self, now: Routines, by: Sequence[Parameter], t: Array, x: Array) -> tuple[Array, Array, Array]:
        """L (m), ∂L/∂x (m × n) and ∂L/∂p (m × k) at times and states."""
        roots = now.eom.numeric(now.settings).value(own_slopes, self.expr, tuple(by), Laws(self.inputs))
        table = _evaluated(roots, now, t, x)
        return table[0], table[1 : 1 + now.width].T, table[1 + now.width :].T


class Laws:
    """Inputs that are expressions, by symbol: equal where the expressions are."""

    def __init__(self, inputs: Mapping[Any, Any]) -> None:
        self.whole: dict[Expr, Expr] = {s: f.whole for s, f in inputs.items() if isinstance(f, Formula)}
        self._key = tuple(id(e) for pair in self.whole.items() for e in pair)

    def read(self, eom: Equations, exprs: Sequence[Expr]) -> list[Expr]:
        """Expressions in a mode of contacts, with inputs as their laws and no unknowns."""
        held = in_mode(eom.system.contacts, eom.system.modes, exprs)
        plain = without_unknowns(eom.solved, [substituted(e, self.whole) for e in held])
        return [substituted(e, self.whole) for e in plain]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Laws) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


def own_slopes(eom: Equations, expr: Expr, by: tuple[Parameter, ...], laws: Laws) -> list[Expr]:
    """An expression with inputs as their laws, and its gradient by the state and parameters."""
    (whole,) = laws.read(eom, [expr])
    return [whole, *gradient(whole, [*eom.state, *by])]


def _evaluated(roots: Sequence[Expr], now: Routines, t: Array, x: Array) -> Array:
    """Values of expressions (roots × times)."""
    eom = now.eom
    values: dict[Expr, Any] = {}
    for f in now.drives:
        if isinstance(f, Formula):
            values |= {**f.values, **f.gains}
    values |= dict(zip(eom.parameters, now.p.tolist(), strict=False)) | dict(zip(eom.state, x.T, strict=True))
    values |= dict(zip(eom.inputs, now.inputs_all(t, x).T, strict=True)) | {time: t}
    return np.array([np.broadcast_to(v, t.shape) for v in evaluate(roots, values)])


class Pulling:
    """What pulls weights back through steps of one set of equations with numbers."""

    def __init__(self, now: Routines, by: Sequence[Parameter]) -> None:
        self.now, self.by, eom = now, tuple(by), now.eom
        own = set(eom.parameters)
        self.place = [k for k, s in enumerate(by) if s in own]
        whole = {s: f.whole for s, f in zip(eom.inputs, now.drives, strict=True) if isinstance(f, Formula)}
        turned = {s: [tangent(e, {b: ONE}) for b in (*eom.state, *by)] for s, e in whole.items()}
        self.laws = {s: row for s, row in turned.items() if any(e is not ZERO for e in row)}
        self.routine = now.routine(pulls, *eom.state, *(by[k] for k in self.place), *self.laws).flat
        r = now.inputs(0.0, np.zeros(now.width)) if not now.drives else np.zeros(len(now.drives))
        zero = np.zeros(now.width)
        self.h = hoisted(self.routine, 0.0, zero, zero, now.p, r)

    @staticmethod
    def serves(now: Routines) -> bool:
        """Whether inputs are numbers, functions of time and expressions, as is needed."""
        return not any(getattr(f, "of_state", False) and not isinstance(f, Formula) for f in now.drives)

    def __call__(self, start: tuple[Array, Array, Array], weights: Weights, integrand: Integrand | None) -> Weights:
        """Weights at the beginning of steps from (times, lengths, states at the beginnings), of weights at the end."""
        size = _S * (self.now.width * (2 + len(self.laws)) + 1 + len(self.now.drives)) + 1
        most = max(1, _DOUBLES // size)
        for k in reversed(range(0, len(start[0]), most)):
            t, h, x = (part[k : k + most] for part in start)
            weights = self._some(t, h, x, weights, integrand)
        return weights

    def _some(self, t: Array, h: Array, x: Array, weights: Weights, integrand: Integrand | None) -> Weights:
        now, n, steps = self.now, self.now.width, len(t)
        rows, (times, states) = len(weights.x), _stages(now, t, h, x)
        drives, count, inputs = len(now.drives), len(self.place), len(self.laws)
        slopes = np.zeros((inputs, n + len(self.by), len(times)))
        for i, row in enumerate(self.laws.values()):
            slopes[i] = _evaluated(row, now, times, states)
        lam, own, sized = weights.x.copy(), np.zeros(rows * count + 1), np.zeros(rows * count + 1)
        of_inputs, source = np.zeros(rows * len(times) * inputs + 1), np.zeros((len(times), n))
        p_gain = np.zeros((rows, len(self.by)))
        share, factors = (h[:, None] * _B).reshape(-1), np.zeros(rows)
        if integrand is not None:
            _, by_x, by_p = integrand.slopes(now, self.by, times, states)
            source, factors = share[:, None] * by_x, integrand.factors
            p_gain = np.outer(factors, share @ by_p)
        _compiled(now.settings or Settings())(
            {
                "rows": rows, "steps": steps, "stages": _S, "n": n, "count": count, "inputs": inputs, "wide": drives,
                "times": times, "x": states.reshape(-1), "p": np.append(now.p, 0.0),
                "r": np.append(now.inputs_all(times, states), 0.0), "h": self.h, "lengths": np.ascontiguousarray(h),
                "a": _A.reshape(-1).copy(), "b": _B.copy(),
                "through": np.append(slopes[:, :n].transpose(2, 0, 1), 0.0), "source": source.reshape(-1),
                "sourced": factors.copy(), "w": np.zeros(n), "k": np.zeros(_S * n), "out": np.zeros(n + count + inputs),
                "lam": lam.reshape(-1), "own": own, "sized": sized, "of_inputs": of_inputs,
                "pull": entry(self.routine),
            }
        )  # fmt: skip
        gained, sizes = np.zeros((rows, len(self.by))), np.zeros((rows, len(self.by)))
        gained[:, self.place], sizes[:, self.place] = (a[:-1].reshape(rows, count) for a in (own, sized))
        carried = of_inputs[:-1].reshape(rows, len(times), inputs)
        gained += np.einsum("mti,ikt->mk", carried, slopes[:, n:]) + p_gain
        sizes += np.einsum("mti,ikt->mk", np.abs(carried), np.abs(slopes[:, n:])) + np.abs(p_gain)
        return Weights(lam, weights.p + gained, weights.sizes + sizes)


def _stages(now: Routines, t: Array, h: Array, x: Array) -> tuple[Array, Array]:
    """Times and states of all stages, of the first step first."""
    steps, n = x.shape
    times, states, f = t[:, None] + h[:, None] * _C, np.empty((steps, _S, n)), np.empty((steps, _S, n))
    for i in range(_S):
        states[:, i] = x + h[:, None] * np.einsum("j,mjn->mn", _A[i, :i], f[:, :i])
        f[:, i] = rates(now, times[:, i], states[:, i])
    return times.reshape(-1), states.reshape(-1, n)
