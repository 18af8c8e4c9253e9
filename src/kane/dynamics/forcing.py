# SPDX-License-Identifier: BSD-3-Clause
"""Generalized forces and the mass matrix: F_r, F*_r, M, f and G from forces at points, torques on frames and partial velocities.

    F_r = Σ v_r·F + Σ ω_r·T,   F*_r = Σ v_r·(−m a) + Σ ω_r·(−I·α − ω × I·ω)

(Kane & Levinson 1985, sec. 4.4 and 4.11). The equations M u̇ = f + G R, with reactions R, have the same terms at u̇ = 0; terms of one
point or frame are summed before the product with its partial velocity:

    f_r = Σ v_r·(F − m a_b) + Σ ω_r·(T − I·α_b − ω × I·ω),   M_rs = Σ m v_r·v_s + ω_r·I·ω_s

Bodies with a common partial velocity V share one scalar product, Σ_k V·X_k = V·Σ_k X_k. Sums run from the last body to the first, so
that along a chain each partial sum is one shared node.

The inertia of each part of a body is written along a frame in which its measure numbers are constant; for a body of revolution this
may be a frame that does not spin with it.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import starmap
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from kane.errors import ModelError
from kane.expr.build import add, sum_of
from kane.expr.differentiation import Affine, affine_forms
from kane.expr.evaluation import evaluate, free_symbols, is_constant_in_time, price
from kane.expr.matrix import Matrix, dot
from kane.expr.matrix import blocks as connected
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.ops import CONST
from kane.expr.square_system import Contents, content, divider, over_number
from kane.expr.symbols import Parameter, QuasiRate, Rate, Reaction
from kane.expr.visit import remembered
from kane.kinematics.aligned import Aligned
from kane.kinematics.speeds import Speeds
from kane.kinematics.velocities import Kinematics, Motion, acceleration_form
from kane.model.bodies import Body, Part
from kane.model.loads import Load, Slip
from kane.numeric.sampling import SEEDS, draw
from kane.numeric.scale import ROUNDED_CHAIN
from kane.space.frame import Frame, Point
from kane.space.rotation import Basis, Cosines, Triple
from kane.space.vector import Dyadic, Parts, Vector
from kane.tree.triples import as_rows


@dataclass(frozen=True, slots=True, eq=False)
class ConstantInertia:
    """A central inertia dyadic by constant measure numbers along a frame; `spun` if the body rotates relative to that frame."""

    frame: Basis
    rows: Cosines
    spun: bool

    @property
    def uniform(self) -> bool:
        """Whether I is a multiple of the unit dyadic, as that of a sphere."""
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


@dataclass(frozen=True, eq=False)
class PartRotation:
    """The rotation of a part's frame, and its central inertia; `made` computes the bias of dH/dt."""

    frame: Frame
    motion: Motion
    inertia: ConstantInertia
    made: Callable[[], Vector] = Vector

    @cached_property
    def bias(self) -> Vector:
        """dH/dt at u̇ = 0, with H the central angular momentum."""
        return self.made()

    def torque(self, alpha: Vector) -> Vector:
        """I·α + ω × I·ω."""
        return self.inertia.torque(self.motion, alpha)


class Moving(NamedTuple):
    """A part of a body with the motion of its mass centre and, if it is extended, its rotation.

    `shared`, if not empty, gives the momentum of the part as Σ m v over motions, instead of its mass times the velocity of its centre.
    """

    body: Body
    part: Part
    center: Motion
    rotation: PartRotation | None
    shared: tuple[tuple[Motion, Expr], ...] = ()

    @property
    def momenta(self) -> tuple[tuple[Motion, Expr], ...]:
        """Pairs (motion, mass) whose Σ m v is the momentum."""
        return self.shared or ((self.center, self.part.mass),)


Inertias = list[tuple[Body, Part, ConstantInertia | None]]


def inertias_of(bodies: Iterable[Body], aligned: Aligned) -> Inertias:
    """Each part of each body, with its inertia along a frame in which it is constant; None of a particle."""
    return [
        (b, p, constant_inertia(p.name, p.frame, p.inertia, aligned) if p.frame and p.inertia else None)
        for b in bodies
        for p in b.parts()
    ]


