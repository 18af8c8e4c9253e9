# SPDX-License-Identifier: BSD-3-Clause
"""The pendulum of rods in MuJoCo: relative angles, contacts and constraints off, `mj_forward`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import mujoco
import numpy as np

from benchmarks.native import Array

# MuJoCo wants a positive inertia about a rod's own axis; it does not enter the plane motion.
_ALONG = 1e-9


def chain(n: int, values: Mapping[str, float]) -> str:
    """The model of n uniform rods hanging along −y, as MJCF."""
    bodies, place = "", 0.0
    for i in range(1, n + 1):
        m, l = values[f"m{i}"], values[f"l{i}"]
        across = m * l**2 / 12
        bodies += (
            f'<body pos="0 {-place!r} 0"><joint type="hinge" axis="0 0 1"/>'
            f'<inertial pos="0 {-l / 2!r} 0" mass="{m!r}" diaginertia="{across!r} {_ALONG!r} {across!r}"/>'
        )
        place = l
    return (
        f'<mujoco><option gravity="0 {-values["g"]!r} 0"><flag contact="disable" constraint="disable"/></option>'
        f"<worldbody>{bodies}{'</body>' * n}</worldbody></mujoco>"
    )


def call(n: int, x: Array, values: Mapping[str, float]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """The function and its arguments."""
    model = mujoco.MjModel.from_xml_string(chain(n, values))
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = np.diff(x[:n], prepend=0.0), np.diff(x[n:], prepend=0.0)
    return mujoco.mj_forward, (model, data)


def accelerations(n: int, x: Array, values: Mapping[str, float]) -> Array:
    """u̇ in absolute angles."""
    f, (model, data) = call(n, x, values)
    f(model, data)
    return np.cumsum(data.qacc)
