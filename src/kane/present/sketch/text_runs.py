# SPDX-License-Identifier: BSD-3-Clause
"""Names of symbols, frames and points as runs of text, with subscripts, dots and hats, and estimates of their width."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

_LETTERS = (
    "alpha:α beta:β gamma:γ delta:δ epsilon:ε zeta:ζ eta:η theta:θ iota:ι kappa:κ lambda:λ mu:μ nu:ν xi:ξ pi:π rho:ρ sigma:σ tau:τ "
    "upsilon:υ phi:φ chi:χ psi:ψ omega:ω Gamma:Γ Delta:Δ Theta:Θ Lambda:Λ Xi:Ξ Pi:Π Sigma:Σ Upsilon:Υ Phi:Φ Psi:Ψ Omega:Ω "
    "varphi:φ vartheta:θ varepsilon:ε"
)
_GREEK = dict(pair.split(":") for pair in _LETTERS.split())
_DOTS = {1: "\u0307", 2: "\u0308", 3: "\u20db"}
_HAT = "\u0302"
SMALL = 0.72
"""Relative size of subscripts and superscripts."""
_EM = {
    " ": 0.34, ",": 0.34, ".": 0.34, "·": 0.36, "*": 0.52, "′": 0.3, "(": 0.42, ")": 0.42, "m": 0.97, "w": 0.88, "M": 1.05, "W": 1.1,
}  # fmt: skip
_THIN, _CAPITAL, _OTHER = 0.4, 0.8, 0.66


class Span(NamedTuple):
    """A run of text with its shift, "" on the line, "sub" or "sup"; single letters are slanted."""

    text: str
    shift: str = ""
    slanted: bool = True


def spans(name: str) -> tuple[Span, ...]:
    """The runs of a symbol's name: q1 with a numerical subscript, mu_k with a Greek letter, u1' with a dot."""
    stem = name.rstrip("'")
    dots = len(name) - len(stem)
    head, *lower = [part for part in stem.split("_") if part] or [stem]
    digits = re.fullmatch(r"(.*?[^0-9])([0-9]+)", head)
    inertia = re.fullmatch(r"([A-Z])([xyz]{1,2})", head)
    split = inertia or digits
    if split:
        head, lower = split[1], [split[2], *lower]
    first = _word(head, _DOTS.get(min(dots, 3), ""))
    below = ",".join(_below(p) for p in lower)
    return (first, Span(below, "sub", False)) if below else (first,)


def _word(word: str, mark: str = "") -> Span:
    letter = _GREEK.get(word, word)
    return Span(letter + mark, "", len(letter) == 1)


def _below(word: str) -> str:
    digits = re.fullmatch(r"(.*?[^0-9])([0-9]+)", word)
    return _GREEK.get(digits[1], digits[1]) + digits[2] if digits else _GREEK.get(word, word)


def point_name(name: str) -> tuple[Span, ...]:
    """The runs of a point's or frame's name: C* with a superscript star, C^ with a hat, words upright."""
    stem = name.rstrip("*^'")
    marks = name[len(stem) :]
    if " " in stem or not stem:
        return (Span(name, "", False),)
    first, *rest = spans(stem)
    if "^" in marks:
        first = first._replace(text=first.text + _HAT)
    raised = "*" * marks.count("*") + "′" * marks.count("'")
    return (first, *rest, *((Span(raised, "sup", False),) if raised else ()))


def unit_vector(frame: str, axis: str) -> tuple[Span, ...]:
    """b̂ with the axis as subscript for a frame B; for frames with longer names the name."""
    parts = re.fullmatch(r"([A-Za-z])([0-9]*)", frame)
    if parts:
        return Span(parts[1].lower() + _HAT), Span(parts[2] + axis, "sub", False)
    return Span("e" + _HAT), Span(f"{axis}, {frame}" if len(frame) < 12 else axis, "sub", False)


def product(text: str) -> tuple[Span, ...]:
    """A product such as c*x' as adjacent symbols."""
    known = re.compile(r"[A-Za-z][A-Za-z0-9_]*'*").fullmatch
    return _between(" ", [spans(f) if known(f) else (Span(f, "", False),) for f in text.split("*")])


def series(names: tuple[str, ...]) -> tuple[Span, ...]:
    """Several symbols, separated by commas."""
    return _between(", ", list(map(spans, names)))


def _between(gap: str, parts: Sequence[tuple[Span, ...]]) -> tuple[Span, ...]:
    first, *others = parts
    return (*first, *(run for part in others for run in (Span(gap, "", False), *part)))


def width_of(runs: tuple[Span, ...], size: float) -> float:
    """Estimated width of runs of text, in wide typefaces."""
    return sum(_letters(r.text) * size * (SMALL if r.shift else 1) for r in runs)


def _letters(text: str) -> float:
    return sum(_EM.get(c) or (0.0 if "\u0300" <= c <= "\u036f" or c == "\u20db" else _by_kind(c)) for c in text)


def _by_kind(c: str) -> float:
    return _THIN if c in "iljtfrI-" else _CAPITAL if c.isupper() else _OTHER
