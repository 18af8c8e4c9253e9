# SPDX-License-Identifier: BSD-3-Clause
"""HTML for notebooks: escaped text, tables, formulas between dollar signs with intermediates, or a sentence for long formulas."""

import html
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from kane.errors import cut
from kane.expr.build import add, mul
from kane.expr.evaluation import count_operations
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.space.rotation import Basis
from kane.space.vector import Dyadic, Vector
from kane.write.arrange import layout
from kane.write.display import Tree
from kane.write.latex import LATEX, latex_name, unit_vector_latex

ROWS, NAMES = 30, 12
"""Rows of a table and names of a list above which they are cut."""

S = TypeVar("S")


def either(make: Callable[[S], str], source: S) -> str:
    """A part of a representation, or the text of its error, so that the other parts are still shown."""
    try:
        return make(source)
    except Exception as error:
        return paragraph(escaped(f"Not shown: {type(error).__name__}: {cut(error, 300)}"))


def escaped(text: object) -> str:
    """Text without markup or formulas.

    Dollar signs and backslashes get elements of their own: MathJax and KaTeX look for delimiters within one text, and recognize
    them however they are escaped.
    """
    return re.sub(r"[$\\]", lambda sign: f"<span>{sign[0]}</span>", html.escape(str(text)))


def listed(names: Sequence[str]) -> str:
    """Names as text."""
    rest = len(names) - NAMES
    return escaped(", ".join(names[:NAMES])) + (f" and {rest} more" if rest > 0 else "")


def plain(latex: str) -> str:
    """LaTeX without < and >, on one line, as some notebooks insert it into the page unchanged."""
    return " ".join(latex.replace("<", r"\lt ").replace(">", r"\gt ").split())


def math(latex: str) -> str:
    """An inline formula."""
    return f"${html.escape(plain(latex), quote=False)}$"


def display(latex: str) -> str:
    """A displayed formula, which scrolls if it is wide."""
    return '<div style="overflow-x:auto">' + math(r"\displaystyle " + latex) + "</div>"


def paragraph(content: str) -> str:
    """A paragraph of HTML."""
    return f"<p>{content}</p>"


def code(text: str) -> str:
    """Names and signatures as code; "" for an empty text."""
    return f"<code>{escaped(text)}</code>" if text else ""


def folded(summary: str, content: str) -> str:
    """Collapsed HTML; "" for empty content."""
    return f"<details><summary>{escaped(summary)}</summary>{content}</details>" if content else ""


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table with text in `head` and HTML in cells, without empty columns; "" without rows."""
    if not rows:
        return ""
    kept = [k for k in range(len(head)) if any(row[k] for row in rows)]
    lines = [_row("th", [escaped(head[k]) for k in kept])] if any(head) else []
    lines += [_row("td", [row[k] for k in kept]) for row in rows[:ROWS]]
    if len(rows) > ROWS:
        lines.append(_row("td", [f"… and {len(rows) - ROWS} more", *[""] * (len(kept) - 1)]))
    return f'<div style="overflow-x:auto"><table>{"".join(lines)}</table></div>'


def _row(tag: str, cells: Sequence[str]) -> str:
    # style sheets of notebooks align cells right, which only a style attribute overrides
    return "<tr>" + "".join(f'<{tag} style="text-align:left">{c}</{tag}>' for c in cells) + "</tr>"


NAMED = 60
"""Number of operations above which all shared expressions get names."""
MOST = 2000
"""Number of operations above which nothing is typeset."""
TALL, WIDE = 20, 10
"""Numbers of rows and columns above which a matrix is not typeset; LaTeX's bmatrix has ten columns."""


@dataclass(frozen=True, slots=True)
class Typeset:
    """LaTeX without dollar signs, "" if it would be too long; and its number of operations."""

    latex: str
    operations: int

    def dollars(self, what: str) -> str:
        """The value of `_repr_latex_`; `what` begins the sentence that replaces a long formula."""
        if not self.latex:
            return f"{what} of {self.operations} operations, too long to typeset; print() shows it."
        return rf"$\displaystyle {plain(self.latex)}$"

    @property
    def cell(self) -> str:
        """HTML within a table, with a sentence for long formulas."""
        return math(self.latex) if self.latex and self.operations <= NAMED else f"{self.operations} operations"


