# SPDX-License-Identifier: BSD-3-Clause
"""`Beam`: a straight flexible beam by assumed modes, a body like any other.

A warning is given if a beam spins so fast that its missing stiffening or its too few functions matter. A beam with its root fixed that
spins at Ω about a transverse axis has out-of-plane frequencies ω of (k EI/L³ + Ω² ρA L S) x = ω² ρA L m x, S = ∫ m₁ φ'_i φ'_j dξ.
Those with more functions are lower; the difference is the error of the beam's own functions.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache, partial
from typing import Any

import numpy as np

from kane import expect
from kane.errors import KaneWarning, ModelError, ModesWarning, StiffeningWarning, cut
from kane.expr.build import div, mul
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr, as_expr, constant, constant_value
from kane.expr.ops import Immutable
from kane.expr.symbols import Coordinate, Parameter, Speed, Symbol, rate
from kane.model.beams.deformation import (
    SHEAR,
    Field,
    Fields,
    Share,
    Tapered,
    check_independent,
    fine,
    measure,
    moments_beyond,
    section,
    section_frame,
)
from kane.model.beams.mass_parts import Gauges, Matter, damping_of, elasticity, particles, sharing, slices, strain
from kane.model.beams.shape_functions import ModeShapes, mode_shapes, unmet, vanish
from kane.model.bodies import Part
from kane.model.joints.joint import across, fixed, numbers
from kane.model.loads import Load
from kane.numeric.arrays import Array
from kane.numeric.polynomials import gauss
from kane.numeric.scale import DECLARED, ROUNDED
from kane.space.frame import Frame, Point
from kane.space.vector import Vector, check_connected

_FORMS = ("linearized", "nonlinear")
_MASS_POINTS = 64
"""Quadrature points for the mass."""


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Beam(Immutable):
    """A straight flexible beam, a body of a system. Its deformation is a sum of shape functions of ξ = x/L times coordinates.

    The undeformed axis starts at `root` along `axis` = e₁. A point of it moves to (L ξ + s + u₂) e₁ + v e₂ + w e₃, with the
    stretch s along the deformed axis, the deflections v and w, and the foreshortening u₂ = −∫ (v'² + w'²) dx/2, whose partial
    velocities give the stiffening of a spinning beam (Yoo, Ryan & Scott 1995). The beam is an Euler–Bernoulli beam, with `rotary`
    a Rayleigh beam, with `shear` a Timoshenko beam; sections have inertia in twist if `polar` is given.

    Parameters
    ----------
    name : of the body; coordinates are v1_name, …, w1_name, …, s1_name, …, t1_name, …, speeds their rates
    root, frame : point and frame to which the end ξ = 0 is attached
    axis : unit vector fixed in the frame, along the undeformed beam
    length, mass_per_length, EI : m, kg/m and N m², parameters or numbers; mass_per_length, EI, EA, GJ and polar may be
        `kn.beams.tapered`. Give two EI for bending along e₂ and e₃, a beam in space
    modes : number of functions of each deflection, or `kn.beams.mode_shapes`, or two of these
    along : e₂, the direction of v; e₃ = e₁ × e₂
    EA, stretch : axial stiffness (N) and functions of s; without them the axis is inextensible
    shear, shear_modes : stiffness k_s G A (N) and functions of the deflection by shear, one for each direction of bending, with the
        coordinates g1_name, … beside v and h1_name, … beside w; by default "rod polynomials", one more than functions of bending
        (for a pinned beam as many sines). Sections turn by the slope of bending alone
    rotary : moment of inertia ρ I of sections about the axis of bending, per length (kg m); two for two directions
    GJ, torsion, polar : stiffness (N m²) and functions of the twist, and the moment of inertia about the axis per length (kg m)
    support : "clamped", "pinned" or "free": the boundary condition between `frame` and the end ξ = 0
    form : "linearized", kinetic energy to second order in the deformation, as in the literature; or "nonlinear", without
        truncation. The strain energy is quadratic in both, which is valid for slopes of a few tenths
    stiffening : False neglects the foreshortening (premature linearization), which is valid for slow motions alone
    damping : {"mass": α, "stiffness": β} of C = α M + β K, or {"ratio": ζ} for all modes of the beam at rest

    Raises
    ------
    ModelError
        if a length, mass or stiffness is not positive, or functions are missing, linearly dependent, nonzero at a root where they
        must vanish, or without strain at a supported end
    """

    name: str
    root: Point
    frame: Frame
    length: Expr
    mass_per_length: Tapered
    deformation: Fields
    clamped: bool
    form: str
    coordinates: tuple[Coordinate, ...]
    speeds: Mapping[Speed, Expr]
    named: frozenset[Symbol]
    own_loads: tuple[Load, ...]
    _parts: tuple[Part, ...]
    _arguments: Mapping[str, Any]
    _places: dict[float, tuple[Point, Frame]] = field(repr=False)

    def __init__(
        self,
        name: str,
        root: Point,
        *,
        frame: Frame,
        axis: Any,
        length: Any,
        mass_per_length: Any,
        EI: Any,
        modes: Any = 3,
        along: Any = None,
        EA: Any = None,
        stretch: Any = None,
        GJ: Any = None,
        torsion: Any = None,
        polar: Any = None,
        shear: Any = None,
        shear_modes: Any = None,
        rotary: Any = None,
        support: str = "clamped",
        form: str = "linearized",
        stiffening: bool = True,
        damping: Mapping[str, Any] | None = None,
    ) -> None:
        arguments = {k: v for k, v in locals().items() if k not in ("self", "name", "root")}
        _check(name, root, frame, form, stiffening)
        L = measure(name, "length", length)
        e1, e2, e3 = directions(name, frame, axis, along)
        bent = bending(name, support, EI, modes, e2, e3)
        sheared = shearing(name, support, shear, shear_modes, bent)
        stretched = axial(name, support, "s", "EA", EA, stretch, e1)
        fields = (*stretched, *sheared, *bent, *axial(name, support, "t", "GJ", GJ, torsion, e1))
        whole = Fields(L, e1, fields, bool(stiffening))
        rotaries = turning(name, rotary, bool(sheared), bent)
        expected = f"polar=moment of inertia about the axis per length of {name}, which twists"
        cure = "For a round section it is mass_per_length times r²/2."
        expect.that(polar is not None or all(f.stem != "t" for f in fields), expected, came="none", cure=cure)
        about = None if polar is None else section(name, "polar", polar)
        matter = Matter(section(name, "mass_per_length", mass_per_length), about, rotaries)
        make = sharing if form == "linearized" else particles
        parts = (*make(name, root, whole, matter), *slices(name, root, frame, whole, matter))
        coordinates = tuple(q for f in fields for q in f.coordinates)
        speeds = {Speed.declare(f"u_{q.name}", None, f"{q.unit}/s", ""): rate(q) for q in coordinates}
        gauges = Gauges(name, root, L, fields)
        loads = (elasticity(name, gauges, L, fields), *damping_of(name, gauges, whole, matter, damping))
        given = (matter.mass, matter.polar, *rotaries, *(f.stiffness for f in fields))
        named = _named(coordinates, [L, *(x.value for x in given if x)], loads, arguments)
        first = (name, root, frame, L, matter.mass, whole, support == "clamped", form, coordinates, speeds, named)
        values: tuple[Any, ...] = (*first, loads, parts, arguments, {})
        for slot, value in zip(self.__slots__, values, strict=True):
            object.__setattr__(self, slot, value)

    def __reduce__(self) -> tuple[Callable[..., "Beam"], tuple[Any, ...]]:
        return partial(Beam, self.name, self.root, **self._arguments), ()

    def parts(self) -> tuple[Part, ...]:
        """The parts with mass that represent the beam: sections at stations, or points that share its momentum."""
        return self._parts

    @property
    def mass(self) -> Expr:
        """Mass of the whole beam; the masses of its parts, some of them negative, add up to it."""
        rule = gauss(_MASS_POINTS, self.mass_per_length.share.ends)
        mean = float(rule.weights @ self.mass_per_length.share(rule.places))
        whole = mul(self.length, self.mass_per_length.value)
        return whole if abs(mean - 1) < ROUNDED else mul(constant(mean), whole)

    def measures(self) -> tuple[tuple[str, Expr], ...]:
        """The quantities that must be positive, each with the name of its argument."""
        stiff = {"v": "EI", "w": "EI", "s": "EA", "t": "GJ", "g": "shear", "h": "shear"}
        fields = ((stiff[f.stem], f.stiffness.value) for f in self.deformation.fields)
        return (("length", self.length), ("mass_per_length", self.mass_per_length.value), *fields)

    def defined_by(self, definitions: Mapping[Speed, Expr]) -> bool:
        """Whether one of the definitions contains the rate of a coordinate of the beam."""
        own = {rate(q) for q in self.coordinates}
        return any(s in own for s in free_symbols(definitions.values()))

    def point_at(self, xi: Any) -> Point:
        """The point of the axis at ξ = x/L, from 0 at the root to 1 at the tip, or at a length x such as L/2."""
        return self._section_at(xi)[0]

    def frame_at(self, xi: Any) -> Frame:
        """The frame of the section at ξ = x/L: `frame` turned by the slopes v' and −w', and by the twist."""
        return self._section_at(xi)[1]

    def distributed(self, per_length: Vector | Callable[[float], Vector], name: str = "") -> Load:
        """A load distributed along the beam: a vector (N/m), whose measure numbers contain parameters alone, or a function of ξ.

        A vector written along the axes of `beam.frame_at(ξ)` follows the sections. The load is integrated by Gauss quadrature, as
        forces at its nodes, which is exact for loads that are polynomials of low degree in ξ.
        """
        most = max(f.shapes.count for f in self.deformation.fields)
        rule = gauss(2 * most + 6)
        forces = []
        for x, w in zip(rule.places, rule.weights, strict=True):
            v = per_length(float(x)) if callable(per_length) else per_length
            expected = f"a load per length on {self.name} as a Vector, or a function of ξ that gives one"
            expect.instance(v, Vector, expected, "Say along which axis it acts: p*N.y.")
            forces.append((self.point_at(float(x)), v * mul(constant(float(w)), self.length)))
        return Load(expect.label(name) or f"load along {self.name}", tuple(forces))

    def _section_at(self, xi: Any) -> tuple[Point, Frame]:
        share = self._share(xi)
        if share not in self._places:
            name = f"{self.name} at {share:.6g}"
            point = self.root.at(name, self.deformation.place(share))
            self._places[share] = point, section_frame(name, self.frame, self.deformation, share)
        return self._places[share]

    def _share(self, xi: Any) -> float:
        value = constant_value(as_expr(xi))
        if value is None:
            value = constant_value(div(as_expr(xi), self.length))
        if value is None or not 0 <= float(value) <= 1:
            raise ModelError(
                f"Expected a position on {self.name} as ξ = x/L from 0, its root, to 1, its tip, got {cut(xi)}. Divide x by the "
                f"length, or give it as a fraction of it: {cut(self.length)}/2."
            )
        return float(value)

    def __repr__(self) -> str:
        n = ", ".join(f"{len(f.coordinates)} of {f.stem}" for f in self.deformation.fields)
        return f"Beam({self.name!r}, from {self.root.name} in {self.frame.name}; {n})"


def _named(
    coordinates: Sequence[Coordinate], properties: Sequence[Expr], loads: Sequence[Load], arguments: Mapping[str, Any]
) -> frozenset[Symbol]:
    """Symbols with units assigned by the beam: its coordinates, and the parameters made from numbers."""
    vectors = [v for load in loads for _, v in (*load.forces, *load.torques)]
    held = free_symbols([*properties, *(x for v in vectors for x in v.scalars())])
    given = set(free_symbols(_given(arguments.values())))
    return frozenset((*coordinates, *(p for p in held if isinstance(p, Parameter) and p not in given)))


def _given(arguments: Iterable[Any]) -> Iterator[Expr]:
    """The expressions in arguments, also within tuples and mappings."""
    for x in arguments:
        if isinstance(x, Expr):
            yield x
        elif isinstance(x, Mapping):
            yield from _given(x.values())
        elif isinstance(x, tuple | list):
            yield from _given(x)


def _check(name: Any, root: Any, frame: Any, form: Any, stiffening: Any) -> None:
    expect.name(name, "a name for the beam")
    geometric = isinstance(root, Point) and root.body is None
    expect.that(geometric, f"a geometric point as the root of {name}", root, "Make one with at(…).")
    expect.instance(frame, Frame, f"frame=Frame for the beam {name}")
    check_connected(root.frame, frame)
    expect.one_of(form, _FORMS, f"form= of {name} to be")
    expect.flag(stiffening, f"stiffening= of {name} to be True or False")


_ENOUGH = 10
"""Number of functions that determine the first frequency of any beam that spins at a few times this frequency."""
_OFF = 0.02
"""Relative error of the first frequency above which a warning is given."""


def first_frequency(
    beam: Beam, field: Field, values: Mapping[Expr, float], spin: float = 0.0, richer: ModeShapes | None = None
) -> float:
    """The first out-of-plane frequency (rad/s) of a deflection of the spinning beam with its root fixed."""
    f = field if richer is None else field._replace(shapes=richer)
    measures = (beam.mass_per_length.value, beam.length, f.stiffness.value)
    mass, length, stiff = (float(evaluate(x, values)) for x in measures)
    inert, elastic, drawn = _integrals(f.shapes, beam.mass_per_length.share, f.stiffness.share)
    k = stiff / length**3 * elastic + spin**2 * mass * length * drawn
    return float(np.sqrt(np.maximum(_eigenvalues(k, mass * length * inert)[0], 0.0)))


@lru_cache(maxsize=64)
def _integrals(shapes: ModeShapes, mass: Share, stiff: Share) -> tuple[Array, Array, Array]:
    """m, k and S without units, which do not depend on parameters."""
    rule = fine([shapes], mass)
    values, slopes = (shapes.evaluate(rule.places, k) for k in (0, 1))
    _, beyond = moments_beyond(mass, rule.places)
    result = (rule.gram(values, values, mass(rule.places)), strain(shapes, stiff, 2), rule.gram(slopes, slopes, beyond))
    for a in result:
        a.flags.writeable = False
    return result


@cache
def _polynomials(count: int) -> ModeShapes:
    return mode_shapes("polynomials", count)


def _eigenvalues(k: Array, m: Array) -> Array:
    size = np.sqrt(np.diag(m))
    inverse = np.linalg.inv(np.linalg.cholesky(m / np.multiply.outer(size, size)))
    return np.asarray(np.linalg.eigvalsh(inverse @ (k / np.multiply.outer(size, size)) @ inverse.T), dtype=float)


def spin_squared(beam: Beam) -> Expr | None:
    """The square of the beam frame's angular speed about transverse axes; None if the frame does not rotate."""
    root = beam.frame.root()
    if root is beam.frame:
        return None
    w = beam.frame.angular_velocity(root)
    square: Expr = w.dot(w) - w.dot(beam.deformation.axis) ** 2
    return square


