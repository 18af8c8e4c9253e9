# SPDX-License-Identifier: BSD-3-Clause
"""Pieces of HTML for notebooks: escaped text, formulas between dollar signs, tables."""

import html
import re
from collections.abc import Callable, Sequence
from typing import TypeVar

from kane.errors import cut

ROWS, NAMES = 30, 12
"""Rows of a table and names of a list beyond which they are cut."""

S = TypeVar("S")


def either(make: Callable[[S], str], source: S) -> str:
    """A part of a representation, or what went wrong in it: the other parts are shown all the same."""
    try:
        return make(source)
    except Exception as error:
        return paragraph(escaped(f"Not shown: {type(error).__name__}: {cut(error, 300)}"))


def escaped(text: object) -> str:
    """Text in which nothing is markup, nor a formula.

    A dollar sign or backslash gets an element of its own: MathJax and KaTeX look for delimiters within one text, and read them
    however they are escaped.
    """
    return re.sub(r"[$\\]", lambda sign: f"<span>{sign[0]}</span>", html.escape(str(text)))


def listed(names: Sequence[str]) -> str:
    """Names as text."""
    rest = len(names) - NAMES
    return escaped(", ".join(names[:NAMES])) + (f" and {rest} more" if rest > 0 else "")


def plain(latex: str) -> str:
    """LaTeX without < and >, on one line: some notebooks put it into the page as it is."""
    return " ".join(latex.replace("<", r"\lt ").replace(">", r"\gt ").split())


def math(latex: str) -> str:
    """A formula within text."""
    return f"${html.escape(plain(latex), quote=False)}$"


def display(latex: str) -> str:
    """A formula on lines of its own, which scroll where they are wide."""
    return '<div style="overflow-x:auto">' + math(r"\displaystyle " + latex) + "</div>"


def paragraph(content: str) -> str:
    """A paragraph of HTML."""
    return f"<p>{content}</p>"


def code(text: str) -> str:
    """Names and signatures; nothing where there are none."""
    return f"<code>{escaped(text)}</code>" if text else ""


def folded(summary: str, content: str) -> str:
    """HTML to unfold; nothing where there is none."""
    return f"<details><summary>{escaped(summary)}</summary>{content}</details>" if content else ""


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table: `head` is text, the cells are HTML. Nothing where there are no rows; columns that are empty are left out."""
    if not rows:
        return ""
    kept = [k for k in range(len(head)) if any(row[k] for row in rows)]
    lines = [_row("th", [escaped(head[k]) for k in kept])] if any(head) else []
    lines += [_row("td", [row[k] for k in kept]) for row in rows[:ROWS]]
    if len(rows) > ROWS:
        lines.append(_row("td", [f"… and {len(rows) - ROWS} more", *[""] * (len(kept) - 1)]))
    return f'<div style="overflow-x:auto"><table>{"".join(lines)}</table></div>'


def _row(tag: str, cells: Sequence[str]) -> str:
    # notebooks set tables flush right, by rules that only an attribute of the cell overrides
    return "<tr>" + "".join(f'<{tag} style="text-align:left">{c}</{tag}>' for c in cells) + "</tr>"
