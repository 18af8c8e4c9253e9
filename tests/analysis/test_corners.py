# SPDX-License-Identifier: BSD-3-Clause
"""Linearization where switches stand: what differs is named, one side agrees with differences into it, what is smooth passes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from tests.examples import examples

x, y = kn.coordinates("x y")
v, w = kn.speeds("v w")


def plane(along_x, along_y=0, **more):
    """A particle of mass 1 in a plane, with a force."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x + y * N.y)
    force = kn.Force(P, along_x * N.x + along_y * N.y, name="push")
    bodies = [kn.Particle("P", P, 1.0)]
    return kn.derive(kn.System(N, bodies=bodies, speeds={v: x.dt, w: y.dt}, loads=[force], **more))


def positive(c, a, b):
    return kn.where(kn.less(0, c), a, b)


def rows(force, side=None, **more):
    """The slopes of v' and w' at rest in the origin."""
    return kn.linearize(plane(force, -y), q=[0, 0], u=[0, 0], side=side, **more).A[2:]


ALIKE = {
    "max": kn.max(x, 0),
    "where": positive(x, x, 0),
    "where below": kn.where(kn.less(x, 0), 0, x),
    "min": -kn.min(0, -x),
    "half": (x + abs(x)) / 2,
    "sign": (1 + kn.sign(x)) / 2 * x,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ALIKE)
def test_one_corner_has_one_verdict_and_one_derivative_a_side_however_it_is_written(name):
    force = -ALIKE[name] - x
    with pytest.raises(kn.CornerError, match=r"in the push switches at x = 0.*side=\{'x': 1\} or side=\{'x': -1\}"):
        rows(force)
    assert rows(force, {"x": 1})[0].tolist() == [-2, 0, 0, 0]
    assert rows(force, {x: -0.3})[0].tolist() == [-1, 0, 0, 0]


SMOOTH = {
    "x |x|": (x * abs(x), 0),
    "parabola on one side": (positive(x, x**2, 0), 0),
    "sign x |x|": (kn.sign(x) * abs(x), 1),
    "guarded": (x * kn.where(kn.less(1e-9, abs(x)), kn.sin(x) / x, 1), 1),
    "root": (positive(x, kn.sqrt(x) * x**2, 0), 0),
    "power 1.5": (positive(x, kn.sqrt(x) * x, 0), 0),
    "power 1.5 on both": (x * kn.sqrt(abs(x)), 0),
    "branches that agree": (abs(x) - positive(2 * x, x, -x), 0),
    "held from outside": (kn.max(abs(x), -abs(x) - 1) - abs(x), 0),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SMOOTH)
def test_what_is_smooth_to_first_order_passes(name):
    force, slope = SMOOTH[name]
    for side in (None, {"x": 1}, {"v": -1}):
        np.testing.assert_allclose(rows(-2 * x + force, side), [[slope - 2, 0, 0, 0], [0, -1, 0, 0]], atol=1e-12)


def test_a_jump_is_told_with_its_values_and_has_a_derivative_on_each_side():
    force = -x - 0.3 * kn.sign(v) - 2 * v
    with pytest.raises(kn.CornerError, match=r"sign\(v\) in the push.*v' jumps between -0\.3 and 0\.3.*steady=False"):
        rows(force)
    one = kn.linearize(plane(force), q=[0, 0], u=[0, 0], side={"v": 1}, steady=False)
    assert one.A[2].tolist() == [-1, 0, -2, 0]
    assert one.rates[2] == -0.3
    with pytest.raises(kn.SimulationError, match=r"v' = -0\.3"):
        rows(force, {"v": 1})


def test_a_direction_that_leaves_the_switch_where_it_is_is_refused_and_another_one_offered():
    force = -x - positive(x, positive(y, v, 0), 0)
    with pytest.raises(kn.CornerError, match=r"0 < x.*0 < y.*such as side=\{'x': 1\.0, 'y': 1\.0\}"):
        rows(force)
    with pytest.raises(kn.CornerError, match="y becomes positive or negative"):
        rows(force, {"x": 1})
    assert rows(force, {"x": 1, "y": 1})[0].tolist() == [-1, 0, -1, 0]
    assert rows(force, {"x": 1, "y": -1})[0].tolist() == [-1, 0, 0, 0]
    assert rows(force, {"x": -1})[0].tolist() == [-1, 0, 0, 0]
    with pytest.raises(kn.ValueMissingError, match=r"a direction in states and inputs .*got z"):
        rows(force, {"z": 1})