def typeset(exprs: Sequence[Expr], body: Callable[[tuple[Tree, ...]], Sequence[str]], *, most: int = MOST) -> Typeset:
    """The lines that `body` makes of expression trees, with their shared intermediates below.

    Expressions with more than `most` operations in total are not processed.
    """
    operations = count_operations(exprs).total
    if operations > most:
        return Typeset("", operations)
    shown = layout(exprs, True if operations > NAMED else None)
    where = [f"{latex_name(name)} = {LATEX.write(tree)}" for name, tree in shown.intermediates]
    return Typeset(lines([*body(shown.trees), *([r"\text{where}", *where] if where else [])]), operations)


def lines(formulas: Sequence[str]) -> str:
    """Formulas one below the other, flush left; a single one is unchanged."""
    if len(formulas) == 1:
        return formulas[0]
    below = r" \\ ".join(f"& {f}" for f in formulas)
    return rf"\begin{{aligned}} {below} \end{{aligned}}"


def expression(expr: Expr) -> Typeset:
    """One expression."""
    return typeset((expr,), lambda trees: [LATEX.write(trees[0])])


def equations(named: Sequence[tuple[str, Expr]], *, most: int = MOST) -> Typeset:
    """Equations left = expression one below the other; `left` is LaTeX."""
    return typeset(
        [e for _, e in named],
        lambda trees: [f"{left} = {LATEX.write(t)}" for (left, _), t in zip(named, trees, strict=True)],
        most=most,
    )


def matrix(m: Matrix) -> Typeset:
    """A matrix; "" if it is too large."""
    if m.shape[0] > TALL or m.shape[1] > WIDE:
        return Typeset("", count_operations(m.entries).total)
    return typeset(m.entries, lambda trees: [brackets(trees, m.shape)])


def matrix_words(m: Matrix) -> str:
    """The size of a matrix that is not typeset, in words."""
    filled = sum(x is not ZERO for x in m.entries)
    return f"{m.shape[0]} × {m.shape[1]} matrix with {filled} entries that are not zero"


def brackets(trees: Sequence[Tree], shape: tuple[int, int]) -> str:
    """Expression trees in row-major order as a matrix."""
    rows, columns = shape
    if not rows or not columns:
        return rf"\left[\;\right]_{{{rows} \times {columns}}}"
    cells = [LATEX.write(t) for t in trees]
    body = r" \\[3pt] ".join(" & ".join(cells[i * columns : (i + 1) * columns]) for i in range(rows))
    return rf"\begin{{bmatrix}} {body} \end{{bmatrix}}"


def vector(v: Vector) -> Typeset:
    """A vector as written, along the axes of its frames."""
    terms = _terms(v)
    return _along([x for x, _, _ in terms], [unit_vector_latex(f.name, axis) for _, f, axis in terms])


def dyadic(d: Dyadic) -> Typeset:
    """A dyadic multiplied out, with a term for each pair of unit vectors."""
    terms: dict[tuple[Basis, str, Basis, str], Expr] = {}
    for a, b in d.dyads:
        for x, f, i in _terms(a):
            for y, g, k in _terms(b):
                terms[f, i, g, k] = add(terms.get((f, i, g, k), ZERO), mul(x, y))
    kept = {key: x for key, x in terms.items() if x is not ZERO}
    pairs = [f"{unit_vector_latex(f.name, i)} {unit_vector_latex(g.name, k)}" for f, i, g, k in kept]
    return _along(list(kept.values()), pairs)


def _terms(v: Vector) -> list[tuple[Expr, Basis, str]]:
    return [(x, f, axis) for f, t in v.parts for x, axis in zip(t, "xyz", strict=True) if x is not ZERO]


def _along(factors: Sequence[Expr], units: Sequence[str]) -> Typeset:
    return typeset(factors, lambda trees: [LATEX.along(trees, units)])
