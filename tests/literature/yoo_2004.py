# SPDX-License-Identifier: BSD-3-Clause
"""Equations (11) to (32) of Yoo's tutorial on Kane's method, as plain NumPy functions.

Source: H. H. Yoo, "Kane's method for the derivation of equations of motion" (in Korean), tutorial
lecture at the 2004 spring conference on noise and vibration, Gyeongju, sections 4 and 5: a disk that
rolls and slides on a plane.

Nothing here knows the library. Vectors are arrays of shape (n, 3), one row a sample; their components
are on the article's a_x, a_y, a_z (functions ending in ``_a``, and where said) or on its b_1, b_2, b_3
(all others). Where the printed equation cannot hold there are two functions: ``eq_NN``, corrected, and
``eq_NN_printed``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """Random states: coordinates, rates, speeds and their derivatives, each (n, 5), and constants (n,).

    The rates `qd` are independent of `u`: (11) to (14) are in rates, all others in speeds. `normal` is
    the article's N, free until (32) determines it.
    """

    q: Array
    qd: Array
    u: Array
    ud: Array
    m: Array
    R: Array
    g: Array
    mu: Array
    normal: Array


def samples(n: int = 50, seed: int = 2004) -> Samples:
    """Draw `n` random states; the lean q2 stays 0.37 rad away from ±pi/2 and 0.05 from 0."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-3.0, 3.0, (n, 5))
    q[:, 1] = rng.choice([-1.0, 1.0], n) * rng.uniform(0.05, 1.2, n)
    return Samples(
        q=q,
        qd=rng.uniform(-2.0, 2.0, (n, 5)),
        u=rng.uniform(-2.0, 2.0, (n, 5)),
        ud=rng.uniform(-5.0, 5.0, (n, 5)),
        m=rng.uniform(0.5, 2.0, n),
        R=rng.uniform(0.2, 0.6, n),
        g=rng.uniform(8.0, 11.0, n),
        mu=rng.uniform(0.05, 0.4, n),
        normal=rng.uniform(2.0, 20.0, n),
    )


# ---------------------------------------------------------------- bases


def vector(*components: Array | float) -> Array:
    """Stack three measure numbers to vectors (n, 3)."""
    return np.stack(np.broadcast_arrays(*components), axis=-1)


def dot(v: Array, w: Array) -> Array:
    """Scalar product, row by row."""
    products: Array = np.einsum("ni,ni->n", v, w)
    return products


def on_b(s: Samples, v: Array) -> Array:
    """Components on b_1, b_2, b_3 of a vector given on a_x, a_y, a_z.

    a_x = c1 b1 - s1 s2 b2 + s1 c2 b3, a_y = s1 b1 + c1 s2 b2 - c1 c2 b3, a_z = c2 b2 + s2 b3.
    """
    c1, s1, c2, s2 = _cosines(s)
    x, y, z = v.T
    return vector(
        c1 * x + s1 * y,
        -s1 * s2 * x + c1 * s2 * y + c2 * z,
        s1 * c2 * x - c1 * c2 * y + s2 * z,
    )


def on_a(s: Samples, v: Array) -> Array:
    """Components on a_x, a_y, a_z of a vector given on b_1, b_2, b_3."""
    c1, s1, c2, s2 = _cosines(s)
    x, y, z = v.T
    return vector(
        c1 * x - s1 * s2 * y + s1 * c2 * z,
        s1 * x + c1 * s2 * y - c1 * c2 * z,
        c2 * y + s2 * z,
    )


def r_P_Cs(s: Samples) -> Array:
    """Position of the mass centre C* from the trace P: R b2."""
    return vector(0.0 * s.R, s.R, 0.0)


def r_Cs_Ch(s: Samples) -> Array:
    """Position of the disk's particle in contact, C^, from the mass centre C*: -R b2."""
    return -r_P_Cs(s)


def _cosines(s: Samples) -> tuple[Array, Array, Array, Array]:
    q1, q2 = s.q[:, 0], s.q[:, 1]
    return np.cos(q1), np.sin(q1), np.cos(q2), np.sin(q2)


# ---------------------------------------------------------------- (11) to (14): in rates


