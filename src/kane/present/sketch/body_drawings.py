# SPDX-License-Identifier: BSD-3-Clause
"""Bodies, ground and connections in a sketch: faces, links with pins, springs, blocks, hatched supports."""

from collections.abc import Callable, Mapping

import numpy as np

from kane.numeric.arrays import Array
from kane.present.scene.records import Item, Posed, Scene
from kane.present.sketch.camera import unit
from kane.present.sketch.outlines import hull, outline, semi_axes, within
from kane.present.sketch.paper import BLOCK, BODY, GROUND, LOAD, POINT, Paper, across, ring, rod_ends

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


_BALL = 8.0
_LOOKS = {"inertia": "body soft", "disk": "body glass", "ring": "body glass"}
_THIN = 5.0
"""Width in pixels below which a box is drawn as a rod."""


def draw_items(paper: Paper, scene: Scene, posed: Posed) -> None:
    """Draw all items, with pins and supports where links meet or are fixed."""
    arrange(paper, scene, posed)
    for item in scene.items:
        _DRAW.get(item.kind, _solid)(paper, item, posed)
    draw_pins(paper, scene, posed)


def _solid(paper: Paper, item: Item, posed: Posed) -> None:
    shape = outline(item, posed, paper.most)
    if shape is None:
        return
    cloud = paper.at(shape.cloud)
    paper.solids.setdefault(item.name, shape.cloud)
    span = float(np.ptp(cloud, axis=0).max())
    if span < 2 * _BALL * paper.unit and item.kind in ("inertia", "sphere"):
        _particle(paper, item, posed)
        return
    if shape.faces:
        _faces(paper, shape.faces, shape.cloud)
        return
    depth = paper.depth(shape.cloud)
    border = hull(cloud) if len(np.unique(np.round(cloud, 3), axis=0)) > 2 else cloud
    if _area(border) < 1.5 * span:
        ends = border[[int(np.argmin(border @ [1.0, 0.3])), int(np.argmax(border @ [1.0, 0.3]))]]
        _bar(paper, ends, depth)
        return
    if item.kind == "inertia" and _extended(paper, item, shape.cloud, posed):
        return
    look = _LOOKS.get(item.kind, "body")
    paper.draw(border, look, BODY, depth, closed=True, holes=tuple(paper.at(h) for h in shape.holes))
    for h in shape.holes:
        paper.draw(paper.at(h), "edge", BODY, depth + 1e-9, closed=True)
    for line in shape.lines:
        shown = _front(paper, line, shape.cloud) if item.kind in ("sphere", "ellipsoid", "inertia") else paper.at(line)
        if len(shown) > 1:
            paper.draw(shown, "detail", BODY, depth + 1e-9, weight=0.4)


def _extended(paper: Paper, item: Item, cloud: Array, posed: Posed) -> bool:
    """Whether a body is drawn as a bar beyond its mass centre: a uniform rod of its inertia, if a link leads to it."""
    link = paper.links.get(item.name)
    axes = semi_axes(*(float(posed.scalars[n]) for n in item.sizes.values()))
    if link is None or item.at is None or not (paper.view.plane or np.sort(axes)[1] < 0.35 * axes.max()):
        return False
    center = posed.positions[item.at]
    other = link[int(np.argmax(np.linalg.norm(link - center, axis=1)))]
    size = float(np.linalg.norm(center - other))
    reach = min(0.775 * float(axes.max()), 1.1 * size)
    if not reach > 0.3 * size:  # no link, or one that is long compared with the body
        return False
    ends = paper.at(np.array([other, center + (center - other) / size * reach]))
    _bar(paper, ends, paper.depth(cloud))
    return True


def _front(paper: Paper, line: Array, cloud: Array) -> Array:
    """The visible half of a great circle."""
    near = (line - cloud.mean(axis=0)) @ paper.view.toward > 0
    if near.all() or not near.any():
        return paper.at(line) if near.any() else np.zeros((0, 2))
    start = int(np.argmin(near))
    turned = np.roll(line[:-1], -start, axis=0)
    return np.asarray(paper.at(turned[np.roll(near[:-1], -start)]))


