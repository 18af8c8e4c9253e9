# SPDX-License-Identifier: BSD-3-Clause
"""Branches of limit cycles over a parameter, by pseudo-arclength continuation past turning points (`kane.numeric.arclength`).

The unknowns are the independent components ξ of the start and the parameter p: F(ξ, p) = T⁺ (P(x) − x), with ∂F/∂ξ = D − I and ∂F/∂p
by the variational equations. A bifurcation, where a multiplier crosses the unit circle, is located by bisection on the branch.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from kane import expect
from kane.analysis.solution_branches import changes, tracked
from kane.errors import Attributes, SimulationError
from kane.expr.symbols import Parameter
from kane.motion.cycles.shooting import FirstReturn, Linearized, Shooting
from kane.motion.derivatives.tangent_space import sizes_of
from kane.numeric.arclength import ImplicitCurve
from kane.numeric.arrays import Array, Complex
from kane.numeric.sampling import symbols_named
from kane.numeric.scale import SOLVED
from kane.progress import far, working

_LEAST = np.exp(-10.0)
"""Lower bound of |μ| in logarithms, which locate crossings of the unit circle."""
_KINDS = {0: "fold", 1: "flip", 2: "torus"}


@dataclass(frozen=True, slots=True, eq=False)
class CycleChange(Attributes):
    """A bifurcation of limit cycles: a Floquet multiplier crosses the unit circle.

    `kind` is "fold" (multiplier 1: two cycles merge), "flip" (−1: a cycle of twice the period branches off) or "torus" (a pair
    e^±iφ). `value` is that of the parameter, `between` the indices of the cycles of the branch before and after it; `grows` tells
    whether perturbations of the cycle grow after it.
    """

    value: float
    multiplier: complex
    kind: str
    cycle: Any
    between: tuple[int, int]
    grows: bool

    def __repr__(self) -> str:
        return f"CycleChange({self.kind} at {self.value:.9g}, multiplier {self.multiplier:.6g})"


@dataclass(frozen=True, slots=True, eq=False)
class CycleBranch(Attributes):
    """A branch of limit cycles: `cycles` at `values` of the parameter `symbol`, in order along the branch.

    `multipliers` (cycles × m) has each Floquet multiplier in one column, `turning` holds the indices of turning points, and
    `changes` the bifurcations. `len(branch)` is the number of cycles; `kn.figures.root_locus(branch)` draws the Floquet exponents.
    """

    symbol: Parameter
    values: Array
    cycles: tuple[Any, ...]
    multipliers: npt.NDArray[np.complex128]
    turning: tuple[int, ...]
    changes: tuple[CycleChange, ...]
    message: str

    @property
    def periods(self) -> Array:
        """Period T of each cycle (s)."""
        return np.array([c.period for c in self.cycles])

    @property
    def stable(self) -> npt.NDArray[np.bool_]:
        """Which cycles are stable."""
        return np.array([c.stable for c in self.cycles], dtype=bool)

    @property
    def turning_points(self) -> tuple[float, ...]:
        """The values of the parameter at the turning points of the branch."""
        return tuple(self.values[list(self.turning)].tolist())

    @property
    def eigenvalues(self) -> npt.NDArray[np.complex128]:
        """Floquet exponents ln μ/T (1/s) of nonzero multipliers; all real parts are negative for a stable cycle."""
        kept = np.abs(self.multipliers).min(axis=0, initial=np.inf) > 1e-12
        return np.asarray(np.log(self.multipliers[:, kept]) / self.periods[:, None])

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        turns = ", ".join(f"{v:.6g}" for v in self.turning_points) or "none"
        told = ", ".join(f"{c.kind} at {c.value:.6g}" for c in self.changes) or "none"
        return (
            f"CycleBranch({len(self)} cycles, {self.symbol.name} = {self.values[0]:.6g} … {self.values[-1]:.6g}; turning points: "
            f"{turns}; changes of stability: {told}; {self.message})"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """F and ∂F/∂y at y = (ξ, p), in units of `columns`: the sizes of ξ along the `first` cycle, and the range of p."""

    first: Any
    make: Callable[..., Any]
    symbol: Parameter
    places: tuple[int, ...]
    columns: Array

    def at(self, y: Array) -> tuple[Shooting, Array]:
        """The shooting problem and the start x at a point y."""
        own: Shooting = self.first.shooting
        shooting = replace(own, constants={**own.constants, self.symbol: float(y[-1] * self.columns[-1])})
        x = self.first.x.copy()
        x[list(self.places)] = y[:-1] * self.columns[:-1]
        return shooting, shooting.onto(x, self.first.names)

    def shot(self, y: Array) -> tuple[Shooting, FirstReturn, Linearized]:
        """The shooting problem, the motion and the derivative of P at a point y."""
        shooting, x = self.at(y)
        shot = shooting.shot(x)
        return shooting, shot, shooting.linear(shot, (self.symbol,))

    def __call__(self, y: Array) -> tuple[Array, Array]:
        """F and ∂F/∂y; F is infinite if the motion cannot be integrated."""
        n = len(y) - 1
        try:
            _, shot, linear = self.shot(y)
        except SimulationError:
            return np.full(n, np.inf), np.zeros((n, n + 1))
        size = self.columns[:-1]
        f = linear.back @ shot.left / size
        j = np.hstack([(linear.d - np.eye(n)) * size, linear.by * self.columns[-1]]) / size[:, None]
        return f, j

    def cycle(self, y: Array) -> Any:
        """The cycle at a point y of the branch."""
        shooting, shot, linear = self.shot(y)
        return self.make(shooting, shot, linear)

    def exponents(self, y: Array) -> Complex:
        """Logarithms of the multipliers at a point y."""
        _, _, linear = self.shot(y)
        return logarithms(linear.multipliers(self.first.map.section is not None))


def logarithms(multipliers: Complex) -> Complex:
    """ln μ, with the imaginary part 0 or π for real multipliers."""
    angle = np.where(multipliers.imag == 0, np.where(multipliers.real < 0, np.pi, 0.0), np.angle(multipliers))
    return np.asarray(np.log(np.maximum(np.abs(multipliers), _LEAST)) + 1j * angle)


def follow(cycle: Any, parameter: Any, to: Any, max_points: int, locate: bool, make: Callable[..., Any]) -> CycleBranch:
    """See LimitCycle.follow."""
    shooting: Shooting = cycle.shooting
    symbols = tuple(s for s in shooting.constants if isinstance(s, Parameter))
    (symbol,) = symbols_named("a parameter to follow", symbols, [parameter])
    begin = float(shooting.constants[symbol])
    expected = f"to= as a value other than {begin:g}, or several that increase or decrease from it"
    values = np.atleast_1d(expect.floats(to, expected, error=SimulationError))
    values = np.append(begin, values[values != begin])
    step = np.diff(values)
    monotonic = len(values) > 1 and np.isfinite(values).all() and (np.all(step > 0) or np.all(step < 0))
    expect.that(monotonic, expected, to, error=SimulationError)
    places = [s.name for s in shooting.map.eom.state]
    unknown = [n for n in cycle.names if n not in places]
    expect.none(
        unknown,
        "independent coordinates to follow a cycle",
        "small angles {} of Euler parameters",
        error=SimulationError,
    )
    indices = tuple(places.index(n) for n in cycle.names)
    scale = sizes_of(shooting.map.eom, np.abs(cycle.solution.states).max(axis=0), 1e-6)[list(indices)]
    chart = Chart(cycle, make, symbol, indices, np.append(scale, abs(values[-1] - begin)))
    y = np.append(cycle.x[list(indices)], begin) / chart.columns
    curve = ImplicitCurve(chart)

    def where(y: Array) -> str:
        return f"{symbol.name} = {y[-1] * chart.columns[-1]:.6g}"

    with working("Following the cycle"):
        path = curve.follow(y, values / chart.columns[-1], max_points, where)
        cycles = []
        for k in path.marked if not locate else range(len(path.points)):
            far(partial(where, path.points[k]))
            cycles.append(chart.cycle(path.points[k]))
        marks = list(path.marked) if locate else list(range(len(cycles)))
        met = _changes(chart, curve, path.points, cycles, marks) if locate else ()
    kept = tuple(cycles[k] for k in marks)
    ordered = tracked([c.multipliers for c in kept]) if len(kept) else np.zeros((0, 0), dtype=complex)
    return CycleBranch(
        symbol,
        np.array([float(c.start.parameters[symbol]) for c in kept]),
        kept,
        ordered,
        path.turning,
        tuple(met),
        path.message,
    )


def _changes(
    chart: Chart, curve: ImplicitCurve, points: Any, cycles: list[Any], marks: list[int]
) -> tuple[CycleChange, ...]:
    """The bifurcations of the branch, where a multiplier crosses the unit circle."""
    roots = [logarithms(c.multipliers) for c in cycles]

    def middle(a: Array, b: Array) -> Array | None:
        return curve.middle(a, b) if np.linalg.norm(b - a) > SOLVED else None

    found = []
    for change in changes(points, roots, middle, chart.exponents):
        cycle = chart.cycle(change.y)
        angle = abs(change.root.imag)
        near = int(np.argmin(np.abs(logarithms(cycle.multipliers) - change.root)))
        kind = _KINDS[0 if angle < 1e-3 else 1 if abs(angle - np.pi) < 1e-3 else 2]
        before = max(k for k, m in enumerate(marks) if m <= change.interval)
        found.append(
            CycleChange(
                float(change.y[-1] * chart.columns[-1]),
                complex(cycle.multipliers[near]),
                kind,
                cycle,
                (before, min(before + 1, len(marks) - 1)),
                change.grows,
            )
        )
    return tuple(found)
