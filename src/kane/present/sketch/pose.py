# SPDX-License-Identifier: BSD-3-Clause
"""The pose of a sketch: open angles, lengths of the size of the bodies, constraints satisfied, nothing below the ground.

Several poses are tried, each moved by least changes until the constraints hold, with contacts open or one of them closed; that in
which the least visible coordinate is seen best is taken.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from kane import expect
from kane.errors import KaneError
from kane.expr.evaluation import Walk
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate, Input, Parameter, Rate, Reaction, Symbol
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEED, named_values
from kane.present.scene.records import Movement, Posed, Scene
from kane.units.rules import parse

_ANGLES = np.radians([38.0, 29.0, 46.0, 33.0, 25.0, 42.0, 36.0])
_SHARES = (1.15, 0.85, 0.95, 0.7, 1.05)
_LENGTH = parse("m").exponents
_ROUNDS = 40
_CLOSED = 1e-9
_ATTITUDE = np.array([0.87, 0.28, 0.22, 0.34])
_SIGNS = ("++++", "+-+-", "-+-+", "--++", "++--", "+--+", "-++-", "----")
_BENT = 0.13
"""Deflection of a beam relative to its length."""
_MORE = 40
"""Number of random starts if no other start satisfies the constraints."""
_HOLDS = 1e-7
_SEVERAL = 4
"""Number of rotations above which each is smaller."""


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Values for all symbols of a scene, the resulting pose, and the typical length."""

    values: Mapping[Symbol, float]
    posed: Posed
    size: float


def pose_of(scene: Scene, given: Any = None) -> Pose:
    """The best pose found; `given` contains prescribed values of coordinates."""
    known = constants(scene)
    size = _size(scene, known)
    told = {q: _finite(q, value) for q, value in named_values("q", scene.system.coordinates, given).items()}
    best: tuple[float, dict[Symbol, float]] | None = None
    laws = _laws(scene)
    for n, start in enumerate(_starts(scene, size, told)):
        if n >= len(_SIGNS) and best is not None and _holds(best[1], laws):
            break
        for closing in laws.choices:
            values = _closed(_bent({**known, **start}, scene, told), scene, laws, closing, told, size)
            worth = _worth(scene, values, laws, size)
            if best is None or worth > best[0] + 1e-6:
                best = worth, values
        if told and len(told) == len(scene.system.coordinates):
            break
    assert best is not None
    return Pose(best[1], scene.poses(best[1]), size)


def _finite(q: Expr, value: Any) -> float:
    expected = f"a finite number for {q} in q="
    number = expect.floats(value, expected)
    expect.that(number.ndim == 0 and np.isfinite(number), expected, value)
    return float(number)


def _holds(values: Mapping[Symbol, float], laws: "_Laws") -> bool:
    """Whether the configuration constraints vanish."""
    return all(abs(float(x)) <= _HOLDS for x in laws.walk(values)[: laws.count])


def constants(scene: Scene) -> dict[Symbol, float]:
    """Values of everything except coordinates: defaults, or visible values where there is none."""
    return {s: _constant(s) for s in _all_symbols(scene) if not isinstance(s, Coordinate)}


def _all_symbols(scene: Scene) -> list[Symbol]:
    system = scene.system
    laws = Walk([*(c.expr for c in system.holonomic), *_gaps(scene)]).symbols
    return list(dict.fromkeys([*scene.symbols, *system.parameters, *laws]))


def _constant(s: Symbol) -> float:
    default = getattr(s, "default", None)
    if isinstance(s, Parameter):
        return 1.0 if default is None else float(default)
    if isinstance(s, Reaction):
        return 1.0
    if isinstance(s, Input):
        return float(default) if default else (0.45 if s.unit in ("rad", "") else 0.2 if s.unit == "m" else 1.0)
    return 1.0 if isinstance(s, Rate) else float(default or 0.0)


