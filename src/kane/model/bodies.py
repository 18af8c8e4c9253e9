# SPDX-License-Identifier: BSD-3-Clause
"""Bodies, as parts that each have a mass, a mass centre and, if they are extended, a frame and an inertia.

Masses and inertias that are impossible at default parameters are refused. A central inertia is symmetric, its principal moments are
not negative, and none is larger than the sum of the other two (∫ (y² + z²) dm ≤ ∫ (x² + z²) dm + ∫ (x² + y²) dm; equal for a flat
body).
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, TypeGuard, runtime_checkable
from weakref import WeakKeyDictionary

import numpy as np

from kane import expect
from kane.errors import ModelError, cut, warn
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Parameter, Speed, Symbol
from kane.expr.visit import remembered
from kane.model.solids import central_inertia
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEED, SEEDS, draw, in_range, sample
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame, Point
from kane.space.rotation import Basis
from kane.space.vector import Dyadic, angular_velocity, check_connected


class Part(NamedTuple):
    """A rigid part of the body `name`: a mass at a mass centre, and the frame and central inertia dyadic, if it is extended.

    A point of a flexible body whose momentum is not m v has `momenta`: Σ μ v over these points, itself included, where μ of P for
    Q is that of Q for P, and the mass is Σ μ. The kinetic energy is then ½ Σ μ v^P·v^Q over all pairs.
    """

    name: str
    mass: Expr
    mass_center: Point
    frame: Frame | None = None
    inertia: Dyadic | None = None
    momenta: tuple[tuple[Point, Expr], ...] = ()


@runtime_checkable
class Body(Protocol):
    """A body: a name, and parts with mass."""

    @property
    def name(self) -> str:
        """The name, by which results are accessed."""

    def parts(self) -> tuple[Part, ...]:
        """The parts with mass, motion and inertia."""


@runtime_checkable
class Deforming(Body, Protocol):
    """A deformable body, with its own coordinates, their rates as speeds, and its own loads."""

    coordinates: tuple[Coordinate, ...]
    speeds: Mapping[Speed, Expr]
    named: frozenset[Symbol]
    """Symbols with units assigned by the body."""

    @property
    def own_loads(self) -> tuple[Any, ...]:
        """The loads due to its deformation."""

    @property
    def mass(self) -> Expr:
        """Mass of the whole body."""

    def defined_by(self, definitions: Mapping[Speed, Expr]) -> bool:
        """Whether a definition contains the rate of one of its coordinates."""


def parts_of(bodies: Iterable[Body]) -> Iterator[Part]:
    """The parts of all bodies."""
    return (part for body in bodies for part in body.parts())


def deforming(bodies: Iterable[Body]) -> tuple[Deforming, ...]:
    """The deformable bodies."""
    return _deforming(tuple(bodies))


@remembered
def _deforming(bodies: tuple[Body, ...]) -> tuple[Deforming, ...]:
    return tuple([body for body in bodies if _deforms(body)])


def _deforms(body: Body) -> TypeGuard[Deforming]:
    """Whether a body is deformable; tested for one attribute first, as the test of a whole protocol is slow."""
    return hasattr(type(body), "own_loads") and isinstance(body, Deforming)


def brought_loads(bodies: Iterable[Body]) -> tuple[Any, ...]:
    """The loads that belong to deformable bodies."""
    return tuple(load for body in deforming(bodies) for load in body.own_loads)


def _check_center(name: str, point: Any) -> None:
    expect.instance(point, Point, f"a Point as the position of {name}")
    if point.body is not None:
        came = f"{point.name}, the particle of {point.body.name} at that position"
        raise expect.refusal(ModelError, f"a geometric point for {name}", came, "Make the point with at(...).")


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Particle(Immutable):
    """A particle: a mass at a point."""

    name: str
    point: Point
    mass: Expr

    def __init__(self, name: str, point: Point, mass: Any) -> None:
        m = as_expr(mass)
        check_mass(expect.name(name, "a text as the name of a particle"), m)
        _check_center(name, point)
        for slot, value in (("name", name), ("point", point), ("mass", m)):
            object.__setattr__(self, slot, value)

    @property
    def mass_center(self) -> Point:
        """The point."""
        return self.point

    def __reduce__(self) -> tuple[Callable[..., "Particle"], tuple[Any, ...]]:
        return Particle, (self.name, self.point, self.mass)

    def parts(self) -> tuple[Part, ...]:
        """The particle itself."""
        return (Part(self.name, self.mass, self.point),)

    def __repr__(self) -> str:
        return f"Particle({self.name!r}, at {self.point.name})"


@dataclass(frozen=True, slots=True, eq=False, init=False)
class RigidBody(Immutable):
    """A rigid body: the frame fixed in it, its mass centre, mass (kg) and central inertia dyadic (kg m²).

    With `inertia=(dyadic, point)` the dyadic is the inertia about another point of the body; `inertia` is then the central one.
    """

    _other_names = MappingProxyType({"mass_center": "center com masscenter point", "inertia": "central_inertia"})

    name: str
    frame: Frame
    mass_center: Point
    mass: Expr
    inertia: Dyadic

    def __init__(
        self, name: str, *, frame: Frame, mass_center: Point, mass: Any, inertia: Dyadic | tuple[Dyadic, Point]
    ) -> None:
        m = as_expr(mass)
        check_mass(expect.name(name, "a text as the name of a rigid body"), m)
        _check_center(name, mass_center)
        expect.instance(frame, Frame, f"a Frame for the body {name}")
        if isinstance(inertia, tuple):
            inertia = _central(name, frame, mass_center, m, inertia)
        if not isinstance(inertia, Dyadic):
            raise ModelError(
                f"Expected an inertia dyadic for {name}, such as kn.inertia({frame.name}, Ixx, Iyy, Izz), got "
                f"{type(inertia).__name__} ({cut(inertia)}). kn.rod, kn.thin_disk, kn.box, … make those of solids."
            )
        check_inertia(name, inertia)
        check_connected(mass_center.frame, frame)
        values = (("name", name), ("frame", frame), ("mass_center", mass_center), ("mass", m), ("inertia", inertia))
        for slot, value in values:
            object.__setattr__(self, slot, value)

    def __reduce__(self) -> tuple[Callable[..., "RigidBody"], tuple[Any, ...]]:
        return partial(RigidBody, **{slot: getattr(self, slot) for slot in self.__slots__}), ()

    def parts(self) -> tuple[Part, ...]:
        """The body itself."""
        return (Part(self.name, self.mass, self.mass_center, self.frame, self.inertia),)

    def __repr__(self) -> str:
        return f"RigidBody({self.name!r}, frame {self.frame.name}, mass centre {self.mass_center.name})"


def _central(name: str, frame: Frame, center: Point, mass: Expr, about: tuple[Any, ...]) -> Dyadic:
    """The central inertia of a body from that about another point of it."""
    expected = f"inertia=dyadic, about the mass centre, or inertia=(dyadic, point) for {name}"
    dyadic, point = expect.pair(about, expected)
    expect.that(isinstance(dyadic, Dyadic) and isinstance(point, Point), expected, about)
    check_connected(frame, point.frame)
    offset = center.position(point).express(frame)
    moving = (s for s in free_symbols(offset.scalars()) if not isinstance(s, Parameter))
    expected = f"the inertia of {name} about a point fixed in {frame.name}"
    came = f"one about {point.name}, whose position in the frame depends on {{}}"
    cure = f"Give it about a point that moves with the body, or about the mass centre {center.name}."
    expect.none(moving, expected, came, cure)
    return central_inertia(dyadic, mass, offset)


_AXES = "xyz"
_PAIRS = ((0, 1), (1, 2), (2, 0))


def check_mass(name: str, mass: Expr) -> None:
    """Raise ModelError unless a mass is constant, and not negative at default parameters.

    With a varying mass, the momentum of the mass that leaves or joins would be missing.
    """
    varying = (s for s in free_symbols([mass]) if not isinstance(s, Parameter))
    came = "one that depends on {}: the momentum of the mass that leaves or joins, ṁ v, would be missing"
    cure = "Model moving masses as separate bodies, and expelled mass as the force that it exerts."
    expect.none(varying, f"a constant mass of {name}", came, cure)
    in_range(mass, f"a mass ≥ 0 for {name}", above=False)


def check_inertia(name: str, inertia: Dyadic) -> None:
    """Raise ModelError unless a central inertia is symmetric with nonnegative moments; warn of a violated triangle inequality."""
    n = _numbers(inertia)
    if n is None:
        return
    frame = inertia.frames()[0]
    size = max(abs(x) for row in n for x in row)
    for i, j in _PAIRS:
        a, b, alike = _AXES[i], _AXES[j], abs(n[i][j] - n[j][i]) <= DECLARED * size
        came = f"I{a}{b} = {n[i][j]:g} and I{b}{a} = {n[j][i]:g} along the axes of {frame.name}"
        cure = f"Write kn.inertia({frame.name}, Ixx, Iyy, Izz, Ixy, Iyz, Izx), which sets both."
        expect.that(alike, f"a symmetric inertia for {name}", came=came, cure=cure)
    tilted = any(n[i][j] for i, j in _PAIRS)
    low, middle, high = np.linalg.eigvalsh(n) if tilted else sorted(n[i][i] for i in range(3))
    said = f"{low:g}, {middle:g}, {high:g}"
    expected = f"central principal moments of inertia ≥ 0 for {name}"
    cure = "Check the signs; an inertia about another point than the mass centre is larger by m r², not smaller."
    expect.that(low >= -DECLARED * size, expected, came=said, cure=cure)
    if high > (low + middle) * (1 + DECLARED) and middle > DECLARED * high:
        warn(
            f"Expected principal moments of inertia for {name} of which none is larger than the sum of the other two, got "
            f"{said}: no body has them. Check them and the signs of the products Ixy, Iyz, Izx (−∫ x y dm, …). In a plane, where Izz "
            "alone counts, give any Ixx and Iyy with Ixx + Iyy ≥ Izz."
        )


def moments(part: Part, constants: Mapping[Expr, Any]) -> Array | None:
    """Central principal moments (… × 3) in ascending order, at values of the parameters, numbers or columns.

    None without inertia, if it contains other symbols, or if no value is finite; NaN in rows that are not finite.
    """
    inertia = part.inertia
    if inertia is None or not (frames := inertia.frames()):
        return None
    rows = inertia.components(frames[0]).rows
    symbols = free_symbols(x for row in rows for x in row)
    if any(s not in constants and (isinstance(s, Parameter) or len(frames) == 1) for s in symbols):
        return None
    values = {s: constants[s] if s in constants else draw(SEED, s) for s in symbols}
    entries = np.stack(np.broadcast_arrays(*evaluate([x for row in rows for x in row], values)), axis=-1)
    n = entries.astype(float).reshape(*entries.shape[:-1], 3, 3)
    finite = np.isfinite(n).all(axis=(-2, -1), keepdims=True)
    if not finite.any():
        return None
    found = np.linalg.eigvalsh(np.where(finite, (n + n.swapaxes(-2, -1)) / 2, 0.0))
    return np.where(finite[..., 0], found, np.nan)


def least_moment(part: Part, constants: Mapping[Expr, Any]) -> Any:
    """The least principal moment, 0 if it is within rounding; None if it is unknown."""
    found = moments(part, constants)
    if found is None:
        return None
    return np.where(np.abs(found[..., 0]) <= DECLARED * np.abs(found[..., -1]), 0.0, found[..., 0])


def largest_moment(part: Part, constants: Mapping[Expr, float]) -> float:
    """The largest principal moment, 0 without inertia, 1 if it is unknown."""
    found = moments(part, constants)
    return float(found[-1]) if found is not None else 0.0 if part.inertia is None else 1.0


def check_turning(inertial: Basis, bodies: Iterable[Body]) -> None:
    """Warn of rigid bodies with a moment of inertia about one axis only that also rotate about another: no body has such inertia."""
    parts = parts_of(b for b in bodies if not _deforms(b))
    turning = [x.name for x in parts if x.frame and x.inertia and _turns_off_its_axis(inertial, x.frame, x.inertia)]
    if turning:
        warn(
            f"Expected moments of inertia about all axes for {', '.join(turning)}, got one about a single axis although they turn "
            "about others too: no body has such an inertia. Give all three principal moments."
        )


def _turns_off_its_axis(inertial: Basis, frame: Basis, inertia: Dyadic) -> bool:
    n = _numbers(inertia)
    if n is None:
        return False
    if not any(n[i][j] or n[j][i] for i, j in _PAIRS):  # most inertia matrices are diagonal
        _, middle, high = sorted(n[i][i] for i in range(3))
        if not (high > 0 and middle <= DECLARED * high):
            return False
    (_, middle, high), axes = np.linalg.eigh(n)
    if not (high > 0 and middle <= DECLARED * high):
        return False
    spin = angular_velocity(frame, inertial).express(inertia.frames()[0]).scalars()
    for seed in SEEDS:
        w = np.array(sample(spin, seed))
        if len(w) and np.isfinite(w).all() and np.abs(np.cross(w, axes[:, 2])).max() > DECLARED * np.abs(w).max():
            return True
    return False


_matrices: WeakKeyDictionary[Dyadic, list[list[float]] | None] = WeakKeyDictionary()
"""Inertia matrices along the first frame of each dyadic, stored because bodies and systems ask repeatedly."""


def _numbers(inertia: Dyadic) -> list[list[float]] | None:
    """The inertia matrix at default parameters; None if a default is missing, or the matrix is not constant in its one frame.

    With several frames, rotations between them are random: symmetry and principal moments do not depend on them.
    """
    if inertia not in _matrices:
        _matrices[inertia] = _computed(inertia)
    return _matrices[inertia]


def _computed(inertia: Dyadic) -> list[list[float]] | None:
    frames = inertia.frames()
    entries = inertia.components(frames[0]).entries if frames else ()
    missing = [s for s in free_symbols(entries) if s.default is None]
    if not frames or any(isinstance(s, Parameter) for s in missing) or (missing and len(frames) == 1):
        return None
    values = sample(entries, SEED)
    return [values[0:3], values[3:6], values[6:9]] if all(map(math.isfinite, values)) else None
