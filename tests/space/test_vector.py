# SPDX-License-Identifier: BSD-3-Clause
"""Vectors over several frames against NumPy, and their derivative in any frame against finite differences."""

from __future__ import annotations

import copy
import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.paths import Path, derivative, numbers

N = kn.Frame("N")
q = kn.coordinates("q1:6")
A = N.rotate("A", q[0], N.z)
B = A.rotate_body("B", q[1:4], "xyz")
C = N.rotate("C", kn.sin(kn.time) + q[4], (2 * N.x - N.y + 2 * N.z) / 3)
FRAMES = (N, A, B, C)
PATH = Path(q, 11, t0=0.2)
STATE = PATH.values()


def random_vector(seed):
    """A vector along two or three frames, and a function that gives its components along N in NumPy."""
    rng = np.random.default_rng(seed)
    chosen = rng.choice(4, size=int(rng.integers(1, 4)), replace=False)
    parts = []
    for i in chosen:
        k = rng.normal(size=3).round(3)
        k[rng.random(3) < 0.3] = 0
        parts.append((FRAMES[i], k))
    made = kn.Vector()
    for frame, k in parts:
        made = made + (frame.x * k[0] * q[0] + k[1] * frame.y * kn.cos(q[2]) + frame.z * (k[2] * kn.time))

    def values(t):
        at = PATH.values(t)
        scale = np.array([at[q[0]], np.cos(at[q[2]]), t])
        return sum(numbers(N.dcm(f), at) @ (k * scale) for f, k in parts)

    return made, values


def along_n(v, values=STATE):
    return numbers(v.components(N), values)