def _faces(paper: Paper, faces: tuple[Array, ...], cloud: Array) -> None:
    center = cloud.mean(axis=0)
    flat = paper.at(cloud)
    spans = np.sort(
        [np.linalg.norm(paper.at(f[1]) - paper.at(f[0])) for f in faces]
        + [np.linalg.norm(paper.at(f[2]) - paper.at(f[1])) for f in faces]
    )
    if spans[0] < _THIN and np.ptp(flat, axis=0).max() > 4 * _THIN:
        axis = np.linalg.svd(cloud - center)[2][0]
        reach = np.abs((cloud - center) @ axis).max()
        _bar(paper, paper.at(np.array([center - axis * reach, center + axis * reach])), paper.depth(cloud))
        return
    for k, face in enumerate(faces):
        out = face.mean(axis=0) - center
        facing = float(out @ paper.view.toward) / max(float(np.linalg.norm(out)), 1e-300)
        if facing > 1e-6:
            shade = "body" if facing > 0.75 or paper.view.plane else "body shade" if k % 4 < 2 else "body dark"
            paper.draw(paper.at(face), shade, BODY, paper.depth(cloud), closed=True)


def _area(border: Array) -> float:
    x, y = border[:, 0], border[:, 1]
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)


def _bar(paper: Paper, ends: Array, depth: float, size: str = "wide") -> None:
    """Draw a rod: its outline as a wide line, its face as a narrower line on it."""
    paper.draw(ends, f"rod {size}", BODY, depth, weight=1.5)
    paper.draw(ends, f"rod {size} face", BODY, depth + 1e-9, weight=0.0)


def _rod(paper: Paper, item: Item, posed: Posed) -> None:
    ends = rod_ends(item, posed)
    _bar(paper, paper.at(ends), paper.depth(ends))


def _link(paper: Paper, item: Item, posed: Posed) -> None:
    """Draw a bar through collinear points, or a plate."""
    places = posed.positions[list(item.points)]
    flat = paper.at(places)
    paper.links[item.name] = places
    center = places.mean(axis=0)
    _, sizes, axes = np.linalg.svd(places - center)
    along = (places - center) @ axes[0]
    if len(places) < 3 or sizes[1] < 0.02 * sizes[0]:
        ends = flat[[int(np.argmin(along)), int(np.argmax(along))]]
        _bar(paper, ends, paper.depth(places))
    elif _area(hull(flat)) > 1.0:
        paper.draw(hull(flat), "plate", BODY, paper.depth(places), closed=True)
        paper.draw(hull(flat), "plate face", BODY, paper.depth(places) + 1e-9, closed=True, weight=0.0)


def _line(size: str) -> Callable[[Paper, Item, Posed], None]:
    """A function that draws a bar along the points."""

    def drawn(paper: Paper, item: Item, posed: Posed) -> None:
        places = posed.positions[list(item.points)]
        _bar(paper, paper.at(places), paper.depth(places), size)

    return drawn


def _hull(paper: Paper, item: Item, posed: Posed) -> None:
    places = posed.positions[list(item.points)]
    flat = paper.at(places)
    if len(places) < 3:
        _bar(paper, flat, paper.depth(places))
        return
    paper.draw(hull(flat), "body", BODY, paper.depth(places), closed=True)


def _at(item: Item, posed: Posed) -> Array:
    """The position of an item."""
    assert item.at is not None
    return np.asarray(posed.positions[item.at])


def _along(item: Item, posed: Posed) -> Array:
    """The direction of an item."""
    assert item.direction is not None
    return np.asarray(posed.directions[item.direction])


