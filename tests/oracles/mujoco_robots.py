# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations of MJCF models by MuJoCo's M, bias and Jacobians, with exact constraints by multipliers of this file."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

import kane as kn
from tests.oracles.compare import error, tolerance

Array = Any
OFF = mujoco.mjtDisableBit
FREE, BALL = 0, 1


def hard(model: Any) -> Any:
    """The model without contacts, limits, dry friction and medium."""
    model.opt.disableflags |= OFF.mjDSBL_CONTACT | OFF.mjDSBL_LIMIT | OFF.mjDSBL_FRICTIONLOSS
    model.opt.density = model.opt.viscosity = 0
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    return model


def rows(model: Any, data: Any) -> tuple[Array, Array]:
    """J and the residuals of the equality constraints."""
    mujoco.mj_fwdPosition(model, data)
    own = np.asarray(data.efc_type) == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    if not own.any() or not model.nv:
        return np.zeros((0, model.nv)), np.zeros(0)
    return data.efc_J.reshape(-1, model.nv)[own].copy(), data.efc_pos[own].copy()


def place(model: Any, data: Any, rng: np.random.Generator) -> None:
    """A random state that the equality constraints admit."""
    for _ in range(20):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, rng.uniform(-0.4, 0.4, model.nv), 1.0)
        for _ in range(50):
            J, r = rows(model, data)
            if not len(r) or np.abs(r).max() < 1e-14:
                break
            mujoco.mj_integratePos(model, data.qpos, -np.linalg.lstsq(J, r, rcond=1e-9)[0], 1.0)
        J, r = rows(model, data)
        if not len(r) or np.abs(r).max() < 1e-12:
            break
    else:
        raise AssertionError("no configuration is found that the constraints admit")
    v = rng.uniform(-1, 1, model.nv)
    data.qvel[:] = v - (np.linalg.lstsq(J, J @ v, rcond=1e-9)[0] if len(J) else 0)


def drift(model: Any, data: Any) -> Array:
    """J̇ v, by differences of fourth order."""
    other = mujoco.MjData(model)

    def at(h: float) -> Array:
        other.qpos[:] = data.qpos
        mujoco.mj_integratePos(model, other.qpos, data.qvel, h)
        return rows(model, other)[0] @ data.qvel

    h = 1e-3
    return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)


def solve(model: Any, data: Any) -> tuple[Array, float, Array]:
    """q̈ of M q̈ + h = τ + Jᵀλ, J q̈ = −J̇ v, the condition of M, or of what the constraints leave of it, and M."""
    J, _ = rows(model, data)
    right = -drift(model, data) if len(J) else np.zeros(0)
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    force = data.qfrc_passive + data.qfrc_actuator - data.qfrc_bias
    _, s, Vt = np.linalg.svd(J) if len(J) else (None, np.zeros(0), np.eye(model.nv))
    rank = int((s > 1e-9 * max(s, default=1)).sum())
    B = Vt[rank:].T
    start = np.linalg.lstsq(J, right, rcond=1e-9)[0] if len(J) else np.zeros(model.nv)
    reduced = B.T @ M @ B
    a = start + B @ np.linalg.solve(reduced, B.T @ (force - M @ start))
    spread = float(s[0] / s[rank - 1]) if rank else 1.0
    return a, float(np.linalg.cond(reduced) if len(reduced) else 1.0) * spread, M


def turn(quaternion: Array) -> Array:
    found = np.zeros(9)
    mujoco.mju_quat2Mat(found, quaternion)
    return found.reshape(3, 3)


def values(model: Any, data: Any, j: int) -> tuple[Array, Array]:
    """Coordinates and speeds as kane's joints have them: of a free one turns first, velocities along the body's axes."""
    kind, p, d = model.jnt_type[j], model.jnt_qposadr[j], model.jnt_dofadr[j]
    if kind == FREE:
        C = turn(data.qpos[p + 3 : p + 7])
        return np.r_[data.qpos[p + 3 : p + 7], data.qpos[p : p + 3]], np.r_[
            data.qvel[d + 3 : d + 6], C.T @ data.qvel[d : d + 3]
        ]
    if kind == BALL:
        return data.qpos[p : p + 4], data.qvel[d : d + 3]
    return data.qpos[p : p + 1], data.qvel[d : d + 1]


def rates(model: Any, data: Any, j: int, a: Array) -> Array:
    """MuJoCo's accelerations of a joint of which `a` are kane's."""
    if model.jnt_type[j] != FREE:
        return a
    p, d = model.jnt_qposadr[j], model.jnt_dofadr[j]
    C, w = turn(data.qpos[p + 3 : p + 7]), data.qvel[d + 3 : d + 6]
    return np.r_[C @ (a[3:] + np.cross(w, C.T @ data.qvel[d : d + 3])), a[:3]]


def compare(model: Any, read: Any, eom: kn.Equations, rng: np.random.Generator, states: int = 3) -> float:
    """The largest error of accelerations, and of M without constraints, over the tolerance of 1e-9 or 100 ε cond."""
    hard(model)
    data, worst, number = mujoco.MjData(model), 0.0, {s: k for k, s in enumerate(eom.speeds)}
    names = list(read.extras["joints"].values())  # in MuJoCo's order
    inputs = list(read.extras["inputs"].items())
    for _ in range(states):
        place(model, data, rng)
        given = {}
        for name, symbol in inputs:
            k = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
            k = int(name.rpartition("_")[2]) if k < 0 else k
            bounds = model.actuator_ctrlrange[k] if model.actuator_ctrllimited[k] else (-1, 1)
            data.ctrl[k] = given[symbol] = rng.uniform(*bounds)
        q: dict[str, Any] = {}
        u: dict[str, Any] = {}
        for j, name in enumerate(names):
            joint = read.system[name]
            own_q, own_u = values(model, data, j)
            q |= zip((s.name for s in joint.coordinates), own_q, strict=True)
            u |= zip((s.name for s in joint.speeds), own_u, strict=True)
        a, condition, M = solve(model, data)
        found = np.array(eom.evaluate(list(eom.accelerations), q=q, u=u, inputs=given), dtype=np.float64)
        order = [[number[s] for s in read.system[name].speeds] for name in names]
        ours = np.concatenate([rates(model, data, j, found[k]) for j, k in enumerate(order)])
        worst = max(worst, error(ours, a) / tolerance(1e-9, condition))
        if not read.system.constraints and all(len(k) == 1 for k in order):
            flat = [k for (k,) in order]
            ours = np.array(eom.evaluate(eom.mass_matrix, q=q, u=u, inputs=given), dtype=np.float64)[np.ix_(flat, flat)]
            worst = max(worst, error(ours, M) / 1e-9)
    return worst