@pytest.mark.parametrize("seed", range(20))
def test_algebra(seed):
    v, v_of = random_vector(seed)
    w, w_of = random_vector(seed + 100)
    a, b = v_of(0.2), w_of(0.2)
    assert along_n(v) == pytest.approx(a, abs=1e-14)
    assert along_n(v + w) == pytest.approx(a + b, abs=1e-14)
    assert along_n(v - w) == pytest.approx(a - b, abs=1e-14)
    assert along_n(-v * q[0] / 3) == pytest.approx(-a * STATE[q[0]] / 3, abs=1e-14)
    assert numbers([v.dot(w), w.dot(v)], STATE) == pytest.approx([a @ b] * 2, abs=1e-13)
    assert along_n(v.cross(w)) == pytest.approx(np.cross(a, b), abs=1e-13)
    assert numbers(v.outer(w).components(N), STATE) == pytest.approx(np.outer(a, b), abs=1e-13)
    for frame in FRAMES:
        turn = numbers(N.dcm(frame), STATE)
        assert numbers(v.components(frame), STATE) == pytest.approx(turn.T @ a, abs=1e-14)
        assert [f for f, _ in v.express(frame).parts] in ([frame], [])
    assert along_n(v.gathered()) == pytest.approx(a, abs=1e-14)
    assert len(v.gathered().parts) <= 1
    assert numbers([v.magnitude()], STATE) == pytest.approx(np.linalg.norm(a))
    n = C.y
    direction = along_n(n)
    assert along_n(v.project(n)) == pytest.approx(direction * (a @ direction), abs=1e-13)
    assert along_n(v.reject(n)) == pytest.approx(a - direction * (a @ direction), abs=1e-13)
    assert along_n(v.project(3 * n)) == pytest.approx(direction * (a @ direction), abs=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("frame", FRAMES, ids=lambda f: f.name)
def test_derivative_in_any_frame(seed, frame):
    v, of = random_vector(seed)

    def seen(t):
        return numbers(N.dcm(frame), PATH.values(t)).T @ of(t)

    assert numbers(v.dt(frame).components(frame), STATE) == pytest.approx(derivative(seen, 0.2), abs=1e-9)
    twice = numbers(v.dt(frame).dt(frame).components(frame), STATE)
    assert twice == pytest.approx(derivative(lambda t: derivative(seen, t), 0.2), abs=1e-7)


def test_a_vector_constant_in_a_frame_does_not_change_there():
    assert (2 * B.x - B.z).dt(B).is_zero
    assert N.x.dt(N).is_zero


def test_axes_of_two_frames_meet_in_one_between_that_has_both():
    """About parallel axes: y of the frame that spins about it, and z of the one that turns about that."""
    N = kn.Frame("N")
    A = N.rotate("A", kn.coordinate("heading"), N.z)
    D = A.rotate("D", kn.coordinate("roll"), A.y)
    R = kn.parameter("R")
    for found in (D.y.cross(R * N.z), -(R * N.z).cross(D.y)):
        assert [(f.name, str(x), str(y), str(z)) for f, (x, y, z) in found.parts] == [("A", "R", "0", "0")]


def test_normalized():
    v, of = random_vector(3)
    expected = of(0.2) / np.linalg.norm(of(0.2))
    assert along_n(v.normalized()) == pytest.approx(expected)
    with pytest.raises(kn.SpaceError, match="zero vector"):
        (v - v).normalized()


def test_zero():
    assert kn.Vector().is_zero
    assert (N.x - N.x).is_zero
    assert N.x.cross(N.x).is_zero
    assert str(kn.Vector()) == "0"
    assert [str(x) for x in kn.Vector().components(A)] == ["0", "0", "0"]
    assert str(kn.Vector().dot(N.x)) == "0"


def test_sum_starts_from_nothing():
    assert along_n(sum([N.x, 2 * N.y])) == pytest.approx([1, 2, 0])


@pytest.mark.parametrize(("i", "j", "k"), [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_unit_vectors_are_right_handed(i, j, k):
    axes = (B.x, B.y, B.z)
    assert str(axes[i].cross(axes[j])) == str(axes[k])
    assert str(axes[j].cross(axes[i])) == f"-{axes[k]}"
    assert str(axes[i].dot(axes[i])) == "1"
    assert str(axes[i].dot(axes[j])) == "0"


def test_numpy_numbers_as_factors():
    assert along_n(np.float64(2) * N.x + N.y * np.int64(3)) == pytest.approx([2, 3, 0])


def test_vectors_are_frozen():
    with pytest.raises(AttributeError, match="frozen"):
        N.x.parts = ()


def test_equality_refuses_to_guess():
    with pytest.raises(kn.SpaceError, match="not compared by"):
        _ = N.x == N.x
    with pytest.raises(kn.SpaceError, match="not compared by"):
        _ = N.x != N.y


def test_map_and_scalars():
    v = q[0] * N.x + 2 * A.y
    assert [str(s) for s in v.scalars()] == ["q1", "0", "0", "0", "2", "0"]
    assert str(v.map(lambda x: 2 * x)) == "2*q1 N.x + 4 A.y"


def test_text():
    u = kn.speed("u")
    assert str(u * N.x - (q[0] + 1) * B.z) == "u N.x - (q1 + 1) B.z"
    assert str(-N.y) == "-N.y"
    assert str(N.x - 2 * N.y) == "N.x - 2 N.y"


def test_a_copy_is_as_good():
    v = q[0] * N.x + 2 * A.y
    assert along_n(copy.copy(v)) == pytest.approx(along_n(v))
    assert pickle.loads(pickle.dumps(kn.Vector())).is_zero


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: N.x * N.y, kn.SpaceError, "scalar factor"),
        (lambda: N.x & N.y, kn.SpaceError, r"a product by its name, .*: write a\.dot\(b\), a\.cross\(b\)"),
        (lambda: kn.inertia(N, 1, 1, 1) @ N.y, kn.SpaceError, "a product by its name"),
        (lambda: N.x * kn.inertia(N, 1, 1, 1), kn.SpaceError, "scalar factor"),
        (lambda: N.x.dot(kn.inertia(N, 1, 1, 1)), kn.SpaceError, "dyadic.dot"),
        (lambda: N.x.dot(kn.Frame("M").x), kn.SpaceError, "N and M, which have no common root"),
        (lambda: N.x.cross(kn.Frame("M").x), kn.SpaceError, "no common root"),
        (lambda: (N.x + N.y).dot(kn.Frame("M").x), kn.SpaceError, "no common root"),
        (lambda: N.x.components(kn.Frame("M")), kn.SpaceError, "no common root"),
        (lambda: N.x.dt(kn.Frame("M")), kn.SpaceError, "no common root"),
        (lambda: N.x + 1, kn.SpaceError, "vector to add to N.x, got the scalar 1. Give it a direction, such as 1"),
        (lambda: N.x - 0.5, kn.SpaceError, "vector to subtract from N.x, got the scalar"),
        (
            lambda: 1 - N.x,
            kn.SpaceError,
            "vector to subtract it from, N.x, got the scalar 1. Give it a direction, such as 1",
        ),
        (lambda: q[0] - N.x, kn.SpaceError, "got the scalar q1. Give it a direction, such as q1"),
        (lambda: N.x / N.y, kn.SpaceError, "scalar divisor, got N.y"),
        (lambda: q[0] / N.y, kn.SpaceError, "scalar divisor, got N.y"),
        (lambda: N.x**2, kn.SpaceError, "Its square is v.dot"),
        (lambda: N.x.dot(N), kn.SpaceError, "a.dot.b., got N. Take one of its axes, such as N.x"),
        (lambda: N.x.cross(q[0]), kn.SpaceError, "a.cross.b., got q1. A product with a scalar is"),
        (lambda: N.x.outer(1), kn.SpaceError, "a.outer.b., got 1"),
        (lambda: N.x.express("A"), kn.SpaceError, "Expected a frame, .*got 'A'"),
        (lambda: N.x.dt(q[0]), kn.SpaceError, "Expected a frame, .*got q1"),
        (lambda: kn.inertia(N, 1, 1, 1) + N.x, kn.SpaceError, "dyadic in a sum of dyadics, got N.x"),
        (lambda: kn.inertia(N, 1, 1, 1) - 1, kn.SpaceError, "dyadic in a sum of dyadics, got 1. A moment"),
        (lambda: 1 - kn.inertia(N, 1, 1, 1), kn.SpaceError, "dyadic in a sum of dyadics, got 1"),
        (lambda: kn.inertia(N, 1, 1, 1).dot(2), kn.SpaceError, "dyadic.dot.w., got 2"),
        (lambda: N.x * "2", kn.ExpressionError, "real number"),
        (lambda: N.x / 0, kn.ExpressionError, "constant 0"),
    ],
)
def test_errors(make, error, message):
    with pytest.raises(error, match=message):
        make()