def eq_11_first_line(s: Samples) -> Array:
    """First line of (11), right in print: q1' a_z - q2' b1 + q3' b3."""
    zero = 0.0 * s.R
    a_z = on_b(s, vector(zero, 0.0, 1.0))
    yaw: Array = s.qd[:, :1] * a_z
    return yaw + vector(-s.qd[:, 1], 0.0, s.qd[:, 2])


def eq_11(s: Samples) -> Array:
    """Angular velocity of C, second line of (11): -q2' b1 + q1' cos q2 b2 + (q3' + q1' sin q2) b3."""
    _, _, c2, s2 = _cosines(s)
    return vector(-s.qd[:, 1], s.qd[:, 0] * c2, s.qd[:, 2] + s.qd[:, 0] * s2)


def eq_11_printed(s: Samples) -> Array:
    """Second line of (11) with csc q2 for cos q2 and sec q2 for sin q2."""
    _, _, c2, s2 = _cosines(s)
    return vector(-s.qd[:, 1], s.qd[:, 0] / s2, s.qd[:, 2] + s.qd[:, 0] / c2)


def eq_12_a(s: Samples) -> Array:
    """Velocity of the trace P, on a: q4' a_x + q5' a_y."""
    return vector(s.qd[:, 3], s.qd[:, 4], 0.0)


def eq_13(s: Samples) -> Array:
    """Angular velocity of B: -q2' b1 + q1' cos q2 b2 + q1' sin q2 b3."""
    _, _, c2, s2 = _cosines(s)
    return vector(-s.qd[:, 1], s.qd[:, 0] * c2, s.qd[:, 0] * s2)


def eq_13_printed(s: Samples) -> Array:
    """(13) with csc q2 for cos q2 and sec q2 for sin q2."""
    _, _, c2, s2 = _cosines(s)
    return vector(-s.qd[:, 1], s.qd[:, 0] / s2, s.qd[:, 0] / c2)


def eq_14(s: Samples) -> Array:
    """Generalized speeds (n, 5): -q2', q1' cos q2, q3' + q1' sin q2, q4', q5'."""
    return np.concatenate([eq_11(s), s.qd[:, 3:]], axis=1)


def eq_14_printed(s: Samples) -> Array:
    """(14) with csc q2 for cos q2 and sec q2 for sin q2."""
    return np.concatenate([eq_11_printed(s), s.qd[:, 3:]], axis=1)


def eq_14_inverse(s: Samples) -> Array:
    """The rates q' (n, 5) that (14), corrected, assigns to the speeds; q1' = u2/cos q2."""
    u1, u2, u3, u4, u5 = s.u.T
    tan = np.tan(s.q[:, 1])
    return np.stack([u2 / np.cos(s.q[:, 1]), -u1, u3 - u2 * tan, u4, u5], axis=1)


def eq_14_printed_inverse(s: Samples) -> Array:
    """The rates q' (n, 5) that (14), as printed, assigns to the speeds; q1' = u2 sin q2."""
    u1, u2, u3, u4, u5 = s.u.T
    tan = np.tan(s.q[:, 1])
    return np.stack([u2 * np.sin(s.q[:, 1]), -u1, u3 - u2 * tan, u4, u5], axis=1)


# ---------------------------------------------------------------- (15) to (23): in speeds


def eq_12_in_u_a(s: Samples) -> Array:
    """(12) with (14), on a: u4 a_x + u5 a_y."""
    return vector(s.u[:, 3], s.u[:, 4], 0.0)


def eq_15(s: Samples) -> Array:
    """Angular velocity of C: u1 b1 + u2 b2 + u3 b3."""
    return s.u[:, :3].copy()


def eq_16(s: Samples) -> Array:
    """Angular velocity of B: u1 b1 + u2 b2 + u2 tan q2 b3."""
    return vector(s.u[:, 0], s.u[:, 1], s.u[:, 1] * np.tan(s.q[:, 1]))


def eq_17(s: Samples) -> Array:
    """Velocity of C*: v^P + omega^B x r^PC*."""
    return on_b(s, eq_12_in_u_a(s)) + np.cross(eq_16(s), r_P_Cs(s))


