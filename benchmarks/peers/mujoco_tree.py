# SPDX-License-Identifier: BSD-3-Clause
"""Trees of pins in MuJoCo's C, contacts and constraints off, compiled against the headers of its wheel."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.native import FLAGS, Array, link
from benchmarks.random_trees import Link

SOURCE = Path(__file__).with_suffix(".c")


@cache
def library() -> ctypes.CDLL:
    """The driver."""
    package = Path(mujoco.__file__).parent
    shared = next(package.glob("libmujoco.so*"))
    found = link(
        SOURCE.read_text(),
        (*FLAGS, "-Wl,--no-as-needed", f"-I{package / 'include'}", f"-Wl,-rpath,{package}", str(shared)),
    )
    found.tree_forward.restype = ctypes.c_double
    return found


def _text(values: Array | list[float]) -> str:
    return " ".join(map(repr, np.asarray(values, dtype=float).ravel().tolist()))


def _body(links: Sequence[Link], k: int) -> str:
    own = links[k]
    x, y, z, w = Rotation.from_matrix(own.seat).as_quat()
    j = own.body.inertia + 1e-9 * np.eye(3)  # MuJoCo wants each moment of inertia above zero
    below = "".join(_body(links, i) for i, other in enumerate(links) if other.parent == k)
    return (
        f'<body pos="{_text(own.at)}" quat="{_text([w, x, y, z])}"><joint name="j{k}" type="hinge" axis="{_text(own.axis)}"/>'
        f'<inertial pos="{_text(own.body.center)}" mass="{own.body.mass!r}" '
        f'fullinertia="{_text([j[0, 0], j[1, 1], j[2, 2], j[0, 1], j[0, 2], j[1, 2]])}"/>{below}</body>'
    )


def forward(
    links: Sequence[Link], gravity: Array, q: Array, v: Array
) -> tuple[Callable[[int], float], Callable[[], Array]]:
    """Seconds of n calls, and the accelerations after them in the order of the links."""
    bodies = "".join(_body(links, k) for k, other in enumerate(links) if other.parent < 0)
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" balanceinertia="true"/><option gravity="{_text(gravity)}"><flag contact="disable" '
        f'constraint="disable"/></option><worldbody>{bodies}</worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    places = [model.joint(f"j{k}").dofadr[0] for k in range(len(links))]
    data.qpos[places], data.qvel[places] = q, v
    # the C structures are reached through the addresses that the bindings keep
    f, m, d = library().tree_forward, ctypes.c_void_p(model._address), ctypes.c_void_p(data._address)
    run = lambda n, _alive=(model, data): float(f(ctypes.c_long(n), m, d))  # noqa: E731
    return run, lambda: data.qacc[places].copy()
