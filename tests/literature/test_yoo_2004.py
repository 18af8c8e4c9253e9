# SPDX-License-Identifier: BSD-3-Clause
"""Every equation (11) to (32) of Yoo's tutorial, against the one derived, at 50 random points.

Agreement means 1e-12 of the magnitude compared: a vector's length, or the sum of the magnitudes of the
terms of a sum. Where the printed equation cannot hold, the test shows two things: the corrected one
agrees, and the printed one is off by more than 1e-3 somewhere. Symbols have random values that are
independent of each other (q', u' and N too), so that a wrong leaf cannot hide.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import rolling_disk
from tests.literature import yoo_2004 as yoo
from tests.literature.yoo_2004 import Array, Samples

pytestmark = pytest.mark.filterwarnings("error")

TOLERANCE = 1e-12
WRONG = 1e-3


@dataclass(frozen=True)
class Disk:
    """The derived disk, the random states, and every leaf's value at them."""

    model: Any
    eom: Any
    s: Samples
    values: Mapping[Any, Array]

    @property
    def auxiliary(self) -> Any:
        """The auxiliary speed, the article's u6."""
        return self.eom.auxiliary_speeds[0]

    def at(self, exprs: Iterable[Any], s: Samples | None = None) -> Array:
        """Values (n, k) of k expressions, at the states or at `s`."""
        values = self.values if s is None else leaves(self.model, self.eom, s)
        return evaluate(exprs, values, len(self.s.m))

    def on_b(self, vector: Any, s: Samples | None = None) -> Array:
        """Components (n, 3) on b1, b2, b3 = B.x, B.y, B.z."""
        return self.at(vector.components(self.model.B), s)

    def on_a(self, vector: Any, s: Samples | None = None) -> Array:
        """Components (n, 3) on a_x, a_y, a_z = N.x, N.y, N.z."""
        return self.at(vector.components(self.model.N), s)

    def partials(self, by_speed: Mapping[Any, Any]) -> Array:
        """Partial velocities (n, 5, 3) on b for u1 to u5."""
        return np.stack([self.on_b(by_speed[u]) for u in self.model.u], axis=1)


def evaluate(exprs: Iterable[Any], values: Mapping[Any, Array], n: int) -> Array:
    """Values (n, k) of k expressions by the reference evaluator."""
    columns = kn.evaluate(list(exprs), values)
    return np.stack([np.broadcast_to(np.asarray(c, dtype=float), (n,)) for c in columns], axis=1)


def leaves(model: Any, eom: Any, s: Samples) -> dict[Any, Array]:
    """Value of every leaf: coordinates, rates, speeds and their derivatives, constants, N; u6 = 0."""
    values = {model.m: s.m, model.R: s.R, model.g: s.g, model.mu: s.mu, model.normal: s.normal}
    for i in range(5):
        values[model.q[i]], values[model.q[i].dt] = s.q[:, i], s.qd[:, i]
        values[model.u[i]], values[model.u[i].dt] = s.u[:, i], s.ud[:, i]
    values[eom.auxiliary_speeds[0]] = np.zeros_like(s.m)
    return values


@pytest.fixture(scope="module")
def disk() -> Disk:
    """The gallery's disk, derived once."""
    model, s = rolling_disk.model(), yoo.samples()
    eom = kn.derive(model.system)
    return Disk(model, eom, s, leaves(model, eom, s))


@pytest.fixture(scope="module")
def solved(disk: Disk) -> tuple[Samples, Array]:
    """The states with the derived u' and N, and a tolerance of 100 eps cond for each, 1e-12 at least."""
    found = disk.at([*disk.eom.accelerations, disk.eom.reaction_values[0]])
    _, condition = yoo.solve(disk.s)
    tolerance = np.maximum(TOLERANCE, 100 * np.finfo(float).eps * condition)
    return replace(disk.s, ud=found[:, :5], normal=found[:, 5]), tolerance


def same(got: Array, expected: Array, scale: Array | None = None) -> None:
    """Equal to 1e-12 of `scale`, by default of the length of `expected` along its last axis."""
    assert got.shape == expected.shape
    if scale is None:
        scale = np.linalg.norm(expected, axis=-1, keepdims=True)
    assert np.all(np.isfinite(got))
    assert np.all(np.abs(got - expected) <= TOLERANCE * scale)


def differs(got: Array, printed: Array) -> None:
    """Somewhere off by more than 1e-3 of the length of `got`."""
    assert got.shape == printed.shape
    scale = np.linalg.norm(got, axis=-1, keepdims=True)
    assert np.max(np.abs(got - printed) - WRONG * scale) > 0.0


