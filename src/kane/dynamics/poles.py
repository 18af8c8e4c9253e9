# SPDX-License-Identifier: BSD-3-Clause
"""False poles: configurations at which W = Y⁻¹ does not exist although the constraints and the speeds together determine q̇.

The speeds and the constraints are u = Y q̇ + z and A_q q̇ + b_q = 0. If Y is singular but the columns of [Y; A_q] are independent, the
motion is regular, and q̇ follows from the independent speeds by [Y_I; A_q]; only expressions that contain W have a pole. With a basis
N of the rates that the constraints admit, A_q N = 0, admissible speeds satisfy B u = const., where B (Y N) = 0, and the dependent
speeds are chosen from B.

The module also makes the events that every system watches: the end of slip, Painlevé's case, and singular kinematics.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from kane.dynamics.constraints.dependence import follow_everywhere
from kane.dynamics.constraints.manifold import Manifold
from kane.dynamics.constraints.partition import Partition, choose, quality
from kane.dynamics.derivation import Derived
from kane.dynamics.solved import Solved
from kane.expr.build import div
from kane.expr.evaluation import evaluate, free_symbols, is_constant_in_time
from kane.expr.matrix import determinant, dot
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.symbols import Coordinate, Reaction, Speed
from kane.expr.visit import substituted
from kane.kinematics.speeds import Speeds
from kane.model.declarations import Event, constraint_rate
from kane.model.loads import Load
from kane.numeric.arrays import Array, Mask, median, medians, spread
from kane.numeric.rank import balance, balanced, level, singular
from kane.numeric.sampling import SEED, sample, values_of
from kane.numeric.scale import BETTER, CLOSED, CLOSED_FULLY, DERIVE_RANK, NEAR_SINGULAR, POOR, bounded

_DRAWN, _SPREAD, _STARTS = 256, 2.0, 3
"""Configurations drawn, how far apart, about, and from how many of them a zero of a pivot is sought."""
_STEPS = 12
"""Steps of Newton's method from each: there p is small already."""
_SMALL = 0.1
"""Share of its usual size that a pivot must fall below at one of them, if it vanishes anywhere."""
_SAMPLES = 9
"""Configurations that tell the sizes of speeds."""


def moving_pivots(derived: Derived) -> list[Expr]:
    """The pivots of W that depend on the configuration."""
    return [p for p in derived.kinematical.pivots if any(isinstance(s, Coordinate) for s in free_symbols([p]))]


def without_poles(derived: Derived, partition: Partition | None, fixed: bool = False) -> Partition | None:
    """A partition with which the motion is regular at false poles; None if none is found.

    It is `partition` or, unless its dependent speeds are `fixed`, named by the user, or determined equally well everywhere, another
    one that is determined no worse at other configurations.
    """
    pivots = moving_pivots(derived)
    if partition is None or not partition.dependent or not pivots:
        return None
    places, f = _Configurations(derived), derived.conditions.f
    place = {u: i for i, u in enumerate(derived.speeds)}
    named = [place[u] for u in derived.system.dependent_speeds]
    dependent = partition.dependent
    fixed = fixed or follow_everywhere(derived.compared, derived.constraints.a, dependent)
    own = f[len(derived.system.holonomic) :]  # the unit lengths of Euler parameters
    # off the constraints first: there most poles are seen to be true ones, for little
    for conditions in dict.fromkeys((own, f)):
        poles = [(b, told) for p in pivots for b, told in places.admissible(conditions, p) if len(b) == len(dependent)]
        if not poles:
            return None
        usual = [b for b, _ in places.admissible(conditions) if len(b) == len(dependent)]
        sizes = np.max([np.abs(b).max(axis=0) for b in usual], axis=0, initial=0)
        sizes = np.where(sizes > 0, sizes, 1.0)
        reach = np.broadcast_to(sizes, usual[0].shape) if usual else sizes
        others = [] if fixed else [choose(b, named, reach=reach).dependent for b in usual]
        choices = dict.fromkeys((dependent, *(tuple(sorted(d)) for d in others if len(d) == len(dependent))))
        best = max(choices, key=lambda d: round(min((_determined(b, d, sizes) for b in usual), default=0.0), 9))
        if not any(_determined(b, best, sizes) > NEAR_SINGULAR and accurate() for b, accurate in poles):
            return None
    return Partition(partition.rows, best, partition.redundant)


