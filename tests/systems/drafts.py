# SPDX-License-Identifier: BSD-3-Clause
"""Models as data: what an engineer writes down, name by name, so that a slip of the pen is an edit of a text.

A draft holds formulas as texts; `built` makes the `System` of them and `verdict` says what the library says of it: on the way
from the declarations through `derive` to the start and a short motion.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import kane as kn

SPAN = (0.0, 0.01)
FORMULAS = ("places", "bodies", "loads", "holonomic", "nonholonomic", "speeds")
"""The groups of a draft that hold formulas."""


@dataclass(frozen=True)
class Draft:
    """A model: `parameters` are values with units, `coordinates` units, `speeds` units with definitions.

    The rest are formulas by name: `places` are frames, points and joints in the order in which they are made, those in `joints` bring
    speeds of their own. `q`, `u`, `values` (of parameters) and `forces` (of
    inputs) are what a motion starts with; `arguments` are further ones of `System`.
    """

    kind: str
    parameters: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    coordinates: Mapping[str, str] = field(default_factory=dict)
    inputs: Mapping[str, str] = field(default_factory=dict)
    speeds: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    places: Mapping[str, str] = field(default_factory=dict)
    bodies: Mapping[str, str] = field(default_factory=dict)
    loads: Mapping[str, str] = field(default_factory=dict)
    holonomic: Mapping[str, str] = field(default_factory=dict)
    nonholonomic: Mapping[str, str] = field(default_factory=dict)
    joints: tuple[str, ...] = ()
    arguments: Mapping[str, Any] = field(default_factory=dict)
    q: Mapping[str, Any] = field(default_factory=dict)
    u: Mapping[str, float] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    forces: Mapping[str, float] = field(default_factory=dict)

    @property
    def constraints(self) -> Mapping[str, str]:
        """All constraints."""
        return {**self.holonomic, **self.nonholonomic}


def built(d: Draft) -> kn.System:
    """The system of a draft."""
    names: dict[str, Any] = {"kn": kn, "N": kn.Frame("N")}
    names["O"] = kn.Point("O", fixed_in=names["N"])
    names |= {n: kn.parameter(n, value, unit) for n, (value, unit) in d.parameters.items()}
    names |= {n: kn.coordinate(n, unit) for n, unit in d.coordinates.items()}
    names |= {n: kn.input(n, unit) for n, unit in d.inputs.items()}
    names |= {n: kn.speed(n, unit) for n, (unit, _) in d.speeds.items()}
    parts: dict[str, list[Any]] = {}
    for formulas in (d.places, d.bodies):
        for n, text in formulas.items():
            names[n] = _read(text, names)
    for group in ("loads", "holonomic", "nonholonomic"):
        parts[group] = [_read(text, names) for text in getattr(d, group).values()]
    definitions = {names[u]: _read(text, names) for u, (_, text) in d.speeds.items()}
    bodies, joints = [names[b] for b in d.bodies], [names[j] for j in d.joints]
    return kn.System(names["N"], bodies=bodies, speeds=definitions or None, joints=joints, **parts, **d.arguments)


def _read(text: str, names: dict[str, Any]) -> Any:
    return eval(text, {}, names)  # noqa: S307  # a formula of a draft, written by the tests


class Verdict(NamedTuple):
    """What was said, "" where nothing was, and where: "system", "derive" or "motion"."""

    said: str
    where: str = ""
    kind: str = ""


def verdict(d: Draft, span: tuple[float, float] = SPAN) -> Verdict:
    """The first error of the library's own family, or its warnings; any other exception is the library's fault and passes through."""
    where, last = "system", ""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            system = built(d)
            where = "derive"
            eom = kn.derive(system)
            where = "motion"
            sol = kn.simulate(eom, span, q=d.q, u=d.u or None, parameters=d.values, inputs=d.forces or None, samples=2)
            last = "" if sol.status == "finished" else sol.message
        except kn.KaneError as error:
            return Verdict(str(error), where, type(error).__name__)
    told = [str(w.message) for w in caught]
    if told or last:
        return Verdict("; ".join([*told, last]), where, "KaneWarning")
    return Verdict("")
