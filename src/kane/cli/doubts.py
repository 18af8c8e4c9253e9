# SPDX-License-Identifier: BSD-3-Clause
"""What `kane check` finds that can be computed but is perhaps not meant."""

import math
from collections.abc import Iterator

import kane as kn
from kane.cli.motion import Start

_TURN = 2 * math.pi


def doubts(eom: kn.Equations, begin: Start) -> list[str]:
    """One sentence or two for each."""
    return [*_missing(eom, begin), *_degrees(eom, begin), *_loads(eom)]


def _missing(eom: kn.Equations, begin: Start) -> Iterator[str]:
    bare = [p.name for p in eom.parameters if p.default is None and p.name not in begin.parameters]
    if bare:
        yield f"No default for {', '.join(bare)}: every simulation needs --parameter NAME=VALUE for them."
    state = [option for option in begin.missing if not option.startswith("--parameter")]
    if state:
        yield f"START does not say everything: a simulation needs {' '.join(state)}."


def _degrees(eom: kn.Equations, begin: Start) -> Iterator[str]:
    """Angles beyond a whole turn, which are perhaps given in degrees."""
    angles = {f: f.orientation.angle for f in eom.system.frames if f.orientation and f.orientation.angle is not None}
    for f, angle in angles.items():
        if all(s.default is not None for s in kn.free_symbols([angle])):
            value = float(kn.evaluate(angle, {}))
            if abs(value) > _TURN:
                yield _turns(f"The frame {f.name} is turned by {value:g} rad", value)
    for q in dict.fromkeys(s for s in kn.free_symbols(angles.values()) if isinstance(s, kn.Coordinate)):
        value = float(begin.q.get(q.name, 0.0))
        if abs(value) > _TURN:
            yield _turns(f"START has the angle {q.name} = {value:g} rad", value)


def _turns(what: str, value: float) -> str:
    return f"{what}, {value / _TURN:.3g} turns: angles are in radians. If degrees are meant, write math.radians({value:g})."


def _loads(eom: kn.Equations) -> Iterator[str]:
    system = eom.system
    if not eom.loads:
        yield "No loads: nothing but inertia acts."
    if len(system.gravities) > 1:
        names = " and ".join(g.name for g in system.gravities)
        yield f"{len(system.gravities)} loads of gravity ({names}) act on every body: they add. List one, if one is meant."
    for load in dict.fromkeys(x for x in system.loads if system.loads.count(x) > 1):
        yield f"The load {load.name!r} is listed {system.loads.count(load)} times: it acts as often. List it once, if once is meant."
