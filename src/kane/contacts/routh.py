# SPDX-License-Identifier: BSD-3-Clause
"""Impact of one contact by Routh's method: the normal impulse p replaces time, dv/dp = W (1, −μ d) while the contact slips along d.

Slip ends at v_t = 0; then the contact sticks if |W_tt⁻¹ W_tn| ≤ μ, else it slips in the one direction in which |v_t| grows. In the
plane v is piecewise linear in p; in space the direction φ of slip turns, and with dp = |v_t| ds the equations are regular:

    dφ/ds = d⊥·r,  d ln|v_t|/ds = d·r,  r = W_tn − μ W_tt d,  dv_n/ds = |v_t| (W_nn − μ W_nt·d).

Compression ends at v_n = 0. Restitution ends by one of three laws: Newton's, v_n⁺ = −e v_n⁻; Poisson's, p⁺ = (1 + e) p_c; Stronge's,
∫ v_n dp = −e² times that of compression, with which energy never increases (Stronge 1990, Proc. R. Soc. Lond. A 431, 169).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np

from kane.contacts.angles import unit
from kane.contacts.problem import numbers
from kane.errors import ArgumentError, ContactError, warn
from kane.expect import number, that
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL, LAST_DIGIT, ROUNDED, ROUNDED_CHAIN, ROUNDED_SUM

_STEPS, _LOCATED = 2000, 60
_ORDERS = (2, 4, 6, 8, 10, 12)
_ROOT = 60


class Law(Enum):
    """The law of restitution: the meaning of e."""

    NEWTON = "velocity"
    POISSON = "impulse"
    STRONGE = "energy"


class ImpactPhase(Enum):
    """A phase of an impact, by its tangential motion."""

    SLIP = "slip"
    STICK = "stick"
    SLIP_AGAIN = "slip again"


@dataclass(frozen=True, slots=True, eq=False)
class ContactImpact:
    """The result of an impact of one contact.

    Attributes
    ----------
    velocity : v⁺ (d), normal first
    impulse : p (d)
    energy : change of the kinetic energy
    phases : the phases, in order
    law : the law of restitution
    """

    velocity: Array
    impulse: Array
    energy: float
    phases: tuple[ImpactPhase, ...]
    law: Law


@dataclass(frozen=True, slots=True, eq=False)
class _Course:
    """The state: v_n, v_t, p, ∫ v_n dp since the beginning of compression or restitution; p and ∫ v_n dp at the end of compression."""

    normal: float
    tangential: Array
    impulse: float = 0.0
    work: float = 0.0
    compressed: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class _End:
    """The conditions that end compression and restitution, by the law, e and v_n⁻."""

    law: Law
    restitution: float
    before: float

    def missing(self, at: _Course) -> float:
        """A function that is zero at the end of the present part, compression or restitution, and negative before."""
        if at.compressed is None:
            return at.normal
        impulse, work = at.compressed
        if self.law is Law.NEWTON:
            return at.normal + self.restitution * self.before
        if self.law is Law.POISSON:
            return at.impulse - (1 + self.restitution) * impulse
        return at.work + self.restitution**2 * work

    def part(self, at: _Course) -> int:
        """The index in (φ, ln|v_t|, v_n, p, ∫ v_n dp) of the variable in `missing`."""
        return 2 if at.compressed is None else {Law.NEWTON: 2, Law.POISSON: 3, Law.STRONGE: 4}[self.law]

    def left(self, at: _Course, slope: float) -> float:
        """The impulse until the present part ends, for a constant slope dv_n/dp; infinite if it does not end."""
        need = -self.missing(at)
        if at.compressed is None or self.law is Law.NEWTON:
            return max(need / slope, 0.0) if slope > 0 else math.inf
        if self.law is Law.POISSON or need <= 0:
            return max(need, 0.0)
        # the root of v_n s + slope s²/2 = need, without cancellation; in space v_n may decrease again, and there may be no root
        square = at.normal * at.normal + 2 * slope * need
        root = at.normal + math.sqrt(square) if square >= 0 else 0.0
        return 2 * need / root if root > 0 else math.inf


def impact(mobility: Any, velocity: Any, friction: float, restitution: float, law: Law = Law.STRONGE) -> ContactImpact:
    """The impact of a contact that approaches, or one at v_n = 0 that friction jams.

    Parameters
    ----------
    mobility : W = J M⁻¹ Jᵀ (d × d) of the contact, normal first, d = 2 in the plane and 3 in space
    velocity : v⁻ = J u (d), v_n⁻ ≤ 0
    friction : μ
    restitution : e, from 0 to 1
    law : the law of restitution

    Raises
    ------
    ArgumentError
        if μ < 0, e is not from 0 to 1, v_n⁻ > 0, or W_nn is not positive
    ContactError
        if the contact sticks, W allows no normal velocity, and v_n⁻ < 0

    Warns
    -----
    KaneWarning
        if energy is gained, as by Newton's law with friction
    """
    v = numbers(velocity, "a velocity of the contact with two or three entries", 1)
    that(len(v) in (2, 3), "a velocity of the contact with two or three entries", v, error=ArgumentError)
    w = numbers(mobility, f"a mobility W of {len(v)} × {len(v)} numbers", 2, (len(v), len(v)))
    check_laws(friction, restitution, law)
    that(w[0, 0] > 0, "a normal along which an impulse moves something, W_nn > 0", float(w[0, 0]), error=ArgumentError)
    that(v[0] <= 0, "a contact that approaches, v_n ≤ 0", float(v[0]), "It needs no impact.", error=ArgumentError)
    result = routh(w, v, friction, restitution, law)
    warn_of_gain(result.energy, float(np.abs(result.impulse) @ (np.abs(v) + np.abs(result.velocity))), law)
    return result


def check_laws(friction: float, restitution: float, law: Law) -> None:
    """Raises an ArgumentError unless μ ≥ 0, 0 ≤ e ≤ 1 and `law` is a `Law`."""
    that(
        number(friction, "a coefficient of friction μ", error=ArgumentError) >= 0,
        "μ ≥ 0",
        friction,
        error=ArgumentError,
    )
    e = number(restitution, "a coefficient of restitution", error=ArgumentError)
    that(0 <= e <= 1, "a coefficient of restitution from 0 to 1", restitution, error=ArgumentError)
    that(isinstance(law, Law), "a law of restitution: Law.NEWTON, POISSON or STRONGE", law, error=ArgumentError)


def warn_of_gain(energy: float, terms: float, law: Law) -> None:
    """Warns if kinetic energy increases by more than the rounding error of its `terms`."""
    if energy > ROUNDED_CHAIN * terms:
        warn(
            f"An impact increases the kinetic energy by {energy:.4g}, which {law.name.title()}'s law permits with friction. "
            "Use Law.STRONGE, which never increases it."
        )


def routh(w: Array, v: Array, mu: float, e: float, law: Law) -> ContactImpact:
    """Routh's method, without checks of the arguments."""
    slip = v[1:] if np.linalg.norm(v[1:]) > 0 else np.zeros_like(v[1:])  # no slip if its square underflows
    end, at, phases, done = _End(law, e, float(v[0])), _Course(float(v[0]), slip.copy()), list[ImpactPhase](), False
    if at.tangential.any():
        phases.append(ImpactPhase.SLIP)
        if len(v) == 3:
            at, done = _turning(w, mu, end, at)
        if not done and at.tangential.any():
            at, done = _slipping(w, mu, end, at)
    if not done:
        sticks, slope, rate = _from_rest(w, mu)
        phases.append(ImpactPhase.STICK if sticks else ImpactPhase.SLIP_AGAIN)
        at = _wedged(at, v) if slope <= ROUNDED_SUM * w[0, 0] else _straight(end, at, slope, rate, math.inf)[0]
    after = np.concatenate([[at.normal], at.tangential])
    friction = np.linalg.lstsq(w[1:, 1:], after[1:] - v[1:] - w[1:, 0] * at.impulse, rcond=ROUNDED)[0]
    impulse = np.concatenate([[at.impulse], friction])
    return ContactImpact(after, impulse, float(impulse @ (v + after)) / 2, tuple(phases), law)


