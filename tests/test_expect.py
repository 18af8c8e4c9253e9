# SPDX-License-Identifier: BSD-3-Clause
"""Checks of arguments: what passes comes back, what does not is refused by one form of message."""

import inspect

import numpy as np
import pytest

import kane as kn
from kane import expect
from kane.errors import ArgumentError, ModelError
from kane.gallery import pendulum


def message(check, *args, error=ModelError, **options):
    with pytest.raises(error) as caught:
        check(*args, **options, **({} if error is ModelError else {"error": error}))
    return str(caught.value)


def test_a_message_says_what_was_expected_what_came_and_the_cure():
    assert message(expect.instance, 3, str, "a name of the disk", "Give a text.") == (
        "Expected a name of the disk, got 3. Give a text."
    )
    assert message(expect.instance, 3, str, "a name", error=ArgumentError) == "Expected a name, got 3."


def test_what_came_is_shortened():
    shown = message(expect.instance, "x" * 500, int, "a number")
    assert len(shown) < 100
    assert shown.endswith(" ….")


def test_what_is_right_comes_back_and_is_not_printed():
    class Silent:
        def __repr__(self):
            raise AssertionError("printed")

    it = Silent()
    assert expect.instance(it, Silent, "it") is it
    assert expect.instances([it, it], Silent, "them") == (it, it)
    assert expect.pair([1, 2], "two") == (1, 2)
    expect.that(True, "it", it)


def test_lists():
    assert expect.items((x for x in (1, 2)), "a list") == (1, 2)
    assert message(expect.items, "ab", "loads= as a list") == "Expected loads= as a list, got 'ab'."
    assert message(expect.items, 3, "loads= as a list") == "Expected loads= as a list, got 3."
    assert message(expect.instances, [1, "b"], int, "whole numbers") == "Expected whole numbers, got 'b'."
    assert message(expect.pair, (1, 2, 3), "two radii") == "Expected two radii, got (1, 2, 3)."


def test_names():
    assert expect.one_of("exact", ("exact", "linear"), "form= to be") == "exact"
    assert message(expect.one_of, "exakt", ("exact", "linear"), "form= to be") == (
        "Expected form= to be one of exact, linear, got 'exakt'. Did you mean exact?"
    )
    for given in (None, [], kn.parameter("m")):
        assert "one of exact, linear, got " in message(expect.one_of, given, ("exact", "linear"), "form= to be")
    expect.different("abc", "bodies of different names")
    assert message(expect.different, "abcbca", "joints of different names", "Rename one.") == (
        "Expected joints of different names, got 'a', 'b', 'c' more than once. Rename one."
    )
    assert expect.name("q", "a name") == "q"
    assert message(expect.name, "", "a name") == "Expected a name, got ''."


@pytest.mark.parametrize("given", [0, 2.5, np.float64(1.0), np.int64(3)])
def test_numbers(given):
    assert expect.number(given, "a number") == given


@pytest.mark.parametrize("given", [True, np.nan, np.inf, "1", None, 1j, kn.parameter("m")])
def test_no_numbers(given):
    assert message(expect.number, given, "a number").startswith("Expected a number, got ")


@pytest.mark.parametrize(
    "given",
    [
        [1j, 0],
        np.array([1j]),
        np.ma.array([1.0, 2.0], mask=[False, True]),
        None,
        ["x"],
        [[1], [2, 3]],
        ["1"],
        [1.0, None],
    ],
)
def test_no_arrays_of_floats(given):
    assert message(expect.floats, given, "numbers").startswith("Expected numbers, got ")


def test_arrays_of_floats():
    for given in (range(3), [0, 1, 2], np.arange(3, dtype=np.float32), np.ma.array([0, 1, 2])):
        assert expect.floats(given, "numbers").tolist() == [0.0, 1.0, 2.0]


def test_whole_numbers():
    assert expect.whole(np.int32(3), "a count", least=1) == 3
    for given in (0, 11, 2.0, True, "3"):
        assert message(expect.whole, given, "a count", least=1, most=10) == f"Expected a count, got {given!r}."


def test_flags():
    assert expect.flag(np.True_, "True or False") is True
    assert expect.flag(False, "True or False") is False
    for given in (1, 0.0, "yes", None):
        assert message(expect.flag, given, "True or False") == f"Expected True or False, got {given!r}."


def test_what_is_wrong_is_listed():
    expect.none((), "a constant mass")
    assert message(
        expect.none, (x for x in ("q1", "q2")), "a constant mass", "one with {} in it", "Leave them out."
    ) == ("Expected a constant mass, got one with q1, q2 in it. Leave them out.")


def test_keywords_are_shown_by_name():
    for shown in (kn.trim, kn.assemble, kn.Equations.evaluate):
        assert {"q", "u", "states", "parameters", "inputs", "t"} <= inspect.signature(shown).parameters.keys()
    assert {"child", "coordinates", "speeds"} <= inspect.signature(kn.joints.pin).parameters.keys()


def test_an_unknown_keyword_is_refused():
    with pytest.raises(TypeError, match="got the keyword 'tolerence'"):
        kn.linearize(kn.derive(pendulum.system()), tolerence=1e-6)
