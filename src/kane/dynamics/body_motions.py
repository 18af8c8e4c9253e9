# SPDX-License-Identifier: BSD-3-Clause
"""The parts of bodies with their motions, and their inertias, each along the frame in which it is constant and short.

A body of revolution may be written in the frame that does not spin with it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kane.errors import ModelError
from kane.expr.evaluation import evaluate, free_symbols, is_constant_in_time, price
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Parameter
from kane.kinematics.aligned import Aligned
from kane.kinematics.velocities import Kinematics, Motion
from kane.model.bodies import Body, Part
from kane.numeric.sampling import SEEDS, draw
from kane.numeric.scale import ROUNDED_CHAIN
from kane.space.frame import Frame
from kane.space.rotation import Basis, Cosines, Triple
from kane.space.vector import Dyadic, Vector
from kane.tree.triples import as_rows


@dataclass(frozen=True, slots=True, eq=False)
class ConstantInertia:
    """The measure numbers of a central inertia dyadic along a frame in which they are constant, and whether the body spins in it."""

    frame: Basis
    rows: Cosines
    spun: bool

    @property
    def uniform(self) -> bool:
        """Whether I is a multiple of the unit dyadic, as that of a sphere: then no frame matters."""
        return all(
            x is (self.rows[0][0] if i == j else ZERO) for i, row in enumerate(self.rows) for j, x in enumerate(row)
        )

    def times(self, w: Vector) -> Vector:
        """I · w."""
        if self.uniform:
            return w * self.rows[0][0]
        components: Triple = w.components(self.frame)
        a, b, c = (dot(row, components) for row in self.rows)
        return Vector(((self.frame, (a, b, c)),))

    def torque(self, motion: Motion, alpha: Vector) -> Vector:
        """I·α + ω × I·ω."""
        if self.uniform:
            return self.times(alpha)
        w = motion.total.express(self.frame)
        return self.times(alpha) + w.cross(self.times(w))


class PartRotation(NamedTuple):
    """The rotation of a part's frame, its central inertia, and what is left of dH/dt at u̇ = 0, the `bias`."""

    frame: Frame
    motion: Motion
    inertia: ConstantInertia
    bias: Vector

    def torque(self, alpha: Vector) -> Vector:
        """I·α + ω × I·ω."""
        return self.inertia.torque(self.motion, alpha)


class Moving(NamedTuple):
    """A part of a body with the motion of its mass centre and, if it is extended, its rotation.

    `shared` are the motions and masses that its momentum is a sum of, where it is not that of its mass at its mass centre.
    """

    body: Body
    part: Part
    center: Motion
    rotation: PartRotation | None
    shared: tuple[tuple[Motion, Expr], ...] = ()

    @property
    def momenta(self) -> tuple[tuple[Motion, Expr], ...]:
        """The momentum as Σ m v: motions, each with its mass."""
        return self.shared or ((self.center, self.part.mass),)


Inertias = list[tuple[Body, Part, ConstantInertia | None]]


def inertias_of(bodies: Iterable[Body], aligned: Aligned) -> Inertias:
    """Each part of each body, and its inertia along the frame in which it is constant and short."""
    return [
        (b, p, constant_inertia(p.name, p.frame, p.inertia, aligned) if p.frame and p.inertia else None)
        for b in bodies
        for p in b.parts()
    ]


def homes(inertias: Inertias, aligned: Aligned) -> dict[Basis, Basis]:
    """For the frames of some parts, the frame along which ω is best written."""
    best = {
        p.frame: inertia.frame
        for _, p, inertia in inertias
        if p.frame is not None and inertia is not None and not inertia.uniform
    }
    return {frame: home for frame, home in best.items() if home is not aligned.rates(frame)[0]}


def moving_parts(inertias: Inertias, kinematics: Kinematics) -> tuple[Moving, ...]:
    """Each part of each body with its motion."""
    return tuple(
        Moving(
            b,
            p,
            kinematics.point(p.mass_center),
            _turning(p.frame, inertia, kinematics) if p.frame is not None and inertia is not None else None,
            tuple((kinematics.point(point), mass) for point, mass in p.momenta),
        )
        for b, p, inertia in inertias
    )