def _wedged(at: _Course, v: Array) -> _Course:
    """The state at rest of a sticking contact whose v_n no impulse changes; ContactError if v_n is not zero up to rounding."""
    that(
        abs(at.normal) <= EQUAL * np.abs(v).max(),
        "v_n = 0 after the slip stops, as W allows no normal velocity without slip",
        came=f"v_n = {at.normal:.3g}",
        cure="Take v = J u and W = J M⁻¹ Jᵀ of the same J.",
        error=ContactError,
    )
    return replace(at, normal=0.0)


def _slipping(w: Array, mu: float, end: _End, at: _Course) -> tuple[_Course, bool]:
    """The state after slip in a constant direction, at the end of the impact or at v_t = 0 exactly; whether the impact has ended."""
    d = at.tangential / np.linalg.norm(at.tangential)
    rate = w[1:, 0] - mu * w[1:, 1:] @ d
    along = float(rate @ d)
    length = float(np.linalg.norm(at.tangential)) / -along if along < 0 else math.inf
    at, done = _straight(end, at, float(w[0, 0] - mu * w[0, 1:] @ d), along * d, length)
    return at if done else replace(at, tangential=np.zeros_like(d)), done


def _straight(end: _End, at: _Course, slope: float, rate: Array, length: float) -> tuple[_Course, bool]:
    """The state after a piece of at most the impulse `length`, with constant dv_n/dp and dv_t/dp; whether the impact has ended."""
    for _ in range(2):
        step = min(end.left(at, slope), length)
        ends = step < length
        at = replace(
            at,
            normal=at.normal + slope * step,
            tangential=at.tangential + rate * step,
            impulse=at.impulse + step,
            work=at.work + step * (at.normal + slope * step / 2),
        )
        if not ends or at.compressed is not None:
            return at, ends
        at, length = _compressed(at), length - step
    return at, False


