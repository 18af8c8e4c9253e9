# SPDX-License-Identifier: BSD-3-Clause
"""Long formulas in plain text broken over lines, at the outermost sums where there are any."""

import re

WIDTH = 110
"""Columns of a line of text."""

_BREAK = re.compile(r" (?=[+-] )")
_OPENING, _CLOSING = "([{", ")]}"


def depths(text: str) -> list[int]:
    """How many brackets are open at each character."""
    depths_at, depth = [], 0
    for c in text:
        depth -= c in _CLOSING
        depths_at.append(depth)
        depth += c in _OPENING
    return depths_at


def wrapped(text: str, *, indent: int = 0, hang: int | None = None, width: int = WIDTH) -> list[str]:
    """Lines of at most `width` columns, the first indented by `indent`, the others by `hang`, where the text allows it.

    Of the places at which a line can end the outermost is taken, and of those the last: first before a + or −, then at a space.
    """
    following = indent + 4 if hang is None else hang
    lines, lead, rest = [], indent, text
    while lead + len(rest) > width:
        at = _place(rest, width - lead, width // 3)
        if at is None:
            break
        lines.append(" " * lead + rest[:at].rstrip())
        rest, lead = rest[at:].lstrip(), following
    return [*lines, " " * lead + rest]


def _place(text: str, room: int, least: int) -> int | None:
    at = depths(text)
    for pattern in (_BREAK, re.compile(" ")):
        places = [m.start() for m in pattern.finditer(text) if min(least, room) <= m.start() <= room]
        if places:
            return min(places, key=lambda i: (at[i], -i))
    later = [m.start() for m in _BREAK.finditer(text) if m.start() > room]
    return later[0] if later else None
