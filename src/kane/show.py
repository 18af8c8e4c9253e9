# SPDX-License-Identifier: BSD-3-Clause
"""How things show themselves: tables by type, which those who write fill from above.

An expression knows its `str` and its picture in a notebook, but what writes them stands above it. So the things ask here, and the
writers enter themselves here, when they are first asked for: `kane.write.arrange`, and for notebooks `kane.present.notebook`.
"""

from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from typing import Any, Self, TypeVar

import numpy as np

V = TypeVar("V")
Writers = dict[type, Callable[[Any], str]]

TEXT: Writers = {}
"""What `str` gives, by type."""
LATEX: Writers = {}
"""What a notebook shows as a formula, by type."""
HTML: Writers = {}
"""What a notebook shows as a table, by type."""


def text(thing: object) -> str:
    """`thing` as a line of text."""
    if not TEXT:
        import_module("kane.write.arrange")
    return _writer(TEXT, thing)(thing)


def latex(thing: object) -> str | None:
    """What a notebook asks for as `_repr_latex_`: a formula between dollar signs, or a sentence."""
    return _quietly(LATEX, thing)


def html(thing: object) -> str | None:
    """What a notebook asks for as `_repr_html_`: nothing of what is a formula."""
    return None if LATEX.keys() & set(type(thing).__mro__) else _quietly(HTML, thing)


class Listing(tuple[V, ...]):
    """A tuple that a notebook shows as a table."""

    __slots__ = ()

    _repr_html_ = html


class Named(Listing[V]):
    """Expressions with what they are, `labels`: shown as equations, one a line."""

    labels: tuple[object, ...]

    def __new__(cls, values: Iterable[V], labels: Iterable[object] = ()) -> Self:
        """The values, each with its label."""
        made = super().__new__(cls, values)
        made.labels = tuple(labels)
        return made

    __repr__ = text
    _repr_latex_ = latex


def counts(**numbers: int) -> str:
    """How many of what, named by the plural: "1 body, 2 speeds"."""
    one = {name: name.removesuffix("ies") + "y" if name.endswith("ies") else name.removesuffix("s") for name in numbers}
    return ", ".join(f"{n} {one[name] if n == 1 else name}" for name, n in numbers.items())


def columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as text, its columns as wide as they need to be."""
    wide = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    return "\n".join("  ".join(x.ljust(w) for x, w in zip(row, wide, strict=True)).rstrip() for row in (head, *rows))


def _quietly(table: Writers, thing: object) -> str | None:
    """A representation that never raises nor warns: where it fails there is none, and the notebook shows `repr` instead."""
    try:
        import_module("kane.present.notebook")
        with np.errstate(all="ignore"):
            return _writer(table, thing)(thing)
    except Exception:
        return None


def _writer(table: Writers, thing: object) -> Callable[[Any], str]:
    return next(table[kind] for kind in type(thing).__mro__ if kind in table)