def _size(scene: Scene, known: Mapping[Symbol, float]) -> float:
    """The typical length: the median of the parameters that are lengths."""
    found = [abs(known[p]) for p in scene.system.parameters if p.unit and _is_length(p.unit) and known[p]]
    return float(np.median(found)) if found else 1.0


def _is_length(unit: str) -> bool:
    try:
        return bool(parse(unit).exponents == _LENGTH)
    except KaneError:
        return False


def _starts(scene: Scene, size: float, told: Mapping[Any, float]) -> Iterator[dict[Symbol, float]]:
    by_name: dict[str, Coordinate] = {q.name: q for q in scene.system.coordinates}
    several = sum(m.kind == "turn" for m in scene.movements) > _SEVERAL
    for n, signs in enumerate(_SIGNS):
        start: dict[Symbol, float] = {}
        turns = shifts = 0
        for m in scene.movements:
            for k, name in enumerate(m.symbols):
                sign = 1.0 if signs[turns % len(signs)] == "+" else -1.0
                sign *= 0.7 if several else 1.0
                start[by_name[name]] = _wanted(m, k, turns, 0 if n % 2 else shifts, sign, size)
            turns += m.kind == "turn"
            shifts += m.kind == "shift"
        yield {**start, **told}
    rng = np.random.default_rng(SEED)
    for _ in range(_MORE if scene.system.holonomic else 0):  # used if no other start satisfies the constraints
        yield {
            **{q: v + float(rng.normal(0, 1.2)) * (size if q.unit == "m" else 1.0) for q, v in start.items()},
            **told,
        }


def _bent(values: dict[Symbol, float], scene: Scene, told: Mapping[Any, float]) -> dict[Symbol, float]:
    """The coordinates of beams, scaled to a visible deflection."""
    posed = scene.poses(values)
    for m in scene.movements:
        if m.kind == "deflection":
            ends = posed.positions[list(m.points)]
            moved = np.linalg.norm(ends[1::2] - ends[::2], axis=-1).max()
            long = 2 * float(np.linalg.norm(ends[0] - ends[2]))
            own = {s for s in scene.system.coordinates if s.name in m.symbols and s not in told}
            factor = _BENT * long / moved if moved > 0 else 1.0
            values = {s: v * factor if s in own else v for s, v in values.items()}
    return values


def _wanted(m: Movement, k: int, turns: int, shifts: int, sign: float, size: float) -> float:
    if m.kind == "turn":
        return float(sign * _ANGLES[turns % len(_ANGLES)])
    if m.kind == "shift":
        return size * _SHARES[shifts % len(_SHARES)]
    if m.kind == "attitude":
        unit = _ATTITUDE / np.linalg.norm(_ATTITUDE)
        return float(unit[k]) if k < 4 else 0.0
    return _BENT * size if m.kind == "deflection" and k == 0 else 0.0


# Constraints and contacts --------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _Laws:
    """Constraints and gaps as one routine; `choices` are the sets of gaps to close, the empty one first."""

    walk: Walk
    count: int
    choices: tuple[tuple[int, ...], ...]


def _gaps(scene: Scene) -> list[Expr]:
    return [law.gap.expr for law in scene.system.contacts if law.gap is not None]


def _laws(scene: Scene) -> _Laws:
    rows, gaps = [c.expr for c in scene.system.holonomic], _gaps(scene)
    some = range(len(rows), len(rows) + min(len(gaps), 4))
    choices: list[tuple[int, ...]] = [(), *((k,) for k in some), *combinations(some, 2)]
    return _Laws(Walk([*rows, *gaps]), len(rows), tuple(choices))


