# SPDX-License-Identifier: BSD-3-Clause
"""The arguments of a beam, read and checked: directions, sections, shape functions and their coordinates."""

from collections.abc import Mapping, Sequence
from typing import Any

from kane import expect
from kane.errors import ModelError, cut
from kane.expr.symbols import Coordinate
from kane.model.beams.deformation import SHEAR, Field, Tapered, check_independent, fine, section
from kane.model.beams.shape_functions import ModeShapes, mode_shapes, unmet, vanish
from kane.model.joints.joint import across, fixed, numbers
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame
from kane.space.vector import Vector

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
