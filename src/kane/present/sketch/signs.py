# SPDX-License-Identifier: BSD-3-Clause
"""Coordinates as arcs and arrows, axes, forces and points, with their labels."""

from collections.abc import Callable, Mapping

import numpy as np

from kane.numeric.arrays import Array
from kane.present.scene.records import Action, Movement, Posed, Scene, Triad
from kane.present.sketch.camera import unit
from kane.present.sketch.labels import Span, point_name, product, series, spans, unit_vector
from kane.present.sketch.outlines import within
from kane.present.sketch.paper import AXES, FORCE, MOVE, POINT, REFERENCE, Paper, across, ring, spaced

_AXIS, _FORCE, _HEAD = 42.0, 46.0, 8.0
_ARC, _MORE = 40.0, 14.0
_ASIDE = 15.0
_LENGTHS = 5
"""Largest number of named lengths."""
_ROUND = np.radians(250.0)


def draw_signs(paper: Paper, scene: Scene, posed: Posed) -> None:
    """Draw all of them."""
    middle = np.mean(
        [s.points.mean(axis=0) for s in paper.strokes if s.look.startswith(("body", "rod"))] or [paper.shift], axis=0
    )
    shown: list[Array] = []
    for t in scene.triads:
        axes = np.vstack([posed.rotations[t.frame], posed.positions[t.at] * paper.scale])
        beside = [k for k, other in enumerate(shown) if np.abs(axes[3] - other[3]).max() < 6]
        same = any(np.abs(axes - shown[k]).max() < 1e-6 for k in beside)
        if not same and not any(k > 0 for k in beside):  # at each place, the inertial axes and those of one body
            shown.append(axes)
            _triad(paper, t, posed, middle)
    used: list[tuple[Array, Array]] = []
    for m in scene.movements:
        if m.kind == "shift":
            _shift(paper, m, posed, middle, used)
        else:
            _MOVES[m.kind](paper, m, posed, middle)
    for a in (a for a in scene.actions if a.kind in _ACTIONS):
        _ACTIONS[a.kind](paper, a, posed, middle)
    _points(paper, scene, posed, middle)
    if len(scene.lengths) <= _LENGTHS:
        _lengths(paper, scene, posed, middle)


def _lengths(paper: Paper, scene: Scene, posed: Posed, middle: Array) -> None:
    """Draw the names of lengths beside rods of this length, and on separate lines within solids."""
    rods = [s.points for s in paper.strokes if s.look.startswith("rod") and "face" in s.look]
    for name, i, k in scene.lengths:
        a, b = paper.at(posed.positions[[i, k]])
        if np.hypot(*(b - a)) <= 30:
            continue
        half = (a + b) / 2
        if not any(_beside(half, line) for line in rods):
            if not any(within(half, s.points) for s in paper.strokes if s.closed and s.look.startswith("body")):
                continue
            paper.draw([a, b], "ray", REFERENCE, weight=0.5)
        paper.label(
            spans(name), half, _away(across(b - a), half - middle), "length", size=14.5, symbols=[name], clearance=3
        )


def _beside(p: Array, line: Array) -> bool:
    return bool(np.hypot(*(spaced(line, 3.0) - p).T).min() < 4)


def _away(side: Array, out: Array) -> Array:
    return side if side @ out >= 0 else -side


# Coordinates ---------------------------------------------------------------------------------------------------------


def _turned(d: Array, axis: Array, angles: Array) -> Array:
    """A direction rotated about a unit axis by angles."""
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return np.asarray(d * c + np.cross(axis, d) * s + axis * (axis @ d) * (1 - c))


