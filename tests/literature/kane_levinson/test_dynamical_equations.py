# SPDX-License-Identifier: BSD-3-Clause
"""Dynamical equations of classical systems (Kane & Levinson 1985, ch. 6) against their closed forms, derived by hand.

Each is what a textbook of mechanics states, most by Lagrange's or Newton's equations; the source stands with it.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane import free_symbols
from kane.expr import as_expr
from kane.numeric import values_of

CLOSE, SEED, STATES = 1e-12, 20113, 20

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
m, M, g, L, R, I, J = kn.parameters("m M g L R I J", 1.0)
G = kn.gravity(-g * N.y)
q1, q2, q3 = kn.coordinates("q1:4")
u1, u2, u3 = kn.speeds("u1:4")
s1, c1, s2, c2 = kn.sin(q1), kn.cos(q1), kn.sin(q2), kn.cos(q2)


def rates(*bodies, loads=(G,), **more):
    """A system with rates as speeds."""
    used = [q for q in (q1, q2, q3) if any(q in set(free_symbols(_places(b))) for b in bodies)]
    speeds = dict(zip((u1, u2, u3), (q.dt for q in used), strict=False))
    return kn.System(N, bodies=list(bodies), speeds=speeds, loads=list(loads), coordinates=tuple(used), **more)


def _places(body):
    (part,) = body.parts()
    found = list(part.mass_center.position(O).components(N))
    return found if part.frame is None else [*found, *(x for row in N.dcm(part.frame).rows for x in row)]


def bead_on_a_turning_hoop():
    """θ̈ = Ω² sin θ cos θ − (g/R) sin θ (Goldstein 1980, ch. 2, problem 18)."""
    Omega = kn.parameter("Omega", 3.0)
    A = N.rotate("A", Omega * kn.time, N.y)
    P = O.at("P", R * (s1 * A.x - c1 * A.y))
    return rates(kn.Particle("P", P, m)), [Omega**2 * s1 * c1 - g / R * s1]


def spherical_pendulum():
    """θ̈ = φ̇² sin θ cos θ − (g/L) sin θ, φ̈ = −2 θ̇ φ̇ cot θ (Whittaker 1937, sec. 55)."""
    A = N.rotate("A", q2, N.y)
    P = O.at("P", L * (s1 * A.x - c1 * A.y))
    return rates(kn.Particle("P", P, m)), [u2**2 * s1 * c1 - g / L * s1, -2 * u1 * u2 * c1 / s1]


def elastic_pendulum():
    """r̈ = r θ̇² + g cos θ − k (r − L)/m, θ̈ = −(g sin θ + 2 ṙ θ̇)/r (Nayfeh 1973, sec. 5.5)."""
    k = kn.parameter("k", 30.0)
    A = N.rotate("A", q2, N.z)
    P = O.at("P", -q1 * A.y)
    spring = kn.linear_spring(O, P, k, L)
    expected = [q1 * u2**2 + g * c2 - k * (q1 - L) / m, -(g * s2 + 2 * u1 * u2) / q1]
    return rates(kn.Particle("P", P, m), loads=(G, spring)), expected


def atwood():
    """ẍ = (M − m) g/(M + m + J/R²): two weights on a pulley with inertia."""
    A = N.rotate("A", -q1 / R, N.z)
    pulley = kn.RigidBody("pulley", frame=A, mass_center=O, mass=M, inertia=kn.inertia(A, J, J, J))
    up, down = O.at("up", -R * N.x + q1 * N.y), O.at("down", R * N.x - q1 * N.y)
    system = kn.System(
        N,
        bodies=[pulley, kn.Particle("up", up, m), kn.Particle("down", down, M)],
        speeds={u1: q1.dt},
        loads=[G],
        coordinates=(q1,),
    )
    return system, [(M - m) * g / (M + m + J / R**2)]


def block_on_a_wedge():
    """Wedge and block slide without friction (Landau & Lifshitz 1976, ch. II): M ẍ + m (ẍ + s̈ cos β) = 0."""
    beta = kn.parameter("beta", 0.5)
    c, s = kn.cos(beta), kn.sin(beta)
    W = O.at("W", q1 * N.x)
    P = W.at("P", q2 * (c * N.x - s * N.y))
    system = kn.System(
        N,
        bodies=[kn.Particle("wedge", W, M), kn.Particle("block", P, m)],
        speeds={u1: q1.dt, u2: q2.dt},
        loads=[G],
        coordinates=(q1, q2),
    )
    below = M + m * s**2
    return system, [-m * g * s * c / below, (M + m) * g * s / below]


def sliding_ladder():
    """A rod with its ends on floor and wall: θ̈ = (3 g/2L) sin θ, θ from the wall."""
    A = N.rotate("A", q1, N.z)
    C = O.at("C", L / 2 * (s1 * N.x + c1 * N.y))
    rod = kn.RigidBody("rod", frame=A, mass_center=C, mass=m, inertia=kn.rod(A, m, L, A.y))
    return rates(rod), [3 * g / (2 * L) * s1]


def rolling_down(shape, share):
    """A body of revolution that rolls down a slope: ẍ = g sin β/(1 + I/m R²)."""

    def made():
        beta = kn.parameter("beta", 0.5)
        P = N.rotate("P", -beta, N.z)
        B = P.rotate("B", -q1 / R, P.z)
        C = O.at("C", q1 * P.x + R * P.y)
        body = kn.RigidBody("body", frame=B, mass_center=C, mass=m, inertia=shape(B))
        return rates(body), [g * kn.sin(beta) / (1 + share)]

    made.__name__ = f"rolling_down_{share}"
    return made


def cylinder_in_a_cylinder():
    """A cylinder of radius R that rolls in a fixed one of radius R + L: θ̈ = −(2 g/3 L) sin θ (Timoshenko & Young 1948)."""
    B = N.rotate("B", -L / R * q1, N.z)
    C = O.at("C", L * (s1 * N.x - c1 * N.y))
    body = kn.RigidBody("body", frame=B, mass_center=C, mass=m, inertia=kn.solid_cylinder(B, m, R, 1, B.z))
    return rates(body), [-2 * g / (3 * L) * s1]


def free_body():
    """Euler's equations: I₁ ω̇₁ = (I₂ − I₃) ω₂ ω₃, … (Kane & Levinson 1985, sec. 6.1; Euler 1765)."""
    first, second, third = kn.parameters("I1:4", 1.0)
    B = N.rotate_body("B", (q1, q2, q3), "xyz")
    body = kn.RigidBody("body", frame=B, mass_center=O, mass=m, inertia=kn.inertia(B, first, second, third))
    w = B.angular_velocity(N)
    system = kn.System(
        N, bodies=[body], speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z)}, coordinates=(q1, q2, q3)
    )
    return system, [
        (second - third) / first * u2 * u3,
        (third - first) / second * u3 * u1,
        (first - second) / third * u1 * u2,
    ]


