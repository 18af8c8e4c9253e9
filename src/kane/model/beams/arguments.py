# SPDX-License-Identifier: BSD-3-Clause
"""What a beam is declared with, read and checked: directions, sections, mode shapes, and the coordinates that they get."""

from collections.abc import Mapping, Sequence
from typing import Any

from kane.errors import ModelError, cut, none_of
from kane.expr.symbols import Coordinate
from kane.model.beams.deformation import SHEAR, Field
from kane.model.beams.integrals import check_independent, fine
from kane.model.beams.section import Tapered, section
from kane.model.beams.shapes import ModeShapes, mode_shapes, unmet, vanish
from kane.model.joints.joint import across, fixed, numbers
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame
from kane.space.vector import Vector

SUPPORTS: dict[str, tuple[int, ...]] = {"clamped": (0, 1), "pinned": (0,), "free": ()}
"""What must vanish at the root in the beam's frame: the value (0) and the slope (1) of deflections."""
_HELD = {"clamped": {"root": 0.0}, "pinned": {"root": 0.0, "tip": 1.0}, "free": {}}
"""Ends that are held: forces stretch and shear the beam there."""
_DEFORMATIONS = {
    "v": "deflection", "w": "deflection", "s": "stretch", "t": "twist", "g": "deflection by shear", "h": "deflection by shear",
}  # fmt: skip
_USUAL = {"clamped": "clamped-free", "pinned": "pinned", "free": "free-free"}


def directions(name: str, frame: Frame, axis: Any, along: Any) -> tuple[Vector, Vector, Vector]:
    """e₁ along the beam, e₂ along which it bends in its plane, e₃."""
    e1 = fixed(axis, frame, f"axis of {name}")
    e2 = across(e1, frame)[0] if along is None else fixed(along, frame, f"along= of {name}")
    e3 = e1.cross(e2).express(frame)
    if along is not None and not _perpendicular(e1, e2):
        raise ModelError(
            f"Expected along= perpendicular to the axis of {name}, got {along} with the axis {axis}. It is the direction of the first "
            "deflection."
        )
    return e1, e2, e3


def _perpendicular(a: Vector, b: Vector) -> bool:
    return abs(numbers([a.dot(b)])[0]) <= DECLARED


def bending(name: str, support: Any, EI: Any, modes: Any, e2: Vector, e3: Vector) -> list[Field]:
    """The deflections v along e₂ and, where EI or modes are two, w along e₃."""
    if support not in SUPPORTS:
        raise ModelError(f"Expected support= of {name} to be one of {none_of(SUPPORTS, support)}")
    both = [x for x in (EI, modes) if _is_pair(x)]
    stiff = EI if _is_pair(EI) else (EI,) * (2 if both else 1)
    given = modes if _is_pair(modes) else (modes,) * len(stiff)
    e = ((e2, e3), (e3, -e2))
    found = []
    for stem, (along, turn), k, m in zip("vw", e, stiff, given, strict=False):
        if _is_none(m) and both:
            continue
        shapes = _shapes(name, "modes", m, _USUAL[support])
        wrong = unmet(shapes, SUPPORTS[support])
        if wrong:
            raise ModelError(
                f"Expected modes of {name} that are zero where its root is {support}, "
                f"{'in value and slope' if support == 'clamped' else 'in value'}, got {shapes.label} of which {wrong[0]} at the root. "
                'Take others, such as kn.mode_shapes("clamped-free", 3), or another support=.'
            )
        if support == "clamped":
            _check_strained(name, "bending", shapes, 2, _HELD[support], "polynomials")
        check_independent(name, shapes, fine([shapes]))
        found.append(
            _field(
                name,
                stem,
                along,
                turn,
                shapes,
                section(name, "EI", k, stem if len(set(map(id, stiff))) > 1 else ""),
                "m",
            )
        )
    if not found:
        raise _without(name, "modes", modes)
    return found


