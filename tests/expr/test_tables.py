# SPDX-License-Identifier: BSD-3-Clause
"""Tables in expressions: values, derivatives, sides, copies, print, units; the same in code as in the reference."""

import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

import kane as kn
from kane.expr import lowered, on_sides, switches
from tests.examples import examples

X = kn.coordinate("x")
KINDS = ("linear", "cubic", "periodic", "steps")


def some(kind, n=6, seed=0):
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(0.2, 1.5, n)) - 2
    y = rng.normal(size=n)
    y[-1] = y[0] if kind == "periodic" else y[-1]
    return x, y, kn.table(x, y, kind)


def wanted(kind, x, y, at):
    """By NumPy and SciPy."""
    if kind == "linear":
        return np.interp(at, x, y)
    if kind == "periodic":
        return CubicSpline(x, y, bc_type="periodic")(at)
    if kind == "steps":
        return y[np.clip(np.searchsorted(x, at, side="right") - 1, 0, None)]
    return np.where(at < x[0], y[0], np.where(at >= x[-1], y[-1], CubicSpline(x, y)(np.clip(at, x[0], x[-1]))))


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 10**6), n=st.integers(4, 9))
@examples(0.2)
def test_values_are_those_of_numpy_and_scipy(kind, seed, n):
    x, y, table = some(kind, n, seed)
    span = x[-1] - x[0]
    at = np.random.default_rng(seed + 1).uniform(x[0] - 2 * span, x[-1] + 2 * span, 200)
    # rounding of x, shifted by periods, is multiplied by the slope
    assert np.allclose(kn.evaluate(table(X), {X: at}), wanted(kind, x, y, at), rtol=1e-12, atol=1e-11 * np.abs(y).max())
    inside = x[1:-1]
    assert np.allclose(kn.evaluate(table(X), {X: inside}), wanted(kind, x, y, inside), rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_code_and_reference_agree(kind):
    """What is written in comparisons and choices rounds as the data do, also at the points themselves."""
    x, _, table = some(kind)
    at = np.concatenate([x, np.linspace(x[0] - 5, x[-1] + 5, 301)])
    for e in (table(X), kn.diff(table(X), X), kn.diff(kn.diff(table(X), X), X)):
        assert np.array_equal(kn.evaluate(e, {X: at}), kn.evaluate(lowered([e])[0], {X: at}))


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_are_exact(kind):
    x, y, table = some(kind)
    at = np.linspace(x[0] - 1, x[-1] + 1, 57)
    at = at[np.abs(at[:, None] - x).min(axis=1) > 1e-3]
    h = 1e-5
    slope = kn.evaluate(kn.diff(table(3 * X), X), {X: at / 3})
    apart = (wanted(kind, x, y, at + h) - wanted(kind, x, y, at - h)) / (2 * h)
    assert np.allclose(slope, 3 * apart, rtol=1e-6, atol=1e-6)
    assert np.allclose(3 * table.derivative()(at), slope)
    if kind in ("linear", "steps"):
        assert not np.any(kn.evaluate([kn.diff(kn.diff(table(X), X), X)], {X: at}))


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 10**6), n=st.integers(4, 8))
@examples(0.1)
def test_sides_of_corners(kind, seed, n):
    """A quantity changes its sign at each corner, and the data are those of its side, also across the corner."""
    x, _, table = some(kind, n, seed)
    (found,) = switches([table(X)]) if kind != "periodic" else (None,)
    if found is None:
        assert not switches([table(X)])
        return
    corners = {"linear": x, "steps": x[1:], "cubic": x[[0, -1]]}[kind]
    h = 1e-7
    before, after = (np.sign(kn.evaluate(found.quantity, {X: corners + d})) for d in (-h, h))
    assert (before == -after).all()
    assert np.abs(kn.evaluate(found.quantity, {X: corners})).max() < 1e-12
    side = kn.parameter("side")
    one = on_sides(table(X), {found.quantity: side}, {})
    for d, sign in ((-h, before), (h, after)):
        own = kn.evaluate(table(X), {X: corners + d})
        assert np.allclose(kn.evaluate(one, {X: corners + d, side: sign}), own, rtol=1e-12, atol=1e-12)
        across = kn.evaluate(one, {X: corners - d, side: sign})
        assert np.allclose(across, own, atol=1e-5)
    between = (x[1:] + x[:-1]) / 2
    signs = np.sign(kn.evaluate(found.quantity, {X: between}))
    assert np.allclose(kn.evaluate(one, {X: between, side: signs}), kn.evaluate(table(X), {X: between}), rtol=1e-12)


