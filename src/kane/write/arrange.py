# SPDX-License-Identifier: BSD-3-Clause
"""How an expression is laid out for people: from the binary graph to the trees that text and LaTeX print.

Sums and products become flat, equal factors powers, constants one leading coefficient, sin/cos of one angle
its tangent. The order follows from names, not from memory addresses or the order of construction. Long
expressions get named intermediates Z1, Z2, … in the order of evaluation.

Nothing here recurses: depth costs nothing.

All notations share brackets where they are needed, signs, sums and measure numbers along unit vectors;
plain text, a line each, is one.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar, TypeAlias

from kane import show
from kane.expr.node import Expr, Number, as_expr, constant_value, number_of, postorder
from kane.expr.numbers import Surd, times
from kane.expr.ops import ADD, CONST, COS, DIV, LESS, MUL, NEG, PI, POW, SIN, SUB, TAN
from kane.expr.regular import unguarded
from kane.expr.symbols import Symbol
from kane.write import display
from kane.write.display import call

LONG = 40
"""Expressions with more operations than this, written out, get named intermediates."""
WORTH = 3
"""Operations that a shared subexpression needs to be worth a name."""
AGAIN = 12
"""Operations from which what has a name in a long expression is not written out in a short one beside it."""
DEEP = 25
"""Nesting beyond which a subexpression gets a name even where it is used once."""


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Display trees: the intermediates in the order of evaluation, then the expressions asked for."""

    intermediates: tuple[tuple[str, display.Tree], ...]
    trees: tuple[display.Tree, ...]


def layout(roots: Sequence[Expr], named: bool | None = None) -> Layout:
    """Display trees of `roots`, with one list of intermediates.

    `named` None gives names inside long or deep expressions, True where anything is shared, False nowhere.
    """
    roots = unguarded(roots)
    chosen = set(roots if named else (r for r in roots if named is None and _is_long(r)))
    names = _choose_names(list(dict.fromkeys(r for r in roots if r in chosen)), roots) if chosen else {}
    chosen |= {r for r in roots if names and r not in chosen and _repeats(r, names)}
    inside: _Forms = {n: (False, display.name_tree(text)) for n, text in names.items()}
    bodies = []
    for node, text in names.items():
        shown = inside.pop(node)
        bodies.append((text, display.unsigned(_build(node, inside, names))))
        inside[node] = shown
    in_full: _Forms = {}
    trees = tuple(display.unsigned(_build(r, inside, names) if r in chosen else _build(r, in_full, {})) for r in roots)
    return Layout(tuple(bodies), trees)


# What gets a name --------------------------------------------------------------------------------------

_FLAT = dict.fromkeys((ADD, SUB), (ADD, SUB)) | dict.fromkeys((MUL, DIV), (MUL, DIV))
"""The operations that are flattened into each operation."""
_SUMS = {ADD, SUB, NEG}
_SATURATED = 10_000


def _level(node: Expr, levels: Mapping[Expr, int]) -> int:
    """Nesting of the display: sums in sums and products in products are flat, signs cost nothing."""
    if not node.args:
        return 0
    if node.op is NEG:
        return levels[node.args[0]]
    family = _FLAT.get(node.op, ()) if not _is_square(node) else ()  # else exponents grow as 2^2^…
    return max(levels[a] + (a.op not in family and bool(a.args)) for a in node.args)


def _is_square(node: Expr) -> bool:
    return node.op is MUL and node.args[0] is node.args[1]


def _is_tangent(node: Expr) -> bool:
    if node.op is not DIV:
        return False
    above, below = node.args
    return above.op is SIN and below.op is COS and above.args[0] is below.args[0]


def _written(node: Expr) -> Sequence[Expr]:
    """The arguments as often as they are printed."""
    return node.args[:1] if _is_square(node) else node.args


def _cost(node: Expr, cost: Mapping[Expr, int]) -> int:
    """Operations that are printed; sin q/cos q is printed as tan q."""
    if _is_tangent(node):
        return 1 + cost[node.args[0].args[0]]
    return node.op.cost + sum(cost[a] for a in _written(node))