def eq_18(s: Samples) -> Array:
    """Velocity of C*, written out."""
    c1, s1, c2, s2 = _cosines(s)
    u1, u2, _, u4, u5 = s.u.T
    return vector(
        u4 * c1 + u5 * s1 - s.R * u2 * np.tan(s.q[:, 1]),
        u5 * c1 * s2 - u4 * s1 * s2,
        u4 * s1 * c2 - u5 * c1 * c2 + s.R * u1,
    )


def eq_19(s: Samples) -> Array:
    """Velocity of C^: v^C* + omega^C x r^C*C^."""
    return eq_18(s) + np.cross(eq_15(s), r_Cs_Ch(s))


def eq_20(s: Samples) -> Array:
    """Velocity of C^, written out."""
    c1, s1, c2, s2 = _cosines(s)
    _, u2, u3, u4, u5 = s.u.T
    return vector(
        u4 * c1 + u5 * s1 - s.R * u2 * np.tan(s.q[:, 1]) + s.R * u3,
        u5 * c1 * s2 - u4 * s1 * s2,
        u4 * s1 * c2 - u5 * c1 * c2,
    )


def a_P(s: Samples) -> Array:
    """Acceleration of the trace P, the derivative of (12): u4' a_x + u5' a_y, here on b."""
    return on_b(s, vector(s.ud[:, 3], s.ud[:, 4], 0.0))


def eq_21(s: Samples) -> Array:
    """Acceleration of C*: a^P + alpha^B x r^PC* + omega^B x (omega^B x r^PC*)."""
    w, r = eq_16(s), r_P_Cs(s)
    return a_P(s) + np.cross(eq_23(s), r) + np.cross(w, np.cross(w, r))


def eq_21_printed(s: Samples) -> Array:
    """(21) without brackets, read from the left: (omega^B x omega^B) x r, which is zero."""
    w, r = eq_16(s), r_P_Cs(s)
    return a_P(s) + np.cross(eq_23(s), r) + np.cross(np.cross(w, w), r)


def eq_22(s: Samples) -> Array:
    """Angular acceleration of C: derivative of (15) in B + omega^B x omega^C."""
    return s.ud[:, :3] + np.cross(eq_16(s), eq_15(s))


def eq_23(s: Samples) -> Array:
    """Angular acceleration of B: u1' b1 + u2' b2 + (u2' tan q2 - u1 u2 sec^2 q2) b3."""
    q2 = s.q[:, 1]
    u1, u2 = s.u[:, 0], s.u[:, 1]
    ud1, ud2 = s.ud[:, 0], s.ud[:, 1]
    return vector(ud1, ud2, ud2 * np.tan(q2) - u1 * u2 / np.cos(q2) ** 2)


# ---------------------------------------------------------------- (24) to (29): forces


def partial(velocity: Callable[[Samples], Array], s: Samples) -> Array:
    """Partial velocities (n, 5, 3) of a velocity that is linear in u: value at unit u less at zero u."""
    zero = velocity(replace(s, u=np.zeros_like(s.u)))
    unit = np.eye(5)
    columns = [velocity(replace(s, u=0.0 * s.u + unit[r])) - zero for r in range(5)]
    return np.stack(columns, axis=1)


def inertia(s: Samples) -> Array:
    """Central inertia (n, 3) of the thin disk about b1, b2, b3: mR^2/4, mR^2/4, mR^2/2."""
    transverse = s.m * s.R**2 / 4.0
    return vector(transverse, transverse, 2.0 * transverse)


def a_Ch(s: Samples) -> Array:
    """Acceleration of the particle C^: a^C* + alpha^C x r + omega^C x (omega^C x r)."""
    w, r = eq_15(s), r_Cs_Ch(s)
    return eq_21(s) + np.cross(eq_22(s), r) + np.cross(w, np.cross(w, r))


def eq_24(s: Samples) -> Array:
    """Inertia force: -m a^C*."""
    return -s.m[:, None] * eq_21(s)


def eq_24_printed(s: Samples) -> Array:
    """(24) with a^C. C is a body; the one point whose letter is a bare C elsewhere in print is C^."""
    return -s.m[:, None] * a_Ch(s)


def eq_25(s: Samples) -> Array:
    """Inertia torque: -I . alpha^C - omega^C x (I . omega^C)."""
    I = inertia(s)
    w = eq_15(s)
    return -I * eq_22(s) - np.cross(w, I * w)