def _compressed(at: _Course) -> _Course:
    """The state at the end of compression."""
    return replace(at, normal=0.0, work=0.0, compressed=(at.impulse, at.work))


def _from_rest(w: Array, mu: float) -> tuple[bool, float, Array]:
    """Whether a contact with v_t = 0 sticks, then dv_n/dp and dv_t/dp.

    If it slips, W_tn − μ W_tt d = κ d with κ > 0; |(κ + μ W_tt)⁻¹ W_tn| = 1 has one root, found by Newton's method on the reciprocal.
    """
    coupling = w[1:, 0]
    q = np.linalg.lstsq(w[1:, 1:], coupling, rcond=ROUNDED)[0]
    if np.linalg.norm(q) <= mu:
        return True, float(w[0, 0] - coupling @ q), np.zeros_like(q)
    values, vectors = np.linalg.eigh(w[1:, 1:])
    c, kappa = vectors.T @ coupling, 0.0
    if mu == 0:
        kappa = float(np.linalg.norm(coupling))
    for _ in range(_ROOT if mu > 0 else 0):
        z = c / (kappa + mu * values)
        length = float(np.linalg.norm(z))
        step = (length - 1) * length * length / float((z * z / (kappa + mu * values)).sum())
        kappa += step
        if abs(step) <= LAST_DIGIT * kappa:
            break
    d = vectors @ (c / (kappa + mu * values))
    d /= np.linalg.norm(d)
    return False, float(w[0, 0] - mu * coupling @ d), kappa * d