def _rectangle(middle: Array, half: Array, other: Array) -> list[Array]:
    return [middle + s * half + t * other for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _particle(paper: Paper, item: Item, posed: Posed) -> None:
    place = _at(item, posed)
    paper.draw(ring(paper.at(place), _BALL * paper.unit, 24), "body ball", BODY, paper.depth(place) + 1e-6, closed=True)


def _block(paper: Paper, item: Item, posed: Posed) -> None:
    """Draw a block on the plane that it touches, or on the guide along which it slides."""
    place, seen = _at(item, posed), paper.pixel_direction(_along(item, posed))
    if np.hypot(*seen) < 0.3 or not paper.view.plane:
        _particle(paper, item, posed)
        return
    a, b = np.array(BLOCK) * paper.unit
    along = seen / np.hypot(*seen)
    middle = paper.at(place)
    if item.kind == "block":  # the position is the contact point, the direction the normal
        along, middle = across(along), middle + along * b
    side = across(along)
    paper.draw(_rectangle(middle, a * along, b * side), "body", BODY, paper.depth(place), closed=True)
    if item.kind == "slider":
        down = side if side[1] > 0 else -side
        hatched(paper, middle + down * (b + 1) - along * 2.2 * a, middle + down * (b + 1) + along * 2.2 * a, down)


def _ball(paper: Paper, item: Item, posed: Posed) -> None:
    """Draw a ball that rests on the plane that it touches."""
    up = paper.pixel_direction(_along(item, posed))
    radius = 1.4 * _BALL * paper.unit
    middle = paper.at(_at(item, posed)) + up * radius
    paper.draw(ring(middle, radius, 32), "body", BODY, 0.0, closed=True)


def _wheel(paper: Paper, item: Item, posed: Posed) -> None:
    """Draw a wheel or blade that does not slip along a direction, seen from above."""
    side = paper.pixel_direction(_along(item, posed))
    if not paper.view.plane or np.hypot(*side) < 0.5:
        return
    corners = _rectangle(paper.at(_at(item, posed)), 13.0 * paper.unit * across(side), 4.0 * paper.unit * side)
    paper.draw(corners, "wheel", BODY, 1e9, closed=True)


def _plane(paper: Paper, item: Item, posed: Posed) -> None:
    place, normal = _at(item, posed), unit(_along(item, posed))
    seen = paper.pixel_direction(normal)
    places = posed.positions - np.outer((posed.positions - place) @ normal, normal)  # projected onto the plane
    if paper.view.plane:
        if np.hypot(*seen) < 0.5:
            return  # seen from above, the paper is the ground
        along, down = across(seen), -seen
        middle = paper.at(place)
        reach = (paper.at(places) - middle) @ along
        pad = 34 * paper.unit
        a, b = middle + along * (reach.min() - pad), middle + along * (reach.max() + pad)
        hatched(paper, _inside(paper, a), _inside(paper, b), down)
        return
    x = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    x /= np.linalg.norm(x)
    y = np.cross(normal, x)
    p, q = (places - place) @ x, (places - place) @ y
    pad = 0.18 * max(np.ptp(p), np.ptp(q), 1e-300) + 14 / paper.scale
    middle = place + (p.min() + p.max()) / 2 * x + (q.min() + q.max()) / 2 * y
    floor = _rectangle(middle, (np.ptp(p) / 2 + pad) * x, (np.ptp(q) / 2 + pad) * y)
    paper.draw(paper.at(np.array(floor)), "floor", GROUND, -1e9, closed=True, weight=0.3)


def _inside(paper: Paper, p: Array) -> Array:
    return np.clip(p, (6.0), (paper.width - 6.0, paper.height - 6.0))


def _rope(paper: Paper, item: Item, posed: Posed) -> None:
    paper.draw(paper.at(posed.positions[list(item.points)]), "rope", LOAD)


def _arm(paper: Paper, item: Item, posed: Posed) -> None:
    """Draw a line from the nearest point of a solid to a point outside of it."""
    cloud, end = paper.solids.get(item.name), posed.positions[item.points[1]]
    if cloud is None:
        return
    start = cloud[int(np.argmin(np.linalg.norm(cloud - end, axis=1)))]
    ends = paper.at(np.array([start, end]))
    if np.hypot(*(ends[1] - ends[0])) > 7 and not within(ends[1], hull(paper.at(cloud))):
        _bar(paper, ends, paper.depth(end), "thin")


_DRAW: Mapping[str, Callable[[Paper, Item, Posed], None]] = {
    "rod": _rod,
    "link": _link,
    "bar": _line("thin"),
    "arm": _arm,
    "hull": _hull,
    "beam": _line("wide"),
    "particle": _particle,
    "block": _block,
    "ball": _ball,
    "slider": _block,
    "wheel": _wheel,
    "plane": _plane,
    "spring": draw_spring,
    "damper": draw_spring,
    "rope": _rope,
    "pin": lambda *_: None,
}
"""The drawing function of each kind of item that is not a solid."""
