# SPDX-License-Identifier: BSD-3-Clause
"""Calls, lists and long statements broken into lines."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

WIDTH = 118
"""The maximum line length."""
INDENT = "    "


def wrapped(text: str) -> Iterator[str]:
    """The lines of a comment."""
    line = ""
    for word in text.split():
        if line and len(line) + len(word) > WIDTH - 3:
            yield line
            line = ""
        line = f"{line} {word}".lstrip()
    yield line


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[()\[\]{}]| [+-] |, ?|[^"()\[\]{},]+?(?= [+-] |["()\[\]{},]|$)')
"""A string, a bracket, a sign or comma at which a line may end, or the text between."""


def folded(statement: str) -> str:
    """A statement broken at commas and signs in brackets into lines of at most `WIDTH` columns."""
    width = WIDTH - len(INDENT)
    if all(len(line) <= width for line in statement.split("\n")):
        return statement
    name, equals, value = statement.partition(" = ")
    if "(" not in value and equals:
        statement = f"{name} = ({value})"
    out, depth = [], 0
    for line in statement.split("\n"):
        margin = " " * (len(line) - len(line.lstrip()) + len(INDENT))
        chunks, depth = _chunks(line, depth)
        out.append(chunks[0])
        for chunk in chunks[1:]:
            if len(out[-1]) + len(chunk.rstrip()) > width:
                out[-1] = out[-1].rstrip()
                out.append(margin + chunk.lstrip())
            else:
                out[-1] += chunk
    return "\n".join(out)


def _chunks(line: str, depth: int) -> tuple[list[str], int]:
    """The parts between possible line ends, and the number of brackets open at the end."""
    chunks = [""]
    for token in _TOKEN.findall(line):
        if token in (" + ", " - ") and depth:
            chunks.append(token)
        else:
            chunks[-1] += token
            depth += (token in ("(", "[", "{")) - (token in (")", "]", "}"))
            if token.startswith(",") and depth:
                chunks.append("")
    return chunks, depth


def call(function: str, arguments: Sequence[str]) -> str:
    """A call in one line if it fits, else one argument per line."""
    line = f"{function}({', '.join(arguments)})"
    if len(line) + len(INDENT) <= WIDTH and "\n" not in line:
        return line
    inner = "".join(f"\n{_deeper(a)}," for a in arguments)
    return f"{function}({inner}\n)"


def listed(items: Sequence[str], brackets: str = "[]") -> str:
    """Items in brackets, in one line if they fit, else one per line."""
    line = ", ".join(items)
    comma = "," if brackets == "()" and len(items) == 1 else ""
    if len(line) + 2 * len(INDENT) + 16 <= WIDTH and "\n" not in line:
        return f"{brackets[0]}{line}{comma}{brackets[1]}"
    return f"{brackets[0]}{''.join(f'{chr(10)}{_deeper(x)},' for x in items)}\n{brackets[1]}"


def _deeper(text: str) -> str:
    return "\n".join(INDENT + line for line in text.split("\n"))
