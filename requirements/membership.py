# SPDX-License-Identifier: BSD-3-Clause
"""A plugin of mypy: no list or tuple of expressions is searched or compared, as `==` of two expressions is an error.

`e in (a, b)` is true where e is a, else an ExpressionError. `index`, `count`, `remove` and `==` of what holds expressions are alike.
"""

from collections.abc import Callable

from mypy.errorcodes import DEPRECATED
from mypy.nodes import TypeAlias
from mypy.plugin import MethodContext, Plugin
from mypy.types import Instance, TupleType, Type, TypeAliasType, UnionType, get_proper_type

EXPRESSION = "kane.expr.node.Expr"
COMPARING = frozenset({"__contains__", "__eq__", "__ne__", "count", "index", "remove"})
BY_IDENTITY = frozenset({"kane.expr.symbols.Symbols", "typing.Mapping", "typing.AbstractSet"})
"""What finds symbols by themselves or by their hash; views of keys are sets."""


def _compares(type_: Type, within: frozenset[TypeAlias | None] = frozenset()) -> bool:
    """Whether the `==` of expressions decides on what a value of this type holds, `within` which it may stand itself."""
    if isinstance(type_, TypeAliasType):
        if type_.alias in within:
            return False
        within |= {type_.alias}
    found = get_proper_type(type_)
    if isinstance(found, UnionType | TupleType):
        return any(_compares(item, within) for item in found.items)
    if not isinstance(found, Instance):
        return False
    bases = {base.fullname for base in found.type.mro}
    return EXPRESSION in bases or (bases.isdisjoint(BY_IDENTITY) and any(_compares(a, within) for a in found.args))


def _check(context: MethodContext) -> Type:
    if _compares(context.type):
        context.api.fail(
            "Expected no comparison of expressions, which have no truth value: take a set or dict, Symbols(…), or `is`",
            context.context,
            code=DEPRECATED,  # the one that mypy does not swallow while it tries `in` in two ways
        )
    return context.default_return_type


class Membership(Plugin):
    """Looks at each method that compares items."""

    def get_method_hook(self, fullname: str) -> Callable[[MethodContext], Type] | None:
        """`_check` for them."""
        return _check if fullname.rpartition(".")[2] in COMPARING else None


def plugin(version: str) -> type[Plugin]:
    """What mypy asks for."""
    return Membership