def _is_long(root: Expr) -> bool:
    cost: dict[Expr, int] = {}
    levels: dict[Expr, int] = {}
    for node in postorder((root,)):
        cost[node] = min(_cost(node, cost), _SATURATED)
        levels[node] = _level(node, levels)
    return cost[root] > LONG or levels[root] > DEEP


def _repeats(root: Expr, names: Mapping[Expr, str]) -> bool:
    """Whether a short expression writes out much that has a name."""
    cost: dict[Expr, int] = {}
    for node in postorder((root,)):
        cost[node] = _cost(node, cost)
        if node in names and cost[node] >= AGAIN:
            return True
    return False


def _choose_names(roots: Sequence[Expr], shown: Iterable[Expr]) -> dict[Expr, str]:
    """Names by node, in the order of evaluation."""
    order = postorder(roots)
    uses = dict.fromkeys(order, 0)
    for r in roots:
        uses[r] += 1
    for node in reversed(order):
        transparent = node.op is NEG or node.op is LESS  # never named itself: its argument is met at each use
        for a in _written(node):
            uses[a] += uses[node] if transparent else 1
    taken = {n.name for n in postorder(shown) if isinstance(n, Symbol)}
    cost: dict[Expr, int] = {}
    levels: dict[Expr, int] = {}
    names: dict[Expr, str] = {}
    number = 0
    final = set(roots)
    for node in order:
        cost[node] = _cost(node, cost)
        levels[node] = _level(node, levels)
        if not node.args or node.op is NEG or node.op is LESS:
            continue
        shared = uses[node] > 1 and cost[node] >= WORTH
        deep = levels[node] >= DEEP and not (node in final and uses[node] == 1)
        if shared or deep:
            number += 1
            while f"Z{number}" in taken:
                number += 1
            names[node] = f"Z{number}"
            cost[node] = levels[node] = 0
    return names


# From the graph to trees -------------------------------------------------------------------------------

_Forms: TypeAlias = dict[Expr, display.Signed]
_Plan: TypeAlias = tuple[Sequence[Expr], Callable[[_Forms], display.Signed]]


def _build(root: Expr, forms: _Forms, stops: Mapping[Expr, str]) -> display.Signed:
    """The form of `root`; `forms` holds those of the named nodes `stops` and gathers the others."""
    plans: dict[Expr, _Plan] = {}

    def parts(node: Expr) -> Sequence[Expr]:
        if node in forms:
            return ()
        if node not in plans:
            plans[node] = _plan(node, stops)
        return plans[node][0]

    for node in _ordered(root, parts):
        if node not in forms:
            forms[node] = plans[node][1](forms)
    return forms[root]


def _ordered(root: Expr, parts: Callable[[Expr], Sequence[Expr]]) -> list[Expr]:
    """`root` and everything below it, each node once, its `parts` before it."""
    order: dict[Expr, None] = {}
    stack = [root]
    while stack:
        waiting = [a for a in parts(stack[-1]) if a not in order]
        if waiting:
            stack.extend(reversed(waiting))
        else:
            order[stack.pop()] = None
    return list(order)


def _plan(node: Expr, stops: Mapping[Expr, str]) -> _Plan:
    op = node.op
    if isinstance(node, Symbol):
        leaf: display.Signed = (False, display.name_tree(node.name, node))
        return (), lambda forms: leaf
    if op is PI:
        return (), lambda forms: (False, display.PI_NAME)
    if op is CONST:
        value = number_of(node)
        return (), lambda forms: (value < 0, display.number_tree(display.size_of(value)))
    if op in _SUMS:
        return _plan_sum(node, stops)
    if op is MUL or op is DIV or _whole_exponent(node) is not None:
        return _plan_product(node, stops)
    return node.args, lambda forms: call(op.label or op.name, [forms[a] for a in node.args])