def homes(inertias: Inertias, aligned: Aligned) -> dict[Basis, Basis]:
    """The frame of the inertia, by the frame of the part, if ω is to be written along it and not along the part's own basis."""
    best = {
        p.frame: inertia.frame
        for _, p, inertia in inertias
        if p.frame is not None and inertia is not None and not inertia.uniform
    }
    return {frame: home for frame, home in best.items() if home is not aligned.rates(frame)[0]}


def moving_parts(inertias: Inertias, kinematics: Kinematics) -> tuple[Moving, ...]:
    """The parts of bodies with their motions."""
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
    """The rotation of a part. If it spins relative to the inertia's frame, the shorter of I·α + ω × I·ω and d(I·ω)/dt is the bias."""
    motion = kinematics.frame(frame)

    def cost(v: Vector) -> int:
        return price(v.components(inertia.frame))

    def bias() -> Vector:
        usual = inertia.torque(motion, motion.bias)
        if not inertia.spun:
            return usual
        momentum = inertia.times(motion.total.express(inertia.frame))
        return min(usual, kinematics.turning(momentum), key=cost)

    return PartRotation(frame, motion, inertia, bias)


def constant_inertia(name: str, frame: Frame, inertia: Dyadic, aligned: Aligned) -> ConstantInertia:
    """The inertia along the frame nearest to the root in which it is constant. ModelError if measure numbers vary in `frame`."""
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
    """Raises a ModelError if declared measure numbers vary with coordinates, time or inputs, as dH/dt would lack their rates."""
    declared = [x for dyad in inertia.dyads for v in dyad for _, triple in v.parts for x in triple]
    varying = [str(s) for s in free_symbols(declared) if not isinstance(s, Parameter)]
    if varying:
        raise ModelError(
            f"Expected a constant inertia of {name}, got measure numbers that depend on {', '.join(varying)}: their rates would be "
            f"missing in dH/dt. Write the dyadic along the axes of {frame.name}, and model what moves in it as separate bodies."
        )


def _turns_with(matrix: Matrix) -> bool:
    """Whether measure numbers differ between random configurations."""
    symbols = free_symbols(x for row in matrix.rows for x in row)
    if is_constant_in_time(symbols):
        return False
    points = [{s: draw(SEEDS[0] if isinstance(s, Parameter) else seed, s) for s in symbols} for seed in SEEDS]
    one, *others = (evaluate(matrix, point) for point in points)
    return any(bool(np.abs(other - one).max() > ROUNDED_CHAIN * np.abs(one).max()) for other in others)


def _despun(frame: Basis, rows: Cosines) -> Basis:
    """The nearest ancestor below which all rotations are about an axis of symmetry, so that I has the same measure numbers in it."""
    if _symmetric_about(rows, 0) and _symmetric_about(rows, 1):
        return frame  # a sphere: I is the same in all frames
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


class LoadTerm(NamedTuple):
    """A force at a point or a torque on a frame (`place`), and the motion of that point or frame."""

    place: Point | Frame
    vector: Vector
    motion: Motion


def acting(loads: Iterable[Load]) -> Iterator[tuple[Point | Frame, Vector]]:
    """Pairs (point, force) and (frame, torque) of loads."""
    for load in loads:
        yield from load.forces
        yield from load.torques


def active_terms(load: Load, kinematics: Kinematics) -> tuple[LoadTerm, ...]:
    """The forces and torques of one load, with the motions of their points and frames."""
    return tuple(LoadTerm(p, kinematics.aligned.vector(v), kinematics.of(p)) for p, v in acting([load]))


