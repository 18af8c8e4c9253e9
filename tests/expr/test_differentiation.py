# SPDX-License-Identifier: BSD-3-Clause
"""What is differentiated by: symbols, or their names; anything else is no zero."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.expr import ONE, as_expr, weighted

x, y = kn.coordinates("x y")


def test_by_name():
    e = x * x * y
    assert kn.diff(e, "x") is kn.diff(e, x) is 2 * x * y
    assert kn.gradient(e, ["x", y]) == kn.gradient(e, [x, y])
    assert kn.jacobian([e, x], ["y"]).entries == kn.jacobian([e, x], [y]).entries
    assert kn.diff(e, kn.parameter("k")) is kn.Rational(0)


@pytest.mark.parametrize("what", ["z", x + y, 2 * x, x * x, 1.0, None])
def test_what_is_no_symbol_is_refused(what):
    for derivative in (
        lambda: kn.diff(x * x * y, what),
        lambda: kn.gradient(x * x * y, [what]),
        lambda: kn.jacobian([x * x * y, x], [what]),
    ):
        with pytest.raises(
            kn.ExpressionError, match=r"Expected a symbol, or the name of one in the expression \(x, y\)"
        ):
            derivative()


def test_a_name_that_two_symbols_have():
    with pytest.raises(kn.ExpressionError, match="got 'x'"):
        kn.diff(x * kn.coordinate("x", "m"), "x")


X = kn.coordinate("x")
GUARDED = {
    "sin x / x": (
        kn.where(kn.less(1e-9, kn.abs(X)), kn.sin(X) / X, 1),
        lambda v: np.cos(v) / v - np.sin(v) / v**2 if abs(v) > 1e-9 else 0.0,
    ),
    "root on one side": (kn.where(kn.less(0, X), kn.sqrt(X) * X * X, 0), lambda v: 2.5 * max(v, 0.0) ** 1.5),
    "log on one side": (
        kn.where(kn.less(X, 0), 0, X * X * kn.log(kn.max(X, 1e-300))),
        lambda v: 2 * v * np.log(v) + v if v > 0 else 0.0,
    ),
}


@pytest.mark.parametrize("name", GUARDED)
@pytest.mark.parametrize("at", [-0.7, -1e-12, 0.0, 1e-6, 0.4])
def test_guarded_expressions_have_finite_derivatives(name, at):
    """What is not chosen may be infinite there."""
    e, slope = GUARDED[name]
    for derivative in (kn.diff(e, X), kn.gradient(e, [X])[0], kn.jacobian([e], [X]).entries[0]):
        assert float(kn.evaluate(derivative, {X: at})) == pytest.approx(float(slope(at)), rel=1e-6, abs=1e-9)


def test_max_is_the_choice_that_it_stands_for():
    for one, other in (
        (kn.max(X, 0), kn.where(kn.less(0, X), X, 0)),
        (kn.min(X, 0), kn.where(kn.less(X, 0), X, 0)),
        (kn.max(2 * X + 1, 3), kn.where(kn.less(3, 2 * X + 1), 2 * X + 1, 3)),
    ):
        for at in (-0.5, 0.0, 0.5, 1.0, 2.0):
            a, b = (float(kn.evaluate(kn.diff(e, X), {X: at})) for e in (one, other))
            assert a == b


@given(st.data())
def test_random_choices_against_one_sided_differences(data):
    """Forwards and backwards, away from a corner and on it."""
    y = kn.coordinate("y")
    smooth = [X, X * X - 0.3, kn.sin(2 * X + y), y * X, kn.exp(X) - 1, kn.Rational(1, 3)]
    a, b, c, d = (data.draw(st.sampled_from(smooth)) for _ in range(4))
    e = data.draw(
        st.sampled_from(
            [
                kn.max(a, b) * c,
                kn.where(kn.less(a, b), c, d) + a,
                kn.min(a, c * b),
                kn.abs(a - b) * d,
                kn.max(kn.min(a, b), c),
            ]
        )
    )
    # of a 64th: a corner is there, or farther away than the differences reach
    values = {s: data.draw(st.integers(-64, 64)) / 64 for s in (X, y)}
    h = 1e-6
    forward, backward = kn.diff(e, X), kn.gradient(e, [X])[0]

    def value(shift):
        return float(kn.evaluate(kn.Rational(0) + e, values | {X: values[X] + shift}))

    left, right = (value(0) - value(-h)) / h, (value(h) - value(0)) / h
    for derivative in (forward, backward):
        found = float(kn.evaluate(kn.Rational(0) + derivative, values))
        assert min(abs(found - left), abs(found - right), abs(found - (left + right) / 2)) < 1e-4 * (
            1 + abs(left) + abs(right)
        )


@pytest.mark.parametrize("start", [-0.5, 0.0, 1e-9, 0.5])
def test_a_motion_on_a_guarded_curve_starts_anywhere(start):
    """A particle on y = 10 √x x² for x > 0, on y = 0 elsewhere: its velocity holds the derivative of what is not chosen."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    height = kn.where(kn.less(0, X), 10 * kn.sqrt(X) * X * X, 0)
    bead = kn.Particle("bead", O.at("P", X * N.x + height * N.y), 2)
    eom = kn.derive(kn.System(N, bodies=[bead], speeds="rates", loads=[kn.gravity(-9.81 * N.y)]))
    sol = kn.simulate(eom, (0, 0.5), q=[start], u=[1.0], samples=5)
    assert sol.status == "finished"
    assert sol.energy == pytest.approx(sol.energy[0], rel=1e-6)


class TestWeighted:
    """Σ w_i ∂root_i/∂symbol of several roots."""

    x, y, w = kn.coordinate("x"), kn.coordinate("y"), kn.parameter("w")

    def numbers(self, roots, weights, at):
        found = weighted([as_expr(r) for r in roots], weights, (self.x, self.y))
        return [float(v) for v in kn.evaluate(list(found), at)]

    def test_in_one_sweep_it_is_the_sum_of_gradients(self):
        x, y, w = self.x, self.y, self.w
        roots, weights = [kn.sin(x) * y, x / y + y**3, x], [w, w * w, ONE]
        at = {x: 0.7, y: 1.3, w: 0.4}
        expected = sum(
            kn.evaluate(e, at) * np.array(kn.evaluate(list(kn.gradient(r, (x, y))), at), dtype=float)
            for r, e in zip(roots, weights, strict=True)
        )
        assert self.numbers(roots, weights, at) == pytest.approx(expected, rel=1e-14)

    def test_what_a_choice_leaves_out_may_be_infinite(self):
        x, y, w = self.x, self.y, self.w
        assert self.numbers([kn.max(1 / x, y) + x * y], [w], {x: -0.0001, y: 2.0, w: 3.0}) == pytest.approx([6, 2.9997])
        assert self.numbers([kn.where(kn.less(0, x), kn.log(x), y)], [w], {x: 0.0, y: 2.0, w: 3.0}) == [0, 3]

    def test_a_length_at_rest_has_the_mean_slope(self):
        x, y, w = self.x, self.y, self.w
        at = {x: 0.0, y: 0.0, w: 3.0}
        assert self.numbers([kn.sqrt(x * x + y * y) * x], [w], at) == [0, 0]
