# SPDX-License-Identifier: BSD-3-Clause
"""What slips are made of: one entry of a draft changed, left out or exchanged for another."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tests.systems.drafts import FORMULAS, Draft

Rng = np.random.Generator
Slip = Callable[[Draft, Rng], Draft | None]
"""The draft with the slip, None where there is no occasion for it."""


def one(rng: Rng, items: Any) -> Any:
    found = list(items)
    return found[int(rng.integers(len(found)))] if found else None


def with_entry(d: Draft, group: str, name: str, value: Any) -> Draft:
    """One entry changed or added."""
    return replace(d, **{group: {**getattr(d, group), name: value}})


def without(d: Draft, group: str, *names: str) -> Draft:
    return replace(d, **{group: {n: v for n, v in getattr(d, group).items() if n not in names}})


def formulas(d: Draft) -> Iterator[tuple[str, str, str]]:
    """(group, name, text) of every formula."""
    for group in FORMULAS:
        for name, value in getattr(d, group).items():
            yield group, name, value[1] if group == "speeds" else value


def rewritten(d: Draft, group: str, name: str, text: str) -> Draft:
    return with_entry(d, group, name, (d.speeds[name][0], text) if group == "speeds" else text)


def uses(text: str, names: Any) -> list[str]:
    """Which of these names stand in a formula."""
    return [n for n in names if re.search(rf"(?<![\w\".]){re.escape(n)}(?![\w\"=])", text)]


def swapped(text: str, a: str, b: str) -> str:
    marks = re.compile(rf"(?<![\w\".])({re.escape(a)}|{re.escape(b)})(?![\w\"=])")
    return marks.sub(lambda m: b if m[1] == a else a, text)
