# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations of a robot in URDF by Pinocchio: its reader, its M and rnea, mimics by a system with multipliers of this file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

Array = Any


@dataclass(frozen=True, slots=True)
class State:
    """Values of a joint as URDF means them: a number, or x, y, angle, or (rotation, place); rates along the child's axes."""

    value: Any
    rate: Array


@dataclass(frozen=True, slots=True)
class Answer:
    """Rates of the rates by joint, of the velocities along the child's axes, and M by joints."""

    acceleration: dict[str, Array]
    mass_matrix: Array
    joints: list[str]
    condition: float


def mimics(text: str) -> dict[str, tuple[str, float, float]]:
    """Of the joints that mimic: the leader, the factor, the offset."""
    found = {}
    for joint in ET.fromstring(text).findall("joint"):
        m = joint.find("mimic")
        if m is not None and joint.get("type") != "fixed":
            factor, offset = float(m.get("multiplier", 1)), float(m.get("offset", 0))
            found[joint.attrib["name"]] = (m.attrib["joint"], factor, offset)
    return found


def damping(text: str) -> dict[str, float]:
    """Coefficients of joints, which Pinocchio reads but does not apply."""
    found = {j.attrib["name"]: j.find("dynamics") for j in ET.fromstring(text).findall("joint")}
    return {name: float(d.get("damping", 0)) for name, d in found.items() if d is not None}


def model_of(text: str, free: bool = False) -> pin.Model:
    """Pinocchio's own reading; mimics move freely in it."""
    if free:
        return pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    return pin.buildModelFromXML(text)


def random_state(
    model: pin.Model, rng: np.random.Generator, tied: dict[str, tuple[str, float, float]]
) -> dict[str, State]:
    """A state that mimics admit."""
    found: dict[str, State] = {}
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        rate = rng.uniform(-1, 1, joint.nv)
        if joint.nv == 6:
            found[name] = State((pin.exp3(rng.uniform(-1, 1, 3)), rng.uniform(-1, 1, 3)), rate)
        else:
            found[name] = State(rng.uniform(-1, 1, joint.nv), rate)
    for _ in tied:  # chains of mimics
        for name, (leader, factor, offset) in tied.items():
            found[name] = State(factor * found[leader].value + offset, factor * found[leader].rate)
    return found


def solve(model: pin.Model, state: dict[str, State], effort: dict[str, float], text: str) -> Answer:
    """M q̈ + h = τ + Jᵀλ, J q̈ = 0."""
    q, v, tau = np.empty(model.nq), np.empty(model.nv), np.zeros(model.nv)
    names, tied, lost = list(model.names)[1:], mimics(text), damping(text)
    column = {}
    for name, joint in zip(names, list(model.joints)[1:], strict=True):
        s, at = state[name], slice(joint.idx_q, joint.idx_q + joint.nq)
        column[name] = slice(joint.idx_v, joint.idx_v + joint.nv)
        v[column[name]] = s.rate
        if joint.nv == 6:
            rotation, place = s.value
            q[at] = np.concatenate([place, pin.Quaternion(rotation).coeffs()])
        elif joint.nv == 3:
            q[at] = [*s.value[:2], np.cos(s.value[2]), np.sin(s.value[2])]
        else:
            q[at] = s.value if joint.nq == 1 else [np.cos(s.value[0]), np.sin(s.value[0])]
        tau[column[name]] = effort.get(name, 0.0) - lost.get(name, 0.0) * s.rate
    data = model.createData()
    upper = np.triu(pin.crba(model, data, q))
    M = upper + np.triu(upper, 1).T
    h = pin.rnea(model, data, q, v, np.zeros(model.nv))
    J = np.zeros((len(tied), model.nv))
    for k, (name, (leader, factor, _)) in enumerate(tied.items()):
        J[k, column[name]] = 1
        J[k, column[leader]] -= factor
    whole = np.block([[M, J.T], [J, np.zeros((len(tied), len(tied)))]])
    a = np.linalg.solve(whole, np.concatenate([tau - h, np.zeros(len(tied))]))[: model.nv]
    return Answer({n: a[c] for n, c in column.items()}, M, names, float(np.linalg.cond(whole)))
