# SPDX-License-Identifier: BSD-3-Clause
"""Inertias of solids, friction loads and joints as calls of the functions that make them, if the call makes the same record."""

from collections.abc import Callable, Sequence
from inspect import signature
from typing import Any, NamedTuple

from kane.errors import KaneError
from kane.expr.evaluation import free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Parameter, Reaction
from kane.interop.python_source.expressions import Expressions, ObjectNames, literal, same, same_vectors
from kane.model import solids
from kane.model.joints.contact import friction
from kane.model.joints.joint import Joint
from kane.model.loads import Load
from kane.model.solids import Inertia
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector


def solid_call(dyadic: Dyadic, mass: Expr) -> tuple[str, Frame, dict[str, Any]] | None:
    """The name of the function, the frame, and the keyword arguments; None if no function makes this inertia."""
    if not isinstance(dyadic, Inertia):
        return None
    shape = dyadic.shape
    name = shape.kind.replace(" ", "_")
    make = getattr(solids, name, None)
    given = {"mass": mass, **shape.sizes, **({} if shape.axis is None else {"axis": shape.axis})}
    if make is None or {*signature(make).parameters} != {"frame", *given}:
        return None
    try:
        made = make(shape.frame, **given)
    except KaneError:
        return None
    vectors = ([v for pair in x.dyads for v in pair] for x in (made, dyadic))
    return (name, shape.frame, given) if same_vectors(*vectors) else None


class WrittenFriction(NamedTuple):
    """The arguments of `kn.friction`."""

    point: Point
    normal: Reaction
    mu: Parameter
    against: Point | None
    threshold: float | None


def friction_call(load: Load) -> WrittenFriction | None:
    """The arguments of `kn.friction` that make a load; None if a coefficient is not a parameter or `kn.friction` did not make it."""
    slip = load.slip
    if slip is None or len(slip.presses) != 1 or load.torques or not 1 <= len(load.forces) <= 2:
        return None
    point, *other = (p for p, _ in load.forces)
    against = other[0] if other else None
    for mu in free_symbols([x for _, v in load.forces for _, triple in v.parts for x in triple]):
        if isinstance(mu, Parameter):
            made = friction(point, slip.presses[0], mu, against=against, threshold=slip.threshold, name=load.name)
            if made.slip and made.slip.speed is slip.speed and made.slip.rolls == slip.rolls and _alike(made, load):
                return WrittenFriction(point, slip.presses[0], mu, against, slip.threshold)
    return None


def pair_of(load: Load) -> tuple[str, tuple[Point | Frame, Vector], tuple[Point | Frame, Vector]] | None:
    """A force or torque with its opposite elsewhere, and the function that makes both; None for other loads."""
    pairs: Sequence[tuple[Point | Frame, Vector]] = load.forces or load.torques
    if load.potential is not None or len(load.forces) + len(load.torques) != 2 or len(pairs) != 2:
        return None
    first, second = pairs
    if not same_vectors([-first[1]], [second[1]]):
        return None
    return "action_reaction" if load.forces else "torque_pair", first, second


def _alike(a: Load, b: Load) -> bool:
    points = ([p for p, _ in x.forces] for x in (a, b))
    return same(*points) and same_vectors(*([v for _, v in x.forces] for x in (a, b)))


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
