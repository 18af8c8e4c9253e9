# SPDX-License-Identifier: BSD-3-Clause
"""Masses and inertias that no body can have, where the defaults of the parameters tell.

A central inertia is symmetric, its principal moments are not negative, and none is larger than the sum of the other two
(∫ (y² + z²) dm ≤ ∫ (x² + z²) dm + ∫ (x² + y²) dm; equal for what is flat).
"""

import math
import warnings
from collections.abc import Iterable, Mapping
from typing import Protocol
from weakref import WeakKeyDictionary

import numpy as np

from kane.errors import KaneWarning, ModelError, cut
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr, constant_value
from kane.expr.ops import CONST
from kane.expr.symbols import Parameter
from kane.numeric.sampling import SEED, SEEDS, draw, sample
from kane.numeric.scale import DECLARED
from kane.space.rotation import Basis
from kane.space.vector import Dyadic, angular_velocity

_AXES = "xyz"
_PAIRS = ((0, 1), (1, 2), (2, 0))


class HasInertia(Protocol):
    """A part of a body."""

    @property
    def inertia(self) -> Dyadic | None:
        """Central inertia, if any."""


def check_mass(name: str, mass: Expr) -> None:
    """Raise a ModelError for a mass that varies, or is below zero at the defaults of its parameters."""
    check_constant(name, "mass", [mass])
    number = mass.default if isinstance(mass, Parameter) else constant_value(mass)
    if number is None:
        if isinstance(mass, Parameter) or any(s.default is None for s in free_symbols([mass])):
            return
        number = evaluate(mass, {})
    value = float(number)
    if value < 0:
        what = "" if constant_value(mass) is not None else f"{cut(mass)} = "
        raise ModelError(f"Expected a mass ≥ 0 for {name}, got {what}{value:g}. Check its sign, or the default.")


def check_inertia(name: str, inertia: Dyadic) -> None:
    """A ModelError for a central inertia that is not symmetric or has a negative moment; warn of a broken triangle inequality."""
    frames = inertia.frames()
    if not frames:
        return
    frame = frames[0]
    n = _numbers(inertia, frame, one=len(frames) == 1)
    if n is None:
        return
    size = max(abs(x) for row in n for x in row)
    for i, j in _PAIRS:
        if abs(n[i][j] - n[j][i]) > DECLARED * size:
            a, b = _AXES[i], _AXES[j]
            raise ModelError(
                f"Expected a symmetric inertia for {name}, got I{a}{b} = {n[i][j]:g} and I{b}{a} = {n[j][i]:g} along the "
                f"axes of {frame.name}. Write kn.inertia({frame.name}, Ixx, Iyy, Izz, Ixy, Iyz, Izx), which sets both."
            )
    tilted = any(n[i][j] for i, j in _PAIRS)
    low, middle, high = np.linalg.eigvalsh(n) if tilted else sorted(n[i][i] for i in range(3))
    said = f"{low:g}, {middle:g}, {high:g}"
    if low < -DECLARED * size:
        raise ModelError(
            f"Expected central principal moments of inertia ≥ 0 for {name}, got {said}. Check the signs; an inertia about another "
            "point than the mass centre is larger by m r², not smaller."
        )
    if high > (low + middle) * (1 + DECLARED) and middle > DECLARED * high:
        warnings.warn(
            f"Expected principal moments of inertia for {name} of which none is larger than the sum of the other two, got "
            f"{said}: no body has them. Check them and the signs of the products Ixy, Iyz, Izx (−∫ x y dm, …). In a plane, where Izz "
            "alone counts, give any Ixx and Iyy with Ixx + Iyy ≥ Izz.",
            KaneWarning,
            stacklevel=3,
        )


def moments(part: HasInertia, constants: Mapping[Expr, float]) -> list[float] | None:
    """Central principal moments at the values of the parameters, rising; None without inertia, or where it holds other symbols."""
    inertia = part.inertia
    frames = inertia.frames() if inertia is not None else ()
    if inertia is None or not frames:
        return None
    rows = inertia.components(frames[0]).rows
    symbols = free_symbols(x for row in rows for x in row)
    if any(s not in constants and (isinstance(s, Parameter) or len(frames) == 1) for s in symbols):
        return None
    values = {s: constants[s] if s in constants else draw(SEED, s) for s in symbols}
    n = np.array([[float(evaluate(x, values)) for x in row] for row in rows])
    return [float(x) for x in np.linalg.eigvalsh((n + n.T) / 2)] if np.isfinite(n).all() else None


