# SPDX-License-Identifier: BSD-3-Clause
"""What is derived once, and the routes that solve it."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.dynamics import Derived, LazyMapping, Partition, classical, derived, read, table
from kane.equations import repartition
from kane.expr import sum_of
from kane.gallery import four_bar, pendulum_on_cart, rolling_disk


def test_the_mass_matrix_is_built_by_the_route_that_needs_it():
    parts = derived(rolling_disk.system())
    assert not {"blocks", "loads", "Fr"} & vars(parts).keys()
    classical(parts, None)
    assert "blocks" in vars(parts)
    assert not {"loads", "Fr", "Fr_star"} & vars(parts).keys()


def test_another_choice_of_dependent_speeds_derives_nothing(monkeypatch):
    """The same Derived, blocks and all; the other choice solves the same equations."""
    eom = kn.derive(four_bar.system())
    first = eom.embedding.partition
    turned = Partition(first.rows, tuple(sorted({0, 1, 2} - {first.dependent[0]})), ())
    with monkeypatch.context() as patched:
        patched.setattr(Derived, "__init__", None)
        other = repartition(eom, turned)
    assert other.derived is eom.derived
    assert set(other.dependent_speeds) != set(eom.dependent_speeds)
    start = kn.assemble(eom, q={"q1": 0.9, "q2": kn.guess(-0.5), "q3": kn.guess(1.2)}, u={"u1": 2.0})
    state = {"q": start.q, "u": start.u}
    solved = [np.array(e.evaluate([*e.accelerations, *e.multipliers.values()], **state)) for e in (eom, other)]
    assert solved[1] == pytest.approx(solved[0], rel=1e-9)


def test_routes_are_rows_of_a_table(monkeypatch):
    """The equations say which one solved them, and another choice of dependent speeds takes the same."""
    calls = []
    monkeypatch.setitem(table.ROUTES, "counted", lambda *arguments: calls.append(1) or classical(*arguments))
    parts = derived(four_bar.system())
    found = table.solved(parts, Partition((0, 1), (1, 2), ()), "counted")
    assert calls
    assert found.derived is parts
    assert kn.derive(four_bar.system()).solved.route == "embedded"


def test_all_readings_of_the_terms_agree():
    eom = kn.derive(rolling_disk.system())
    for speed, active, inertia in zip(eom.all_speeds, eom.Fr, eom.Fr_star, strict=True):
        terms = eom.contributions(speed)
        at = {"q": [0.3, 0.4, 0.1, 0.2, 0.5], "u": [0.5, -1.0, 6.0, 0.7, -0.4]}
        shares = [sum_of(c.term for c in terms.active), sum_of(c.term for c in terms.inertia)]
        found, whole = (np.array(eom.evaluate(e, **at)) for e in (shares, [active, inertia]))
        assert found == pytest.approx(whole, rel=1e-12, abs=1e-12)


class Inner:
    value = 3.0
    half = read[float](lambda x: x.value / 2, "Half of it.")

    @read  # type: ignore[untyped-decorator]  # of a package that offers its names when they are used
    def double(self) -> float:
        """Twice of it."""
        return 2.0 * self.value


class Outer:
    half = Inner.half.within("inner")
    double = Inner.double.within("inner")
    inner = Inner()


class TestLazy:
    def test_a_mapping_computes_a_value_once(self):
        calls = []
        squares = LazyMapping([1, 2, 3], lambda k: calls.append(k) or k * k)
        assert len(squares) == 3
        assert calls == []
        assert (squares[2], squares[2]) == (4, 4)
        assert calls == [2]
        assert repr(squares) == "{1: 1, 2: 4, 3: 9}"
        with pytest.raises(KeyError, match="Expected one of 1, 2, 3, got 5"):
            squares[5]

    def test_a_key_is_in_it_by_its_name_too(self):
        a, b, other = kn.coordinate("a"), kn.coordinate("b"), kn.coordinate("other")
        pairs = LazyMapping([(a, b), (b, a)], lambda key: key)
        assert [key in pairs for key in ((a, b), ("a", b), ("b", "a"), ("a", "a"), "a", (a, other), ("a",))] == [
            True, True, True, False, False, False, False,
        ]  # fmt: skip
        assert pairs["a", b] == (a, b)

    def test_attributes_of_a_part_are_its_own(self):
        assert (Outer().half, Outer().double) == (1.5, 6.0)
        assert (Outer.half.__doc__, Outer.double.__doc__) == ("Half of it.", "Twice of it.")
        assert Outer.half.func.__annotations__ == {"return": float}


def test_weights_do_not_cancel_where_a_speed_moves_nothing_up():
    """f of the cart holds no g: m g cos θ sin θ − m g cos θ sin θ stood there."""
    eom = kn.derive(pendulum_on_cart.system())
    x, theta = eom.forcing
    assert "g" not in {s.name for s in kn.free_symbols([x])}
    assert "g" in {s.name for s in kn.free_symbols([theta])}
    assert kn.count_operations(eom.right_hand_side).total <= 25