def total(terms: Array) -> tuple[Array, Array]:
    """Sum of the terms over the last axis, and the sum of their magnitudes."""
    return terms.sum(axis=-1), np.abs(terms).sum(axis=-1)


def plain(vector: Any) -> list[list[str]]:
    """The printed sum as a list of terms, each a sorted list of factors; B.x, B.y, B.z as b1, b2, b3."""
    text = str(vector)
    for i, axis in enumerate("xyz", start=1):
        text = text.replace(f"B.{axis}", f"b{i}")
    text = re.sub(r"tan\(\s*q2\s*\)|tan q2", "tan_q2", text)
    text = text.replace("*", " ").replace("·", " ")
    return [sorted(term.split()) for term in text.split(" + ")]


# ---------------------------------------------------------------- section 2


def test_eq_07() -> None:
    """(7), with r for F: the dot cancels, d(r')/d(q') = d(r)/d(q), on the measure numbers of a particle.

    The particle is at a distance that moves, on an arm that turns, in a frame that turns with time.
    """
    q1, q2 = kn.coordinates("q1:3")
    a = kn.parameter("a", 0.7, "m")
    N = kn.Frame("N")
    A = N.rotate("A", q1 * kn.sin(kn.time) + kn.time**2, N.z)
    D = A.rotate("D", kn.exp(q2) * q1, A.x)
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", (a + q2**2) * D.y + q1 * A.x)
    r = P.position(O).components(N)
    v = P.velocity(N).components(N)

    rng = np.random.default_rng(7)
    symbols = (q1, q2, q1.dt, q2.dt, a, kn.time)
    values = {symbol: rng.uniform(0.3, 1.5, 50) for symbol in symbols}
    for q in (q1, q2):
        got = evaluate([kn.diff(x, q.dt) for x in v], values, 50)
        same(got, evaluate([kn.diff(x, q) for x in r], values, 50))


def test_eq_08(disk: Disk) -> None:
    """(8), with r for F: d(r')/d(q'_i) = sum over j of d(r')/d(u_j) d(u_j)/d(q'_i), for C* of the disk."""
    eom, model = disk.eom, disk.model
    v = model.Cs.velocity(model.N).components(model.N)
    by_rate = np.stack([disk.at([kn.diff(x, q.dt) for x in v]) for q in model.q], axis=1)
    by_speed = np.stack([disk.on_a(eom.partial_velocities[model.Cs][u]) for u in model.u], axis=1)
    scale = np.linalg.norm(by_speed, axis=(1, 2))[:, None, None] * np.ones_like(by_rate)
    same(by_rate, np.einsum("nji,njk->nik", matrix_Y(disk), by_speed), scale)


def test_eq_10(disk: Disk) -> None:
    """(10): det Y is not zero; it is -cos q2 in magnitude, where the printed (14) would give csc q2."""
    q2 = disk.s.q[:, 1]
    determinant = np.abs(np.linalg.det(matrix_Y(disk)))[:, None]
    same(determinant, np.cos(q2)[:, None])
    differs(determinant, np.abs(1.0 / np.sin(q2))[:, None])


def matrix_Y(disk: Disk) -> Array:
    """Y (n, 5, 5) of u = Y q' + z, rows u1 to u5, columns q1 to q5."""
    eom, model = disk.eom, disk.model
    rows = [{s: i for i, s in enumerate(eom.speeds)}[u] for u in model.u]
    columns = [{s: i for i, s in enumerate(eom.coordinates)}[q] for q in model.q]
    return disk.at([eom.Y[i, j] for i in rows for j in columns]).reshape(-1, 5, 5)


# ---------------------------------------------------------------- section 4: kinematics in rates


def test_eq_11(disk: Disk) -> None:
    """(11): angular velocity of C in rates; csc q2, sec q2 in print must be cos q2, sin q2."""
    w = disk.on_b(disk.model.C.angular_velocity(disk.model.N))
    same(w, yoo.eq_11_first_line(disk.s))
    same(w, yoo.eq_11(disk.s))
    differs(w, yoo.eq_11_printed(disk.s))


def test_eq_12(disk: Disk) -> None:
    """(12): velocity of the trace P in rates, on a."""
    same(disk.on_a(disk.model.P.velocity(disk.model.N)), yoo.eq_12_a(disk.s))


