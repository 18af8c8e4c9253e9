# SPDX-License-Identifier: BSD-3-Clause
"""A drawing as SVG: styles by class, colours as variables for light and dark themes, text with halos, a title and a description."""

import re
from collections.abc import Sequence
from html import escape

import numpy as np

from kane.numeric.arrays import Array
from kane.present.sketch.labels import LEADER, SMALL, Label, Span
from kane.present.sketch.paper import Paper, Stroke

LIGHT = {
    "card": "#ffffff", "ink": "#1b1d21", "body": "#dbe7f4", "shade": "#c3d5ea", "dark": "#aec5e0", "floor": "#eef0ea",
    "grey": "#5a5f66", "axis": "#0b57b0", "move": "#0d7333", "force": "#b23c06", "detail": "#7d95b0",
}  # fmt: skip
DARK = {
    "card": "#16181c", "ink": "#e9eaec", "body": "#2b3a4d", "shade": "#243246", "dark": "#1d2a3c", "floor": "#20231f",
    "grey": "#a8adb5", "axis": "#7fb6ff", "move": "#62d089", "force": "#ff9d6b", "detail": "#6f86a0",
}  # fmt: skip
"""Colours by role. Text has a contrast of at least 4.5 to the background and to bodies, in both themes."""
TEXT = {
    "coordinate": "move", "force-name": "force", "axis-name": "axis", "inertial-name": "grey", "point-name": "ink",
    "length": "ink", "name": "ink",
}  # fmt: skip
"""The colour of each kind of label."""
_STYLE = """
.kane-sketch .b,.kane-sketch path{stroke-linejoin:round;stroke-linecap:round;fill:none}
.kane-sketch .card{fill:var(--k-card);stroke:none}
.kane-sketch .body{fill:var(--k-body);stroke:var(--k-ink);stroke-width:1.5}
.kane-sketch .soft{stroke-dasharray:none;stroke-width:1.2}
.kane-sketch .glass{fill-opacity:.8}
.kane-sketch .shade{fill:var(--k-shade)}
.kane-sketch .dark{fill:var(--k-dark)}
.kane-sketch .plate{stroke-width:9;stroke:var(--k-ink)}
.kane-sketch .plate.face{stroke-width:6.2;stroke:var(--k-body);fill:var(--k-body)}
.kane-sketch .edge{stroke:var(--k-ink);stroke-width:1.5}
.kane-sketch .detail{stroke:var(--k-detail);stroke-width:1.1}
.kane-sketch .rod{stroke:var(--k-ink)}
.kane-sketch .wide{stroke-width:9}
.kane-sketch .thin{stroke-width:4.6}
.kane-sketch .wide.face{stroke:var(--k-body);stroke-width:6.2}
.kane-sketch .thin.face{stroke:var(--k-body);stroke-width:2.2}
.kane-sketch .wheel{fill:var(--k-ink);stroke:none}
.kane-sketch .floor{fill:var(--k-floor);stroke:none}
.kane-sketch .ground{stroke:var(--k-grey);stroke-width:1.6}
.kane-sketch .hatch{stroke:var(--k-grey);stroke-width:.9}
.kane-sketch .support{fill:var(--k-card);stroke:var(--k-grey);stroke-width:1.4}
.kane-sketch .pin{fill:var(--k-card);stroke:var(--k-ink);stroke-width:1.5}
.kane-sketch .point{fill:var(--k-ink);stroke:none}
.kane-sketch .spring{stroke:var(--k-ink);stroke-width:1.4}
.kane-sketch .piston{stroke-width:2.6}
.kane-sketch .rope{stroke:var(--k-ink);stroke-width:1.6}
.kane-sketch .base{stroke:var(--k-grey);stroke-width:1;stroke-dasharray:4 3}
.kane-sketch .ray,.kane-sketch .tick{stroke:var(--k-grey);stroke-width:.9}
.kane-sketch .move{stroke:var(--k-move);stroke-width:1.8}
.kane-sketch .move-head{fill:var(--k-move);stroke:none}
.kane-sketch .force{stroke:var(--k-force);stroke-width:2.8}
.kane-sketch .force.ring,.kane-sketch .force.thin{stroke-width:1.4}
.kane-sketch .force-head{fill:var(--k-force);stroke:none}
.kane-sketch .axis{stroke:var(--k-axis);stroke-width:1.8}
.kane-sketch .axis-head{fill:var(--k-axis);stroke:none}
.kane-sketch .inertial{stroke:var(--k-grey);stroke-width:1.6}
.kane-sketch .inertial-head{fill:var(--k-grey);stroke:none}
.kane-sketch .leader{stroke:var(--k-move);stroke-width:.8}
.kane-sketch text{stroke:var(--k-card);stroke-width:4px;stroke-linejoin:round;paint-order:stroke;text-anchor:middle}
.kane-sketch text{font-family:"STIX Two Text","Cambria","Times New Roman",Times,"Liberation Serif",serif}
"""


