# SPDX-License-Identifier: BSD-3-Clause
"""Placement of labels without overlap: each near its anchor, away from lines, within the drawing, for the width at which it is read.

Each label is tried around its anchor in 24 directions at increasing distances. Lines below a label and deviation from the desired
direction have a cost; overlap with another label, or with the edge, costs more than all else. Optional labels without room are
omitted; needed ones move away, with a leader line.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from kane.numeric.arrays import Array

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


_TURNS = np.arange(24) * (2 * np.pi / 24)
_REACH = (3.0, 7.0, 12.0, 18.0, 26.0, 40.0, 60.0, 85.0, 115.0)
_NEAR = 5
"""Number of distances at which optional labels are tried."""
_LINE, _LABEL, _EDGE, _TURN, _FAR = 2.2, 400.0, 2000.0, 3.6, 0.22
_SWEEPS = 6
_LEAVE = 26.0
"""Cost above which an optional label is omitted."""
GAP = 1.5
"""Least gap between boxes."""
LEADER = 34.0
"""Distance from which a label has a leader line."""


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """Runs of text with an anchor, the desired direction from it, and the symbols that it represents."""

    runs: tuple[Span, ...]
    anchor: tuple[float, float]
    toward: tuple[float, float]
    size: float
    look: str
    symbols: tuple[str, ...] = ()
    needed: bool = False
    clearance: float = 0.0
    x: float = 0.0
    y: float = 0.0
    reach: float = 0.0

    @property
    def wide(self) -> float:
        """The estimated width, for wide typefaces."""
        return width_of(self.runs, self.size)

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom of the box about the centre x, y."""
        tall = self.size * (1.1 + 0.25 * len({r.shift for r in self.runs if r.shift}))
        return self.x - self.wide / 2, self.y - tall / 2, self.x + self.wide / 2, self.y + tall / 2


def placed(labels: Sequence[Label], points: Array, weights: Array, width: float, height: float) -> list[Label]:
    """The labels in their places, without optional ones that have no room; `points` (n × 2) of lines cost their weights."""
    order = sorted(labels, key=lambda b: not b.needed)
    tried = [_tried(b, points, weights, width, height) for b in order]
    chosen = [int(np.argmin(cost)) for _, cost in tried]
    boxes = np.array([at[k] for (at, _), k in zip(tried, chosen, strict=True)]) if order else np.zeros((0, 4))
    alive = np.ones(len(order), dtype=bool)
    for sweep in range(_SWEEPS):
        for n, (at, cost) in enumerate(tried):
            others = boxes[alive & (np.arange(len(order)) != n)]
            total = cost + _LABEL * _overlaps(at, others).sum(axis=1)
            chosen[n] = int(np.argmin(total))
            boxes[n] = at[chosen[n]]
            if sweep >= _SWEEPS // 2 and not order[n].needed:
                alive[n] = total[chosen[n]] < _LEAVE
    _parted(order, tried, boxes, chosen, alive)
    kept = [n for n in range(len(order)) if alive[n]]
    return [_at(order[n], boxes[n], chosen[n]) for n in kept]


def _parted(
    order: list[Label], tried: list[tuple[Array, Array]], boxes: Array, chosen: list[int], alive: Array
) -> None:
    """Omit optional labels that still overlap, then move the needed ones until none overlaps."""
    for n in reversed(range(len(order))):
        others = boxes[alive & (np.arange(len(order)) != n)]
        if alive[n] and not order[n].needed and _overlaps(boxes[n : n + 1], others).any():
            alive[n] = False
    for _ in range(_SWEEPS):
        for n, (at, cost) in enumerate(tried):
            if alive[n] and order[n].needed:
                others = boxes[alive & (np.arange(len(order)) != n)]
                chosen[n] = int(np.argmin(cost + 1e6 * _overlaps(at, others).sum(axis=1)))
                boxes[n] = at[chosen[n]]


def _tried(label: Label, points: Array, weights: Array, width: float, height: float) -> tuple[Array, Array]:
    """Candidate boxes around the anchor, and the cost of each without other labels."""
    left, top, right, bottom = replace(label, x=0.0, y=0.0).box
    wide, tall = right - left, bottom - top
    reach = np.array(_REACH if label.needed else _REACH[:_NEAR]) + label.clearance
    turn, far = (m.ravel() for m in np.meshgrid(_TURNS, reach, indexing="ij"))
    way = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    # half the size of the box along the direction, so that it touches a circle about the anchor
    half = np.minimum(wide / 2 / np.maximum(np.abs(way[:, 0]), 1e-9), tall / 2 / np.maximum(np.abs(way[:, 1]), 1e-9))
    middle = np.array(label.anchor) + way * (far + half)[:, None]
    edge = np.array([wide, tall]) / 2
    boxes = np.concatenate([middle - edge, middle + edge], axis=1)
    wanted = np.array(label.toward, dtype=float)
    size = np.hypot(*wanted)
    aligned = way @ (wanted / size) if size > 0 else np.zeros(len(way))
    cost = _TURN * (1 - aligned) / 2 * 2 + _FAR * (far - label.clearance)
    out = (boxes[:, :2] < 3).any(axis=1) | (boxes[:, 2] > width - 3) | (boxes[:, 3] > height - 3)
    cost = cost + _EDGE * out
    for k in range(0, len(points), 4000):
        p, w = points[k : k + 4000], weights[k : k + 4000]
        inside = (p[None, :, 0] > boxes[:, None, 0] - 1) & (p[None, :, 0] < boxes[:, None, 2] + 1)
        inside &= (p[None, :, 1] > boxes[:, None, 1] - 1) & (p[None, :, 1] < boxes[:, None, 3] + 1)
        cost = cost + _LINE * np.einsum("ij,j->i", inside.astype(float), w)
    return boxes, cost


def _overlaps(boxes: Array, others: Array) -> Array:
    """Which boxes are nearer to which others than the gap."""
    a, b = boxes[:, None, :], others[None, :, :]
    return np.asarray(
        (a[..., 0] < b[..., 2] + GAP)
        & (a[..., 2] > b[..., 0] - GAP)
        & (a[..., 1] < b[..., 3] + GAP)
        & (a[..., 3] > b[..., 1] - GAP)
    )


def _at(label: Label, box: Array, choice: int) -> Label:
    x, y = float(box[0] + box[2]) / 2, float(box[1] + box[3]) / 2
    reaches = _REACH if label.needed else _REACH[:_NEAR]
    return replace(label, x=x, y=y, reach=reaches[choice % len(reaches)])