def _turning(w: Array, mu: float, end: _End, at: _Course) -> tuple[_Course, bool]:
    """The state after slip in space with turning direction, up to its end or constant direction; whether the impact has ended.

    The variables of integration are y = (φ, ln(|v_t|/|v_t⁻|), v_n, p, ∫ v_n dp).
    """
    first = float(np.linalg.norm(at.tangential))
    rates = _rates(w, mu, first)

    def course(y: Array) -> _Course:
        return replace(
            at,
            normal=float(y[2]),
            tangential=first * math.exp(y[1]) * unit(y[0]),
            impulse=float(y[3]),
            work=float(y[4]),
        )

    speed = max(first, abs(at.normal))
    sizes = np.array([1.0, 1.0, speed, speed / w[0, 0], speed * speed / w[0, 0]])
    y = np.array([math.atan2(at.tangential[1], at.tangential[0]), 0.0, at.normal, 0.0, 0.0])
    step = 0.5 / float(np.linalg.norm(w, 2) * (1 + mu))
    for _ in range(_STEPS):
        turn, grows = rates(y)[:2]
        if y[1] < math.log(LAST_DIGIT) or abs(turn) <= LAST_DIGIT * abs(grows):
            break
        new, error = _extrapolated(rates, y, step)
        wrong = float((error / np.maximum(sizes, np.abs(new))).max())
        if not wrong <= ROUNDED_CHAIN:
            step *= max(0.2, 0.8 * (ROUNDED_CHAIN / wrong) ** (1 / 11)) if math.isfinite(wrong) else 0.2
        elif end.missing(course(new)) < 0:
            y = new
            step *= min(3.0, 0.8 * (ROUNDED_CHAIN / max(wrong, ROUNDED_CHAIN**2)) ** (1 / 11))
        else:
            y = _located(rates, y, step, lambda z: end.missing(course(z)), end.part(at))
            if at.compressed is not None:
                return course(y), True
            at = _compressed(course(y))
            y = np.array([y[0], y[1], at.normal, at.impulse, at.work])
            if end.missing(at) >= 0:
                return at, True
    return course(y), False


def _rates(w: Array, mu: float, first: float) -> Callable[[Array], Array]:
    """The function dy/ds(y) of slip in space; `first` is |v_t⁻|."""
    (nn, na, nb), (_, aa, ab), (_, _, bb) = w.tolist()

    def rates(y: Array) -> Array:
        c, s, speed = math.cos(y[0]), math.sin(y[0]), first * math.exp(y[1])
        a, b = na - mu * (aa * c + ab * s), nb - mu * (ab * c + bb * s)
        return np.array([c * b - s * a, c * a + s * b, speed * (nn - mu * (na * c + nb * s)), speed, speed * y[2]])

    return rates


def _extrapolated(rates: Callable[[Array], Array], y: Array, step: float) -> tuple[Array, Array]:
    """One step of order 12 by extrapolation of the midpoint rule (Gragg 1965), and its error estimate."""
    rows = []
    for n in _ORDERS:
        h = step / n
        a, b = y, y + h * rates(y)
        for _ in range(n - 1):
            a, b = b, a + 2 * h * rates(b)
        rows.append((a + b + h * rates(b)) / 2)
    for j in range(1, len(rows)):
        for i in range(len(rows) - 1, j - 1, -1):
            rows[i] = rows[i] + (rows[i] - rows[i - 1]) / ((_ORDERS[i] / _ORDERS[i - j]) ** 2 - 1)
    return rows[-1], np.abs(rows[-1] - rows[-2])


def _located(
    rates: Callable[[Array], Array], y: Array, step: float, missing: Callable[[Array], float], part: int
) -> Array:
    """y at the zero of `missing` within a step: Newton's method in the step length, with bisection if it leaves the bracket."""
    low, high, at = 0.0, step, step
    for _ in range(_LOCATED):
        new = _extrapolated(rates, y, at)[0]
        left, slope = missing(new), float(rates(new)[part])
        low, high = (at, high) if left < 0 else (low, at)
        change = -left / slope if slope else math.inf
        if abs(change) <= EQUAL * step:
            return _extrapolated(rates, y, at + change)[0]
        at = at + change if low < at + change < high else (low + high) / 2
    return _extrapolated(rates, y, at)[0]
