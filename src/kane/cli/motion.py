# SPDX-License-Identifier: BSD-3-Clause
"""The motion that the options ask for: START of the model, changed by what the command line says."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import kane as kn
from kane.cli.faults import Misuse, own_code
from kane.cli.models import KINDS, Model
from kane.errors import ModelError, ValueMissingError, alike
from kane.motion.interrupts import check_whole
from kane.progress import working

_OPTIONS = dict(zip(KINDS, ("--q", "--u", "--parameter", "--input", "--state"), strict=True))
_WHAT = dict(zip(KINDS, ("coordinate", "speed", "parameter", "input", "further state"), strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Values by name for `simulate`, and the options that give those which are missing."""

    q: Mapping[str, Any]
    u: Mapping[str, Any]
    parameters: Mapping[str, Any]
    inputs: Mapping[str, Any]
    states: Mapping[str, Any]
    missing: tuple[str, ...]


def start(model: Model, eom: kn.Equations, told: Mapping[str, Sequence[str] | None]) -> Start:
    """START, changed by `told`: texts NAME=VALUE for some of `KINDS`.

    A name that the system does not have is Misuse in `told`, and a ModelError in START.
    """
    with own_code(model.path, "START"):
        return _start(model, eom, told)


def _start(model: Model, eom: kn.Equations, options: Mapping[str, Sequence[str] | None]) -> Start:
    symbols_of: dict[str, list[Any]] = {
        "q": list(eom.coordinates),
        "u": list(eom.speeds),
        "parameters": list(eom.parameters),
        "inputs": [s for s in eom.inputs if isinstance(s, kn.expr.Input)],
        "states": list(eom.states),
    }
    values: dict[str, dict[str, Any]] = {}
    missing: list[str] = []
    for kind, symbols in symbols_of.items():
        names = [s.name for s in symbols]
        own, option = model.start.get(kind, {}), _OPTIONS[kind]
        told = _assignments(option, options.get(kind))
        for name in told:
            if name not in names:
                raise Misuse(f"{_expected(kind, names)} in {option}, got {name!r}.{alike(name, names)}")
        for name in own:
            if name not in names:
                raise ModelError(f"{_expected(kind, names)} in START[{kind!r}], got {name!r}.{alike(str(name), names)}")
        values[kind] = {**own, **told}
        missing += [
            f"{option} {s.name}=…"
            for s in symbols
            if s.name not in values[kind] and not (kind in ("parameters", "states") and s.default is not None)
        ]
    begin = Start(**values, missing=tuple(missing))
    return _assembled(eom, begin, model.span[0]) if eom.system.constraints else begin


def _assignments(option: str, texts: Sequence[str] | None) -> dict[str, float]:
    """Values by name from texts NAME=VALUE."""
    values: dict[str, float] = {}
    for text in texts or ():
        name, sign, value = (part.strip() for part in text.partition("="))
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (name and sign and math.isfinite(number)):
            raise Misuse(f"Expected {option} NAME=VALUE with a finite number, got {text!r}.")
        if name in values:
            raise Misuse(f"Expected one value for each name, got {option} {name}=… twice.")
        values[name] = number
    return values


def _assembled(eom: kn.Equations, begin: Start, t: float) -> Start:
    """What START guesses or leaves out solved for, where the constraints give it."""
    values = {p.name: p.default for p in eom.parameters} | dict(begin.parameters)
    if None in values.values():
        return begin
    inputs = {name: f(t) if callable(f) else f for name, f in begin.inputs.items()}
    for speeds in (begin.u, None):  # where too few speeds are given the coordinates are solved for all the same
        try:
            assembled = kn.assemble(eom, q=begin.q, u=speeds, parameters=values, inputs=inputs, t=t)
        except ValueMissingError:
            continue
        q, u = ({s.name: x for s, x in part.items()} for part in (assembled.q, assembled.u))
        free = [] if speeds is not None else [s.name for s in eom.independent_speeds if s.name not in begin.u]
        rest = [option for option in begin.missing if not option.startswith((_OPTIONS["q"], _OPTIONS["u"]))]
        missing = (*(f"{_OPTIONS['u']} {name}=…" for name in free), *rest)
        return Start(q, begin.u if free else u, begin.parameters, begin.inputs, begin.states, missing)
    return begin


def _expected(kind: str, names: Sequence[str]) -> str:
    return f"Expected the name of {'an' if kind == 'inputs' else 'a'} {_WHAT[kind]} ({', '.join(names) or 'there is none'})"


def motion(model: Model, eom: kn.Equations, begin: Start, end: float | None) -> kn.Solution:
    """The motion from the start of SPAN to `end`, or to the end of SPAN; Misuse where start values are missing."""
    if begin.missing:
        raise Misuse(
            f"Expected a value for everything at the start, got none for some: add {' '.join(begin.missing)}, or set them in START of "
            "the model's file."
        )
    span = (model.span[0], model.span[1] if end is None else end)
    if not span[1] > span[0]:
        raise Misuse(f"Expected the motion to end after its start at {span[0]:g} s, got --t1 {span[1]:g}.")
    with working("Simulating"), own_code(model.path, "START"):
        solution = kn.simulate(
            eom, span, q=begin.q, u=begin.u, parameters=begin.parameters, inputs=begin.inputs, states=begin.states
        )
    whole: kn.Solution = check_whole(solution)
    return whole