def least_moment(part: HasInertia, constants: Mapping[Expr, float]) -> float | None:
    """The least of them, 0 where it is rounding's; None where they are not known."""
    found = moments(part, constants)
    return None if found is None else 0.0 if abs(found[0]) <= DECLARED * abs(found[-1]) else found[0]


def largest_moment(part: HasInertia, constants: Mapping[Expr, float]) -> float:
    """The largest of them, 0 without inertia."""
    found = moments(part, constants)
    return found[-1] if found is not None else 0.0 if part.inertia is None else 1.0


def check_constant(name: str, what: str, exprs: Iterable[Expr]) -> None:
    """A ModelError for a mass that varies: what leaves or joins takes momentum along, of which nothing is said."""
    varying = [str(s) for s in free_symbols(exprs) if not isinstance(s, Parameter)]
    if varying:
        raise ModelError(
            f"Expected a constant {what} of {name}, got one with {', '.join(varying)} in it: the momentum that leaves or joins, ṁ v, "
            "would be missing. Model what moves as bodies of their own, and what is thrown off as the force that it exerts."
        )


def check_turning(inertial: Basis, parts: Iterable[tuple[str, Basis, Dyadic]]) -> None:
    """Warn of bodies with a moment of inertia about one axis alone that turn about another one too: no body has such."""
    turning = [name for name, frame, inertia in parts if _turns_off_its_axis(inertial, frame, inertia)]
    if turning:
        warnings.warn(
            f"Expected moments of inertia about all axes for {', '.join(turning)}, got one about a single axis, of what turns about "
            "others too: no body has it. Give all three principal moments.",
            KaneWarning,
            stacklevel=4,
        )


def _turns_off_its_axis(inertial: Basis, frame: Basis, inertia: Dyadic) -> bool:
    frames = inertia.frames()
    n = _numbers(inertia, frames[0], one=len(frames) == 1) if frames else None
    if n is None:
        return False
    if not any(n[i][j] or n[j][i] for i, j in _PAIRS):  # those of most bodies are principal ones as they stand
        _, middle, high = sorted(n[i][i] for i in range(3))
        if not (high > 0 and middle <= DECLARED * high):
            return False
    (_, middle, high), axes = np.linalg.eigh(n)
    if not (high > 0 and middle <= DECLARED * high):
        return False
    spin = [x for _, triple in angular_velocity(frame, inertial).express(frames[0]).parts for x in triple]
    for seed in SEEDS:
        w = np.array(sample(spin, seed))
        if len(w) and np.isfinite(w).all() and np.abs(np.cross(w, axes[:, 2])).max() > DECLARED * np.abs(w).max():
            return True
    return False


_found: WeakKeyDictionary[Dyadic, list[list[float]] | None] = WeakKeyDictionary()
"""What inertias are along the first of their frames: bodies ask when they are made, and systems for each of theirs."""


def _numbers(inertia: Dyadic, frame: Basis, one: bool) -> list[list[float]] | None:
    """The matrix at the parameters' defaults; None where one has none, or the matrix is not constant in its one frame.

    Along several frames the turns between them are drawn at random: neither symmetry nor principal moments depend on them.
    """
    if inertia not in _found:
        _found[inertia] = _computed(inertia, frame, one)
    return _found[inertia]


def _computed(inertia: Dyadic, frame: Basis, one: bool) -> list[list[float]] | None:
    if one:
        entries = [x for a, b in inertia.dyads for v in (a, b) for x in v.parts[0][1]]
    else:
        entries = [x for row in inertia.components(frame).rows for x in row]
    own = list(dict.fromkeys(x for x in entries if x.op is not CONST))  # most are 0 and 1
    missing = [s for s in free_symbols(own) if s.default is None]
    if any(isinstance(s, Parameter) for s in missing) or (missing and one):
        return None
    known = dict(zip(own, sample(own, SEED), strict=True))
    values = [known[x] if x in known else float(constant_value(x) or 0) for x in entries]
    if not all(map(math.isfinite, values)):
        return None
    if not one:
        return [values[0:3], values[3:6], values[6:9]]
    dyads = [(values[k : k + 3], values[k + 3 : k + 6]) for k in range(0, len(values), 6)]
    return [[sum(a[i] * b[j] for a, b in dyads) for j in range(3)] for i in range(3)]