def inertia_terms(moving: Moving) -> tuple[LoadTerm, ...]:
    """−m a at the mass centre and −(I·α + ω × I·ω) on the frame of one part of a body, in u̇."""
    part, center, rotation = moving.part, moving.center, moving.rotation
    force = sum((acceleration_form(m) * -mass for m, mass in moving.momenta), start=Vector())
    shift = LoadTerm(part.mass_center, force, center)
    if rotation is None:
        return (shift,)
    return shift, LoadTerm(rotation.frame, -rotation.torque(acceleration_form(rotation.motion)), rotation.motion)


def bias_terms(
    loads: Iterable[LoadTerm], bodies: Sequence[Moving], fall: Vector, u_dot: Mapping[Expr, Expr] = MappingProxyType({})
) -> list[LoadTerm]:
    """The terms of f: loads, weights by the acceleration `fall`, and inertia forces at u̇ = 0 or `u_dot`.

    One term per point or frame, forces first.
    """
    by_place: dict[Point | Frame, LoadTerm] = {}
    for term in loads:
        before = by_place.get(term.place)
        by_place[term.place] = term if before is None else term._replace(vector=before.vector + term.vector)
    forces: list[LoadTerm] = []
    torques: list[LoadTerm] = []
    given = tuple(u_dot.items())
    for moving in reversed(bodies):
        part, center, rotation = moving.part, moving.center, moving.rotation
        own = _inertia_force(moving.momenta, bool(moving.shared), fall.parts, given)
        load = by_place.pop(part.mass_center, None)
        forces.append(LoadTerm(part.mass_center, (own if load is None else own + load.vector).gathered(), center))
        if rotation is not None:
            load = by_place.pop(rotation.frame, None)
            torque = _left_torque(rotation, () if load is None else load.vector.parts, given)
            torques.append(LoadTerm(rotation.frame, torque, rotation.motion))
    forces += [term for place, term in by_place.items() if isinstance(place, Point)]
    torques += [term for place, term in by_place.items() if isinstance(place, Frame)]
    return [*forces, *torques]


_Given = tuple[tuple[Expr, Expr], ...]
"""u̇ by speed."""


@remembered
def _inertia_force(momenta: tuple[tuple[Motion, Expr], ...], shared: bool, fall: Parts, u_dot: _Given) -> Vector:
    """Σ m (g − a) at u̇ = 0 or `u_dot`."""
    total = Vector()
    for motion, mass in momenta:
        own = (Vector(fall) - motion.bias).gathered()
        if u_dot:
            own = (own - _acceleration(motion, u_dot)).gathered()
        total = total + own * mass
    return total.gathered() if shared else total


@remembered
def _left_torque(rotation: PartRotation, load: Parts, u_dot: _Given) -> Vector:
    """T − I·α − ω × I·ω at u̇ = 0 or `u_dot`."""
    torque = Vector(load) - rotation.bias
    return (torque - rotation.inertia.times(_acceleration(rotation.motion, u_dot))).gathered() if u_dot else torque


@remembered
def _acceleration(motion: Motion, u_dot: _Given) -> Vector:
    """Σ v_r u̇_r."""
    own = dict(u_dot)
    return sum((v * own[s] for s, v in motion.partials.items() if s in own), start=Vector()).gathered()


def terms_moved_by(terms: Iterable[LoadTerm], speed: Expr) -> Iterator[tuple[LoadTerm, Vector]]:
    """The terms with a partial velocity for `speed`, each with it."""
    return ((term, term.motion.partials[speed]) for term in terms if speed in term.motion.partials)


def generalized(terms: Iterable[LoadTerm], speed: Expr) -> Expr:
    """Σ v_r·F + Σ ω_r·T, term by term."""
    return sum_of(partial.dot(term.vector) for term, partial in terms_moved_by(terms, speed))


def generalized_by_motion(
    terms: Iterable[LoadTerm], speed: Expr, product: Callable[[Vector, Vector], Expr] = Vector.dot
) -> Expr:
    """Σ v_r·F + Σ ω_r·T; forces with equal v_r, and torques with equal ω_r, are summed before the scalar `product`."""
    met = [
        (isinstance(place, Frame), motion.partials[speed], vector)
        for place, vector, motion in terms
        if vector.parts and speed in motion.partials
    ]
    return _by_motion(tuple(met), product)