def weight(s: Samples) -> Array:
    """The weight W = -m g a_z."""
    return on_b(s, vector(0.0 * s.m, 0.0, -s.m * s.g))


def _active(s: Samples, contact: Callable[[Samples], Array]) -> Array:
    """Terms (n, 5, 2) of F_r: of the weight at C*, of the friction (29) at `contact`."""
    at_center = np.einsum("nri,ni->nr", partial(eq_18, s), weight(s))
    at_contact = np.einsum("nri,ni->nr", partial(contact, s), eq_29(s))
    return np.stack([at_center, at_contact], axis=-1)


def eq_26(s: Samples) -> Array:
    """Terms (n, 5, 2), to be summed, of the active force: v_r^C* . W + v_r^C^ . R."""
    return _active(s, eq_20)


def eq_26_printed(s: Samples) -> Array:
    """(26) with v_r^C for v_r^C^: friction at the disk's only other named point, C*."""
    return _active(s, eq_18)


def eq_27(s: Samples) -> Array:
    """Terms (n, 5, 2), to be summed, of the inertia force: v_r^C* . F* + omega_r^C . T*."""
    force = np.einsum("nri,ni->nr", partial(eq_18, s), eq_24(s))
    torque = np.einsum("nri,ni->nr", partial(eq_15, s), eq_25(s))
    return np.stack([force, torque], axis=-1)


def eq_28(s: Samples) -> Array:
    """Terms (n, 5, 4) whose sum over the last axis is zero: F_r + F*_r."""
    return np.concatenate([eq_26(s), eq_27(s)], axis=-1)


def _friction(s: Samples, slip: Array) -> Array:
    speed: Array = np.linalg.norm(slip, axis=1)
    force: Array = -(s.mu * s.normal / speed)[:, None] * slip
    return force


def eq_29(s: Samples) -> Array:
    """Friction on the disk: -mu_k N v^C^/|v^C^|."""
    return _friction(s, eq_20(s))


def eq_29_printed(s: Samples) -> Array:
    """(29) with v^C for v^C^: the velocity of the disk's only other named point, C*."""
    return _friction(s, eq_18(s))


# ---------------------------------------------------------------- (30) to (32): the normal force


def eq_30_a(s: Samples, u6: Array) -> Array:
    """Velocity of P with the auxiliary speed, on a: u4 a_x + u5 a_y + u6 a_z."""
    return vector(s.u[:, 3], s.u[:, 4], u6)


def eq_31_a(s: Samples) -> tuple[Array, Array]:
    """Partial velocities of C* and of C^ for u6, on a: a_z, a_z."""
    a_z = vector(0.0 * s.R, 0.0, 1.0)
    return a_z, a_z


def eq_32(s: Samples) -> Array:
    """Terms (n, 3), to be summed: v_6^C^ . N a_z + v_6^C* . (-m g a_z) + v_6^C* . (-m a^C*)."""
    v6_Cs, v6_Ch = eq_31_a(s)
    normal = vector(0.0 * s.m, 0.0, s.normal)
    force = dot(v6_Cs, on_a(s, weight(s)))
    return np.stack([dot(v6_Ch, normal), force, dot(v6_Cs, on_a(s, eq_24(s)))], axis=1)


# ---------------------------------------------------------------- the article's equations, solved


def residual(s: Samples) -> Array:
    """Left sides (n, 6) of (28) and (32)."""
    return np.concatenate([eq_28(s).sum(-1), eq_32(s).sum(-1)[:, None]], axis=1)


def solve(s: Samples) -> tuple[Samples, Array]:
    """Solve (28) and (32), linear in u' and N: the states with u' and N replaced; condition numbers."""
    zero = replace(s, ud=np.zeros_like(s.ud), normal=np.zeros_like(s.normal))
    bias = residual(zero)
    unit = np.eye(5)
    columns = [residual(replace(zero, ud=0.0 * s.ud + unit[r])) - bias for r in range(5)]
    columns.append(residual(replace(zero, normal=np.ones_like(s.normal))) - bias)
    matrix = np.stack(columns, axis=-1)
    x = np.asarray(np.linalg.solve(matrix, -bias[..., None])[..., 0], dtype=np.float64)
    return replace(s, ud=x[:, :5], normal=x[:, 5]), np.linalg.cond(matrix)