def _whole_exponent(node: Expr) -> int | None:
    if node.op is not POW:
        return None
    exponent = constant_value(node.args[1])
    return exponent if isinstance(exponent, int) else None


def _region(root: Expr, stops: Mapping[Expr, str], inner: Callable[[Expr], Sequence[Expr]]) -> list[Expr]:
    """Nodes that are flattened into `root`, and their outer arguments; arguments before users."""
    return _ordered(root, lambda node: inner(node) if node is root or node not in stops else ())


def _plan_sum(root: Expr, stops: Mapping[Expr, str]) -> _Plan:
    order = _region(root, stops, lambda node: node.args if node.op in _SUMS else ())
    weights: dict[Expr, Number] = dict.fromkeys(order, 0)
    weights[root] = 1
    constant: Number = 0
    terms: dict[Expr, Number] = {}
    for node in reversed(order):
        w, op = weights[node], node.op
        if node is not root and node in stops:
            terms[node] = terms.get(node, 0) + w
        elif op in _SUMS:
            for i, a in enumerate(node.args):
                weights[a] += -w if op is NEG or (op is SUB and i) else w
        elif op is CONST:
            constant += w * number_of(node)
        elif op is MUL and node.args[0].op is CONST:
            rest = node.args[1]
            terms[rest] = terms.get(rest, 0) + w * number_of(node.args[0])
        else:
            terms[node] = terms.get(node, 0) + w
    left = [(n, w) for n, w in terms.items() if w]
    return [n for n, _ in left], lambda forms: display.sum_form(
        constant, [(display.scaled(w, forms[n]), n) for n, w in left]
    )


def _factors(node: Expr) -> Sequence[Expr]:
    if node.op is MUL or node.op is DIV or node.op is NEG:
        return node.args
    return node.args[:1] if _whole_exponent(node) is not None else ()


_MAX_FOLDED = 64


def _folded(coefficient: Number, value: Number, exponent: int) -> Number | None:
    """coefficient · value^exponent where that is a number of ordinary size, else None."""
    if abs(exponent) > _MAX_FOLDED:
        return None
    try:
        product = times(coefficient, (value if isinstance(value, float) else Fraction(value)) ** exponent)
    except (ArithmeticError, ValueError):
        return None
    return product if product and -math.inf < product < math.inf else None


def _plan_product(root: Expr, stops: Mapping[Expr, str]) -> _Plan:
    order = _region(root, stops, _factors)
    exponents = dict.fromkeys(order, 0)
    exponents[root] = 1
    negative = False
    coefficient: Number = 1
    factors: dict[Expr, int] = {}
    for node in reversed(order):
        e, op = exponents[node], node.op
        whole = _whole_exponent(node)
        if node is not root and node in stops:
            factors[node] = e
        elif op is MUL or op is DIV:
            exponents[node.args[0]] += e
            exponents[node.args[1]] += e if op is MUL else -e
        elif op is NEG:
            exponents[node.args[0]] += e
            negative ^= e % 2 == 1
        elif whole is not None:
            exponents[node.args[0]] += e * whole
        elif op is CONST and (product := _folded(coefficient, number_of(node), e)) is not None:
            coefficient = product
        else:
            factors[node] = e
    tangents = _tangents(factors)
    left = [(n, e) for n, e in factors.items() if e]

    def finish(forms: _Forms) -> display.Signed:
        tans = [(call("tan", [forms[a]]), e, a) for a, e in tangents.items() if e]
        return display.product_form(negative, coefficient, [*tans, *((forms[n], e, n) for n, e in left)])

    return [*(n for n, _ in left), *tangents], finish