@remembered
def _by_motion(met: tuple[tuple[bool, Vector, Vector], ...], product: Callable[[Vector, Vector], Expr]) -> Expr:
    """The same for triples (is angular, partial velocity, vector)."""
    shifts: dict[Parts, tuple[Vector, Vector]] = {}
    turns: dict[Parts, tuple[Vector, Vector]] = {}
    for angular, partial, vector in met:
        group = turns if angular else shifts
        key = partial.parts
        known = group.get(key)
        group[key] = partial, vector if known is None else (known[1] + vector).gathered()
    return add(sum_of(starmap(product, shifts.values())), sum_of(starmap(product, turns.values())))


def loads_in_speeds(loads: Sequence[Load], speeds: Speeds) -> tuple[Load, ...]:
    """The loads with every rate written in speeds."""
    memo: dict[Expr, Affine] = {}

    def convert(e: Expr) -> Expr:
        return speeds.in_speeds(e, memo)

    symbols = free_symbols(x for _, v in acting(loads) for x in v.scalars())
    if not any(isinstance(s, Rate | QuasiRate) for s in symbols):
        return tuple(loads)
    return tuple(
        Load(
            load.name,
            tuple((p, v.map(convert)) for p, v in load.forces),
            tuple((f, v.map(convert)) for f, v in load.torques),
            load.potential,
            _converted(load.slip, convert),
        )
        for load in loads
    )


def _converted(slip: Slip | None, convert: Callable[[Expr], Expr]) -> Slip | None:
    return slip if slip is None or slip.speed is None else replace(slip, speed=convert(slip.speed))


Rows = list[list[Expr]]
Place = tuple[int, int]

_FEW = 6
"""The largest number of coupled equations in which common factors are looked for."""


class Blocks(NamedTuple):
    """M (n × n), f (n) and G (n × reactions) of the generalized speeds; M_a, f_a and G_a of the auxiliary speeds.

    `evident` is G_a without the part of loads that depend on reactions.
    """

    mass: Matrix
    forcing: tuple[Expr, ...]
    coupling: Matrix
    mass_a: Matrix
    forcing_a: tuple[Expr, ...]
    coupling_a: Matrix
    evident: Matrix


def blocks(
    mass: Rows,
    right: Sequence[Expr],
    auxiliary: Sequence[Expr],
    reactions: Sequence[Reaction],
    pairs: Mapping[tuple[Expr, Expr], Expr],
) -> Blocks:
    """M, f and G from the rows of M and f + G R, auxiliary speeds last; `pairs` are the reactions that these bring into evidence."""
    n, r = len(mass) - len(auxiliary), len(reactions)
    forcing, coupling = _reaction_form(right, reactions)
    evident = Matrix([[pairs.get((s, x), ZERO) for x in reactions] for s in auxiliary], (len(auxiliary), r))
    return Blocks(
        Matrix(mass[:n], (n, n)),
        tuple(forcing[:n]),
        Matrix(coupling[:n], (n, r)),
        Matrix(mass[n:], (len(auxiliary), n)),
        tuple(forcing[n:]),
        Matrix(coupling[n:], (len(auxiliary), r)) + evident,
        evident,
    )


def _reaction_form(right: Sequence[Expr], reactions: Sequence[Reaction]) -> tuple[list[Expr], Rows]:
    """f and G of the right-hand sides f + G R, which are affine in R."""
    if not reactions or not any(isinstance(s, Reaction) for s in free_symbols(right)):
        return list(right), [[ZERO] * len(reactions) for _ in right]
    forms = affine_forms(right, reactions)
    return [rest for _, rest in forms], [[c.get(r, ZERO) for r in reactions] for c, _ in forms]