def gyrostat():
    """A carrier with a rotor along its third axis at a constant relative spin σ: I₁ ω̇₁ = (I₂ − I₃) ω₂ ω₃ − J σ ω₂, … (Kelvin)."""
    first, second, third = kn.parameters("I1:4", 1.0)
    sigma = kn.parameter("sigma", 5.0)
    B = N.rotate_body("B", (q1, q2, q3), "xyz")
    C = B.rotate("C", sigma * kn.time, B.z)
    carrier = kn.RigidBody("carrier", frame=B, mass_center=O, mass=m, inertia=kn.inertia(B, first, second, third))
    rotor = kn.RigidBody("rotor", frame=C, mass_center=O, mass=m, inertia=kn.inertia(C, I, I, J))
    w = B.angular_velocity(N)
    system = kn.System(
        N, bodies=[carrier, rotor], speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z)}, coordinates=(q1, q2, q3)
    )
    a, b, c = first + I, second + I, third + J
    return system, [
        ((b - c) * u2 * u3 - J * sigma * u2) / a,
        ((c - a) * u3 * u1 + J * sigma * u1) / b,
        (a - b) / c * u1 * u2,
    ]


def kapitza_pendulum():
    """A pendulum whose pivot moves as A cos Ωt: θ̈ = −(g − A Ω² cos Ωt) sin θ/L (Landau & Lifshitz 1976, sec. 30)."""
    a, Omega = kn.parameter("a", 0.1), kn.parameter("Omega", 4.0)
    t = kn.time
    A = O.at("A", a * kn.cos(Omega * t) * N.y)
    P = A.at("P", L * (s1 * N.x - c1 * N.y))
    return rates(kn.Particle("P", P, m)), [-(g - a * Omega**2 * kn.cos(Omega * t)) * s1 / L]


def foucault_pendulum():
    """In a frame that turns at ω about the vertical: ẍ = 2 ω ẏ + (ω² − g/L) x, … for a linear spring (K. & L., sec. 6.2)."""
    omega, k = kn.parameter("omega", 0.3), kn.parameter("k", 4.0)
    A = N.rotate("A", omega * kn.time, N.z)
    P = O.at("P", q1 * A.x + q2 * A.y)
    force = kn.Force(P, -k * (q1 * A.x + q2 * A.y))
    system = rates(kn.Particle("P", P, m), loads=(force,))
    return system, [2 * omega * u2 + (omega**2 - k / m) * q1, -2 * omega * u1 + (omega**2 - k / m) * q2]


