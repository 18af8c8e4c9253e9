# SPDX-License-Identifier: BSD-3-Clause
"""The pendulum of rods in Pinocchio: relative angles, accelerations by the articulated-body algorithm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from benchmarks.native import Array


def chain(n: int, values: Mapping[str, float]) -> Any:
    """The model of n uniform rods hanging along −y; each turns about z relative to the one before."""
    model = pin.Model()
    model.gravity.linear = np.array([0.0, -values["g"], 0.0])
    joint, place = 0, pin.SE3.Identity()
    for i in range(1, n + 1):
        m, l = values[f"m{i}"], values[f"l{i}"]
        joint = model.addJoint(joint, pin.JointModelRZ(), place, f"joint {i}")
        across = m * l**2 / 12
        rod = pin.Inertia(m, np.array([0.0, -l / 2, 0.0]), np.diag([across, 0.0, across]))
        model.appendBodyToJoint(joint, rod, pin.SE3.Identity())
        place = pin.SE3(np.eye(3), np.array([0.0, -l, 0.0]))
    return model


def call(n: int, x: Array, values: Mapping[str, float]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """The function and its arguments."""
    model = chain(n, values)
    q, u = np.diff(x[:n], prepend=0.0), np.diff(x[n:], prepend=0.0)
    return pin.aba, (model, model.createData(), q, u, np.zeros(n))


def accelerations(n: int, x: Array, values: Mapping[str, float]) -> Array:
    """u̇ in absolute angles."""
    f, arguments = call(n, x, values)
    return np.cumsum(f(*arguments))
