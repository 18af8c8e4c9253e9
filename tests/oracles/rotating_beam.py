# SPDX-License-Identifier: BSD-3-Clause
"""Rotating beams by other ways, written without `kane`: spectral collocation for frequencies, Legendre–Ritz for motions.

`exact_spin_up` is a geometrically exact beam that keeps its length, by the angle of its tangent; `elastica` its statics.

Collocation at Chebyshev points has the highest derivative as its unknown, the lower ones as integrals from the end where they vanish,
so that all end conditions hold and nothing is differentiated. Lengths in L, times in √(ρA L⁴/EI).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import Chebyshev, Legendre
from scipy.integrate import solve_bvp, solve_ivp
from scipy.linalg import eig, eigh


def _integrals(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points in (0, 1), and the matrices of ∫₀^ξ and ∫_ξ^1 of what is interpolated there."""
    x = (1 - np.cos(np.pi * (np.arange(n) + 0.5) / n)) / 2
    to_series = np.linalg.inv(np.polynomial.chebyshev.chebvander(2 * x - 1, n - 1))
    up, down = np.zeros((n, n)), np.zeros((n, n))
    for k in range(n):
        whole = Chebyshev.basis(k, domain=[0, 1]).integ(lbnd=0)
        up[:, k] = whole(x)
        down[:, k] = whole(1) - whole(x)
    return x, up @ to_series, down @ to_series


def flapwise(gamma: float, hub: float = 0.0, *, chordwise: bool = False, n: int = 48) -> np.ndarray:
    """Frequencies: w'''' − γ² (T w')' [− γ² w in the plane of rotation] = ω² w, T = (1 − ξ²)/2 + δ (1 − ξ)."""
    x, up, down = _integrals(n)
    d2 = down @ down
    d1 = up @ d2
    d0 = up @ d1
    tension, slope = (1 - x**2) / 2 + hub * (1 - x), -x - hub
    a = np.eye(n) - gamma**2 * (tension[:, None] * d2 + slope[:, None] * d1)
    if chordwise:
        a -= gamma**2 * d0
    squares = eig(a, d0, right=False)
    squares = squares[np.isfinite(squares) & (np.abs(squares.imag) < 1e-6 * np.abs(squares))].real
    found: np.ndarray = np.sqrt(np.sort(squares[squares > 0]))
    return found


def free_flapwise(gamma: float, n: int = 14) -> np.ndarray:
    """Bending frequencies of a beam free at both ends that turns about its middle: Ritz's method by Legendre polynomials of x.

    ∫ w''² + γ² T w'² dx against ∫ w² dx, −½ < x < ½, T = (¼ − x²)/2: of these the constant has 0, x has γ.
    """
    z, w = np.polynomial.legendre.leggauss(2 * n)
    p = [Legendre.basis(k, domain=[-0.5, 0.5]) for k in range(n)]
    f, f1, f2 = (np.array([q.deriv(k)(z / 2) if k else q(z / 2) for q in p]) for k in range(3))
    tension = (0.25 - z**2 / 4) / 2
    stiff = (f2 * w) @ f2.T + gamma**2 * (f1 * w * tension) @ f1.T
    squares = eigh(stiff, (f * w) @ f.T, eigvals_only=True)
    found: np.ndarray = np.sqrt(squares[2:])
    return found


def in_plane(gamma: float, hub: float, slenderness: float, n: int = 40) -> np.ndarray:
    """Frequencies with stretch: s̈ − 2γ v̇ − γ² s = α² s'', v̈ + 2γ ṡ − γ² v + v'''' − γ² (T v')' = 0."""
    x, up, down = _integrals(n)
    d2 = down @ down
    d1 = up @ d2
    d0 = up @ d1
    s0 = -up @ down  # of s'' with s(0) = s'(1) = 0
    tension, slope = (1 - x**2) / 2 + hub * (1 - x), -x - hub
    bend = np.eye(n) - gamma**2 * (tension[:, None] * d2 + slope[:, None] * d1) - gamma**2 * d0
    stretch = -(slenderness**2) * np.eye(n) - gamma**2 * s0
    zero = np.zeros((n, n))
    mass, stiff = np.block([[s0, zero], [zero, d0]]), np.block([[stretch, zero], [zero, bend]])
    turn = 2 * gamma * np.block([[zero, -d0], [s0, zero]])
    one = np.eye(2 * n)
    left = np.block([[np.zeros_like(mass), one], [-stiff, -turn]])
    right = np.block([[one, np.zeros_like(mass)], [np.zeros_like(mass), mass]])
    values = eig(left, right, right=False)
    values = values[np.isfinite(values) & (np.abs(values.real) < 1e-6 * np.abs(values))].imag
    return np.sort(values[values > 0])