def mass_rows(bodies: Sequence[Moving], speeds: Sequence[Expr], auxiliary: Sequence[Expr]) -> Rows:
    """The rows M_rs = Σ m v_r·v_s + ω_r·I·ω_s, for r in `speeds`, then `auxiliary`, and s in `speeds`."""
    symbols, n = [*speeds, *auxiliary], len(speeds)
    vectors: dict[Parts, Vector] = {}
    shifts: dict[Place, dict[Vector, dict[Vector, Expr]]] = {}  # v_r → (v_s → Σ m) over the bodies that both move
    turns: dict[Place, dict[Vector, Vector]] = {}  # ω_r → Σ I·ω_s over the bodies that both turn
    for b in reversed(bodies):
        met = _numbered(b.center, symbols, vectors)
        for motion, mass in b.momenta:
            moved = met if motion is b.center else _numbered(motion, symbols, vectors)
            for i, j in _pairs(met, moved, n):
                masses = shifts.setdefault((i, j), {}).setdefault(met[i], {})
                v = moved[j]
                masses[v] = add(masses[v], mass) if v in masses else mass
        if b.rotation is None:
            continue
        turned = _numbered(b.rotation.motion, symbols, vectors)
        momenta = {j: b.rotation.inertia.times(w) for j, w in turned.items() if j < n}
        for i, j in _pairs(turned, turned, n):
            group, w = turns.setdefault((i, j), {}), turned[i]
            group[w] = (group[w] + momenta[j]).gathered() if w in group else momenta[j]
    rows: Rows = []
    carried: dict[tuple[Any, ...], Vector] = {}
    for i in range(len(symbols)):
        line = [rows[j][i] for j in range(i)] if i < n else []
        for j in range(len(line), n):
            shift = sum_of([v.dot(_carried(masses, carried)) for v, masses in shifts.get((i, j), {}).items()])
            line.append(add(shift, sum_of([w.dot(h) for w, h in turns.get((i, j), {}).items()])))
        rows.append(line)
    return rows


def _numbered(motion: Motion, symbols: Sequence[Expr], vectors: dict[Parts, Vector]) -> dict[int, Vector]:
    """The partial velocities by the number of the speed; equal ones are one object, to be compared by identity."""
    partials = motion.partials
    return {i: vectors.setdefault(partials[s].parts, partials[s]) for i, s in enumerate(symbols) if s in partials}


def _pairs(met: Iterable[int], moved: Iterable[int], n: int) -> list[Place]:
    """The entries of M to which a body contributes, on and above the diagonal and in auxiliary rows."""
    return [(i, j) for i in met for j in moved if j < n and (i <= j or i >= n)]


def _carried(masses: Mapping[Vector, Expr], vectors: dict[tuple[Any, ...], Vector]) -> Vector:
    """Σ m v_s, one object for equal groups."""
    key = tuple(masses.items())
    if key not in vectors:
        vectors[key] = sum((v * mass for v, mass in masses.items()), start=Vector()).gathered()
    return vectors[key]


def primitive(blocks: Blocks) -> Blocks:
    """M, f and G divided by parameters common to all terms of a block of coupled equations; M stays symmetric.

    An uncoupled equation whose entry of M is a number is divided by that too.
    """
    count = len(blocks.forcing)
    memo: Contents = {}
    divided = divider(memo)
    mass, coupling = ([list(row) for row in m.rows] for m in (blocks.mass, blocks.coupling))
    forcing, changed = list(blocks.forcing), False
    for rows in connected(blocks.mass.rows, list(range(count))):
        if len(rows) > _FEW:
            continue
        common = content((x for i in rows for x in (*mass[i], *coupling[i], forcing[i])), memo)
        if not common:
            continue
        changed = True
        for i in rows:
            mass[i] = [divided(x, common) for x in mass[i]]
            coupling[i] = [divided(x, common) for x in coupling[i]]
            forcing[i] = divided(forcing[i], common)
        i = rows[0]
        number = mass[i][i]
        if len(rows) == 1 and number.op is CONST and all(x is ZERO for x in coupling[i]):
            mass[i][i], forcing[i] = ONE, over_number(forcing[i], number)
    if not changed:
        return blocks
    return blocks._replace(
        mass=Matrix(mass, (count, count)), forcing=tuple(forcing), coupling=Matrix(coupling, blocks.coupling.shape)
    )