def doubts(beam: Beam, spin: float, values: Mapping[Expr, float]) -> Iterator[tuple[str, type[KaneWarning]]]:
    """Warnings for a beam that spins at `spin` (rad/s) about a transverse axis, at given values of parameters."""
    if not beam.clamped or not beam.deformation.bending or not np.isfinite(spin) or spin == 0:
        return
    first = min(first_frequency(beam, f, values) for f in beam.deformation.bending)
    if not beam.deformation.stiffening:
        if spin > first:
            message = (
                f"Expected the stiffening of {beam.name}, which spins at up to {spin:.4g} rad/s, beyond its first frequency at "
                f"rest, {first:.4g} rad/s, got stiffening=False: this premature linearization diverges for any motion of the "
                "beam. Leave stiffening= out."
            )
            yield message, StiffeningWarning
        return
    if spin < first:  # mode shapes change little below the first frequency
        return
    for f in beam.deformation.bending:
        coarse = first_frequency(beam, f, values, spin)
        better = first_frequency(beam, f, values, spin, _polynomials(max(_ENOUGH, 2 * f.shapes.count)))
        if coarse > better * (1 + _OFF):
            message = (
                f"Expected enough modes of {beam.name} for its spin, up to {spin:.4g} rad/s, got {f.shapes!r}, with which its first "
                f"frequency at that spin is {coarse:.5g} rad/s instead of {better:.5g}. Use more modes."
            )
            yield message, ModesWarning