def test_eq_13(disk: Disk) -> None:
    """(13): angular velocity of B in rates; csc q2, sec q2 in print must be cos q2, sin q2."""
    w = disk.on_b(disk.model.B.angular_velocity(disk.model.N))
    same(w, yoo.eq_13(disk.s))
    differs(w, yoo.eq_13_printed(disk.s))


def test_eq_14(disk: Disk) -> None:
    """(14): the speeds Y q' + z; csc q2, sec q2 in print must be cos q2, sin q2."""
    Y_qd = np.einsum("nij,nj->ni", matrix_Y(disk), disk.s.qd)
    z = disk.at(disk.eom.z)
    same(z, np.zeros_like(z), np.ones_like(z))
    same(Y_qd, yoo.eq_14(disk.s))
    differs(Y_qd, yoo.eq_14_printed(disk.s))


def test_eq_14_inverse(disk: Disk) -> None:
    """(14) solved for the rates: q1' = u2/cos q2, where the print would give u2 sin q2."""
    eom = disk.eom
    rates = dict(zip(eom.coordinates, eom.rates, strict=True))
    yaw_rate = disk.at([rates[disk.model.q[0]]])
    u2, q2 = disk.s.u[:, 1:2], disk.s.q[:, 1:2]
    same(yaw_rate, u2 / np.cos(q2))
    differs(yaw_rate, u2 * np.sin(q2))
    same(disk.at([rates[q] for q in disk.model.q]), yoo.eq_14_inverse(disk.s))


def test_misprint_is_hidden_by_speeds(disk: Disk) -> None:
    """The misprints of (13) and (14) cancel in (16): sec q2/csc q2 = tan q2.

    So no equation in speeds reveals them, the accelerations at given q and u neither; only q1' does.
    """
    s = disk.s
    printed = replace(s, qd=yoo.eq_14_printed_inverse(s))
    w = disk.on_b(disk.eom.angular_velocities[disk.model.B])
    same(w, yoo.eq_13_printed(printed))
    differs(s.u[:, 1:2] / np.cos(s.q[:, 1:2]), printed.qd[:, 0:1])


# ---------------------------------------------------------------- section 4: kinematics in speeds


def test_eq_15(disk: Disk) -> None:
    """(15): angular velocity of C in speeds."""
    same(disk.on_b(disk.eom.angular_velocities[disk.model.C]), yoo.eq_15(disk.s))


def test_eq_15_prints(disk: Disk) -> None:
    """(15) is also what is printed: u1 b1 + u2 b2 + u3 b3, without an angle."""
    printed = plain(disk.eom.angular_velocities[disk.model.C])
    assert printed == [["b1", "u1"], ["b2", "u2"], ["b3", "u3"]]


def test_eq_15_is_finite_at_right_angle(disk: Disk) -> None:
    """(15) has no cos q2 to divide by: at q2 = pi/2 it is what it is elsewhere."""
    q = disk.s.q.copy()
    q[:, 1] = np.pi / 2
    lying = replace(disk.s, q=q)
    same(disk.on_b(disk.eom.angular_velocities[disk.model.C], lying), yoo.eq_15(lying))


def test_eq_16(disk: Disk) -> None:
    """(16): angular velocity of B in speeds."""
    same(disk.on_b(disk.eom.angular_velocities[disk.model.B]), yoo.eq_16(disk.s))


def test_eq_16_prints(disk: Disk) -> None:
    """(16) is also what is printed: u1 b1 + u2 b2 + u2 tan q2 b3."""
    printed = plain(disk.eom.angular_velocities[disk.model.B])
    assert printed == [["b1", "u1"], ["b2", "u2"], ["b3", "tan_q2", "u2"]]


def test_eq_17(disk: Disk) -> None:
    """(17): velocity of C* as v^P + omega^B x r^PC*, and r^PC* = R b2."""
    same(disk.on_b(disk.model.Cs.position(disk.model.P)), yoo.r_P_Cs(disk.s))
    same(disk.on_b(disk.eom.velocities[disk.model.Cs]), yoo.eq_17(disk.s))


def test_eq_18(disk: Disk) -> None:
    """(18): velocity of C* written out, and its partial velocities."""
    same(disk.on_b(disk.eom.velocities[disk.model.Cs]), yoo.eq_18(disk.s))
    got = disk.partials(disk.eom.partial_velocities[disk.model.Cs])
    scale = np.linalg.norm(got, axis=(1, 2))[:, None, None]
    same(got, yoo.partial(yoo.eq_18, disk.s), scale)


