# SPDX-License-Identifier: BSD-3-Clause
"""Joints listed in a system: known by name, with their speeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from kane.errors import ModelError
from kane.expr.node import as_expr
from kane.expr.symbols import Speed
from kane.model.joints.joint import Joint
from kane.space.vector import Vector


def with_joints(speeds: Mapping[Speed, Any] | str | None, joints: Sequence[Joint]) -> Mapping[Speed, Any] | str:
    """The definitions of the speeds: the joints', in order, but for those whose rates are defined otherwise, then the others."""
    check_joints(joints)
    if isinstance(speeds, str) or not (speeds is None or isinstance(speeds, Mapping)):
        return speeds  # what is no mapping is refused where the definitions are read
    if speeds is None and not joints:
        raise ModelError('Expected speeds={u: definition, …}, "rates", or joints= with speeds of their own, got none.')
    definitions = dict(speeds or {})
    scalars = {u: as_expr(e) for u, e in definitions.items() if not isinstance(e, Vector)}
    own: dict[Speed, Any] = {}
    for joint in joints:
        if not joint.defined_by(scalars):
            own.update(joint.speeds)
    return own | definitions


def check_joints(joints: Sequence[Any]) -> None:
    """Joints, no two of one name."""
    for joint in joints:
        if not isinstance(joint, Joint):
            raise ModelError(f"Expected joints= made by kn.pin, kn.slider, …, got {joint!r:.60}.")
    names = [joint.name for joint in joints]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ModelError(f"Expected joints of different names, got {', '.join(map(repr, twice))} more than once.")