def _determined(b: Array, dependent: Sequence[int], sizes: Array) -> float:
    """How well B u = const. determines the dependent speeds: their least singular value, relative, with columns divided by `sizes`."""
    values = singular(level(b / sizes)[:, list(dependent)]).values
    return float(values[-1]) if len(values) == len(b) else 0.0


class RateRows:
    """The numerical matrices Y and A_q in the basic rates."""

    def __init__(self, derived: Derived) -> None:
        rates = derived.kinematical.rates
        rows = [dot(list(row.values()), list(row)) for row in derived.kinematical.rows]
        euler = derived.kinematical.euler_rates
        held = [constraint_rate(c) for c in derived.system.constraints]
        held = [substituted(x, euler) for x in held] if euler else held
        self.exprs = (*rows, *held)
        self.count = len(rates)
        self.unit: dict[Any, Any] = dict(zip(rates, np.eye(len(rates), len(rates) + 1), strict=True))

    def at(self, values: Mapping[Expr, Any], count: int) -> Array:
        """[Y; A_q] (count × (n + m) × n) at `values` of all other symbols, numbers or columns (count × 1)."""
        n = self.count
        with np.errstate(all="ignore"):
            numbers = spread(evaluate(self.exprs, {**values, **self.unit}), (count, n + 1)).swapaxes(0, 1)
        return np.asarray(numbers[..., :n] - numbers[..., n:])

    def are_accurate(self, values: Mapping[Expr, Any], every: Array) -> Mask:
        """Whether `every`, the result of `at`, is accurate enough (count) to decide if speeds are determined.

        It is not for a wheel flat on the road, for instance, which has no lowest point: its row is 0/0 up to rounding.
        """
        n = self.count
        scales = balance(every)
        with np.errstate(all="ignore"):
            errors = [e for _, e in bounded(self.exprs, {**values, **self.unit})]
            wide = spread(errors, (len(every), n + 1)).swapaxes(0, 1)
            shares = (wide[..., :n] + wide[..., n:]) / (scales.rows * scales.columns)
        return np.asarray((shares <= NEAR_SINGULAR).all(axis=(1, 2)))

    def admitted(self, both: Array) -> Array | None:
        """B (rank × n) with orthonormal rows and B (Y N) = 0, for [Y; A_q] = `both`; None if that does not determine the rates."""
        n = self.count
        if not np.isfinite(both).all() or singular(balanced(both)).rank(DERIVE_RANK) < n:
            return None
        held = balance(both[n:])
        admitted = singular(held.matrix).kernel(DERIVE_RANK) / held.columns
        return singular(both[:n] @ admitted.T).cokernel(DERIVE_RANK)


class AdmittedSpeeds:
    """The choice of dependent speeds at a state at which W may have a pole; `values` are those of parameters, inputs and time.

    Speeds are scaled by their sizes in the constraints at random configurations.
    """

    def __init__(self, derived: Derived, values: Mapping[Expr, Any]) -> None:
        self.derived, self.rows = derived, RateRows(derived)
        n, q = self.rows.count, derived.system.coordinates
        drawn = np.random.default_rng(SEED).uniform(-np.pi, np.pi, (_SAMPLES, len(q)))
        both = self.rows.at({**values, **dict(zip(q, drawn.T[:, :, None], strict=True))}, _SAMPLES)
        usual = [np.abs(x[n:] @ np.linalg.pinv(x[:n])) for x in both if np.isfinite(x).all()]
        self.sizes = balance(medians(np.array(usual)), order=(1, 0)).columns if usual else np.ones((1, n))

    def others(self, values: Mapping[Expr, Any], dependent: Sequence[int]) -> tuple[int, ...] | None:
        """Speeds that are much better determined at a state than the `dependent` ones, if these are poorly determined; else None."""
        found = self.rows.admitted(self.rows.at(values, 1)[0])
        if found is None or len(found) != len(dependent):
            return None
        b = np.linalg.qr((found / self.sizes).T)[0].T
        rows, as_it_is = tuple(range(len(b))), np.ones_like(b)
        now = quality(b, Partition(rows, tuple(dependent), ()), as_it_is)
        other = choose(b, reach=as_it_is)
        better = len(other.rows) == len(b) and quality(b, other, as_it_is) > max(BETTER * now, POOR)
        return other.dependent if now < POOR and better else None

    def cure(self, values: Mapping[Expr, Any], present: Partition) -> tuple[int, ...] | None:
        """`others`, if the equations are then regular at the state; else None."""
        others = self.others(values, present.dependent)
        if others is None:
            return None
        (both,) = self.rows.at(values, 1)
        regular = singular(balanced(both[: self.rows.count])).regular(NEAR_SINGULAR)
        by = self.partition(values, present, others)
        return tuple(sorted(others)) if regular or without_poles(self.derived, by, fixed=True) is not None else None

    def partition(self, values: Mapping[Expr, Any], present: Partition, dependent: Sequence[int]) -> Partition:
        """The partition of the `dependent` speeds by elimination at a state; at a pole of W with the rows of `present`."""
        n = self.rows.count
        (both,) = self.rows.at(values, 1)
        if singular(balanced(both[:n])).regular(NEAR_SINGULAR):
            result = choose(np.linalg.solve(both[:n].T, both[n:].T).T, dependent)
            if set(result.dependent) == set(dependent):
                return result
        return Partition(present.rows, tuple(sorted(dependent)), present.redundant)