def collar_on_a_turning_rod():
    """r̈ = r θ̇², θ̈ = −2 m r ṙ θ̇/(I + m r²): a collar on a rod that turns freely."""
    A = N.rotate("A", q2, N.z)
    rod = kn.RigidBody("rod", frame=A, mass_center=O, mass=M, inertia=kn.inertia(A, 0, I, I))
    P = O.at("P", q1 * A.x)
    system = kn.System(N, bodies=[rod, kn.Particle("P", P, m)], speeds={u1: q1.dt, u2: q2.dt}, coordinates=(q1, q2))
    return system, [q1 * u2**2, -2 * m * q1 * u1 * u2 / (I + m * q1**2)]


def central_motion():
    """r̈ = r θ̇² − μ/r², θ̈ = −2 ṙ θ̇/r (Newton 1687)."""
    mu = kn.parameter("mu", 2.0)
    A = N.rotate("A", q2, N.z)
    P = O.at("P", q1 * A.x)
    force = kn.Force(P, -m * mu / q1**2 * A.x)
    return rates(kn.Particle("P", P, m), loads=(force,)), [q1 * u2**2 - mu / q1**2, -2 * u1 * u2 / q1]


def particle_in_a_cone():
    """(1 + cot² α) r̈ = r φ̇² − g cot α, φ̈ = −2 ṙ φ̇/r (Goldstein 1980, ch. 1)."""
    alpha = kn.parameter("alpha", 0.7)
    cot = kn.cos(alpha) / kn.sin(alpha)
    A = N.rotate("A", q2, N.y)
    P = O.at("P", q1 * A.x + q1 * cot * A.y)
    return rates(kn.Particle("P", P, m)), [(q1 * u2**2 - g * cot) / (1 + cot**2), -2 * u1 * u2 / q1]


def yo_yo():
    """A disk that unwinds from a thread around it: ẍ = g/(1 + ½) for a uniform one."""
    B = N.rotate("B", q1 / R, N.z)
    C = O.at("C", R * N.x - q1 * N.y)
    body = kn.RigidBody("body", frame=B, mass_center=C, mass=m, inertia=kn.thin_disk(B, m, R, B.z))
    return rates(body), [2 * g / 3]


def heavy_top_by_body_fixed_speeds():
    """A ω̇₁ = (A − C) ω₂ ω₃ + m g L (n·b₂), A ω̇₂ = −(A − C) ω₁ ω₃ − m g L (n·b₁), ω̇₃ = 0, b₃ the axis, n up (Lagrange 1788)."""
    B = N.rotate_body("B", (q1, q2, q3), "yxz")
    body = kn.RigidBody("top", frame=B, mass_center=O.at("C", L * B.z), mass=m, inertia=kn.inertia(B, I, I, J))
    w = B.angular_velocity(N)
    system = kn.System(
        N,
        bodies=[body],
        speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z)},
        loads=[G],
        coordinates=(q1, q2, q3),
    )
    a, weight = I + m * L**2, m * g * L
    up = N.y.components(B)
    return system, [((a - J) * u2 * u3 + weight * up[1]) / a, (-(a - J) * u1 * u3 - weight * up[0]) / a, as_expr(0)]


PROBLEMS = [
    bead_on_a_turning_hoop,
    spherical_pendulum,
    elastic_pendulum,
    atwood,
    block_on_a_wedge,
    sliding_ladder,
    rolling_down(lambda B: kn.solid_sphere(B, m, R), 0.4),
    rolling_down(lambda B: kn.thin_disk(B, m, R, B.z), 0.5),
    rolling_down(lambda B: kn.ring(B, m, R, B.z), 1.0),
    rolling_down(lambda B: kn.spherical_shell(B, m, R), 2 / 3),
    cylinder_in_a_cylinder,
    free_body,
    gyrostat,
    kapitza_pendulum,
    foucault_pendulum,
    collar_on_a_turning_rod,
    central_motion,
    particle_in_a_cone,
    yo_yo,
    heavy_top_by_body_fixed_speeds,
]


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda p: p.__name__)
def test_accelerations_are_those_of_the_book(problem):
    """At random states; by another method, too, which starts from other kinematics."""
    system, expected = problem()
    eom = kn.derive(system)
    other = eom.by("newton-euler")
    roots = [*eom.accelerations, *map(as_expr, expected), *other.accelerations]
    rng = np.random.default_rng(SEED)
    symbols = free_symbols(roots)
    states = {*eom.coordinates, *eom.speeds, *(s for s in symbols if s.default is None)}
    values = values_of(symbols, SEED) | {s: rng.uniform(0.3, 1.2, STATES) for s in sorted(states, key=str)}
    numbers = np.array([np.broadcast_to(x, STATES) for x in kn.evaluate(roots, values)])
    found, wanted, again = np.split(numbers, 3)
    size = np.maximum(1, np.abs(wanted).max(axis=0))
    assert (np.abs(found - wanted).max(axis=0) <= CLOSE * size).all()
    assert (np.abs(again - wanted).max(axis=0) <= CLOSE * size).all()