def _tangents(factors: dict[Expr, int]) -> dict[Expr, int]:
    """Take sin/cos of one angle out of `factors`: exponents of the tangent by angle."""
    sines = {n.args[0]: n for n in factors if n.op is SIN}
    exponents: dict[Expr, int] = {}
    for cosine in [n for n in factors if n.op is COS]:
        sine = sines.get(cosine.args[0])
        if sine is None:
            continue
        s, c = factors[sine], factors[cosine]
        if s > 0 > c:
            k = min(s, -c)
        elif s < 0 and c == -s:
            k = s
        else:
            continue
        factors[sine] -= k
        factors[cosine] += k
        exponents[cosine.args[0]] = k
    for tangent in [n for n in factors if n.op is TAN and n.args[0] in exponents]:
        exponents[tangent.args[0]] += factors.pop(tangent)
    return exponents


COMPARISON, SUM, PRODUCT, PREFIX, POWER, ATOM = range(6)
"""How firmly a tree holds together, loosest first."""

Pieces: TypeAlias = "Iterator[str | display.Tree]"


class Notation(ABC):
    """A way to write display trees. The methods give pieces, text and trees that are still to be written: depth costs nothing."""

    brackets: tuple[str, str]
    power: tuple[str, str]
    """What stands before and after an exponent."""
    exponent: int
    """How firmly an exponent must hold together."""
    gap: str
    """Between a measure number and its unit vector."""
    where: tuple[str, str]
    """Between an expression and its intermediates, and between these."""
    calls: ClassVar[Mapping[str, int]]
    """How firmly functions hold together; "" stands for the others."""

    @abstractmethod
    def name(self, text: str) -> str:
        """A symbol or an intermediate."""

    def symbol(self, tree: display.Name) -> str:
        """A symbol or an intermediate of a tree."""
        return self.name(tree.text)

    @abstractmethod
    def unit_vector(self, frame: str, axis: str) -> str:
        """A unit vector of the frame of that name."""

    @abstractmethod
    def number(self, value: Number) -> str:
        """A number that is not negative."""

    @abstractmethod
    def call(self, tree: display.Call) -> Pieces:
        """A function of its arguments."""

    @abstractmethod
    def product(self, tree: display.Product) -> Pieces:
        """A product of powers, some of them below the line."""

    def binding(self, tree: display.Tree) -> int:
        """How firmly a tree holds together."""
        if isinstance(tree, display.Sum | display.Minus):
            return SUM
        if isinstance(tree, display.Call):
            return self.calls.get(tree.name, self.calls[""])
        if isinstance(tree, display.NumberTree):
            return PRODUCT if isinstance(tree.value, Fraction | Surd) else ATOM
        return PRODUCT if isinstance(tree, display.Product) else POWER if isinstance(tree, display.Power) else ATOM

    def within(self, tree: display.Tree, least: int) -> Pieces:
        """The tree, in brackets where it holds together less firmly than `least`."""
        if self.binding(tree) < least:
            yield from (self.brackets[0], tree, self.brackets[1])
        else:
            yield tree

    def pieces(self, tree: display.Tree) -> Pieces:
        """What a tree consists of."""
        if isinstance(tree, display.NumberTree):
            yield self.number(tree.value)
        elif isinstance(tree, display.Name):
            yield self.symbol(tree)
        elif isinstance(tree, display.Minus):
            yield "-"
            yield from self.within(tree.body, PRODUCT)
        elif isinstance(tree, display.Sum):
            for i, (minus, term) in enumerate(tree.terms):
                yield sign(minus, not i)
                yield from self.within(term, PRODUCT)
        elif isinstance(tree, display.Product):
            yield from self.product(tree)
        elif isinstance(tree, display.Power):
            yield from self.within(tree.base, ATOM)
            yield from (self.power[0], *self.within(tree.exponent, self.exponent), self.power[1])
        elif tree.name == "less":
            yield from (*self.within(tree.args[0], SUM), " < ", *self.within(tree.args[1], SUM))
        else:
            yield from self.call(tree)

    def write(self, tree: display.Tree, least: int = COMPARISON) -> str:
        """The text of a tree, in brackets where it holds together less firmly than `least`."""
        out: list[str] = []
        stack: list[str | display.Tree] = [*reversed(list(self.within(tree, least)))]
        while stack:
            item = stack.pop()
            if isinstance(item, str):
                out.append(item)
            else:
                stack.extend(reversed(list(self.pieces(item))))
        return "".join(out)

    def line(self, expr: Expr, intermediates: bool | None) -> str:
        """An expression, and after "where" what it shares."""
        shown = layout((as_expr(expr),), intermediates)
        return self.defined(self.write(shown.trees[0]), shown.intermediates)

    def defined(self, line: str, intermediates: Iterable[tuple[str, display.Tree]]) -> str:
        """A line, and after "where" the intermediates in it."""
        definitions = [f"{self.name(name)} = {self.write(tree)}" for name, tree in intermediates]
        head, comma = self.where
        return line + (head + comma.join(definitions) if definitions else "")

    def along(self, trees: Iterable[display.Tree], units: Iterable[str]) -> str:
        """The sum of measure numbers, each along its unit vector; "0" where there are none."""
        line = ""
        for tree, unit in zip(trees, units, strict=True):
            minus, size = (True, tree.body) if isinstance(tree, display.Minus) else (False, tree)
            if isinstance(size, display.Sum) and all(negative for negative, _ in size.terms):
                minus, size = not minus, size.flipped()
            one = isinstance(size, display.NumberTree) and size.value == 1
            line += sign(minus, not line) + ("" if one else self.write(size, PRODUCT) + self.gap) + unit
        return line or "0"


