# SPDX-License-Identifier: BSD-3-Clause
"""The seven steps of the method as records: titles, and results, each with what it is and its name in plain text."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from operator import attrgetter
from typing import Any

from kane.dynamics.derivation import Derived
from kane.dynamics.solved import Solved
from kane.expr.build import add
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Speed, Symbol
from kane.kinematics.velocities import Motion, acceleration_form, velocity_form
from kane.model.constraints import Constraint, constraint_of
from kane.model.system import System
from kane.space.frame import Frame, Point


class Kind(Enum):
    """The kinds of results, each with its name in plain text."""

    SYMBOL = "{place}"
    RATE = "{place}'"
    CONSTRAINT = "(A u + b)[{place}]"
    ANGULAR_VELOCITY = "w_{place}"
    PARTIAL_ANGULAR_VELOCITY = "w_{place},{speed}"
    ANGULAR_ACCELERATION = "alpha_{place}"
    VELOCITY = "v_{place}"
    PARTIAL_VELOCITY = "v_{place},{speed}"
    ACCELERATION = "a_{place}"
    ACTIVE_FORCE = "F_{place}"
    INERTIA_FORCE = "F*_{place}"
    NONHOLONOMIC_ACTIVE_FORCE = "~F_{place}"
    NONHOLONOMIC_INERTIA_FORCE = "~F*_{place}"
    NONHOLONOMIC_PARTIAL_ANGULAR_VELOCITY = "~w_{place},{speed}"
    NONHOLONOMIC_PARTIAL_VELOCITY = "~v_{place},{speed}"
    NONHOLONOMIC_MASS = "~M[{place}, {speed}]"
    NONHOLONOMIC_FORCING = "~f[{place}]"
    MASS = "M[{place}, {speed}]"
    FORCING = "f[{place}]"


@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """A result of a step: its kind, what it belongs to (of F_r, M_rs and f_r the speed r), and the other speed, if it has one."""

    kind: Kind
    place: Frame | Point | Constraint | Symbol
    speed: Symbol | None = None

    def named(self, form: str, written: Callable[[Any], str] = attrgetter("name")) -> str:
        """`form` with place and speed, as `written` writes them."""
        return form.format(place=written(self.place), speed="" if self.speed is None else written(self.speed))

    def __eq__(self, other: object) -> bool:
        """Whether all parts are the same objects: symbols refuse `==`."""
        if not isinstance(other, Quantity):
            return NotImplemented
        return self.kind is other.kind and self.place is other.place and self.speed is other.speed

    def __hash__(self) -> int:
        return hash((self.kind, id(self.place), id(self.speed)))

    def __str__(self) -> str:
        return self.named(self.kind.value)


Result = tuple[Quantity, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One step: its number, title, a sentence on what it does, and its results, expressions or vectors."""

    number: int
    title: str
    text: str
    results: tuple[Result, ...]

    @property
    def items(self) -> tuple[tuple[str, Any], ...]:
        """The results by name."""
        return tuple((str(quantity), value) for quantity, value in self.results)

    def __str__(self) -> str:
        lines = [f"Step {self.number}. {self.title}", f"   {self.text}"]
        lines += [f"   {quantity} = {value}" for quantity, value in self.results]
        return "\n".join(lines)

    __repr__ = __str__


