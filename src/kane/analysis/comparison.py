# SPDX-License-Identifier: BSD-3-Clause
"""`compare_speeds`, `compare_methods`: one system in several sets of generalized speeds, or by several methods, and their costs.

For each set of speeds: operations of one evaluation of (q̇, u̇, R) by each route, configurations where q̇ = W u + X is singular, and
along a motion the condition numbers of W and of M̃, the mass matrix of the independent speeds. W is scaled by the typical sizes of
its entries, and M̃ by its diagonal, so that the condition numbers do not depend on units.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from kane import expect, show
from kane.dynamics.formalisms import METHODS, Formulation
from kane.dynamics.formulation.candidates import divisors
from kane.dynamics.formulation.table import ASKED
from kane.equations.equations import Equations, derive
from kane.errors import Attributes, KaneError, ModelError, SpeedsError, alike, cut, none_of
from kane.expr.evaluation import is_constant_in_time
from kane.expr.matrix import Matrix
from kane.expr.node import Expr
from kane.expr.ops import MUL
from kane.expr.regular import factors
from kane.model.system import System
from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import balance

DECLARED = "declared"
"""The name of the system's own speeds."""


class MotionValues(Protocol):
    """A motion: its times, and values of expressions along it, such as a Solution."""

    @property
    def t(self) -> Array:
        """The times (n)."""

    def __getitem__(self, what: Any) -> Any:
        """The values of expressions (n each)."""


@dataclass(frozen=True, eq=False, repr=False)
class SpeedSet(Attributes):
    """A set of generalized speeds, with the equations of motion in them and their number of operations.

    `operations` are those of each route, by name. `singular` holds the denominators of q̇ and u̇ that vanish at singular
    configurations. `condition` (n) is the condition number of W at the samples of a motion, `mass_condition` (n) that of M̃; None
    without a motion.
    """

    name: str
    equations: Equations
    operations: Mapping[str, int]
    singular: tuple[Expr, ...]
    t: Array | None = None
    condition: Array | None = None
    mass_condition: Array | None = None

    @property
    def total(self) -> int:
        """Operations of the shortest route."""
        return min(self.operations.values())

    @property
    def worst(self) -> tuple[float, float] | None:
        """The largest condition number of W along the motion, and its time (s); None without a motion."""
        if self.condition is None or self.t is None:
            return None
        k = int(np.argmax(np.where(np.isnan(self.condition), np.inf, self.condition)))
        return float(self.condition[k]), float(self.t[k])

    def __repr__(self) -> str:
        return f"SpeedSet({self.name!r}: {self.total} operations)"