class _Configurations:
    """Configurations at which B u = const. is examined."""

    def __init__(self, derived: Derived) -> None:
        self.system, self.rows = derived.system, RateRows(derived)

    def admissible(self, f: tuple[Expr, ...], pivot: Expr | None = None) -> Iterator[tuple[Array, Callable[[], bool]]]:
        """B (rank × n) at configurations with f = 0 and, if given, `pivot` = 0, each with a function that tests its accuracy.

        Configurations at which Y and A_q together do not determine the rates are left out.
        """
        q = self.system.coordinates
        if pivot is not None:
            size = float(sample([pivot], SEED)[0])
            if not np.isfinite(size):  # undefined at random values, as √(a² − b²) may be
                return
            f = (*f, div(pivot, as_expr(size)))
        values = values_of((*free_symbols([*f, *self.rows.exprs]), *q), SEED, self.rows.unit)
        moving = {*q, *self.rows.unit}
        others = {s: v for s, v in values.items() if s not in moving}
        closed: list[Array] = list(self._starts(values, pivot))
        if f and closed:
            level = Manifold(self.system, (), f).at(others)
            ends = [level.closest(x, CLOSED_FULLY, _STEPS) for x in closed]
            closed = [last.x for last in ends if level.shares(last.residual).max(initial=0) <= CLOSED]
        if not closed:
            return
        places = np.array(closed).reshape(-1, len(q), 1)
        there = values | {x: places[:, k] for k, x in enumerate(q)}
        every = self.rows.at(there, len(places))
        accurate = cache(lambda: self.rows.are_accurate(there, every).tolist())
        for k, both in enumerate(every):
            b = self.rows.admitted(both)
            if b is not None:
                yield b, partial(lambda k: bool(accurate()[k]), k)

    def _starts(self, values: Mapping[Expr, Any], pivot: Expr | None) -> Array:
        """Random configurations or, with a pivot, those at which it is smallest; empty if it is nowhere small."""
        q = self.system.coordinates
        begin = np.array([values[x] for x in q])
        drawn = begin + _SPREAD * np.random.default_rng(SEED).normal(size=(_DRAWN, len(q)))
        place = {x: k for k, x in enumerate(q)}
        for group in self.system.euler_parameters:
            own = [place[e] for e in group.coordinates]
            drawn[:, own] /= np.linalg.norm(drawn[:, own], axis=1, keepdims=True)
        if pivot is None:
            return drawn[:_STARTS]
        with np.errstate(all="ignore"):
            (x,) = evaluate([pivot], {**values, **{c: drawn[:, k] for k, c in enumerate(q)}})
        size = np.abs(np.broadcast_to(x, _DRAWN))
        nearest = np.argsort(size)[:_STARTS]
        return drawn[nearest] if size[nearest[0]] < _SMALL * median(size) else drawn[:0]


SLIPS = 1e-4
"""Share of the largest slip of a motion below which a contact no longer slides, unless its friction says from which speed on."""
PAINLEVE_THRESHOLD = 1e-3
"""Share of its frictionless value below which the reactions' determinant counts as lost: they grow without bound towards 0."""

SINGULAR = "singular kinematics"
"""How the name of the event begins that ends a motion where W does not exist."""

_LARGEST_WATCHED = 3