_TITLES = (
    "Coordinates",
    "Velocities that matter",
    "Generalized speeds",
    "Kinematics in the speeds",
    "Generalized active forces",
    "Generalized inertia forces",
    "Equations of motion",
)
REACTIONS = "; the auxiliary equations give the reactions"
STATES = " The further states have their own rates."
"""What is said of step 7 where there are any."""
_TEXTS = (
    "The configuration is described by these.",
    "Angular velocities of the frames and velocities of the points, in the rates of the coordinates.",
    "u = Y q' + z, chosen so that these velocities become short; solved, q' = W u + X.",
    "Angular velocities, velocities, their partial velocities, and accelerations.",
    "F_r = sum of v_r . F + w_r . T over all loads.",
    "F*_r = sum of v_r . (-m a) + w_r . (-I . alpha - w x I . w) over all bodies.",
    f"F_r + F*_r = 0, ordered as M u' = f{REACTIONS}.",
)
_CONSTRAINED = {
    4: _TEXTS[3]
    + " The constraints A u + b = 0 give the dependent speeds, u_D = A_n u_I + b_n, and with them the nonholonomic "
    "partial velocities ~v_r = v_r + sum of v_D A_n[D, r] of the others.",
    5: _TEXTS[4] + " Of the independent speeds, ~F_r = F_r + sum of A_n[D, r] F_D over the dependent ones D.",
    7: "~F_r + ~F*_r = 0, ordered as ~M u_I' = ~f, or M u' = f + A^T lambda with A u + b = 0" + f"{REACTIONS}.",
}
"""The texts of a system with constraints, where they differ."""


def seven_steps(solved: Solved) -> tuple[Step, ...]:
    """Coordinates, velocities that matter, speeds, kinematics, active forces, inertia forces, equations."""
    derived, other = solved.derived.as_declared, _CONSTRAINED if solved.embedding is not None else {}
    system = derived.system
    frames, points = moving_frames_and_points(system)
    results = (
        _each(Kind.SYMBOL, system.coordinates, (q.description or "coordinate" for q in system.coordinates)),
        (
            *((Quantity(Kind.ANGULAR_VELOCITY, f), f.angular_velocity(system.inertial)) for f in frames),
            *((Quantity(Kind.VELOCITY, p), p.velocity(system.inertial)) for p in points),
        ),
        (
            *_each(Kind.SYMBOL, system.speeds, system.speeds.values()),
            *_each(Kind.RATE, system.coordinates, derived.rates),
        ),
        (*_kinematics(derived), *_constrained(solved)),
        _forces(solved, Kind.ACTIVE_FORCE, Kind.NONHOLONOMIC_ACTIVE_FORCE, derived.Fr, solved.Fr_nh),
        _forces(solved, Kind.INERTIA_FORCE, Kind.NONHOLONOMIC_INERTIA_FORCE, derived.Fr_star, solved.Fr_star_nh),
        _equations(solved),
    )
    rows = enumerate(zip(_TITLES, _TEXTS, results, strict=True), start=1)
    said, more = REACTIONS if derived.reactions else "", {7: STATES if derived.states else ""}
    return tuple(
        Step(n, title, other.get(n, text).replace(REACTIONS, said) + more.get(n, ""), values)
        for n, (title, text, values) in rows
    )


def shown_speeds(derived: Derived) -> tuple[Symbol, ...]:
    """The rows that hold partial velocities: speeds and auxiliary speeds of cuts. That of a constraint only lets it give way."""
    return (*derived.speeds, *(s for s in derived.auxiliary_speeds if constraint_of(s) is None))


def moving_frames_and_points(system: System) -> tuple[list[Frame], list[Point]]:
    """All but the inertial frame and the points fixed in it from the beginning."""
    return [f for f in system.frames if f is not system.inertial], [p for p in system.points if p.parent is not None]


def _each(kind: Kind, places: Iterable[Symbol | Constraint], values: Iterable[Any]) -> tuple[Result, ...]:
    return tuple((Quantity(kind, place), value) for place, value in zip(places, values, strict=True))


_TURN = (
    Kind.ANGULAR_VELOCITY,
    Kind.PARTIAL_ANGULAR_VELOCITY,
    Kind.ANGULAR_ACCELERATION,
    Kind.NONHOLONOMIC_PARTIAL_ANGULAR_VELOCITY,
)
_SHIFT = (Kind.VELOCITY, Kind.PARTIAL_VELOCITY, Kind.ACCELERATION, Kind.NONHOLONOMIC_PARTIAL_VELOCITY)


