# SPDX-License-Identifier: BSD-3-Clause
"""Sets of bound vectors: resultant, moments, couples, replacement by a force and a couple, wrench and central axis.

    R = Σ F,   M^{S/P} = Σ p × F + Σ T,   M^{S/Q} = M^{S/P} + r^{QP} × R

Kane & Levinson 1985, sec. 4.1 to 4.3. No equations of motion are needed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane import expect, show
from kane.errors import ModelError, cut
from kane.expr.build import div
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.forms.collect import collected
from kane.expr.node import ZERO, Expr
from kane.expr.ops import Immutable
from kane.expr.regular import Sizes, size
from kane.model.loads import Gravity, Load
from kane.model.mass import parts_listed
from kane.numeric.sampling import SEEDS, draw
from kane.numeric.scale import ROUNDED_SUM
from kane.space.frame import Frame, Point
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Wrench(Immutable):
    """The simplest set equivalent to a set of forces: a force along the central axis, and a couple with its torque along it.

    `position` leads from the given point to the nearest point of the central axis. The moment about points of this axis,
    `torque` = pitch · force, has the least magnitude.
    """

    force: Vector
    torque: Vector
    position: Vector
    pitch: Expr

    @property
    def direction(self) -> Vector:
        """Unit vector along the central axis."""
        return self.force.normalized()

    def __repr__(self) -> str:
        return f"Wrench(force {self.force}, torque {self.torque}, at {self.position}, pitch {self.pitch})"

    _repr_html_ = show.html


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ForceSystem(Immutable):
    """A set of bound vectors, from `kn.loads.force_system`: forces at points, and torques of couples."""

    forces: tuple[tuple[Point, Vector], ...]
    torques: tuple[Vector, ...] = ()

    @property
    def resultant(self) -> Vector:
        """R = Σ F (sec. 4.1)."""
        return _short(sum((f for _, f in self.forces), start=Vector()))

    def moment(self, point: Point) -> Vector:
        """Moment about a point, Σ p × F + Σ T (sec. 4.1)."""
        expect.instance(point, Point, "the Point about which a moment is asked for", "Make one with at(…).")
        return _short(
            sum((p.position(point).cross(f) for p, f in self.forces), start=sum(self.torques, start=Vector()))
        )

    @property
    def is_couple(self) -> bool:
        """Whether the resultant is zero: then the moment is the same about all points, the torque of the couple (sec. 4.2)."""
        return _vanishes(self.resultant, [f for _, f in self.forces])

    @property
    def torque(self) -> Vector:
        """Torque of the couple; raises a ModelError if the resultant is not zero."""
        if not self.is_couple:
            came = f"a set with the resultant {cut(self.resultant)}, whose moment depends on the point"
            raise expect.refusal(ModelError, "a couple", f"{came}: use moment(point)")
        return self.moment(self.forces[0][0]) if self.forces else _short(sum(self.torques, start=Vector()))

    def replacement(self, point: Point) -> "ForceSystem":
        """An equivalent set: one force at `point`, and a couple (sec. 4.3)."""
        return ForceSystem(((point, self.resultant),), (self.moment(point),))

    def is_equivalent(self, other: "ForceSystem") -> bool:
        """Whether both sets have the same resultant and the same moment about one point, hence about every point (sec. 4.3)."""
        expect.instance(other, ForceSystem, "another set of forces", "Make one: kn.force_system(loads).")
        both = ForceSystem(
            (*self.forces, *((p, -f) for p, f in other.forces)), (*self.torques, *(-t for t in other.torques))
        )
        if not both.is_couple:
            return False
        if not both.forces:
            return _vanishes(sum(both.torques, start=Vector()), both.torques)
        point = both.forces[0][0]
        arms = [p.position(point).cross(f) for p, f in both.forces]
        return _vanishes(both.moment(point), [*both.torques, *arms])

    def wrench(self, point: Point) -> Wrench:
        """The wrench of the set, with the position of its central axis from `point`: r = R × M/R², M* = (M·R) R/R² (sec. 4.3).

        Raises
        ------
        ModelError
            if the set is a couple, which has no central axis
        """
        if self.is_couple:
            raise ModelError(
                f"Expected a set with a resultant, got a couple of torque {cut(self.moment(point))}: it has no central axis."
            )
        force, moment = self.resultant, self.moment(point)
        square = force.dot(force)
        pitch = collected(div(moment.dot(force), square))
        return Wrench(force, _short(force * pitch), _short(force.cross(moment) / square), pitch)

    def load(self, frame: Frame, name: str = "set of forces") -> Load:
        """The set as a load on a body whose frame is `frame`: its forces, and the torque of its couples."""
        couples = sum(self.torques, start=Vector())
        return Load(name, forces=self.forces, torques=() if couples.is_zero else ((frame, couples),))

    def __add__(self, other: "ForceSystem") -> "ForceSystem":
        if not isinstance(other, ForceSystem):
            return NotImplemented
        return ForceSystem((*self.forces, *other.forces), (*self.torques, *other.torques))

    def __repr__(self) -> str:
        forces = ", ".join(f"{f} at {p.name}" for p, f in self.forces)
        torques = ", ".join(f"torque {t}" for t in self.torques)
        return f"ForceSystem({', '.join(x for x in (forces, torques) if x)})"

    _repr_html_ = show.html


def force_system(loads: Any, *, bodies: Any = ()) -> ForceSystem:
    """The forces and torques of loads as a set of bound vectors (Kane & Levinson 1985, sec. 4.1).

    Parameters
    ----------
    loads : a load, or a list of loads, force systems, forces (point, vector) and gravity
    bodies : the bodies on which gravity acts
    """
    forces: list[tuple[Point, Vector]] = []
    torques: list[Vector] = []
    for x in _listed(loads):
        if isinstance(x, ForceSystem):
            forces += x.forces
            torques += x.torques
        elif isinstance(x, Gravity):
            parts = parts_listed(bodies)
            cure = "Name them: kn.force_system(loads, bodies=[…])."
            expect.that(parts, "bodies on which gravity acts", came="none", cure=cure)
            forces += [(p.mass_center, x.acceleration * p.mass) for p in parts]
        elif isinstance(x, Load):
            came = f"{x.name!r}, which is given by a scalar function only"
            expect.that(x.forces or x.torques, "loads of forces and torques", came=came)
            forces += x.forces
            torques += [t for _, t in x.torques]
        else:
            forces.append(x)
    return ForceSystem(tuple(forces), tuple(torques))


def _listed(item: Any) -> Iterator[Any]:
    if isinstance(item, Load | Gravity | ForceSystem) or (
        isinstance(item, tuple) and len(item) == 2 and isinstance(item[0], Point) and isinstance(item[1], Vector)
    ):
        yield item
    elif expect.is_list(item):
        for x in item:
            yield from _listed(x)
    else:
        expected = "loads such as kn.Force(point, vector) and kn.Torque(frame, vector), or (point, vector)"
        raise expect.refusal(ModelError, expected, cut(repr(item)))


def _terms(v: Vector) -> int:
    return sum(x is not ZERO for x in v.scalars())


def _short(v: Vector) -> Vector:
    """The vector with its measure numbers collected, along one frame if that is shorter."""
    found = v.map(collected)
    whole = v.gathered().map(collected)
    return whole if _terms(whole) < _terms(found) else found


def _vanishes(v: Vector, terms: Sequence[Vector]) -> bool:
    """Whether a sum of terms is zero, as written, or within rounding at several random states."""
    if v.is_zero:
        return True
    frame = v.parts[0][0]
    rows = v.components(frame)
    memo: Sizes = {}
    sizes = [size(x, memo) for t in terms for x in t.components(frame)]
    symbols = free_symbols([*rows, *sizes])
    for seed in SEEDS:
        values = {s: draw(seed, s) for s in symbols}
        found = np.abs(np.asarray(evaluate(list(rows), values), dtype=float)).max()
        bound = np.asarray(evaluate(sizes, values), dtype=float).max(initial=0.0)
        if not found <= ROUNDED_SUM * bound:  # NaN is not zero
            return False
    return True