# The arguments of a beam, read and checked: directions, sections, shape functions and their coordinates ------------------

SUPPORTS: dict[str, tuple[tuple[int, ...], str, Mapping[str, float]]] = {
    "clamped": ((0, 1), "clamped-free", {"root": 0.0}),
    "pinned": ((0,), "pinned", {"root": 0.0, "tip": 1.0}),
    "free": ((), "free-free", {}),
}
"""By support: what vanishes at the root, value (0) and slope (1); default functions; ends ξ where forces strain the beam axially."""
_SHEAR = "deflection by shear"
_DEFORMATIONS = {"v": "deflection", "w": "deflection", "s": "stretch", "t": "twist", "g": _SHEAR, "h": _SHEAR}


def directions(name: str, frame: Frame, axis: Any, along: Any) -> tuple[Vector, Vector, Vector]:
    """Unit vectors: e₁ along the beam, e₂ in the plane of bending, and e₃."""
    e1 = fixed(axis, frame, f"axis of {name}")
    e2 = across(e1, frame)[0] if along is None else fixed(along, frame, f"along= of {name}")
    e3 = e1.cross(e2).express(frame)
    right = along is None or abs(numbers([e1.dot(e2)])[0]) <= DECLARED
    came, cure = f"{along} with the axis {axis}", "It is the direction of the first deflection."
    expect.that(right, f"along= perpendicular to the axis of {name}", came=came, cure=cure)
    return e1, e2, e3


