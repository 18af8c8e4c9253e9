# SPDX-License-Identifier: BSD-3-Clause
"""Every kind of joint once, in the language of `kane` and as steps of the oracle of trees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import kane as kn
from tests.oracles.kane_tree import vector
from tests.oracles.tree import Step, Triple, normalized

AXIS: Triple = normalized(np.array([1.0, -2.0, 2.0]))
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
TURNS = (Step("turn", X), Step("turn", Y), Step("turn", Z))
PITCH = 0.3


@dataclass(frozen=True, slots=True)
class Kind:
    """`make` a joint and `close` a loop by it, with the arguments `given` of the parent; `steps` are None for a screw."""

    name: str
    given: Callable[[kn.Frame], dict[str, Any]]
    steps: tuple[Step, ...] | None
    closed: int
    more: dict[str, Any]

    def make(self, name: str, at: kn.Point, parent: kn.Frame, **options: Any) -> kn.Joint:
        joint: kn.Joint = getattr(kn, self.name)(name, at, parent, **self.given(parent), **self.more, **options)
        return joint

    def close(self, name: str, at: kn.Point, parent: kn.Frame, point: kn.Point, frame: kn.Frame) -> Any:
        return getattr(kn, f"close_{self.name}")(name, at, parent, point, frame, **self.given(parent))


def _axis(axis: Triple) -> Callable[[kn.Frame], dict[str, Any]]:
    return lambda frame: {"axis": vector(frame, axis)}


def _planar(frame: kn.Frame) -> dict[str, Any]:
    return {"normal": frame.y}


def _none(frame: kn.Frame) -> dict[str, Any]:
    return {}


ANGLES = {"orientation": "angles"}
KINDS = {
    "pin": Kind("pin", _axis(AXIS), (Step("turn", AXIS),), 5, {}),
    "slider": Kind("slider", _axis(AXIS), (Step("slide", AXIS),), 5, {}),
    "cylindrical": Kind("cylindrical", _axis(Z), (Step("turn", Z), Step("slide", Z)), 4, {}),
    "screw": Kind("screw", lambda f: {**_axis(AXIS)(f), "pitch": kn.parameter("h", PITCH, "m/rad")}, None, 5, {}),
    "universal": Kind("universal", lambda f: {"axes": (f.x, f.z)}, (Step("turn", X), Step("turn", Z)), 4, {}),
    "ball": Kind("ball", _none, TURNS, 3, ANGLES),
    "planar": Kind("planar", _planar, (Step("slide", Z), Step("slide", X), Step("turn", Y)), 3, {}),
    "weld": Kind("weld", _none, (), 6, {}),
    "free": Kind("free", _none, (*(Step("slide", a) for a in (X, Y, Z)), *TURNS), 0, ANGLES),
}


def rigid(name: str, frame: kn.Frame, center: kn.Point, mass: Any, inertia: kn.Dyadic) -> kn.RigidBody:
    return kn.RigidBody(name, frame=frame, mass_center=center, mass=mass, inertia=inertia)
