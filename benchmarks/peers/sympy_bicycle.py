# SPDX-License-Identifier: BSD-3-Clause
"""The Whipple bicycle of the gallery by SymPy's KanesMethod: four coordinates, six speeds, three of them dependent.

The rear contact is at rest by construction, neither its place nor the wheels' angles are coordinates, on which nothing
depends, and the speeds are the rates of the angles: the least that SymPy can be asked. Angles and parameters have the
gallery's meanings and names.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sm
from sympy.physics import mechanics as me

from benchmarks.native import Array

COORDINATES = ("psi", "phi", "delta", "theta")
SPEEDS = ("u_phi", "u_delta", "u_theta_R", "u_theta", "u_psi", "u_theta_F")
INPUTS = ("T_phi", "T_delta")


@dataclass(frozen=True, eq=False)
class Model:
    """What KanesMethod is given: bodies, loads and equations in q and u, the dependent ones last."""

    frame: Any
    q: Mapping[str, Any]
    u: Mapping[str, Any]
    bodies: tuple[Any, ...]
    loads: tuple[Any, ...]
    kinematic: tuple[Any, ...]
    configuration: tuple[Any, ...]
    velocity: tuple[Any, ...]


def model() -> Model:
    """The bicycle, z down."""
    q = {name: me.dynamicsymbols(name) for name in COORDINATES}
    u = {name: me.dynamicsymbols(name) for name in SPEEDS}
    T_phi, T_delta = (me.dynamicsymbols(name) for name in INPUTS)
    g, w, c, tilt, r_R, r_F = sm.symbols("g w c lambda r_R r_F")
    x_B, z_B, x_H, z_H = sm.symbols("x_B z_B x_H z_H")
    psi, phi, delta, theta = (q[name] for name in COORDINATES)

    N = me.ReferenceFrame("N")
    Y = N.orientnew("Y", "Axis", (psi, N.z))
    L = Y.orientnew("L", "Axis", (phi, Y.x))
    S = L.orientnew("S", "Axis", (theta + tilt, L.y))
    B = S.orientnew("B", "Axis", (-tilt, S.y))
    H = S.orientnew("H", "Axis", (delta, S.z))
    E = H.orientnew("E", "Axis", (-tilt, H.y))
    R, F = me.ReferenceFrame("R"), me.ReferenceFrame("F")

    kinematic = tuple(q[name].diff() - u[f"u_{name}"] for name in COORDINATES)
    Y.set_ang_vel(N, u["u_psi"] * N.z)
    L.set_ang_vel(Y, u["u_phi"] * Y.x)
    S.set_ang_vel(L, u["u_theta"] * L.y)
    B.set_ang_vel(S, 0)
    H.set_ang_vel(S, u["u_delta"] * S.z)
    E.set_ang_vel(H, 0)
    R.set_ang_vel(L, u["u_theta_R"] * L.y)
    F.set_ang_vel(H, u["u_theta_F"] * H.y)

    def along(dx: Any, dz: Any) -> tuple[Any, Any]:
        return sm.cos(tilt) * dx - sm.sin(tilt) * dz, sm.sin(tilt) * dx + sm.cos(tilt) * dz

    reach = along(w + c, r_R)[0]
    front_x, front_z = along(w, r_R - r_F)
    fork_x, fork_z = along(x_H, z_H + r_R)
    body_x, body_z = along(x_B, z_B + r_R)
    P = me.Point("P")
    P.set_vel(N, 0)
    Rs = P.locatenew("R*", -r_R * L.z)
    Bs = Rs.locatenew("B*", body_x * S.x + body_z * S.z)
    A = Rs.locatenew("A", reach * S.x)
    Hs = A.locatenew("H*", (fork_x - reach) * H.x + fork_z * H.z)
    Fs = A.locatenew("F*", (front_x - reach) * H.x + front_z * H.z)
    down = N.z.express(H)
    ahead, below = down.dot(H.x), down.dot(H.z)
    Fh = Fs.locatenew("F^", r_F * (ahead * H.x + below * H.z) / sm.sqrt(ahead**2 + below**2))
    for point, other, frame in ((Rs, P, R), (Bs, Rs, S), (A, Rs, S), (Hs, A, H), (Fs, A, H), (Fh, Fs, F)):
        point.v2pt_theory(other, N, frame)

    def body(letter: str, frame: Any, centre: Any, inertia: Any) -> Any:
        return me.RigidBody(letter, centre, frame, sm.Symbol(f"m_{letter}"), (inertia, centre))

    def wheel(letter: str, axes: Any) -> Any:
        across, about = sm.symbols(f"I_{letter}xx I_{letter}yy")
        return me.inertia(axes, across, about, across)

    def framed(letter: str, axes: Any) -> Any:
        xx, yy, zz, xz = sm.symbols(" ".join(f"I_{letter}{k}" for k in ("xx", "yy", "zz", "xz")))
        return me.inertia(axes, xx, yy, zz, 0, 0, xz)

    bodies = (
        body("R", R, Rs, wheel("R", L)),
        body("B", S, Bs, framed("B", B)),
        body("H", H, Hs, framed("H", E)),
        body("F", F, Fs, wheel("F", H)),
    )
    weights = tuple((b.masscenter, b.mass * g * N.z) for b in bodies)
    torques = ((S, T_phi * L.x - T_delta * S.z), (H, T_delta * S.z))
    slip = Fh.vel(N)
    height = Fh.pos_from(P).dot(N.z)
    rates = {q[name].diff(): u[f"u_{name}"] for name in COORDINATES}
    # each has one dependent speed more than the one before, and SymPy's elimination then keeps the equations short
    velocity = (me.msubs(height.diff(me.dynamicsymbols._t), rates), slip.dot(H.y), slip.dot(H.x))
    return Model(N, q, u, bodies, (*weights, *torques), kinematic, (height,), velocity)


def derive() -> Any:
    """The model and its KanesMethod."""
    m = model()
    q, u = list(m.q.values()), list(m.u.values())
    method = me.KanesMethod(
        m.frame,
        q_ind=q[:3],
        q_dependent=q[3:],
        u_ind=u[:3],
        u_dependent=u[3:],
        kd_eqs=m.kinematic,
        configuration_constraints=m.configuration,
        velocity_constraints=m.velocity,
    )
    method.kanes_equations(m.bodies, m.loads)
    return method


def numbers(symbols: Iterable[Any], values: Mapping[str, float]) -> dict[Any, float]:
    """Symbols and functions of time → their values, by name."""
    return {s: values[s.name] for s in symbols if s.name in values}


def accelerations(method: Any, values: Mapping[str, float]) -> dict[str, float]:
    """u̇ by name at a state, inputs and parameters by name."""
    held = [*me.find_dynamicsymbols(method.forcing), *method.q, *method.u]
    constants = method.mass_matrix.free_symbols | method.forcing.free_symbols
    table = numbers([*held, *constants], values)
    mass, forcing = (np.array(me.msubs(m, table), dtype=float) for m in (method.mass_matrix, method.forcing))
    found = np.linalg.solve(mass, forcing[:, 0])
    return {s.name: float(v) for s, v in zip(method.u, found, strict=True)}


def linear(method: Any, values: Mapping[str, float]) -> Array:
    """A of ẋ = A x + B r in the independent coordinates and speeds, at a steady motion given by name.

    The parameters' numbers go in with the state's, before SymPy solves;
    NumPy solves what is numeric, for SymPy's own elimination finds the
    matrix of these numbers singular, which it is not.
    """

    def solve(matrix: Any, right: Any) -> Any:
        if matrix.free_symbols or right.free_symbols:
            return matrix.LUsolve(right)
        return sm.Matrix(np.linalg.solve(np.array(matrix, dtype=float), np.array(right, dtype=float)))

    constants = method.mass_matrix.free_symbols | method.forcing.free_symbols | method.mass_matrix_full.free_symbols
    held = [*method.q, *method.u, *me.find_dynamicsymbols(method.forcing), *constants]
    at = numbers(held, values) | {s.diff(): 0.0 for s in (*method.u, *method.q)}
    A, _, _ = method.linearize(linear_solver=solve, A_and_B=True, op_point=at)
    return np.array(A, dtype=float)