def _turn(paper: Paper, m: Movement, posed: Posed, middle: Array) -> None:
    if m.axis is None or m.direction is None or m.sweep is None:
        return
    axis, end = unit(posed.directions[m.axis]), unit(posed.directions[m.direction])
    sweep = float(posed.scalars[m.sweep])
    center = paper.at(posed.positions[m.points[0]])
    radius = (_ARC + _MORE * paper.ring(center)) * paper.unit
    radius = max(radius, min(0.42 * _reach(paper, posed.directions[m.direction]), 1.7 * _ARC * paper.unit))
    line = _turned(end, axis, np.linspace(-sweep, 0.0, 33))
    flat = paper.view.flat(line) * (radius, -radius) + center
    for look, ray in (("base", flat[0]), ("ray", flat[-1])):
        paper.draw([center, center + 1.22 * (ray - center)], look, REFERENCE, weight=0.5)
    _arrow(paper, flat, "move", MOVE)
    top = flat[len(flat) // 2]
    _coordinate(paper, m, spans(m.symbols[0]), top, top - center)


def _coordinate(
    paper: Paper,
    m: Movement,
    runs: tuple[Span, ...],
    at: Array,
    toward: Array,
    size: float = 17,
    clearance: float = 0.0,
) -> None:
    """Draw the label of a movement."""
    paper.label(runs, at, toward, "coordinate", size=size, symbols=m.symbols, needed=True, clearance=clearance)


def _reach(paper: Paper, way: Array) -> float:
    """The length of a rotating vector in pixels; 0 for an axis, of unit length."""
    size = float(np.linalg.norm(way))
    return size * paper.scale if abs(size - 1) > 1e-9 else 0.0


def _arrow(paper: Paper, line: Array, look: str, layer: int, head: float = _HEAD) -> None:
    long = float(np.hypot(*np.diff(line, axis=0).T).sum())
    paper.draw(line, look, layer, head=min(head * paper.unit, 0.6 * long), weight=1.0)


def _shift(paper: Paper, m: Movement, posed: Posed, middle: Array, used: list[tuple[Array, Array]]) -> None:
    way = paper.at(posed.positions[list(m.points)])
    long = float(np.hypot(*(way[-1] - way[0])))
    if long < 3:  # normal to the drawing, or zero
        _coordinate(paper, m, spans(m.symbols[0]), way[-1], way[-1] - middle)
        return
    if len(way) > 2:
        _arrow(paper, way, "move", MOVE)
        side = across(way[-1] - way[0]) / long
        top = way[len(way) // 2]
    else:
        along = (way[1] - way[0]) / long
        side = _away(across(along), (way[0] + way[1]) / 2 - middle)
        level = _ASIDE * paper.unit
        while any(_meet(way + side * level, old) for old in used):
            level += _ASIDE * paper.unit
        line = way + side * level
        used.append((line[0], line[1]))
        paper.draw(way, "base", REFERENCE, weight=0.5)
        for p in way:
            paper.draw([p, p + side * (level + 4)], "tick", REFERENCE, weight=0.3)
        _arrow(paper, line, "move", MOVE)
        top = (line[0] + line[1]) / 2
    _coordinate(paper, m, spans(m.symbols[0]), top, side)


def _meet(line: Array, old: tuple[Array, Array]) -> bool:
    """Whether two segments overlap."""
    a, b = old
    along = (b - a) / max(float(np.hypot(*(b - a))), 1e-9)
    off, at = (line - a) @ across(along), np.sort((line - a) @ along)
    return bool(np.abs(off).max() < 9 and at[0] < float(np.hypot(*(b - a))) + 2 and at[1] > -2)


def _attitude(paper: Paper, m: Movement, posed: Posed, middle: Array) -> None:
    axis = unit(posed.directions[m.axis]) if m.axis is not None else paper.view.toward
    center = paper.at(posed.positions[m.points[0]])
    flat = _circle(paper, axis, center, (_ARC + 8 + _MORE * paper.ring(center)) * paper.unit)
    _arrow(paper, flat, "move", MOVE)
    top = flat[len(flat) // 2]
    _coordinate(paper, m, series(m.symbols), top, top - center, 16)


def _circle(paper: Paper, axis: Array, center: Array, radius: float) -> Array:
    """An arc about an axis as seen, with its gap at the upper left."""
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    x /= np.linalg.norm(x)
    whole = _turned(x, axis, np.linspace(0, 2 * np.pi, 73))
    flat = paper.view.flat(whole) * (radius, -radius)
    start = int(np.argmax(flat[:-1] @ (-1.0, -1.0))) + 5
    picked = (start + np.arange(0, round(72 * _ROUND / (2 * np.pi)))) % 72
    return np.asarray(flat[picked] + center)


def _deflection(paper: Paper, m: Movement, posed: Posed, middle: Array) -> None:
    places = paper.at(posed.positions[list(m.points)])
    pairs = [(places[k], places[k + 1]) for k in range(0, len(places), 2)]
    start, end = max(pairs, key=lambda p: float(np.hypot(*(p[1] - p[0]))))
    root = places[2] * 2 - places[0]
    paper.draw([root, places[0]], "base", REFERENCE, weight=0.5)
    side = np.array([0.0, -1.0])
    if np.hypot(*(end - start)) > 4:
        side = end - start
        _arrow(paper, np.array([start, end]), "move", MOVE)
    _coordinate(paper, m, _modes(m), end, side, 16, clearance=6)


def _modes(m: Movement) -> tuple[Span, ...]:
    """v1_rod, v2_rod as v₁, v₂ if the beam's name is a common subscript."""
    tail = f"_{m.frame}"
    if len(m.symbols) > 1 and all(s.endswith(tail) for s in m.symbols):
        first = tuple(s.removesuffix(tail) for s in m.symbols[:-1])
        return (*series(first), Span(", ", "", False), *spans(m.symbols[-1]))
    return series(m.symbols)


def _unplaced(paper: Paper, m: Movement, posed: Posed, middle: Array) -> None:
    _coordinate(paper, m, series(m.symbols), np.array([24.0, paper.height - 18.0]), np.array([1.0, 0.0]), 16)


_MOVES: Mapping[str, Callable[[Paper, Movement, Posed, Array], None]] = {
    "turn": _turn,
    "attitude": _attitude,
    "deflection": _deflection,
    "none": _unplaced,
}

# Axes, loads, points -------------------------------------------------------------------------------------------------


def _triad(paper: Paper, t: Triad, posed: Posed, middle: Array) -> None:
    at, look = paper.at(posed.positions[t.at]), "inertial" if t.inertial else "axis"
    size = _AXIS * paper.unit * (0.9 if t.inertial else 1.0)
    for letter, d in zip("xyz", posed.rotations[t.frame].T, strict=True):
        way = paper.pixel_direction(d)
        if np.hypot(*way) < 0.12:
            continue
        end = at + way * size
        _arrow(paper, np.array([at, end]), look, AXES, 7.0)
        paper.label(unit_vector(t.name, letter), end, way, f"{look}-name", size=14.5)


def _force(paper: Paper, a: Action, posed: Posed, middle: Array) -> None:
    way, at = paper.pixel_direction(posed.directions[a.direction]), paper.at(posed.positions[a.at])
    if np.hypot(*way) < 0.2:
        _name(paper, a, at, at - middle)
        return
    end = at + way / max(float(np.hypot(*way)), 0.6) * _FORCE * paper.unit
    _arrow(paper, np.array([at, end]), "force", FORCE, 10.0)
    _name(paper, a, end, way)


def _torque(paper: Paper, a: Action, posed: Posed, middle: Array) -> None:
    axis, center = unit(posed.directions[a.direction]), paper.at(posed.positions[a.at])
    about = axis if np.linalg.norm(axis) else paper.view.toward
    flat = _circle(paper, about, center, (24 + 7 * paper.ring(center)) * paper.unit)
    _arrow(paper, flat, "force", FORCE, 9.0)
    _name(paper, a, flat[-1], flat[-1] - center)


def _gravity(paper: Paper, a: Action, posed: Posed, middle: Array) -> None:
    """Draw the arrow of gravity in the corner with the most room."""
    way = paper.pixel_direction(posed.directions[a.direction])
    points, _ = paper.obstacles()
    long = 40 * paper.unit
    corners = [np.array([x, y]) for x in (paper.width - 30, 30) for y in (34.0, paper.height - 34)]
    free = [float(np.hypot(*(points - c).T).min(initial=1e3)) for c in corners]
    at = corners[int(np.argmax(np.round(free)))]
    if np.hypot(*way) < 0.2:
        paper.draw(ring(at, 7, 24), "force ring", FORCE, closed=True)
        for s in (1, -1):
            paper.draw([at + 4.9 * np.array([-1, s]), at + 4.9 * np.array([1, -s])], "force thin", FORCE)
        _name(paper, a, at, np.array([-1.0, 0.0]), 8)
        return
    way = way / np.hypot(*way)
    start = at - way * long / 2
    _arrow(paper, np.array([start, start + way * long]), "force", FORCE, 10.0)
    inner = np.array([paper.width / 2, paper.height / 2]) - at
    _name(paper, a, at, _away(across(way), inner), 4)


def _name(paper: Paper, a: Action, at: Array, toward: Array, clearance: float = 0.0) -> None:
    """Draw the name of an arrow, which may be a symbol."""
    known = all(c.isalnum() or c in "_*'" for c in a.label)
    runs = product(a.label) if known else (Span(a.label, "", False),)
    paper.label(runs, at, toward, "force-name", size=15, symbols=(a.label,) if known else (), clearance=clearance)


_ACTIONS: Mapping[str, Callable[[Paper, Action, Posed, Array], None]] = {
    "force": _force,
    "torque": _torque,
    "gravity": _gravity,
}


def _points(paper: Paper, scene: Scene, posed: Posed, middle: Array) -> None:
    seen: list[Array] = []
    for m in scene.marks:
        at = paper.at(posed.positions[m.at])
        if any(np.hypot(*(at - s)) < 2 for s in seen):
            continue
        seen.append(at)
        paper.draw(ring(at, 2.4 * paper.unit, 12), "point", POINT, closed=True, weight=2.0)
        paper.label(point_name(m.name), at, at - middle, "point-name", size=14.5, clearance=2)
