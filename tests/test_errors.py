# SPDX-License-Identifier: BSD-3-Clause
"""What messages show of long things ends in "…"."""

import inspect
import pickle
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.errors import cut
from tests.systems.things import N, things


@given(st.text(alphabet="ab +-*/(^", max_size=120), st.integers(3, 80))
def test_a_cut_is_seen(text, most):
    shown = cut(text, most)
    assert len(shown) <= most
    assert shown == text or (shown.endswith(" …") and text.startswith(shown[:-2]))
    assert len(text) > most or shown == text


def test_no_message_is_cut_without_a_word():
    bare = re.compile(r"\{[^{}]+![rs]:\.\d+\}")
    for path in Path(kn.__file__).parent.rglob("*.py"):
        assert not bare.search(path.read_text(encoding="utf-8")), f"{path}: take cut(…) of kane.errors"


def test_in_a_message():
    long = sum(kn.coordinates("x1:40"), start=kn.Rational(0))
    with pytest.raises(kn.ExpressionError, match=r"got an expression: `==` on x1 .* … cannot be decided"):
        assert long == 1


def test_there_is_one_of_every_public_class():
    public = [c for n in kn.__all__ if inspect.isclass(c := getattr(kn, n)) and not issubclass(c, BaseException)]
    assert not [c for c in public if not any(isinstance(thing, c) for thing in things())]


def test_an_unknown_attribute_names_one_that_resembles_it():
    """Of every public class: one letter too many in each attribute, and a word that resembles none."""
    for thing in things():
        known = [n for n in dir(thing) if not n.startswith("_")]
        for name in known:
            with pytest.raises(kn.MissingAttributeError) as caught:
                getattr(thing, f"{name}z")
            assert re.search(rf"Did you mean .*\b{name}\b", str(caught.value)), (thing, name)
        with pytest.raises(AttributeError, match=f"It has {known[0]}"):
            _ = thing.qqqqqqqqqqqq
        assert not hasattr(thing, "_anything")
        assert getattr(thing, "anything", None) is None
    with pytest.raises(
        kn.MissingAttributeError, match=r"^Expected an attribute of Frame N, got 'zz'\. Did you mean z\?$"
    ):
        _ = N.zz


def test_what_an_attribute_raises_itself_is_its_own():
    class Odd(kn.Frame):
        @property
        def odd(self):
            return self.nothing.of_the_kind

    with pytest.raises(kn.MissingAttributeError, match="got 'nothing'"):
        _ = Odd("O").odd


def test_every_object_pickles_or_says_why_not():
    kept = {}
    for thing in things():
        try:
            again = pickle.loads(pickle.dumps(thing))
        except kn.KaneError as error:
            kept[type(thing)] = str(error)
            continue
        assert type(again) is type(thing)
        assert repr(again) == repr(thing)
    assert list(kept) == [kn.Compiled]
    assert "compiled.rhs" in kept[kn.Compiled]