def bending(name: str, support: Any, EI: Any, modes: Any, e2: Vector, e3: Vector) -> list[Field]:
    """The deflection v along e₂ and, if two EI or two modes are given, w along e₃."""
    vanishing, usual, ends = SUPPORTS[expect.one_of(support, SUPPORTS, f"support= of {name} to be")]
    both = _is_pair(EI) or _is_pair(modes)
    stiff, given = (x if _is_pair(x) else (x,) * (1 + both) for x in (EI, modes))
    fields = []
    for stem, (along, turn), k, m in zip("vw", ((e2, e3), (e3, -e2)), stiff, given, strict=False):
        if _is_none(m) and both:
            continue
        shapes = _shapes(name, "modes", m, usual)
        where = "in value and slope" if support == "clamped" else "in value"
        expected = f"modes of {name} that are zero where its root is {support}, {where}"
        cure = 'Take others, such as kn.mode_shapes("clamped-free", 3), or another support=.'
        expect.none(unmet(shapes, vanishing)[:1], expected, f"{shapes.label} of which {{}} at the root", cure)
        if support == "clamped":
            _check_strained(name, "bending", shapes, 2, ends, "polynomials")
        value = section(name, "EI", k, _which(stiff, stem))
        fields.append(_field(name, stem, along, turn, shapes, value, "m"))
    if not fields:
        raise _without(name, "modes", modes)
    return fields