def style() -> str:
    """The style sheet, common to all sketches of a page."""

    def colours(table: dict[str, str]) -> str:
        return ".kane-sketch{" + "".join(f"--k-{k}:{v};" for k, v in table.items()) + "}"

    text = "".join(f".kane-sketch .{look}{{fill:var(--k-{colour})}}\n" for look, colour in TEXT.items())
    bold = ".kane-sketch .axis-name,.kane-sketch .inertial-name{font-weight:700}\n"
    dark = "@media (prefers-color-scheme:dark){" + colours(DARK) + "}\n"
    return f"{colours(LIGHT)}\n{dark}{_STYLE.lstrip()}{text}{bold}"


def looks(classes: str) -> dict[str, str]:
    """The properties of a style on light paper; rules with more classes are applied later."""
    have, found = {"b", *classes.split()}, {"fill": "black"}
    rules = []
    for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", _STYLE):
        for selector in selectors.split(","):
            needs = set(selector.split()[-1].split(".")) - {"", "path"}
            if needs <= have and "text" not in needs:
                rules.append((len(needs), body))
    for _, body in sorted(rules, key=lambda rule: rule[0]):
        found |= dict(part.split(":", 1) for part in body.split(";") if part)
    return {k: re.sub(r"var\(--k-(\w+)\)", lambda m: LIGHT[m[1]], v) for k, v in found.items()}


def render(paper: Paper, labels: Sequence[Label], title: str, description: str) -> str:
    """The SVG of a drawing with placed labels."""
    w, h = round(paper.width), round(paper.height)
    key = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") + f"-{w}"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="kane-sketch" width="{w}" height="{h}" viewBox="0 0 {w} {h}" '
        f'role="img" aria-labelledby="{key}-t {key}-d" style="max-width:100%;height:auto">',
        f'<title id="{key}-t">{escape(title)}</title>',
        f'<desc id="{key}-d">{escape(description)}</desc>',
        f"<style>{style()}</style>",
        f'<rect class="card" width="{w}" height="{h}" rx="6"/>',
    ]
    for s in sorted(paper.strokes, key=lambda s: s.order):
        rule = ' fill-rule="evenodd"' if s.holes else ""
        for look, parts in shapes_of(s):
            lines.append(f'<path class="{look}"{rule} d="{"".join(_path(line, closed) for line, closed in parts)}"/>')
    for b in labels:
        if b.reach >= LEADER:
            lines.append(f'<path class="leader" d="{_path(leader(b))}"/>')
    lines += map(_text, labels)
    return "\n".join([*lines, "</svg>\n"])


def leader(b: Label) -> Array:
    """The line from a label's anchor to the edge of its box."""
    a, (left, top, right, bottom) = np.array(b.anchor), b.box
    return np.array([a, np.clip(a, (left, top), (right, bottom))])


def shapes_of(s: Stroke) -> list[tuple[str, list[tuple[Array, bool]]]]:
    """The styles of a stroke with their lines, each closed or open; holes are further lines, an arrowhead a further shape."""
    if not s.head:
        return [(s.look, [(s.points, s.closed), *((h, True) for h in s.holes)])]
    tip, way = s.points[-1], _ending(s.points, s.head)
    side = np.array([-way[1], way[0]]) * 0.36 * s.head
    base = tip - way * s.head
    shaft = np.concatenate([_shortened(s.points, 0.7 * s.head), [tip - way * 0.7 * s.head]])
    first = s.look.split()[0]
    head = np.array([tip, base + side, base - side])
    return [(s.look, [(shaft, False)]), (f"{first}-head", [(head, True)])]


def _ending(line: Array, head: float) -> Array:
    """The direction at the end of a line, as a chord of the length of its arrowhead."""
    back = _shortened(line, head)[-1]
    way = line[-1] - back
    size = float(np.hypot(*way))
    return np.asarray(way / size) if size > 0 else np.array([1.0, 0.0])


def _shortened(line: Array, by: float) -> Array:
    """The points of a line farther than `by` from its end, measured along it, at least one."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    left = np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])
    kept = line[left >= by]
    return kept if len(kept) else line[:1]


def _path(points: Array, closed: bool = False) -> str:
    text = "".join(f"{'L' if k else 'M'}{_number(x)} {_number(y)}" for k, (x, y) in enumerate(points))
    return text + ("Z" if closed else "")


def _number(x: float) -> str:
    text = f"{x:.1f}"
    text = text.removesuffix(".0")
    return "0" if text == "-0" else text


def _text(b: Label) -> str:
    symbols = f' data-s="{escape(" ".join(b.symbols))}"' if b.symbols else ""
    y = b.y + 0.34 * b.size
    runs, shifted = [], 0.0
    for r in b.runs:
        runs.append(_run(r, b.size, shifted))
        shifted = SHIFT[r.shift] * b.size
    return f'<text class="{b.look}" x="{_number(b.x)}" y="{_number(y)}" font-size="{_number(b.size)}"{symbols}>{"".join(runs)}</text>'


SHIFT = {"": 0.0, "sub": 0.24, "sup": -0.36}
"""Downward shift of runs, relative to the letter size."""


def _run(r: Span, size: float, before: float) -> str:
    move = SHIFT[r.shift] * size - before
    attributes = f' dy="{_number(move)}"' if abs(move) > 0.04 else ""
    attributes += f' font-size="{_number(SMALL * size)}"' if r.shift else ""
    attributes += ' font-style="italic"' if r.slanted else ""
    return f"<tspan{attributes}>{escape(r.text)}</tspan>"
