# SPDX-License-Identifier: BSD-3-Clause
"""Final form of a sheet's expressions: later assignments and kinematical equations substituted, further states identified."""

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from kane.errors import ModelError
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate, Input, Parameter, Rate, Speed, Symbol, rate
from kane.expr.visit import substituting
from kane.interop.autolev.sheet import Sheet
from kane.interop.autolev.values import Dyad, Vec
from kane.numeric.sampling import SEEDS, sample
from kane.numeric.scale import UNRELATED

_DEEP = 60


def replacing(changes: Mapping[Any, Any]) -> Callable[[Expr], Expr]:
    """A function that substitutes values for symbols."""
    return substituting(dict(changes))


class LastForm:
    """The final form of expressions: `final(e)` contains only coordinates, speeds, parameters, inputs and time."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        self.numbers = numbers_of(sheet)
        self._drop_flat_inertias()
        self.constants: dict[Expr, Expr] = {}
        self._given_values()
        self._drop_contradictions()
        late = self._closed(self._with_rates(dict(sheet.late)))
        self._late = substituting(late)
        self._speeds: dict[Expr, Expr] = {}
        kinematic = {self._late(k): self._late(v) for k, v in sheet.kinematic.items()}
        for symbol in sheet.symbols.values():
            if isinstance(symbol, Coordinate) and rate(symbol) not in kinematic and symbol not in sheet.outputs:
                kinematic[rate(symbol)] = Speed.declare(f"{symbol.name}p", None, "", "")
        self.kinematic = self._closed(kinematic)
        self._by_speeds = substituting(self.kinematic)
        self._at_rest = substituting(dict.fromkeys((x for u in sheet.auxiliary for x in (u, rate(u))), ZERO))
        late |= self._standing()
        self._late = substituting(late)

    def _given_values(self) -> None:
        """Makes constants of variables with only an Input value, or that occur in masses, inertias, positions or orientations."""
        s = self.sheet
        held = set(free_symbols(_fixed(s)))
        for low, symbol in s.symbols.items():
            free = isinstance(symbol, Input) and symbol not in s.late and low not in s.unknown and low not in s.given
            constant = isinstance(symbol, Parameter) and symbol not in s.late and low in self.numbers
            if constant or (free and (low in s.inputs or symbol in held)):
                self.constants[symbol] = Parameter.declare(symbol.name, self.numbers.get(low), "", "")
        s.late |= self.constants

    def _standing(self) -> dict[Expr, Expr]:
        """Coordinates whose rates are linear in auxiliary speeds only are constant: makes parameters of them."""
        result: dict[Expr, Expr] = {}
        for q in self.coordinates():
            told = self.kinematic.get(rate(q), ZERO)
            if told is not ZERO and self._at_rest(told) is ZERO:
                result[q] = Parameter.declare(q.name, self.numbers.get(q.name.lower()), "", "")
                self.sheet.remarks.say("changed", f"{q.name} changes with auxiliary speeds only: it is a parameter")
        self.constants |= result
        return result

    def _drop_flat_inertias(self) -> None:
        """Drops Input values that make a body's inertia singular, such as one value for all elements: they are placeholders."""
        s = self.sheet
        for name, (dyad, _, _) in s.inertias.items():
            held = free_symbols(x for pair in dyad.terms for v in pair for x in v.parts.values())
            values = {x: self.numbers[x.name.lower()] for x in held if x.name.lower() in self.numbers}
            if len(values) == len(held) > 0 and _is_flat(dyad, values):
                for x in held:
                    self.numbers.pop(x.name.lower())
                names = ", ".join(x.name for x in held)
                s.remarks.say(
                    "changed", f"the values of {names} give {s.say(name)} no valid inertia: they are left out"
                )

    def _drop_contradictions(self) -> None:
        """Drops values of specified variables that are not each other's derivatives: the actual functions are given elsewhere."""
        s = self.sheet
        for low in s.given:
            symbol = s.symbols.get(low)
            chain = [symbol, rate(symbol), rate(rate(symbol))] if isinstance(symbol, Input) else []
            told = [(s.late[a], s.late[b]) for a, b in pairwise(chain) if a in s.late and b in s.late]
            if any(not agree([s.rate(a)], [b], ()) for a, b in told):
                for key in chain:
                    s.late.pop(key, None)
                s.remarks.say(
                    "changed", f"{s.say(low)} has values that are not each other's derivatives: it becomes an input"
                )

    def _with_rates(self, late: dict[Expr, Expr]) -> dict[Expr, Expr]:
        for symbol, value in list(late.items()):
            if isinstance(symbol, Input):
                first = late.setdefault(rate(symbol), self.sheet.rate(value))
                late.setdefault(rate(rate(symbol)), self.sheet.rate(first))
        return late

    def _closed(self, changes: dict[Expr, Expr]) -> dict[Expr, Expr]:
        """Replacements substituted into each other until no value contains a key; ModelError for a cycle."""
        for _ in range(_DEEP):
            held = set(free_symbols(changes.values()))
            if not held & changes.keys():
                return changes
            if any(k in set(free_symbols([v])) for k, v in changes.items() if k in held):
                break
            replace = substituting({k: v for k, v in changes.items() if k in held})
            changes = {k: replace(v) for k, v in changes.items()}
        names = ", ".join(str(k) for k in changes if k in set(free_symbols(changes.values())))
        raise ModelError(f"Expected assignments without circular references, got a cycle of {names}.")

    def with_auxiliary(self, e: Expr) -> Expr:
        """The final form with auxiliary speeds."""
        return self._by_speeds(self._late(e))

    def final(self, e: Expr) -> Expr:
        """The final form with auxiliary speeds zero."""
        return self._at_rest(self.with_auxiliary(e))

    def vector(self, v: Vec) -> Vec:
        """The final form of a vector."""
        return v.map(self.final)

    def geometric(self, e: Expr) -> Expr:
        """The final form for positions and orientations: rates are not replaced by speeds."""
        return self._late(e)

    def coordinates(self) -> list[Coordinate]:
        """The declared coordinates."""
        return [s for s in self.sheet.symbols.values() if isinstance(s, Coordinate) and s not in self.constants]