def test_inputs_and_outputs_have_corners_too():
    F = kn.input("F")
    eom = plane(-x - v + kn.max(F, 0), -y)
    with pytest.raises(kn.CornerError, match=r"max\(0, F\).*side=\{'F': 1\}"):
        kn.linearize(eom, q=[0, 0], u=[0, 0])
    assert kn.linearize(eom, q=[0, 0], u=[0, 0], side={"F": 1}).B[2, 0] == 1
    assert kn.linearize(eom, q=[0, 0], u=[0, 0], side={F: -1}).B[2, 0] == 0
    smooth = plane(-x, -y)
    with pytest.raises(kn.CornerError, match="in the output 'gap'"):
        kn.linearize(smooth, q=[0, 0], u=[0, 0], outputs={"gap": abs(y)})
    one = kn.linearize(smooth, q=[0, 0], u=[0, 0], outputs={"gap": abs(y), "a": abs(v.dt)}, side={"y": -1, "x": 1})
    assert one.C.tolist() == [[0, -1, 0, 0], [1, 0, 0, 0]]


def test_a_kink_of_a_constraint_has_a_tangent_on_each_side():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    P = O.at("P", x * N.x + y * N.y)
    eom = kn.derive(
        kn.System(
            N, bodies=[kn.Particle("P", P, 1.0)], speeds={v: x.dt, w: y.dt}, holonomic=[y - positive(x, 3 * x, -x / 2)],
            dependent_coordinates=[y], dependent_speeds=[w], loads=[kn.Force(P, -x * N.x, name="spring")],
        ),
        near={x: 1.0},
    )  # fmt: skip
    at = {"q": {"x": 0, "y": 0}, "u": {"v": 0.0, "w": 0.0}, "outputs": {"rise": y}}
    with pytest.raises(kn.CornerError, match=r"in the constraint .*switches at x = 0"):
        kn.linearize(eom, **at)
    for side, slope in ((1, 3.0), (-1, -0.5)):
        one = kn.linearize(eom, **at, side={"x": side})
        np.testing.assert_allclose(one.C, [[slope, 0]], atol=1e-14)
        np.testing.assert_allclose(one.A, [[0, 1], [-1 / (1 + slope**2), 0]], atol=1e-14)


def test_an_equilibrium_found_beside_a_corner_by_rounding_is_on_it():
    for scale in (1.0, 1e6, 1e-6):
        k = 3 / scale
        eom = plane(k * (0.1 * scale - x) - k / 3 * kn.max(x - 0.1 * scale, 0), -y)
        point = kn.equilibrium(eom, q={"x": kn.guess(0.37 * scale), "y": kn.guess(-0.2)})
        for there in (point, point.replace(q={"x": 0.1 * scale * (1 + 4e-16)})):
            with pytest.raises(kn.CornerError):
                kn.linearize(eom, **there.arguments)
            assert kn.linearize(eom, **there.arguments, side={"x": 1}).A[2, 0] == pytest.approx(-4 / scale)
        beside = kn.linearize(eom, q=[0.1 * scale * (1 + 1e-9), 0], u=[0, 0])
        assert beside.A[2, 0] == pytest.approx(-4 / scale)


def test_linearization_in_symbols_names_corners_and_passes_what_is_smooth():
    k = kn.parameter("k", 2.0)
    for force in ALIKE.values():
        with pytest.raises(kn.CornerError, match=r"switches at x = 0.*kn\.linearize\(eom, …, side=…\)"):
            kn.linearize_symbolic(plane(-k * x - force, -y), {x: 0, y: 0, v: 0, w: 0})
    smooth = plane(-k * x - x * abs(x) + kn.sign(x) * abs(x), -y)
    assert str(kn.linearize_symbolic(smooth, {x: 0, y: 0, v: 0, w: 0}).A[2, 0]) == "1 - k"


