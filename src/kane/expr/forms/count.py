# SPDX-License-Identifier: BSD-3-Clause
"""Operation counts: deterministic, by tier and by operation."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from operator import attrgetter

from kane.errors import Attributes
from kane.expr.node import Expr, as_exprs, nodes, postorder
from kane.expr.symbols import Parameter, Symbol


@dataclass(frozen=True, slots=True)
class Operations(Attributes):
    """What one evaluation costs: + − × ÷ √ and each transcendental count 1; changes of sign, |x|, comparisons and choices 0.

    `parameter` holds what depends on parameters alone and can be computed once; `state` the rest. Nodes of constants
    only are folded before counting.
    """

    parameter: int
    state: int
    by_operation: tuple[tuple[str, int], ...]

    @property
    def total(self) -> int:
        """Parameter and state tier together: what every limit binds."""
        return self.parameter + self.state

    def __str__(self) -> str:
        kinds = ", ".join(f"{n} {k}" for k, n in self.by_operation)
        told = f"{self.total} operations: {self.state} with the state, {self.parameter} of parameters"
        return f"{told} ({kinds})" if kinds else told


_CONSTANT, _PARAMETER, _STATE = range(3)


def count_operations(roots: Iterable[Expr] | Expr) -> Operations:
    """Operations of one evaluation of all `roots` together, each shared node once."""
    wanted = [roots] if isinstance(roots, Expr) else as_exprs("what is counted", roots)
    tier: dict[Expr, int] = {}
    totals = [0, 0, 0]
    kinds: Counter[str] = Counter()
    for node in postorder(wanted):
        if isinstance(node, Symbol):
            tier[node] = _PARAMETER if isinstance(node, Parameter) else _STATE
            continue
        tier[node] = max((tier[a] for a in node.args), default=_CONSTANT)
        if tier[node] and node.op.cost:
            totals[tier[node]] += node.op.cost
            kinds[node.op.name] += node.op.cost
    return Operations(totals[_PARAMETER], totals[_STATE], tuple(sorted(kinds.items())))


def price(roots: Iterable[Expr]) -> int:
    """What `count_operations` gives in total, sooner; to compare ways by. Operations on constants alone, which are rare, count."""
    return _cost(nodes(roots))


class Prices:
    """The `price` of expressions beside others that are there in any case, which are walked once."""

    def __init__(self, known: Iterable[Expr]) -> None:
        self._known = nodes(known)
        self._own = _cost(self._known)

    def __call__(self, roots: Iterable[Expr]) -> int:
        """Of the known ones and `roots` together."""
        return self._own + _cost(nodes(roots, self._known))


def exceeds(roots: Iterable[Expr], most: int) -> bool:
    """Whether the `price` of `roots` is more than `most`: no further nodes are looked at than tells that."""
    front, seen, total = set(roots), set[Expr](), 0
    while front and total <= most:
        seen |= front
        total += _cost(front)
        front = set[Expr]().union(*map(_args_of, front)) - seen
    return total > most


_args_of = attrgetter("args")
_cost_of = attrgetter("op.cost")


def _cost(of: Iterable[Expr]) -> int:
    return sum(map(_cost_of, of))
