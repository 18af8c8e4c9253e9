# SPDX-License-Identifier: BSD-3-Clause
"""What messages show of long things ends in "…"."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.errors import cut


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