def axial(name: str, support: str, stem: str, what: str, value: Any, modes: Any, e1: Vector) -> list[Field]:
    """The stretch s or the twist t, with functions that vanish at the root; none without a stiffness."""
    argument, noun, unit = ("stretch", "stretch", "m") if stem == "s" else ("torsion", "twist", "rad")
    if value is None:
        if not _is_none(modes):
            raise ModelError(f"Expected {what} of {name} for its {argument}=, got none. Give both or neither.")
        return []
    shapes = _shapes(name, argument, 1 if _is_none(modes) else modes, "rod")
    _check_root(name, noun, shapes, 'Take kn.mode_shapes("rod", 2), or ("legendre rod", 2).')
    if support != "free":
        _check_strained(name, noun, shapes, 1, {"root": 0.0}, "rod")
    return [_field(name, stem, e1, None, shapes, section(name, what, value), unit)]


def shearing(name: str, support: str, shear: Any, modes: Any, bent: Sequence[Field]) -> list[Field]:
    """The deflections by shear beside those by bending, with functions that vanish at the root; none without a stiffness k_s G A.

    The default functions are polynomials of the degree of as many functions of bending: sines, whose slopes all vanish at the tip,
    converge slowly, especially with a body there.
    """
    if shear is None:
        if not _is_none(modes):
            raise ModelError(f"Expected k_s G A of {name} as its shear=, got only functions. Give both or neither.")
        return []
    stiff, given = (_each(name, "shear", x, len(bent)) for x in (shear, modes))
    usual, further = ("pinned", 0) if support == "pinned" else ("rod polynomials", 1)
    fields = []
    for f, k, m in zip(bent, stiff, given, strict=True):
        shapes = _shapes(name, "shear_modes", f.shapes.count + further if _is_none(m) else m, usual)
        _check_root(name, "shear", shapes, f'Take kn.mode_shapes("{usual}", {shapes.count}).')
        _check_strained(name, "shear", shapes, 1, SUPPORTS[support][2], usual)
        value = section(name, "shear", k, _which(stiff, f.stem))
        fields.append(_field(name, SHEAR[f.stem], f.along, None, shapes, value, "m"))
    return fields