@pytest.mark.parametrize(
    "differentiate",
    [lambda t: kn.diff(kn.sin(q[0]), t), lambda t: (q[0] * N.x).diff(t, N), lambda t: A.x.diff(t, N)],
)
def test_a_partial_derivative_by_the_time_that_leaves_all_out_is_doubted(differentiate):
    with pytest.warns(kn.KaneWarning, match=r"that is zero, although q1 may vary\. .* kn\.time_derivative\(e\)"):
        zero = differentiate(kn.time)
    assert zero is kn.Rational(0) or zero.is_zero


def test_other_partial_derivatives_are_not_doubted():
    assert kn.diff(kn.parameter("m"), kn.time) is kn.diff(q[0], q[1]) is kn.Rational(0)
    assert kn.diff(q[0] * kn.time, kn.time) is q[0]


NAMES = dict(zip("abcd", kn.parameters("a b c d"), strict=True))


class TestText:
    """What is printed of a vector reads as the vector."""

    frames = (kn.Frame("P"), kn.Frame("Q"))

    @staticmethod
    def term(draw, depth):
        a = draw(st.sampled_from(sorted(NAMES)))
        if depth == 0:
            return draw(st.sampled_from([NAMES[a], kn.Rational(2), kn.Rational(-1, 3), kn.Rational(3, 2)]))
        x, y = TestText.term(draw, depth - 1), TestText.term(draw, draw(st.integers(0, depth - 1)))
        kind = draw(st.sampled_from(["add", "sub", "mul", "div", "neg", "sin"]))
        if kind == "div":
            return x / (y * y + 1)
        return {"add": x + y, "sub": x - y, "mul": x * y, "neg": -x, "sin": kn.sin(x)}[kind]

    @given(st.data())
    def test_it_reads_back_as_it_was(self, data):
        axes = [getattr(f, a) for f in self.frames for a in "xyz"]
        entries = [
            TestText.term(data.draw, data.draw(st.integers(0, 2))) if data.draw(st.booleans()) else 0 for _ in axes
        ]
        v = sum((axis * e for axis, e in zip(axes, entries, strict=True)), start=kn.Vector())
        text = str(v)
        assert not re.search(r"--|- -|\+ -|\+ \+", text), text
        values = dict(zip("abcd", (0.7, 1.9, 0.3, 2.3), strict=True))
        for k, (frame, axis) in enumerate((f, a) for f in "PQ" for a in "xyz"):
            plain = re.sub(rf"{frame}\.{axis}\b", "1", text)
            plain = re.sub(r"[PQ]\.[xyz]\b", "0", plain)
            plain = re.sub(r"(?<=[\w)]) (?=[01]\b)", "*", plain).replace("^", "**")
            found = eval(plain, {"__builtins__": {}}, {"sin": np.sin, **values})  # noqa: S307
            exact = float(kn.evaluate(kn.Rational(0) + entries[k], {NAMES[n]: x for n, x in values.items()}))
            assert found == pytest.approx(exact, rel=1e-9, abs=1e-12), text


@pytest.mark.slow
@pytest.mark.parametrize("along", ["first", "last", "own", "beside"])
def test_products_with_long_chains_are_those_of_their_parts(along):
    """A vector of fifteen parts with one along the root, the end, a frame between and a frame apart: each part by itself."""
    N = kn.Frame("N")
    frames = [N]
    for i in range(15):
        frames.append(frames[-1].rotate(f"B{i}", kn.coordinate(f"q{i}"), (frames[-1].x, frames[-1].z)[i % 2]))
    apart = N.rotate("D", kn.coordinate("p"), N.y)
    parts = [f.y * kn.parameter(f"l{i}", 1.0) + f.x * 0.2 * i for i, f in enumerate(frames)]
    other = {"first": N, "last": frames[-1], "own": frames[7], "beside": apart}[along]
    for v in (other.x, other.x * 0.3 - other.z):
        whole, each = sum(parts, start=kn.Vector()).dot(v), sum(p.dot(v) for p in parts)
        values = {s: 0.3 + 0.1 * k for k, s in enumerate(kn.free_symbols([whole, each]))}
        assert np.isclose(*np.array(kn.evaluate([whole, each], values), dtype=float), rtol=1e-13)
        assert kn.count_operations([whole]).total <= kn.count_operations([each]).total