def numbers_of(sheet: Sheet) -> dict[str, float]:
    """The values that Input assigns, with other inputs and assigned names substituted."""
    known: dict[Expr, float] = {}
    result: dict[str, float] = {}
    for _ in range(8):
        for name, value in sheet.inputs.items():
            e = substituting(dict(sheet.late))(value)
            symbols = free_symbols([e])
            if name not in result and all(s in known for s in symbols):
                result[name] = float(evaluate(e, {s: known[s] for s in symbols}))
                symbol = sheet.symbols.get(name)
                if symbol is not None:
                    known[symbol] = result[name]
    for name in sheet.inputs.keys() - result.keys():
        sheet.remarks.say("ignored", f"the start value of {name}, which needs values that are missing")
    return result


def _is_flat(dyad: Dyad, values: Mapping[Symbol, float]) -> bool:
    """Whether moments of inertia are positive and the dyadic, along the axes of one frame, is singular with these values."""
    frames = dict.fromkeys(f for pair in dyad.terms for v in pair for f in v.frames())
    if len(frames) != 1:
        return False
    rows = np.zeros((3, 3))
    for pair in dyad.terms:
        a, b = (np.zeros(3) for _ in pair)
        for column, v in zip((a, b), pair, strict=True):
            for (_, k), x in v.parts.items():
                column[k] = evaluate(x, {y: values[y] for y in free_symbols([x])})
        rows += np.outer(a, b)
    sizes = np.linalg.eigvalsh(rows)
    return bool(np.all(np.diag(rows) > 0) and sizes[0] <= UNRELATED * sizes[-1])


def _fixed(s: Sheet) -> list[Expr]:
    """The expressions in masses, inertias, positions and orientations."""
    dyads = [x for dyad, _, _ in s.inertias.values() for pair in dyad.terms for v in pair for x in v.parts.values()]
    turns = [x for turn in s.turns.values() for row in turn.cosines for x in row]
    return [*s.masses.values(), *dyads, *turns, *(x for v in s.positions.values() for x in v.parts.values())]


def speeds_in(expressions: Iterable[Expr]) -> list[Speed]:
    """Generalized speeds, in the order of appearance."""
    return list(dict.fromkeys(s for s in free_symbols(expressions) if isinstance(s, Speed)))


def agree(these: Iterable[Expr], those: Iterable[Expr], groups: Iterable[tuple[Coordinate, ...]]) -> bool:
    """Whether expressions have the same values at random states."""
    a, b, sets = list(map(undefined, these)), list(map(undefined, those)), list(groups)
    for seed in SEEDS[:2]:
        numbers = np.array(sample([*a, *b], seed, sets), dtype=float)
        x, y = numbers[: len(a)], numbers[len(a) :]
        size = float(np.max(np.abs(numbers), initial=0.0))
        if not np.all(np.isfinite(numbers)) or np.max(np.abs(x - y), initial=0.0) > UNRELATED * size:
            return False
    return True


def undefined(e: Expr) -> Expr:
    """An expression with parameters without defaults, because terms could cancel at the defaults."""
    told = [p for p in free_symbols([e]) if isinstance(p, Parameter) and p.default is not None]
    return substituting({p: Parameter.declare(p.name, None, p.unit, "") for p in told})(e) if told else e


def no_accelerations(e: Expr) -> bool:
    """Whether an expression contains no derivative of a speed."""
    return not any(isinstance(s, Rate) and isinstance(s.place, Speed) for s in free_symbols([e]))