def _each(name: str, what: str, given: Any, count: int) -> Any:
    """One value for each direction of bending, repeated if only one is given."""
    values = given if _is_pair(given) else (given,) * count
    expected = f"one {what}= of {name}, which bends along one direction"
    expect.that(len(values) == count, expected, came="two", cure="Give EI=(…, …), too.")
    return values


def _which(values: Sequence[Any], stem: str) -> str:
    """A suffix for the symbols of a direction, if the values differ."""
    return stem if len(set(map(id, values))) > 1 else ""


def _check_root(name: str, what: str, shapes: ModeShapes, cure: str) -> None:
    expected = f"functions of the {what} of {name} that are zero at the root"
    expect.none(unmet(shapes, (0,))[:1], expected, f"{shapes.label} of which {{}} there", cure)


def turning(name: str, rotary: Any, sheared: bool, bent: Sequence[Field]) -> tuple[Tapered, ...]:
    """Moments of inertia per length of sections about the axes of bending; none without `rotary`."""
    if rotary is None:
        expected = f"rotary=moment of inertia of a section per length of {name}, which shears"
        came, cure = "none: sections then turn by themselves", "It is mass_per_length times I/A."
        expect.that(not sheared, expected, came=came, cure=cure)
        return ()
    given = _each(name, "rotary", rotary, len(bent))
    return tuple(section(name, "rotary", x, _which(given, f.stem)) for f, x in zip(bent, given, strict=True))


def _check_strained(
    name: str, what: str, shapes: ModeShapes, order: int, ends: Mapping[str, float], usual: str
) -> None:
    """Raise ModelError if at a constrained end the derivatives of an order vanish for all functions, and thus the strain."""
    locked = [end for end, xi in ends.items() if vanish(shapes, xi, order).all()]
    if locked:
        raise ModelError(
            f"Expected functions of the {what} of {name} whose {'curvatures' if order == 2 else 'slopes'} do not all vanish at the "
            f"{locked[0]}, which is constrained, got {shapes.label}: no force could strain it there, and it would be too stiff. "
            f'Use kn.mode_shapes("{usual}", {shapes.count}).'
        )


def _is_pair(x: Any) -> bool:
    return isinstance(x, tuple | list) and not isinstance(x, Tapered) and len(x) == 2 and not callable(x[0])


def _is_none(modes: Any) -> bool:
    return modes is None or (isinstance(modes, int) and not isinstance(modes, bool) and modes == 0)


def _shapes(name: str, what: str, modes: Any, usual: str) -> ModeShapes:
    if isinstance(modes, ModeShapes):
        return modes
    if _is_none(modes) or (isinstance(modes, Sequence) and len(modes) == 0):
        raise _without(name, what, modes)
    if callable(modes) or (isinstance(modes, Sequence) and not isinstance(modes, str)):
        return mode_shapes(modes)
    if isinstance(modes, str):
        raise ModelError(
            f"Expected {what}= of {name} as a number of functions, {usual}, or as kn.mode_shapes({modes!r}, …), got {modes!r}."
        )
    return mode_shapes(usual, modes)


def _without(name: str, what: str, modes: Any) -> ModelError:
    return ModelError(
        f"Expected at least one function as {what}= of {name}, got {cut(repr(modes))}. A beam without any is a rigid body: "
        "kn.RigidBody."
    )


def _field(
    name: str, stem: str, along: Vector, turn: Vector | None, shapes: ModeShapes, value: Tapered, unit: str
) -> Field:
    check_independent(name, shapes, fine([shapes]))
    tag, what = "_".join(name.split()), _DEFORMATIONS[stem]
    coordinates = tuple(
        Coordinate.declare(f"{stem}{k}_{tag}", None, unit, f"{what} of {name}, function {k}")
        for k in range(1, shapes.count + 1)
    )
    return Field(stem, along, turn, shapes, coordinates, value)
