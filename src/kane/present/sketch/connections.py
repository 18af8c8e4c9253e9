# SPDX-License-Identifier: BSD-3-Clause
"""Connections of bodies: springs and dampers, pins where links meet, supports and hatched ground."""

from __future__ import annotations

import numpy as np

from kane.numeric.arrays import Array
from kane.present.scene.records import Item, Posed, Scene
from kane.present.sketch.paper import BLOCK, GROUND, LOAD, POINT, Paper, across, ring, rod_ends

_HATCH = 7.0


def hatched(paper: Paper, a: Array, b: Array, down: Array) -> None:
    """Draw a line of ground, hatched below."""
    paper.draw([a, b], "ground", GROUND, 0.0, weight=0.8)
    size = float(np.hypot(*(b - a)))
    along = (b - a) / max(size, 1e-9)
    for t in np.arange(_HATCH / 2, size, _HATCH):
        top = a + along * t
        paper.draw([top, top + (down - along) * 0.7 * _HATCH], "hatch", GROUND, 0.0, weight=0.2)


def draw_spring(paper: Paper, item: Item, posed: Posed) -> None:
    """Draw a zigzag for a spring or a cylinder with piston for a damper, side by side if there are both."""
    a, b = paper.at(posed.positions[list(item.points[:2])]) + paper.lifts.get(item.name, np.zeros(2))
    size = float(np.hypot(*(b - a)))
    if size < 12:
        return
    along = (b - a) / size
    edge = along * BLOCK[0] * paper.unit
    a, b = (a + edge if item.points[0] in paper.blocks else a), (b - edge if item.points[1] in paper.blocks else b)
    side = across(along) * paper.sides.get(item.name, 0.0) * paper.unit
    lead = min(0.16 * size, 24.0)
    start, end = a + along * lead + side, b - along * lead + side
    joined = (
        [a, a + along * lead * 0.6, a + along * lead * 0.6 + side],
        [b - along * lead * 0.6 + side, b - along * lead * 0.6, b],
    )
    w = across(along) * 7 * paper.unit
    if item.kind == "damper":
        middle = (start + end) / 2
        paper.draw([*joined[0], middle], "spring", LOAD)
        paper.draw([middle + 0.7 * w, middle - 0.7 * w], "spring piston", LOAD)
        pot = [middle - along * 9 + w, middle + along * 9 + w, middle + along * 9 - w, middle - along * 9 - w]
        paper.draw(pot, "spring", LOAD)
        paper.draw([middle + along * 9, *joined[1]], "spring", LOAD)
    else:
        turns = max(5, min(9, int(size / 14)))
        zig = [start + (end - start) * ((k + 0.5) / (2 * turns)) + w * (1 if k % 2 else -1) for k in range(2 * turns)]
        paper.draw([*joined[0], start, *zig, end, *joined[1]], "spring", LOAD, weight=0.8)
    fixed = [n for n in (0, 1) if item.points[n] in paper.held]
    if paper.view.plane and len(fixed) == 1:
        at, out = (a, -along) if fixed[0] == 0 else (b, along)
        hatched(paper, at - 1.9 * w, at + 1.9 * w, out)


def arrange(paper: Paper, scene: Scene, posed: Posed) -> None:
    """Determine which springs are drawn beside others and above blocks, and which points are fixed."""
    paper.held = {m.at for m in scene.marks if m.fixed}
    paper.blocks = {
        i.at for i in scene.items if i.kind in ("block", "slider") and i.at is not None and paper.view.plane
    }
    blocks = {i.at: i.direction for i in scene.items if i.kind == "block" and i.direction is not None}
    pairs: dict[frozenset[int], list[str]] = {}
    for i in scene.items:
        if i.kind in ("spring", "damper"):
            pairs.setdefault(frozenset(i.points), []).append(i.name)
            for k in i.points:
                if k in blocks and paper.view.plane:
                    paper.lifts[i.name] = paper.pixel_direction(posed.directions[blocks[k]]) * BLOCK[1] * paper.unit
    for names in pairs.values():
        for n, name in enumerate(names):
            paper.sides[name] = (n - (len(names) - 1) / 2) * 22.0


def draw_pins(paper: Paper, scene: Scene, posed: Posed) -> None:
    """Draw a ring where two links meet, or where a rotation is about the end of one; with a support if it is fixed to the ground."""
    if not paper.view.plane:
        return
    ends = _ends(scene, posed)
    turns = [posed.positions[m.points[0]] for m in scene.movements if m.kind == "turn"]
    turns += [posed.positions[i.at] for i in scene.items if i.kind == "pin" and i.at is not None]
    fixed = [posed.positions[m.at] for m in scene.marks if m.fixed]
    balls = [posed.positions[i.at] for i in scene.items if i.kind == "particle"]
    least = 1e-7 * (float(np.ptp(posed.positions, axis=0).max()) or 1.0)
    seen: list[Array] = []
    for place in (*turns, *ends):

        def here(places: list[Array], place: Array = place) -> int:
            return sum(float(np.linalg.norm(p - place)) < least for p in places)

        if here(seen) or here(ends) < 2 - bool(here(turns)):
            continue
        seen.append(place)
        at = paper.at(place)
        if here(fixed):
            _support(paper, at)
        if not here(balls):
            paper.draw(ring(at, 3.6 * paper.unit, 16), "pin", POINT, -1.0, closed=True)


def _ends(scene: Scene, posed: Posed) -> list[Array]:
    result: list[Array] = []
    for i in scene.items:
        result += list(rod_ends(i, posed))
        if i.kind in ("link", "bar"):
            result += [posed.positions[k] for k in i.points]
        elif i.kind == "beam":
            result += [posed.positions[i.points[0]], posed.positions[i.points[-1]]]
    return result


def _support(paper: Paper, at: Array) -> None:
    w = 11.0 * paper.unit
    low = at[1] + 1.4 * w
    a, b, c, d = (np.array([at[0] + k * w, low]) for k in (-1.5, -0.8, 0.8, 1.5))
    paper.draw([at, b, c], "support", GROUND, 1.0, closed=True)
    hatched(paper, a, d, np.array([0.0, 1.0]))