def test_eq_19(disk: Disk) -> None:
    """(19): velocity of C^ as v^C* + omega^C x r^C*C^."""
    same(disk.on_b(disk.eom.velocities[disk.model.Ch]), yoo.eq_19(disk.s))


def test_eq_20(disk: Disk) -> None:
    """(20): velocity of C^ written out, horizontal, and its partial velocities."""
    v = disk.eom.velocities[disk.model.Ch]
    same(disk.on_b(v), yoo.eq_20(disk.s))
    vertical = disk.at([v.dot(disk.model.N.z)])
    same(vertical, np.zeros_like(vertical), np.linalg.norm(disk.on_b(v), axis=1, keepdims=True))
    got = disk.partials(disk.eom.partial_velocities[disk.model.Ch])
    scale = np.linalg.norm(got, axis=(1, 2))[:, None, None]
    same(got, yoo.partial(yoo.eq_20, disk.s), scale)


def test_eq_21(disk: Disk) -> None:
    """(21): acceleration of C* at random u'; without its brackets the print loses the central term."""
    a = disk.on_b(disk.eom.point_accelerations[disk.model.Cs])
    same(a, yoo.eq_21(disk.s))
    differs(a, yoo.eq_21_printed(disk.s))


def test_eq_22(disk: Disk) -> None:
    """(22): angular acceleration of C at random u', and its partial angular velocities."""
    same(disk.on_b(disk.eom.angular_accelerations[disk.model.C]), yoo.eq_22(disk.s))
    got = disk.partials(disk.eom.partial_angular_velocities[disk.model.C])
    same(got, yoo.partial(yoo.eq_15, disk.s), np.ones_like(got))


def test_eq_23(disk: Disk) -> None:
    """(23): angular acceleration of B at random u'."""
    same(disk.on_b(disk.eom.angular_accelerations[disk.model.B]), yoo.eq_23(disk.s))


# ---------------------------------------------------------------- section 4: forces


def inertia_force(disk: Disk) -> Array:
    """F* on a, read off the derived F*_4, F*_5, F*_6: their partial velocities are a_x, a_y, a_z."""
    return disk.at(disk.eom.Fr_star)[:, 3:6]


def test_eq_24(disk: Disk) -> None:
    """(24): the inertia force is -m a^C*, not the print's -m a^C (C^, were it a point of C).

    F* is read off the derived F*_4, F*_5, F*_6.
    """
    force = inertia_force(disk)
    same(force, yoo.on_a(disk.s, yoo.eq_24(disk.s)))
    differs(force, yoo.on_a(disk.s, yoo.eq_24_printed(disk.s)))
    m_a = disk.model.m * disk.eom.point_accelerations[disk.model.Cs]
    same(-disk.on_b(m_a), yoo.eq_24(disk.s))


def test_eq_25(disk: Disk) -> None:
    """(25): the inertia torque, from the derived vectors and read off F*_1, F*_2, F*_3.

    The partial angular velocities are b1, b2, b3, so T* . b_r = F*_r - v_r^C* . F*.
    """
    model, eom, s = disk.model, disk.eom, disk.s
    w, alpha = eom.angular_velocities[model.C], eom.angular_accelerations[model.C]
    inertia = model.disk.inertia
    torque = -inertia.dot(alpha) - w.cross(inertia.dot(w))
    same(disk.on_b(torque), yoo.eq_25(s))

    of_force = np.einsum("nri,ni->nr", yoo.partial(yoo.eq_18, s), yoo.eq_24(s))[:, :3]
    got = disk.at(eom.Fr_star)[:, :3] - of_force
    scale = np.linalg.norm(yoo.eq_25(s), axis=1, keepdims=True) + np.abs(of_force)
    same(got, yoo.eq_25(s), scale)


def test_eq_26(disk: Disk) -> None:
    """(26): F_1 to F_5 at a free N; friction acts at C^, whose hat the print has lost."""
    active = disk.at(disk.eom.Fr)[:, :5]
    expected, scale = total(yoo.eq_26(disk.s))
    same(active, expected, scale)
    differs(active, yoo.eq_26_printed(disk.s).sum(axis=-1))


def test_eq_27(disk: Disk) -> None:
    """(27): F*_1 to F*_5 at random u'."""
    expected, scale = total(yoo.eq_27(disk.s))
    same(disk.at(disk.eom.Fr_star)[:, :5], expected, scale)


