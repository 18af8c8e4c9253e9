# SPDX-License-Identifier: BSD-3-Clause
"""Joints as calls of the functions that make them, in a table by kind."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from kane.expr.node import ZERO
from kane.interop.python_source.expressions import Expressions, ObjectNames, literal, same
from kane.model.joints.joint import Joint
from kane.space.vector import Vector


def joint_call(j: Joint, text: Expressions, by_name: bool, names: ObjectNames) -> tuple[str, list[str]]:
    """The function of a joint, and its arguments after name, point and parent."""
    arguments = _ARGUMENTS[j.kind](j, text)
    if not j.coordinates:
        return j.kind, arguments
    if by_name:
        coordinates, speeds = (literal(" ".join(s.name for s in symbols)) for symbols in (j.coordinates, j.speeds))
    else:
        coordinates = _in_turn([names[q] for q in j.coordinates])
        rates = same(j.speeds.values(), [q.dt for q in j.coordinates])
        pairs = [f"{names[u]}: {text(e)}" for u, e in j.speeds.items()]
        speeds = _in_turn([names[u] for u in j.speeds]) if rates else f"{{{', '.join(pairs)}}}"
    return j.kind, [*arguments, f"coordinates={coordinates}", f"speeds={speeds}"]


def _in_turn(items: Sequence[str]) -> str:
    return items[0] if len(items) == 1 else f"({', '.join(items)})"


def _axis(j: Joint, text: Expressions) -> list[str]:
    return [f"axis={text.vector(j.axis)}"]


def _screw(j: Joint, text: Expressions) -> list[str]:
    advance, axis = (v.components(j.parent) for v in (j.free[0].translation, j.axis))
    pitch = next(a / n for a, n in zip(advance, axis, strict=True) if n is not ZERO)
    return [*_axis(j, text), f"pitch={text(pitch)}"]


def _universal(j: Joint, text: Expressions) -> list[str]:
    first, turned = j.axes
    cross = j.frame.parent
    assert cross is not None
    second = Vector(((j.parent, turned.components(cross)),))
    return [f"axes=({text.vector(first)}, {text.vector(second)})"]


def _orientation(j: Joint, text: Expressions) -> list[str]:
    o = j.frame.orientation
    assert o is not None
    if o.parameters:
        return []
    letters, frame = "", j.frame
    while frame is not j.parent:
        o = frame.orientation
        assert o is not None
        assert o.axis is not None
        assert frame.parent is not None
        letters, frame = "xyz"[o.axis] + letters, frame.parent
    return ['orientation="angles"', *([] if letters == "xyz" else [f"sequence={literal(letters)}"])]


def _free(j: Joint, text: Expressions) -> list[str]:
    ((home, _),) = j.free[-1].translation.parts
    return [*_orientation(j, text), *(['velocity="parent"'] if home is j.parent else [])]


_ARGUMENTS: dict[str, Callable[[Joint, Expressions], list[str]]] = {
    "pin": _axis,
    "slider": _axis,
    "cylindrical": _axis,
    "screw": _screw,
    "planar": lambda j, text: [f"normal={text.vector(j.axis)}"],
    "universal": _universal,
    "weld": lambda j, text: [],
    "ball": _orientation,
    "free": _free,
}