def _turning(frame: Frame, inertia: ConstantInertia, kinematics: Kinematics) -> PartRotation:
    """The rotation of a part; dH/dt in the frame in which it spins where that is shorter, as one writes it for a disk or a top."""
    motion = kinematics.frame(frame)
    bias = inertia.torque(motion, motion.bias)
    if inertia.spun:
        momentum = inertia.times(motion.total.express(inertia.frame))

        def cost(v: Vector) -> int:
            return price(v.components(inertia.frame))

        bias = min(bias, kinematics.turning(momentum), key=cost)
    return PartRotation(frame, motion, inertia, bias)


def constant_inertia(name: str, frame: Frame, inertia: Dyadic, aligned: Aligned) -> ConstantInertia:
    """The inertia along the frame highest up the tree in which its measure numbers are those of the body's own frame."""
    _check_constant(name, frame, inertia)
    frames = inertia.frames()
    home = frames[0] if len(frames) == 1 else frame
    matrix = inertia.components(home)
    if home is not frame and not is_constant_in_time(x for row in matrix.rows for x in row):
        home = frame
        matrix = inertia.components(home)
    moving = [str(s) for s in free_symbols(x for row in matrix.rows for x in row) if not is_constant_in_time([s])]
    wrong = ""
    if moving and _turns_with(matrix):
        wrong = f"measure numbers that depend on {', '.join(moving)}"
    elif home is not frame and _turns_with(inertia.components(frame)):
        wrong = f"one that is constant in {home.name}, in which {frame.name} turns"
    if wrong:
        raise ModelError(
            f"Expected the inertia of {name} constant in its frame {frame.name}, got {wrong}. Write the dyadic along the axes of "
            f"{frame.name}."
        )
    rows = as_rows(list(map(list, matrix.rows)))
    basis, rows = aligned.symmetric(home, rows)
    home = _despun(basis, rows)
    return ConstantInertia(home, rows, home is not basis)


def _check_constant(name: str, frame: Frame, inertia: Dyadic) -> None:
    """A ModelError for measure numbers that vary as they are declared, with time, place or an input: dH/dt would miss their rates."""
    declared = [x for dyad in inertia.dyads for v in dyad for _, triple in v.parts for x in triple]
    varying = [str(s) for s in free_symbols(declared) if not isinstance(s, Parameter)]
    if varying:
        raise ModelError(
            f"Expected a constant inertia of {name}, got measure numbers that depend on {', '.join(varying)}: their rates would be "
            f"missing in dH/dt. Write the dyadic along the axes of {frame.name}, and model what moves in it as bodies of their own."
        )


def _turns_with(matrix: Matrix) -> bool:
    """Whether measure numbers that are constant along other frames differ between configurations, drawn at random."""
    symbols = free_symbols(x for row in matrix.rows for x in row)
    if is_constant_in_time(symbols):
        return False
    points = [{s: draw(SEEDS[0] if isinstance(s, Parameter) else seed, s) for s in symbols} for seed in SEEDS]
    one, *others = (evaluate(matrix, point) for point in points)
    return any(bool(np.abs(other - one).max() > ROUNDED_CHAIN * np.abs(one).max()) for other in others)


def _despun(frame: Basis, rows: Cosines) -> Basis:
    """Climb over rotations about an axis of symmetry: I is the same on either side of them."""
    if _symmetric_about(rows, 0) and _symmetric_about(rows, 1):
        return frame  # a sphere has the same inertia everywhere; its own frame serves
    while frame.orientation is not None:
        axis = frame.orientation.axis
        if axis is None or not _symmetric_about(rows, axis):
            break
        frame = frame.orientation.base
    return frame


def _symmetric_about(rows: Cosines, axis: int) -> bool:
    j, k = (axis + 1) % 3, (axis + 2) % 3
    diagonal = all(rows[i][m] is ZERO for i in range(3) for m in range(3) if i != m)
    return diagonal and rows[j][j] is rows[k][k]
