# SPDX-License-Identifier: BSD-3-Clause
"""Typed leaves: identity by declaration, names, rates."""

import pickle

import pytest

import kane as kn
from kane import (
    Coordinate,
    Input,
    Parameter,
    Rate,
    Speed,
    coordinate,
    coordinates,
    input,
    parameter,
    parameters,
    speed,
    speeds,
    time,
)
from kane.errors import ExpressionError
from kane.expr import QuasiRate, digest, names, rate
from tests.expr.expressions import identical


def test_equal_declarations_are_one_symbol() -> None:
    assert parameter("m", 1.2, "kg", "mass") is parameter("m", 1.2, "kg", "mass")
    assert parameter("m", 1) is parameter("m", 1.0)
    assert coordinates("q1:3")[1] is coordinate("q2")


@pytest.mark.parametrize(
    "other",
    [
        parameter("m", 1.3, "kg", "mass"),
        parameter("m", None, "kg", "mass"),
        parameter("m", 1.2, "g", "mass"),
        parameter("m", 1.2, "kg", "Mass"),
        parameter("M", 1.2, "kg", "mass"),
        coordinate("m", "kg", "mass"),
    ],
)
def test_any_difference_makes_another_symbol(other) -> None:
    m = parameter("m", 1.2, "kg", "mass")
    assert other is not m
    assert digest(other) != digest(m)
    assert (other - m).op.name in ("sub", "neg")


def test_kinds() -> None:
    kinds = [type(s) for s in (parameter("a"), coordinate("a"), speed("a"), input("a"))]
    assert kinds == [Parameter, Coordinate, Speed, Input]
    assert len({parameter("a"), coordinate("a"), speed("a"), input("a")}) == 4


def test_declaration_is_kept() -> None:
    m = parameter("m", 1.2, "kg", "mass")
    assert (m.name, m.default, m.unit, m.description) == ("m", 1.2, "kg", "mass")
    assert Parameter.declare(*m.declaration()) is m


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("q1:4", ("q1", "q2", "q3")),
        ("q:3", ("q0", "q1", "q2")),
        ("q9:12", ("q9", "q10", "q11")),
        ("x, y", ("x", "y")),
        ("x y z", ("x", "y", "z")),
        ("theta", ("theta",)),
        ("a, q1:3", ("a", "q1", "q2")),
    ],
)
def test_names(text: str, found: tuple[str, ...]) -> None:
    assert names(text) == found


@pytest.mark.parametrize("text", ["", " ", ",", "q1:q4", ":4", "q1:", "q3:2"])
def test_names_that_mean_nothing_are_refused(text: str) -> None:
    with pytest.raises(ExpressionError, match="Expected names such as"):
        names(text)


@pytest.mark.parametrize("name", ["", " ", "a b", "a\n"])
def test_one_symbol_needs_one_name(name: str) -> None:
    with pytest.raises(ExpressionError, match="without spaces"):
        parameter(name)


def test_plurals_are_always_tuples() -> None:
    assert identical(coordinates("q"), (coordinate("q"),))
    assert type(coordinates("q")) is tuple
    assert type(speeds("u")) is tuple
    assert [p.default for p in parameters("m1:4", 2.0, "kg")] == [2.0, 2.0, 2.0]


def test_rates_are_leaves() -> None:
    q, u, torque = coordinate("q", "m"), speed("u"), input("T", "N*m")
    assert isinstance(q.dt, Rate)
    assert q.dt is rate(q)
    assert (q.dt.name, q.dt.unit, q.dt.place) == ("q'", "m/s", q)
    assert u.dt.name == "u'"  # type: ignore[attr-defined]
    assert torque.dt.unit == "N*m/s"  # type: ignore[attr-defined]
    assert coordinate("q", "rad").dt is not q.dt


def test_what_has_no_rate_says_so() -> None:
    with pytest.raises(ExpressionError, match="it has no rate"):
        rate(parameter("m"))


def test_default_must_be_a_number() -> None:
    with pytest.raises(ExpressionError, match="Expected a number as the default of 'm'"):
        parameter("m", parameter("k"))  # type: ignore[arg-type]
    with pytest.raises(ExpressionError, match=r"default of 'm', got 'kg'.* write unit='kg'"):
        parameter("m", "kg")  # type: ignore[arg-type]


def test_symbols_pickle_with_their_place() -> None:
    e = coordinates("e0:4")
    quasi = QuasiRate.declare("w1(e0)", None, "rad/s", "", (*e, 1))
    for s in (time, coordinate("q").dt, quasi):
        assert pickle.loads(pickle.dumps(s)) is s


def test_time_is_one_leaf() -> None:
    assert time.name == "t"
    assert time.unit == "s"


@pytest.mark.parametrize("plural", [kn.coordinates, kn.speeds, kn.parameters])
def test_names_in_one_text_or_in_a_list(plural):
    assert plural(["a", "b"]) == plural("a b") == plural(("a, b",))
    assert plural(["q1:3", "x"]) == plural("q1:3, x")
    for wrong in ([], [1], 3, None, [""], ["a", None]):
        with pytest.raises(kn.ExpressionError, match='Expected names such as "q1:6"'):
            plural(wrong)