def test_eq_28(disk: Disk, solved: tuple[Samples, Array]) -> None:
    """(28): F_r + F*_r = 0 at the derived u' and N, both sums the derived ones and the article's.

    The tolerance is 100 eps cond of the equations, 1e-12 at least, of the sum of the terms' magnitudes.
    """
    s, tolerance = solved
    article, scale = total(yoo.eq_28(s))
    bound = tolerance[:, None] * scale
    derived = disk.at(disk.eom.Fr, s)[:, :5] + disk.at(disk.eom.Fr_star, s)[:, :5]
    assert np.all(np.abs(article) <= bound)
    assert np.all(np.abs(derived) <= bound)


def test_eq_28_solved(disk: Disk, solved: tuple[Samples, Array]) -> None:
    """(28) and (32), solved in NumPy for u' and N, give the derived u' and N, by either evaluator."""
    s, tolerance = solved
    model, eom = disk.model, disk.eom
    article, _ = yoo.solve(s)
    bound = tolerance[:, None] * np.linalg.norm(article.ud, axis=1, keepdims=True)
    assert np.all(np.abs(s.ud - article.ud) <= bound)
    assert np.all(np.abs(s.normal - article.normal) <= tolerance * np.abs(article.normal))

    found = eom.evaluate(
        [*(u.dt for u in model.u), model.normal, *(q.dt for q in model.q)],
        q=dict(zip(model.q, s.q.T, strict=True)),
        u=dict(zip(model.u, s.u.T, strict=True)),
        parameters={model.m: s.m, model.R: s.R, model.g: s.g, model.mu: s.mu},
    )
    got = np.stack(np.broadcast_arrays(*found), axis=1)
    assert np.all(np.abs(got[:, :5] - article.ud) <= bound)
    assert np.all(np.abs(got[:, 5] - article.normal) <= tolerance * np.abs(article.normal))
    same(got[:, 6:], yoo.eq_14_inverse(s))


def test_eq_29(disk: Disk) -> None:
    """(29): the friction, read off the derived F_4 and F_5; v^C^, whose hat the print has lost."""
    active = disk.at(disk.eom.Fr)
    friction = np.concatenate([active[:, 3:5], np.zeros((len(active), 1))], axis=1)
    same(friction, yoo.on_a(disk.s, yoo.eq_29(disk.s)))
    differs(friction, yoo.on_a(disk.s, yoo.eq_29_printed(disk.s)))


# ---------------------------------------------------------------- section 5: the normal force


def test_eq_30(disk: Disk) -> None:
    """(30): the auxiliary speed of N adds u6 a_z to the velocity of P."""
    rng = np.random.default_rng(30)
    u6 = rng.uniform(-2.0, 2.0, len(disk.s.m))
    v = disk.on_a(disk.eom.velocities[disk.model.P])
    v6 = disk.on_a(disk.eom.partial_velocities[disk.model.P][disk.auxiliary])
    same(v + u6[:, None] * v6, yoo.eq_30_a(disk.s, u6))


def test_eq_31(disk: Disk) -> None:
    """(31): the partial velocities of C* and C^ for u6 are a_z; the disk's angular one is zero."""
    model, eom = disk.model, disk.eom
    v6_Cs, v6_Ch = yoo.eq_31_a(disk.s)
    same(disk.on_a(eom.partial_velocities[model.Cs][disk.auxiliary]), v6_Cs)
    same(disk.on_a(eom.partial_velocities[model.Ch][disk.auxiliary]), v6_Ch)
    w6 = disk.on_a(eom.partial_angular_velocities[model.C][disk.auxiliary])
    same(w6, np.zeros_like(w6), np.ones_like(w6))


def test_eq_32(disk: Disk, solved: tuple[Samples, Array]) -> None:
    """(32): F_6 = N - mg and F*_6 = -m a^C* . a_z at free u' and N; its N is the reaction derived."""
    terms = yoo.eq_32(disk.s)
    scale = np.abs(terms).sum(axis=1, keepdims=True)
    same(disk.at(disk.eom.Fr)[:, 5:6], terms[:, :2].sum(axis=1, keepdims=True), scale)
    same(disk.at(disk.eom.Fr_star)[:, 5:6], terms[:, 2:], scale)

    s, tolerance = solved
    at_zero = yoo.eq_32(replace(s, normal=np.zeros_like(s.normal)))
    bound = tolerance * np.abs(at_zero).sum(axis=1)
    assert np.all(np.abs(s.normal + at_zero.sum(axis=1)) <= bound)
