# SPDX-License-Identifier: BSD-3-Clause
"""Kane's equations by hand in CasADi: velocities written out, the rest by differentiation, the solution by symbolic LDLᵀ.

With velocities v(q, u) of the mass centres and ω(q, u) of the bodies, both linear in u, J = ∂v/∂u, and the rest of the
accelerations (∂v/∂q) q̇ = jtimes(v, q, q̇). Every mass, length and g is an input at run time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.native import FLAGS, Array, Kernel, address, casadi_loop, link
from benchmarks.peers import recursion

_alive: list[object] = []


@dataclass(frozen=True)
class Model:
    """f(x, p) → ẋ = (q̇, u̇) with x = (q, u) and p in the order of `parameters`."""

    parameters: tuple[str, ...]
    function: Any

    def p(self, values: Mapping[str, float]) -> Array:
        """The parameters as the function's vector."""
        return np.array([values[name] for name in self.parameters])


def _model(parameters: Sequence[str], q: Any, u: Any, p: Any, rates: Any, accelerations: Any) -> Model:
    # differentiation makes each sine and cosine anew; cse leaves one of each
    state, change = ca.vertcat(q, u), ca.cse(ca.vertcat(rates, accelerations))
    return Model(tuple(parameters), ca.Function("rhs", [state, p], [change]))


def _solve(mass: Any, forcing: Any) -> Any:
    return ca.ldl_solve(forcing, *ca.ldl(mass))


def chain(n: int) -> Model:
    """n uniform rods in a plane, angles from the downward vertical, u = q̇."""
    q, u, p = ca.SX.sym("q", n), ca.SX.sym("u", n), ca.SX.sym("p", 2 * n + 1)
    m, l, g = p[:n], p[n : 2 * n], p[2 * n]
    x, y = ca.SX(0), ca.SX(0)
    centers: list[Any] = []
    for i in range(n):
        across, down = l[i] * ca.sin(q[i]), l[i] * ca.cos(q[i])
        centers += [x + across / 2, y - down / 2]
        x, y = x + across, y - down
    v = ca.jtimes(ca.vertcat(*centers), q, u)
    J, bias = ca.jacobian(v, u), ca.jtimes(v, q, u)
    masses = ca.vec(ca.repmat(m.T, 2, 1))
    weights = ca.vec(ca.vertcat(ca.SX.zeros(1, n), -g * m.T))
    mass = J.T @ ca.diag(masses) @ J + ca.diag(m * l**2 / 12)
    return _model(_names(n), q, u, p, u, _solve(mass, J.T @ (weights - masses * bias)))


def _names(n: int) -> list[str]:
    return [f"m{i}" for i in range(1, n + 1)] + [f"l{i}" for i in range(1, n + 1)] + ["g"]


def chain_recursive(n: int) -> Model:
    """The same rods by the recursion instead of a mass matrix: another formulation, for context."""
    q, u, p = ca.SX.sym("q", n), ca.SX.sym("u", n), ca.SX.sym("p", 2 * n + 1)
    qs, us, ms, ls = (ca.vertsplit(v) for v in (q, u, p[:n], p[n : 2 * n]))
    found = recursion.accelerations(qs, us, ms, ls, p[2 * n], ca.sin, ca.cos)
    return _model(_names(n), q, u, p, u, ca.vertcat(*found))


def top() -> Model:
    """The symmetrical top in Euler angles z-x-z, u = q̇, components along the node frame, which does not spin with it."""
    q, u, p = ca.SX.sym("q", 3), ca.SX.sym("u", 3), ca.SX.sym("p", 5)
    m, l, I, J_axial, g = ca.vertsplit(p)
    s, c = ca.sin(q[1]), ca.cos(q[1])
    node = ca.vertcat(u[1], u[0] * s, u[0] * c)
    spin = ca.vertcat(u[1], u[0] * s, u[0] * c + u[2])
    v = ca.cross(node, ca.vertcat(0, 0, l))
    up = ca.vertcat(0, s, c)
    inertia = ca.diag(ca.vertcat(I, I, J_axial))
    Jv, Jw = ca.jacobian(v, u), ca.jacobian(spin, u)
    a = ca.jtimes(v, q, u) + ca.cross(node, v)
    torque = inertia @ ca.jtimes(spin, q, u) + ca.cross(node, inertia @ spin)
    mass = m * (Jv.T @ Jv) + Jw.T @ inertia @ Jw
    return _model(("m", "l", "I", "J", "g"), q, u, p, u, _solve(mass, Jv.T @ (-m * g * up - m * a) - Jw.T @ torque))