def _moving(derived: Derived) -> list[tuple[Frame | Point, Motion, tuple[Kind, Kind, Kind, Kind]]]:
    frames, points = moving_frames_and_points(derived.system)
    motions = derived.kinematics
    return [*((f, motions.frame(f), _TURN) for f in frames), *((p, motions.point(p), _SHIFT) for p in points)]


def _kinematics(derived: Derived) -> Iterator[Result]:
    for place, motion, (velocity, partial, acceleration, _) in _moving(derived):
        yield Quantity(velocity, place), velocity_form(motion)
        yield from _partials(partial, place, motion, derived.all_speeds)
        yield Quantity(acceleration, place), acceleration_form(motion)


def _partials(kind: Kind, place: Frame | Point, motion: Motion, speeds: Iterable[Symbol]) -> Iterator[Result]:
    """The partial velocities that are not zero."""
    for s in speeds:
        if s in motion.partials and not motion.partials[s].is_zero:
            yield Quantity(kind, place, s), motion.partials[s]


def _constrained(solved: Solved) -> tuple[Result, ...]:
    rows = solved.derived.constraints
    if solved.embedding is None:
        return ()
    return (
        *_each(Kind.CONSTRAINT, rows.constraints, solved.derived.constraint_rates),
        *_each(Kind.SYMBOL, solved.dependent_speeds, map(add, solved.A_n @ solved.independent_speeds, solved.b_n)),
        *(
            result
            for place, motion, kinds in _moving(solved.nonholonomic)
            for result in _partials(kinds[-1], place, motion, solved.independent_speeds)
        ),
    )


def _forces(
    solved: Solved, kind: Kind, nonholonomic: Kind, plain: Sequence[Expr], embedded: Sequence[Expr]
) -> tuple[Result, ...]:
    """F_r of every row, before them ~F_r of the independent ones where there are dependent ones."""
    derived, rows = solved.derived, shown_speeds(solved.derived)
    of_row: dict[Symbol, Expr] = dict(zip(derived.all_speeds, plain, strict=True))
    results = _each(kind, rows, (of_row[s] for s in rows))
    if solved.embedding is None:
        return results
    total: dict[Symbol, Expr] = dict(
        zip((*solved.independent_speeds, *derived.auxiliary_speeds), embedded, strict=True)
    )
    other = [s for s in rows if s in total and (isinstance(s, Speed) or total[s] is not of_row[s])]
    return (*_each(nonholonomic, other, (total[s] for s in other)), *results)


def _equations(solved: Solved) -> tuple[Result, ...]:
    derived = solved.derived
    speeds, blocks, auxiliary = derived.speeds, derived.blocks, derived.auxiliary_speeds
    results: list[Result] = []
    if solved.embedding is not None:
        own = solved.independent_speeds
        for i, (r, row) in enumerate(zip(own, solved.mass_matrix_nh, strict=True)):
            results += _entries(r, own[i:], row[i:], Kind.NONHOLONOMIC_MASS)
        results += _each(Kind.NONHOLONOMIC_FORCING, own, solved.forcing_nh)
    for i, (r, row) in enumerate(zip(speeds, blocks.mass, strict=True)):
        results += _entries(r, speeds[i:], row[i:])
    results += _each(Kind.FORCING, speeds, derived.forcing)
    for s, row, f in zip(auxiliary, blocks.mass_a, derived.auxiliary_forcing, strict=True):
        if constraint_of(s) is None:
            results += [*_entries(s, speeds, row), (Quantity(Kind.FORCING, s), f)]
    multipliers = ((r, constraint_of(r)) for r in derived.reactions)
    results += [(Quantity(Kind.SYMBOL, r), solved.multipliers[c]) for r, c in multipliers if c is not None]
    return (*results, *_each(Kind.RATE, derived.states, derived.state_rates))


def _entries(r: Symbol, speeds: Sequence[Symbol], row: Sequence[Expr], kind: Kind = Kind.MASS) -> list[Result]:
    """The entries of a row of M that are not zero."""
    return [(Quantity(kind, r, s), x) for s, x in zip(speeds, row, strict=True) if x is not ZERO]