def spin_up(
    angle_rates: Callable[[float], tuple[float, float]],
    times: np.ndarray,
    *,
    length: float,
    EA: float,
    EI: float,
    rhoA: float,
    bending: int = 5,
    stretch: int = 2,
    step: float = 5e-3,
) -> np.ndarray:
    """Deflection of the tip (m) at times: the equations of Yoo, Ryan and Scott (1995), by x² and x times Legendre polynomials."""
    z, w = np.polynomial.legendre.leggauss(40)
    x, w = length * (z + 1) / 2, w * length / 2
    ramp = np.polynomial.Polynomial([0, 1])
    legendre = [
        Legendre.basis(k, domain=[0, length]).convert(kind=np.polynomial.Polynomial)
        for k in range(max(bending, stretch))
    ]
    phi, psi = [ramp**2 * p for p in legendre[:bending]], [ramp * p for p in legendre[:stretch]]

    def values(functions: list, order: int) -> np.ndarray:
        return np.array([(f.deriv(order) if order else f)(x) for f in functions])

    f, g = values(phi, 0), values(psi, 0)
    f1, f2, g1 = values(phi, 1), values(phi, 2), values(psi, 1)
    mass = rhoA * np.block(
        [[(g * w) @ g.T, np.zeros((stretch, bending))], [np.zeros((bending, stretch)), (f * w) @ f.T]]
    )
    cross = rhoA * (g * w) @ f.T
    turn = np.block([[np.zeros((stretch, stretch)), -cross], [cross.T, np.zeros((bending, bending))]])
    tension = rhoA * (f1 * w * (length**2 - x**2) / 2) @ f1.T
    stiff = np.zeros_like(mass)
    stiff[:stretch, :stretch] = EA * (g1 * w) @ g1.T
    stiff[stretch:, stretch:] = EI * (f2 * w) @ f2.T
    spun = -mass
    spun[stretch:, stretch:] += tension
    out, across = np.zeros(stretch + bending), np.zeros(stretch + bending)
    out[:stretch], across[stretch:] = rhoA * (g * w) @ x, rhoA * (f * w) @ x
    inverse = np.linalg.inv(mass)
    n = stretch + bending
    unit, zero = np.eye(n), np.zeros((n, n))

    def linear(t: float) -> tuple[np.ndarray, np.ndarray]:
        """A and b of ẏ = A y + b."""
        omega, alpha = angle_rates(t)
        springs = inverse @ (stiff + omega**2 * spun + alpha * turn)
        a = np.block([[zero, unit], [-springs, -2 * omega * (inverse @ turn)]])
        return a, np.concatenate([np.zeros(n), inverse @ (omega**2 * out - alpha * across)])

    y = _gauss(linear, np.zeros(2 * n), times, step)
    tip: np.ndarray = np.array([p(length) for p in phi]) @ y[stretch:n]
    return tip


def exact_spin_up(
    angle_rates: Callable[[float], tuple[float, float]],
    times: np.ndarray,
    *,
    length: float,
    EI: float,
    rhoA: float,
    count: int = 5,
    points: int = 20,
) -> np.ndarray:
    """Deflection of the tip (m) at times of a beam that keeps its length: curvature φ', r' = (cos φ, sin φ), nothing left out.

    φ, the angle of the tangent from the hub's axis, is `count` times x times Legendre polynomials; integrals along the beam are those
    of the polynomials through `points` of Gauss.
    """
    z, w = np.polynomial.legendre.leggauss(points)
    x, w = length * (z + 1) / 2, w * length / 2
    integrals = [Legendre.basis(k, domain=[0, length]).integ(lbnd=0)(np.append(x, length)) for k in range(points)]
    along = np.array(integrals).T @ np.linalg.inv(np.polynomial.legendre.legvander(z, points - 1))
    up, whole = along[:-1], along[-1]
    ramp = np.polynomial.Polynomial([0, 1 / length])
    basis = [ramp * Legendre.basis(k, domain=[0, length]).convert(kind=np.polynomial.Polynomial) for k in range(count)]
    f, f1 = np.array([p(x) for p in basis]).T, np.array([p.deriv()(x) for p in basis]).T
    stiff = EI * (f1.T * w) @ f1

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        a, v = y[:count], y[count:]
        omega, alpha = angle_rates(t)
        c, s, spin = np.cos(f @ a), np.sin(f @ a), omega + f @ v
        partial = [up @ (-s[:, None] * f), up @ (c[:, None] * f)]
        rest = [up @ (-s * alpha - c * spin**2), up @ (c * alpha - s * spin**2)]
        mass = rhoA * sum((p.T * w) @ p for p in partial)
        forces = -stiff @ a - rhoA * sum((p.T * w) @ r for p, r in zip(partial, rest, strict=True))
        return np.concatenate([v, np.linalg.solve(mass, forces)])

    span = (times[0], times[-1])
    sol = solve_ivp(rates, span, np.zeros(2 * count), method="DOP853", t_eval=times, rtol=1e-8, atol=1e-10)
    tip: np.ndarray = whole @ np.sin(f @ sol.y[:count])
    return tip


def elastica(load: float) -> float:
    """Deflection of the tip over the length, F L²/EI = `load` at the tip staying normal to the straight beam: φ'' = −load cos φ."""
    x = np.linspace(0, 1, 40)

    def rates(_: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.array([y[1], -load * np.cos(y[0]), np.sin(y[0])])

    def ends(root: np.ndarray, tip: np.ndarray) -> np.ndarray:
        return np.array([root[0], tip[1], root[2]])

    return float(solve_bvp(rates, ends, x, np.zeros((3, len(x))), tol=1e-8).y[2, -1])


def _gauss(linear: Callable, y: np.ndarray, times: np.ndarray, step: float) -> np.ndarray:
    """ẏ = A(t) y + b(t) by Gauss's method of two stages, equal steps between the times."""
    found, at, root = [y], times[0], np.sqrt(3) / 6
    for t in times[1:]:
        count = max(1, round((t - at) / step))
        h = (t - at) / count
        for k in range(count):
            (a, f), (b, g) = (linear(at + h * (k + c)) for c in (0.5 - root, 0.5 + root))
            one = np.eye(len(y))
            left = np.block([[one - h / 4 * a, -h * (0.25 - root) * a], [-h * (0.25 + root) * b, one - h / 4 * b]])
            slopes = np.linalg.solve(left, np.concatenate([a @ y + f, b @ y + g]))
            y = y + h / 2 * (slopes[: len(y)] + slopes[len(y) :])
        at = t
        found.append(y)
    return np.array(found).T