def test_switches_that_stand_elsewhere_leave_the_derivative_as_it_is():
    eom = plane(-kn.max(x, -1) - abs(v + 2) + 2, -y)
    assert rows(-kn.max(x, -1) - abs(v + 2) + 2)[0].tolist() == [-1, 0, -1, 0]
    assert kn.linearize(eom, q=[0, 0], u=[0, 0]).A[2].tolist() == [-1, 0, -1, 0]


def test_equilibria_at_which_accelerations_jump_are_warned_of():
    with pytest.warns(kn.KaneWarning, match=r"sign\(v\) in the push.*v' jumps between -0\.3 and 0\.3"):
        kn.equilibrium(plane(-x - 0.3 * kn.sign(v), -y))
    assert kn.equilibrium(plane(-x - 0.3 * kn.max(v, 0) + abs(x), -y))["x"] == 0


def test_a_branch_through_a_corner_has_there_the_eigenvalues_of_one_side_and_says_so():
    F = kn.input("F")
    eom = plane(F - x - kn.max(x, 0) - v * positive(x, 0.2, 0.4), -y - w)
    with pytest.warns(kn.KaneWarning, match=r"got corners at F = .*switches at x = 0"):
        branch = kn.continuation(eom, F, [-1, -0.5, 0, 0.5, 1])
    left, right = (np.linalg.eigvals([[0, 1], [-k, -d]])[0] for k, d in ((1, 0.4), (2, 0.2)))
    for k, roots in enumerate(branch.eigenvalues):
        own = ([left], [left], [left, right], [right], [right])[k]
        assert any(min(abs(roots - e)) < 1e-9 for e in own)
    assert not branch.crossings


def test_an_eigenvalue_that_a_switch_takes_over_the_axis_keeps_its_real_part():
    F = kn.input("F")
    eom = plane(F - x - v * positive(x - 0.1, -0.3, 0.5), -y - w)
    (crossing,) = kn.continuation(eom, F, [-1, 1]).crossings
    assert crossing.value == pytest.approx(0.1, abs=1e-9)
    assert crossing.eigenvalue.real in (pytest.approx(0.15), pytest.approx(-0.25))
    assert crossing.grows


QUANTITIES = [x, y, v, w, x - y, x + v, x - 2 * w, x * x - y, kn.sin(x) + w, x * v]
FORMS = [
    lambda c, e: abs(c) * e,
    lambda c, e: kn.max(c, 0) + e,
    lambda c, e: kn.min(c, e),
    lambda c, e: positive(c, e, c * e),
    lambda c, e: positive(c, c**2, 0) - e,
    lambda c, e: kn.sign(c) * e,
    lambda c, e: kn.max(abs(c), e),
]


@examples(0.1)
@given(
    st.lists(st.tuples(st.sampled_from(FORMS), st.sampled_from(QUANTITIES)), min_size=1, max_size=3),
    st.permutations((1.0, 1.7, 2.3, 3.1)),
    st.lists(st.sampled_from((-1, 1)), min_size=4, max_size=4),
)
def test_one_side_agrees_with_differences_into_it(terms, lengths, signs):
    """The derivative of the side into which d leads, times d, is (F(h d) − F(0))/h."""
    force = y - 2 * v
    for form, c in terms:
        force = form(c, force)
    eom = plane(force, -x)
    d = np.array(lengths) * signs
    side = dict(zip(("x", "y", "v", "w"), d, strict=True))
    try:
        one = kn.linearize(eom, q=[0, 0], u=[0, 0], side=side, steady=False)
    except kn.CornerError:
        assert any(c.op.name == "mul" for _, c in terms)  # x v does not change to first order
        return
    h = 2.0**-20

    def acceleration(step):
        return np.array(eom.evaluate([v.dt, w.dt], q=step[:2], u=step[2:]), dtype=float)

    np.testing.assert_allclose((acceleration(h * d) - one.rates[2:]) / h, one.A[2:] @ d, atol=1e-4)
    try:
        both = kn.linearize(eom, q=[0, 0], u=[0, 0], steady=False)
    except kn.CornerError:
        return
    np.testing.assert_allclose((acceleration(h * d) - acceleration(-h * d)) / (2 * h), both.A[2:] @ d, atol=1e-4)