_STOPS_SLIPPING = (
    "the slip speed of the {0} fell below {1}: {2} sets in, and the direction of the load, given by the slip, is "
    "undefined. The sliding model ends here; friction with smooth= continues, with creep"
)
_OPENS = (
    "the magnitude of the {0} follows from {1}, which must be compressive: at {1} = 0 the contact opens, and the model ends here. If "
    "negative values are compressive, declare the reaction along the opposite direction"
)
_HAS_NO_RATES = (
    "W of q' = W u + X divides by {}, which vanishes here. Choose coordinates that are regular along this motion (another sequence of "
    "angles, Euler parameters), or speeds that need no such division"
)
_HAS_NO_REACTIONS = (
    "the friction multiplies the reactions that it depends on so strongly that they have no unique finite solution. Lower the "
    "friction coefficient, or model the contact as compliant"
)


class SlipEnd(Event):
    """The end of a slip, at its threshold or, if that is zero, at a share of the largest slip speed of the motion."""

    __slots__ = ()

    @property
    def by_share(self) -> bool:
        """Whether the threshold is a share of the largest slip speed."""
        return self.threshold == 0


class KinematicsEnd(Event):
    """The event that a pivot of W passes zero."""

    __slots__ = ()


def watched_events(solved: Solved) -> tuple[Event, ...]:
    """Painlevé's case, the ends of slip and of the kinematics, and the events that the system declares."""
    derived = solved.regular
    events = (
        *painleve_events(solved),
        *slip_events(derived.declared_loads),
        *singular_events(derived.kinematical),
        *(replace(e, quantity=derived.kinematical.in_speeds(e.quantity, {})) for e in derived.system.events),
    )
    quantities = solved.written(e.quantity for e in events)
    return tuple(replace(e, quantity=x) for e, x in zip(events, quantities, strict=True))


def slip_events(loads: Sequence[Load]) -> tuple[Event, ...]:
    """The ends of slip of loads that declare friction, and the loss of contact of loads proportional to a reaction and a speed.

    If such a reaction becomes a pull, the load would add energy to the motion, whether it was declared as friction or not.
    """
    slips: dict[Expr, Event] = {}
    contacts: dict[Expr, str] = {}
    for load in loads:
        held = free_symbols(x for _, v in (*load.forces, *load.torques) for x in v.scalars())
        own = load.slip
        if own is not None and own.speed is not None:
            least = "a ten-thousandth of its largest" if own.threshold is None else f"{own.threshold:g}"
            onset = "rolling" if own.rolls else "sticking"
            told = _STOPS_SLIPPING.format(load.name, least, onset)
            event = SlipEnd(f"onset of {onset} ({load.name})", own.speed, own.threshold or 0.0, -1, message=told)
            slips.setdefault(own.speed, event)
        pressing = own.presses if own is not None else held if any(isinstance(s, Speed) for s in held) else ()
        for s in pressing:
            if isinstance(s, Reaction):
                contacts.setdefault(s, load.name)
    lost = [(r, str(r), name) for r, name in contacts.items()]
    return (
        *slips.values(),
        *(
            Event(f"contact lost ({told} = 0)", r, direction=-1, message=_OPENS.format(name, told))
            for r, told, name in lost
        ),
    )


def singular_events(speeds: Speeds) -> tuple[Event, ...]:
    """The events that pivots of W pass zero, where the speeds do not determine q̇."""
    moving = {p: str(p) for p in dict.fromkeys(speeds.pivots) if not is_constant_in_time([p])}
    return tuple(
        KinematicsEnd(f"{SINGULAR} ({told} = 0)", pivot, message=_HAS_NO_RATES.format(told))
        for pivot, told in moving.items()
    )


def painleve_events(solved: Solved) -> tuple[Event, ...]:
    """The event of Painlevé's case (1895): the ratio of determinants of the reaction matrix with and without friction passes zero.

    The ratio is 1 without loads that depend on reactions; where it vanishes, the reactions have no finite solution. Watched for up to
    three reactions.
    """
    matrix, bare = solved.reaction_matrix, solved.bare_reaction_matrix
    count = matrix.shape[0]
    if not 1 <= count <= _LARGEST_WATCHED:
        return ()
    base = determinant(bare.rows)
    if base is ZERO:  # singular without loads: some reactions occur in loads alone
        return ()
    ratio = div(determinant(matrix.rows), base)
    if ratio is ONE:
        return ()
    return (Event("Painlevé's case", ratio, PAINLEVE_THRESHOLD, -1, message=_HAS_NO_REACTIONS),)
