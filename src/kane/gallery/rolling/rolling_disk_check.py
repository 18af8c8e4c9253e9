# SPDX-License-Identifier: BSD-3-Clause
"""The sliding disk held against Newton's and Euler's equations, written out in NumPy without the rest of the package.

Redundant unknowns: acceleration a of the centre, angular acceleration α, normal force N, seven a state. With the disk's unit vectors
b1 level, b2 up the plane of the disk, d along the axis, z up, f = −μ slip/|slip| and s = d·z,

    m a = N (z + f) − m g z,      I α + ω × I ω = −R b2 × N (z + f),

and the height h of the centre obeys h² = R² (1 − s²), twice differentiated with ḋ = ω × d:

    h z·a + R² s z·(α × d) = −R² (ṡ² + s z·(ω × (ω × d))) − ḣ².
"""

from dataclasses import dataclass

import numpy as np

import kane as kn
from kane.gallery.rolling.rolling_disk import Model, model
from kane.numeric.arrays import Array
from kane.present.check_figures import Check

_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class NewtonEuler:
    """What Newton and Euler say at n states: vectors are n × 3 with inertial components."""

    speeds: Array
    a: Array
    alpha: Array
    normal: Array
    friction_power: Array


def newton_euler(
    q: Array, rates: Array, m: float, R: float, g: float, mu: float, axial: float = 0.5, diametral: float = 0.25
) -> NewtonEuler:
    """Accelerations and normal force at coordinates `q` and `rates` (5 × n); moments of inertia in units of m R²."""
    yaw, lean = q[0], q[1]
    level = np.zeros_like(yaw)
    b1 = np.stack([np.cos(yaw), np.sin(yaw), level], axis=-1)
    side = np.stack([-np.sin(yaw), np.cos(yaw), level], axis=-1)
    c, s = np.cos(lean)[:, None], np.sin(lean)[:, None]
    b2, d = s * side + c * _Z, s * _Z - c * side
    turning = rates[0][:, None] * _Z - rates[1][:, None] * b1
    omega = turning + rates[2][:, None] * d
    v = np.stack([rates[3], rates[4], level], axis=-1) + R * np.cross(turning, b2)
    slip = v - R * np.cross(omega, b2)
    f = -mu * slip / np.linalg.norm(slip, axis=-1, keepdims=True)

    outer = d[:, :, None] * d[:, None, :]
    inertia = m * R**2 * (diametral * (np.eye(3) - outer) + axial * outer)
    momentum = np.einsum("nij,nj->ni", inertia, omega)
    table, right = np.zeros((len(yaw), 7, 7)), np.zeros((len(yaw), 7))
    table[:, :3, :3] = m * np.eye(3)
    table[:, :3, 6] = -(_Z + f)
    table[:, 3:6, 3:6] = inertia
    table[:, 3:6, 6] = R * np.cross(b2, _Z + f)
    table[:, 6, 2] = R * c[:, 0]
    table[:, 6, 3:6] = R**2 * s * np.cross(d, _Z)
    right[:, 2] = -m * g
    right[:, 3:6] = -np.cross(omega, momentum)
    s_rate = np.cross(omega, d)[:, 2]
    s_bias = np.cross(omega, np.cross(omega, d))[:, 2]
    right[:, 6] = -(R**2) * (s_rate**2 + s[:, 0] * s_bias) - v[:, 2] ** 2
    x = np.asarray(np.linalg.solve(table, right[:, :, None])[:, :, 0], dtype=np.float64)

    spins = [np.einsum("ni,ni->n", omega, axis) for axis in (b1, b2, d)]
    power = x[:, 6] * np.einsum("ni,ni->n", f, slip)
    return NewtonEuler(np.array([*spins, rates[3], rates[4]]), x[:, :3], x[:, 3:6], x[:, 6], power)


def checks(
    disk: Model | None = None,
    eom: kn.Equations | None = None,
    *,
    states: int = 100,
    seed: int = 2004,
    axial: float = 0.5,
    diametral: float = 0.25,
) -> tuple[Check, ...]:
    """The derived equations against the other route at random states; `axial` and `diametral` are that route's inertia."""
    if disk is None or eom is None:
        disk = model()
        eom = kn.derive(disk.system)
    rng = np.random.default_rng(seed)
    q, rates = rng.uniform(-3.0, 3.0, (5, states)), rng.uniform(-3.0, 3.0, (5, states))
    q[1] = rng.uniform(-1.2, 1.2, states)
    m, R, g, mu = (float(p.default or 0) for p in (disk.m, disk.R, disk.g, disk.mu))
    truth = newton_euler(q, rates, m, R, g, mu, axial, diametral)
    other = model(speeds="rates")
    mine = _values(disk, eom, q, truth.speeds)
    theirs = _values(other, kn.derive(other.system), q, rates)
    change, power = (
        np.asarray(x)[None]
        for x in eom.evaluate([eom.time_derivative(eom.energy), eom.power], q=list(q), u=list(truth.speeds))
    )
    at = f"at {states} random states"
    newton = f"Newton–Euler in redundant coordinates (a, α, N), {at}"
    speeds = f"a, α and N with u = q′ instead of the components of ω, {at}"
    invariance = max(_off(mine[i:j], theirs[i:j]) for i, j in ((0, 3), (3, 6), (6, 7)))
    found = (
        ("accelerations of the centre", _off(mine[:3], truth.a.T), newton),
        ("angular acceleration", _off(mine[3:6], truth.alpha.T), newton),
        ("normal force", _off(mine[6:], truth.normal[None]), newton),
        ("dE/dt less the power of friction", _off(change, truth.friction_power[None]), f"{newton}; power N f·slip"),
        ("dE/dt less the power derived", _off(change, power), f"energy and power as derived, {at}"),
        ("invariance under the choice of speeds", invariance, speeds),
    )
    return tuple(Check(what, off, 1e-10, how) for what, off, how in found)


def _values(disk: Model, eom: kn.Equations, q: Array, u: Array) -> Array:
    """a, α (inertial components) and N, 7 × n."""
    exprs = [
        *eom.point_accelerations[disk.Cs].components(disk.N),
        *eom.angular_accelerations[disk.C].components(disk.N),
        disk.normal,
    ]
    return np.stack([np.broadcast_to(v, q.shape[1:]) for v in eom.evaluate(exprs, q=list(q), u=list(u))])


def _off(values: Array, expected: Array) -> float:
    """Largest relative difference over the states."""
    return float(np.max(np.linalg.norm(values - expected, axis=0) / np.linalg.norm(expected, axis=0)))