def disk() -> Model:
    """The sliding disk, components along its lean frame B; the normal force is solved with the accelerations.

    An auxiliary speed w lifts the contact: its equation holds the normal force N. With f the generalized forces of N = 1,
    u̇ = M⁻¹ b + N M⁻¹ f in the equation of w gives N.
    """
    q, u, p = ca.SX.sym("q", 5), ca.SX.sym("u", 5), ca.SX.sym("p", 4)
    lift = ca.SX.sym("w")
    m, R, g, mu = ca.vertsplit(p)
    s1, c1, s2, c2 = ca.sin(q[0]), ca.cos(q[0]), ca.sin(q[1]), ca.cos(q[1])
    up = ca.vertcat(0, c2, s2)
    along, side = ca.vertcat(1, 0, 0), ca.vertcat(0, s2, -c2)
    lean = ca.vertcat(u[0], u[1], u[1] * s2 / c2)
    omega = u[:3]
    rates = ca.vertcat(u[1] / c2, -u[0], u[2] - u[1] * s2 / c2, u[3], u[4])
    contact = along * (u[3] * c1 + u[4] * s1) + side * (u[4] * c1 - u[3] * s1) + up * lift
    radius = ca.vertcat(0, R, 0)
    v = contact + ca.cross(lean, radius)
    touching = v - ca.cross(omega, radius)
    slide, drift = touching[0], ca.dot(touching, side)
    inertia = m * R**2 * ca.diag(ca.vertcat(0.25, 0.25, 0.5))

    speeds = ca.vertcat(u, lift)
    Jv, Jw = ca.jacobian(v, speeds), ca.jacobian(omega, speeds)
    slip = (along * slide + side * drift) / ca.sqrt(slide**2 + drift**2)
    unit = ca.jacobian(contact, speeds).T @ up - mu * (ca.jacobian(touching, speeds).T @ slip)
    a = ca.jtimes(v, q, rates) + ca.cross(lean, v)
    torque = ca.cross(lean, inertia @ omega)
    mass = m * (Jv.T @ Jv) + Jw.T @ inertia @ Jw
    forcing = Jv.T @ (-m * g * up - m * a) - Jw.T @ torque
    mass, forcing, unit = ca.substitute([mass, forcing, unit], [lift], [ca.SX(0)])

    factors = ca.ldl(mass[:5, :5])
    free, pushed = (ca.ldl_solve(column[:5], *factors) for column in (forcing, unit))
    row = mass[5, :5]
    normal = (forcing[5] - row @ free) / (row @ pushed - unit[5])
    return _model(("m", "R", "g", "mu_k"), q, u, p, rates, free + pushed * normal)


def evaluate(model: Model, x: Array, values: Mapping[str, float]) -> Array:
    """ẋ by CasADi's own interpreter."""
    return np.asarray(model.function(x, model.p(values)), dtype=np.float64).ravel()


def buffered(model: Model, x: Array, values: Mapping[str, float]) -> tuple[Callable[[], None], Array]:
    """A call of CasADi's interpreter that reads and writes arrays in place, and the array it writes."""
    function, p, out = model.function, model.p(values), np.empty_like(x)
    buffer, evaluate = function.buffer()
    buffer.set_arg(0, x.data)
    buffer.set_arg(1, p.data)
    buffer.set_res(0, out.data)
    _alive.append((function, buffer, x, p, out))  # the callable holds none of them
    return evaluate, out


def kernel(model: Model, x: Array, values: Mapping[str, float], flags: Sequence[str] = FLAGS) -> Kernel:
    """The generated C, compiled."""
    f = model.function
    generator = ca.CodeGenerator("rhs.c")
    generator.add(f)
    library = link(generator.dump(), flags)
    return casadi_loop(address(library, f.name()), x, model.p(values), f.sz_iw(), f.sz_w())