def axial(name: str, support: str, stem: str, what: str, value: Any, modes: Any, e1: Vector) -> list[Field]:
    """The stretch s, or the twist t, none without a stiffness; their functions are zero at the root."""
    if value is None:
        if not _is_none(modes):
            raise ModelError(
                f"Expected {what} of {name} for its {'stretch' if stem == 's' else 'torsion'}=, got none. Give both or neither."
            )
        return []
    shapes = _shapes(name, "stretch" if stem == "s" else "torsion", 1 if _is_none(modes) else modes, "rod")
    wrong = unmet(shapes, (0,))
    if wrong:
        raise ModelError(
            f"Expected functions of the {'stretch' if stem == 's' else 'twist'} of {name} that are zero at the root, got "
            f'{shapes.label} of which {wrong[0]} there. Take kn.mode_shapes("rod", 2), or ("legendre rod", 2).'
        )
    if support != "free":
        _check_strained(name, "stretch" if stem == "s" else "twist", shapes, 1, {"root": 0.0}, "rod")
    check_independent(name, shapes, fine([shapes]))
    return [_field(name, stem, e1, None, shapes, section(name, what, value), "m" if stem == "s" else "rad")]


def shearing(name: str, support: str, shear: Any, modes: Any, bent: Sequence[Field]) -> list[Field]:
    """The deflections by shear beside those by bending, none without a stiffness k_s G A; their functions are zero at the root.

    By default they are polynomials of the degree that those of bending of this number have: sines, whose slopes all vanish at the tip,
    converge slowly, above all with a body there.
    """
    if shear is None:
        if not _is_none(modes):
            raise ModelError(f"Expected k_s G A of {name} as its shear=, got functions alone. Give both or neither.")
        return []
    stiff = shear if _is_pair(shear) else (shear,) * len(bent)
    given = modes if _is_pair(modes) else (modes,) * len(bent)
    if len(stiff) != len(bent) or len(given) != len(bent):
        raise ModelError(
            f"Expected one shear= of {name}, which bends along one direction, got two. Give EI=(…, …), too."
        )
    usual, further = ("pinned", 0) if support == "pinned" else ("rod polynomials", 1)
    found = []
    for f, k, m in zip(bent, stiff, given, strict=True):
        shapes = _shapes(name, "shear_modes", f.shapes.count + further if _is_none(m) else m, usual)
        wrong = unmet(shapes, (0,))
        if wrong:
            raise ModelError(
                f"Expected functions of the shear of {name} that are zero at the root, got {shapes.label} of which {wrong[0]} there. "
                f'Take kn.mode_shapes("{usual}", {shapes.count}).'
            )
        _check_strained(name, "shear", shapes, 1, _HELD[support], usual)
        check_independent(name, shapes, fine([shapes]))
        which = f.stem if len(set(map(id, stiff))) > 1 else ""
        found.append(_field(name, SHEAR[f.stem], f.along, None, shapes, section(name, "shear", k, which), "m"))
    return found


def turning(name: str, rotary: Any, sheared: bool, bent: Sequence[Field]) -> tuple[Tapered, ...]:
    """Moments of inertia per length of sections about the axes of bending."""
    if rotary is None:
        if sheared:
            raise ModelError(
                f"Expected rotary=moment of inertia of a section per length of {name}, which shears, got none: sections then turn by "
                "themselves. It is mass_per_length times I/A."
            )
        return ()
    given = rotary if _is_pair(rotary) else (rotary,) * len(bent)
    if len(given) != len(bent):
        raise ModelError(
            f"Expected one rotary= of {name}, which bends along one direction, got two. Give EI=(…, …), too."
        )
    several = len(set(map(id, given))) > 1
    return tuple(section(name, "rotary", x, f.stem if several else "") for f, x in zip(bent, given, strict=True))


def _check_strained(
    name: str, what: str, shapes: ModeShapes, order: int, ends: Mapping[str, float], usual: str
) -> None:
    """A ModelError for functions all of which are without strain, their derivative of an order, at one of the ends that are held."""
    locked = [end for end, xi in ends.items() if vanish(shapes, xi, order).all()]
    if locked:
        raise ModelError(
            f"Expected functions of the {what} of {name} whose {'curvatures' if order == 2 else 'slopes'} do not all vanish at the "
            f"{locked[0]}, which is held, got {shapes.label}: no force could strain it there, and it would be too stiff. "
            f'Take kn.mode_shapes("{usual}", {shapes.count}).'
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
    tag = "_".join(name.split())
    what = _DEFORMATIONS[stem]
    coordinates = tuple(
        Coordinate.declare(f"{stem}{k}_{tag}", None, unit, f"{what} of {name}, function {k}")
        for k in range(1, shapes.count + 1)
    )
    return Field(stem, along, turn, shapes, coordinates, value)