def _closed(
    values: dict[Symbol, float],
    scene: Scene,
    laws: _Laws,
    closing: Sequence[int],
    told: Mapping[Any, float],
    size: float,
) -> dict[Symbol, float]:
    """The values moved by least changes until constraints, and the gaps in `closing`, vanish."""
    wanted = [*range(laws.count), *closing]
    free = [q for q in scene.system.coordinates if q not in told]
    if not wanted or not free:
        return values
    at = dict(values)
    bent = {name for m in scene.movements if m.kind == "deflection" for name in m.symbols}
    unit = np.array([1e-3 * size if q.name in bent else size if q.unit == "m" else 1.0 for q in free])
    for _ in range(_ROUNDS):
        residual, slope = _linear(laws.walk, at, free, unit, wanted)
        if not np.isfinite(residual).all() or np.abs(residual).max() <= _CLOSED:
            break
        step = np.linalg.lstsq(slope, -residual, rcond=None)[0]
        step *= min(1.0, 0.5 / max(np.abs(step).max(), 1e-12))
        at.update({q: at[q] + float(s * u) for q, s, u in zip(free, step, unit, strict=True)})
        for group in scene.system.euler_parameters:
            norm = float(np.sqrt(sum(at[q] ** 2 for q in group.coordinates)))
            at.update({q: at[q] / norm for q in group.coordinates})
    return at


def _linear(
    walk: Walk, at: Mapping[Symbol, float], free: Sequence[Symbol], unit: Array, wanted: Sequence[int]
) -> tuple[Array, Array]:
    """Residuals, and their slopes by central differences, in one pass."""
    n, h = len(free), 1e-6
    moved: dict[Symbol, Any] = dict(at)
    for k, q in enumerate(free):
        column = np.full(2 * n + 1, at[q])
        column[1 + k] += h * unit[k]
        column[1 + n + k] -= h * unit[k]
        moved[q] = column
    rows = np.array([np.broadcast_to(np.asarray(x, dtype=float), 2 * n + 1) for x in walk(moved)])[list(wanted)]
    return rows[:, 0], (rows[:, 1 : n + 1] - rows[:, n + 1 :]) / (2 * h)


# Value of a pose -----------------------------------------------------------------------------------------------------


def _worth(scene: Scene, values: Mapping[Symbol, float], laws: _Laws, size: float) -> float:
    """The value of a pose: the least visibility of a coordinate, less the violation of constraints and contacts."""
    posed = scene.poses(values)
    if not np.isfinite(posed.positions).all():
        return -1e9
    shown = [_shown(m, posed, size) for m in scene.movements]
    worth = (min(shown) + 0.3 * float(np.mean(shown))) if shown else 0.0
    off = np.array([float(x) for x in laws.walk(values)]) if laws.walk.roots else np.zeros(0)
    if off.size:
        held, gaps = off[: laws.count], off[laws.count :]
        worth -= 20.0 * float(np.minimum(np.abs(held), 1.0).sum()) if held.size and np.abs(held).max() > 1e-6 else 0.0
        if gaps.size:
            worth -= 4.0 * float(np.clip(-gaps / size - 1e-6, 0, 1).sum()) + 0.25 * min(
                float(abs(gaps.min())) / size, 1.0
            )
    return worth + 0.4 * _apart(scene, posed)


def _shown(m: Movement, posed: Posed, size: float) -> float:
    if m.kind == "turn" and m.sweep is not None:
        angle = abs((float(posed.scalars[m.sweep]) + np.pi) % (2 * np.pi) - np.pi)
        return float(np.clip(np.degrees(angle) / 25.0, 0, 1) - np.clip((np.degrees(angle) - 100.0) / 60.0, 0, 1))
    if m.kind == "shift":
        long = float(np.linalg.norm(posed.positions[m.points[-1]] - posed.positions[m.points[0]])) / size
        return float(np.clip(long / 0.6, 0, 1) - np.clip((long - 2.0) / 4.0, 0, 1))
    return 1.0


def _apart(scene: Scene, posed: Posed) -> float:
    """The least distance of named points, relative to the extent of all."""
    places = posed.positions[[m.at for m in scene.marks][:40]]
    if len(places) < 2:
        return 1.0
    gaps = np.linalg.norm(places[:, None] - places[None], axis=-1)
    far = float(gaps.max()) or 1.0
    apart = gaps[np.triu_indices(len(places), 1)]
    apart = apart[apart > 1e-9 * far]
    return float(min(apart.min() / far / 0.15, 1.0)) if apart.size else 0.0