@dataclass(frozen=True, eq=False, repr=False)
class SpeedComparison(Attributes):
    """A comparison of sets of generalized speeds, `comparison[name]`; `shortest` is the set with the fewest operations."""

    sets: tuple[SpeedSet, ...]

    @property
    def shortest(self) -> SpeedSet:
        """The set with the fewest operations, the first of several."""
        return min(self.sets, key=lambda s: s.total)

    def __iter__(self) -> Iterator[str]:
        return (s.name for s in self.sets)

    def __getitem__(self, name: str) -> SpeedSet:
        by_name = {s.name: s for s in self.sets}
        if name not in by_name:
            raise ModelError(f"Expected one of {none_of(by_name, name)}")
        return by_name[name]

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Head and rows, as text."""
        routes = list(dict.fromkeys(r for s in self.sets for r in s.operations))
        with_motion = any(s.condition is not None for s in self.sets)
        along = ("cond W, usually", "at worst", "cond M") if with_motion else ()
        head = ("speeds", *routes, *along, "singular where")
        rows = []
        for s in self.sets:
            counts = (f"{s.operations[r]:,}" if r in s.operations else "–" for r in routes)
            where = ", ".join(f"{cut(e, 40)} = 0" for e in s.singular) or "nowhere"
            rows.append((s.name, *counts, *(_conditions(s) if with_motion else ()), where))
        return head, rows

    def __repr__(self) -> str:
        return show.columns(*self.table())

    _repr_html_ = show.html


def compare_speeds(
    system: System,
    candidates: Mapping[str, Any],
    *,
    along: MotionValues | None = None,
    routes: Sequence[str] | None = None,
) -> SpeedComparison:
    """Derive the equations of a system in its declared generalized speeds and in each of the `candidates`, for comparison.

    Parameters
    ----------
    system : System
    candidates : {name: speeds}, with speeds as for `System(…, speeds=…)`: a mapping of speeds to definitions, or "rates"
    along : a motion of the system in any speeds, from `kn.simulate`, for condition numbers at its samples
    routes : further routes to count operations for, of "classical", "recursive" and "composite"; by default all that are applicable

    Raises
    ------
    SpeedsError
        if a candidate is not a valid set of speeds of the system; the message names it
    """
    given: object = candidates
    expect.instance(system, System, "a System whose speeds are compared")
    named = isinstance(given, Mapping) and all(isinstance(name, str) for name in given)
    expect.that(named, "candidates by name, {name: speeds}", candidates)
    if DECLARED in candidates:
        raise ModelError(f"Expected names other than {DECLARED!r}, which is that of the system's own speeds.")
    asked = routes if routes is None else (routes,) if isinstance(routes, str) else tuple(routes)
    expect.none((repr(r) for r in asked or () if r not in ASKED), f"routes among {', '.join(map(repr, ASKED))}")
    expect.that(along is None or hasattr(along, "t"), "a motion as along=", along, "Give kn.simulate(…).")
    sets = [_set(DECLARED, system, along, asked)]
    for name, speeds in candidates.items():
        try:
            sets.append(_set(name, system.replace(speeds=speeds, dependent_speeds=()), along, asked))
        except KaneError as error:
            raise SpeedsError(f"Expected speeds of this system as {name!r}: {error}") from error
    return SpeedComparison(tuple(sets))


def _set(name: str, system: System, along: MotionValues | None, routes: Sequence[str] | None) -> SpeedSet:
    eom = derive(system)
    operations = {eom.route: eom.operations.total, **eom.routes}
    for route in ASKED if routes is None else routes:
        if route not in operations:
            try:
                operations[route] = derive(system, route=route).operations.total
            except ModelError:  # the route is not applicable
                continue
    if along is None:
        return SpeedSet(name, eom, operations, _singular(eom))
    mass = eom.mass_matrix_nh if eom.embedding else eom.mass_matrix
    measured = (eom.W, _of_entries), (mass, _of_diagonal)
    conditions = (_condition(_values(m, along), sizes) for m, sizes in measured)
    return SpeedSet(name, eom, operations, _singular(eom), np.array(along.t), *conditions)


def _singular(eom: Equations) -> tuple[Expr, ...]:
    """Nonconstant factors of the pivots of W that are denominators of q̇ or u̇."""
    below = divisors((*eom.rates, *eom.accelerations))
    parts = dict.fromkeys(f for p in eom.solved.regular.kinematical.pivots for f in factors(p))
    return tuple(f for f in parts if f in below and f.op is not MUL and not is_constant_in_time([f]))


def _values(m: Matrix, along: MotionValues) -> Array:
    """Values of a matrix along a motion (n × rows × columns)."""
    return np.stack(along[list(m.entries)], axis=-1).reshape(len(along.t), *m.shape)


def _condition(a: Array, sizes: Callable[[Array], Array]) -> Array:
    """Condition numbers (n) of matrices A, divided by `sizes` of the typical absolute values of their entries."""
    finite: Mask = np.asarray(np.isfinite(a).all(axis=(1, 2)))
    usual = np.median(np.abs(a[finite]), axis=0) if finite.any() else np.ones(a.shape[1:])
    result = np.full(len(a), np.inf)
    with np.errstate(divide="ignore"):
        values = np.linalg.svd(a[finite] / sizes(usual), compute_uv=False)
        result[finite] = values[:, 0] / values[:, -1]
    return result


def _of_entries(usual: Array) -> Array:
    scaled = balance(usual)
    return scaled.rows * scaled.columns


def _of_diagonal(usual: Array) -> Array:
    unit = np.sqrt(np.diagonal(usual))
    return np.outer(unit, unit)


def _conditions(s: SpeedSet) -> tuple[str, str, str]:
    if s.condition is None or s.mass_condition is None or s.worst is None:
        return ("", "", "")
    worst, t = s.worst
    return f"{np.median(s.condition):.2g}", f"{worst:.2g} at {t:.3g} s", f"{np.median(s.mass_condition):.2g}"


@dataclass(frozen=True, eq=False, repr=False)
class MethodComparison(Attributes):
    """Formulations of one system by several methods, `comparison[name]`; `refused` gives the reason for each inapplicable method."""

    formulations: dict[str, Formulation]
    refused: dict[str, str]

    @property
    def shortest(self) -> str:
        """The method with the fewest operations, the first of several."""
        return min(self.formulations, key=lambda name: self.formulations[name].operations.total)

    def __iter__(self) -> Iterator[str]:
        return iter(self.formulations)

    def __getitem__(self, name: str) -> Formulation:
        if name in self.refused:
            raise ModelError(self.refused[name])
        if name not in self.formulations:
            raise ModelError(f"Expected one of {none_of(self.formulations, name)}")
        return self.formulations[name]

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Head and rows, as text."""
        head = "method", "operations", "unknowns", "state", "eliminated"
        rows = []
        for name, f in self.formulations.items():
            sizes = map(str, (f.operations.total, len(f.unknowns), len(f.state)))
            rows.append((name, *sizes, "; ".join(f.eliminated) or "nothing"))
        return head, [*rows, *((name, "–", "–", "–", cut(why, 100)) for name, why in self.refused.items())]

    def __repr__(self) -> str:
        return show.columns(*self.table())

    _repr_html_ = show.html


def compare_methods(system: System | Equations, methods: Sequence[str] = METHODS) -> MethodComparison:
    """Formulate a system by several methods, to compare operations of the right-hand side, unknowns and eliminated quantities.

    Parameters
    ----------
    system : System, or its Equations
    methods : names of methods, as for `eom.by`; by default all

    Raises
    ------
    ModelError
        if the name of a method is unknown
    """
    expect.instance(system, (System, Equations), "a System or its Equations")
    wanted: Any = methods
    names: Any = tuple(wanted) if expect.is_list(wanted) else (wanted,)
    expect.that(names, "methods to compare", methods)
    for name in names:
        expected = f"methods among {', '.join(map(repr, METHODS))}"
        expect.that(isinstance(name, str) and name in METHODS, expected, name, alike(str(name), METHODS).strip())
    eom = derive(system) if isinstance(system, System) else system
    found, refused = dict[str, Formulation](), dict[str, str]()
    for name in names:
        try:
            found[name] = eom.by(name)
            _ = found[name].operations
        except ModelError as error:
            found.pop(name, None)
            refused[name] = str(error)
    return MethodComparison(found, refused)