@pytest.mark.slow
def test_equal_data_are_one_operation_in_every_process():
    x, y, table = some("cubic")
    again = kn.table(list(x), list(y), "cubic")
    assert again(X) is table(X)
    assert kn.table(x, y, "cubic", name="p")(X) is not table(X)
    e = kn.sin(table(X)) + kn.diff(table(2 * X), X)
    assert pickle.loads(pickle.dumps(e)) is e
    code = (
        "import pickle, sys, kane as kn; e = pickle.load(sys.stdin.buffer); print(float(kn.evaluate(e, {'x': 0.3})), e)"
    )
    ran = subprocess.run([sys.executable, "-c", code], input=pickle.dumps(e), capture_output=True, check=True)
    assert ran.stdout.decode().strip() == f"{float(kn.evaluate(e, {X: 0.3}))} {e}"


def test_print_and_other_tools():
    _, _, table = some("linear")
    p = kn.table([0, 1], [0, 2], name="p")
    assert str(p(X) + 1) in ("p(x) + 1", "1 + p(x)")
    assert kn.to_latex(p(X)) == r"\operatorname{p} x"
    assert str(kn.diff(p(X), X)) == "p'(x)"
    assert repr(p) == "Table(p: 2 points, 0 … 1, linear)"
    for t in (table, some("periodic")[2]):
        back = kn.from_sympy(kn.to_sympy(t(X)), {"x": X})
        at = np.linspace(-3, 4, 40)
        assert np.allclose(kn.evaluate(back, {X: at}), t(at), rtol=1e-12)
    assert p(0.25) == 0.5
    assert p(X * 0) is X * 0  # of a number, a number


def test_units():
    x, f = kn.coordinate("x", "m"), kn.parameter("f", 1.0, "N")
    p = kn.table([0, 1], [0, 2], name="p", unit="N", of="m")
    assert kn.unit_of(p(x)) == "N"
    assert kn.unit_of(p(x) + f) == "N"
    assert kn.unit_of(kn.diff(p(x), x)) == "N/m"
    with pytest.raises(kn.UnitError, match=r"Expected an argument in m of p, got f \[N\] in p\(f\)"):
        kn.unit_of(p(f))
    assert kn.unit_of(kn.table([0, 1], [0, 2])(x)) == ""


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ([0, 1, 1], [1, 2, 3]),
            r"increasing points x of a table, got 1 after 1\. Sort the points; where the value jumps",
        ),
        (([0, 2, 1], [1, 2, 3]), r"got 1 after 2"),
        (([0], [1]), r"at least 2 points \(x, y\) for a table of kind 'linear', got shapes \(1,\) and \(1,\)"),
        (([0, 1], [1, 2], "cubic"), r"at least 3 points"),
        (([0, 1, 2], [1, 2]), r"got shapes \(3,\) and \(2,\)"),
        (([0, 1], [1, np.nan]), r"finite points of a table, got NaN"),
        ((["a", 1], [1, 2]), r"numbers as the points of a table"),
        (([0, 1], [1, 2], "quartic"), r"kind of a table as one of linear, cubic, periodic, steps, got 'quartic'"),
        (([0, 1, 2, 3], [1, 2, 3, 4], "periodic"), r"to end at the value that it begins with, 1, got 4\. Close it"),
    ],
)
def test_points_that_are_none(arguments, said):
    with pytest.raises(kn.ExpressionError, match=said):
        kn.table(*arguments)


def test_names_and_calls():
    with pytest.raises(kn.ExpressionError, match="Expected name of a table"):
        kn.table([0, 1], [0, 1], name="a b")
    with pytest.raises(kn.ExpressionError, match="Expected unit of a table"):
        kn.table([0, 1], [0, 1], unit=3)