def sign(minus: bool, first: bool) -> str:
    """The sign of a term."""
    return ("-" if minus else "") if first else " - " if minus else " + "


def to_text(expr: Expr, *, intermediates: bool | None = None) -> str:
    """`expr` in one line.

    With `intermediates` None, long or very deep expressions are printed with named intermediates, "…, where Z1 = …"; with True
    whenever something is shared, with False never, however long it gets.
    """
    return TEXT.line(expr, intermediates)


class _Text(Notation):
    brackets = ("(", ")")
    power, exponent = ("^", ""), ATOM
    gap = " "
    where = (", where ", ", ")
    calls: ClassVar = {"less": COMPARISON, "": ATOM}

    def name(self, text: str) -> str:
        return text

    def unit_vector(self, frame: str, axis: str) -> str:
        return f"{frame}.{axis}"

    def number(self, value: Number) -> str:
        if isinstance(value, Surd):
            over, under = display.split_coefficient(value.ratio)
            return ("" if over == 1 else f"{over}*") + f"sqrt({value.radicand})" + ("" if under == 1 else f"/{under}")
        return repr(value) if isinstance(value, float) else str(value)

    def call(self, tree: display.Call) -> Pieces:
        yield f"{tree.name}("
        for i, a in enumerate(tree.args):
            yield from (", ", a) if i else (a,)
        yield ")"

    def product(self, tree: display.Product) -> Pieces:
        over, under = display.split_coefficient(tree.coefficient)
        yield from self._factors(tree.above, "" if over == 1 and tree.above else self.number(over))
        if tree.below or under != 1:
            several = len(tree.below) + (under != 1) > 1
            yield "/(" if several else "/"
            yield from self._factors(tree.below, "" if under == 1 else str(under))
            yield ")" if several else ""

    def _factors(self, factors: Sequence[tuple[display.Tree, int]], start: str) -> Pieces:
        yield start
        for i, (factor, exponent) in enumerate(factors):
            yield "*" if i or start else ""
            yield from self.within(factor, ATOM if exponent != 1 else POWER)
            yield f"^{exponent}" if exponent != 1 else ""


def _named(exprs: show.Named[Expr]) -> str:
    """A line for each, and below them, after "where", what they share."""
    shown = layout(exprs)
    lines = [f"{label} = {TEXT.write(tree)}" for label, tree in zip(exprs.labels, shown.trees, strict=True)]
    where = [f"  {name} = {TEXT.write(tree)}" for name, tree in shown.intermediates]
    return "\n".join([*lines, *(["where", *where] if where else [])]) or "()"


TEXT = _Text()
show.TEXT[Expr] = to_text
show.TEXT[show.Named] = _named
