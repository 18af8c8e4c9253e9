# SPDX-License-Identifier: BSD-3-Clause
"""SymPy's frames as a tree of frames of kane, with each rotation in its original form; frames with an angular velocity only.

SymPy keeps a matrix for each pair of oriented frames. A simple rotation, a sequence of three and Euler parameters are recognized by
comparing that matrix with theirs at random values; others remain matrices.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import permutations, product
from typing import Any

import numpy as np

from kane.errors import ModelError
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, ZERO, Expr, constant_value, nodes, pi
from kane.expr.ops import COS, SIN
from kane.expr.symbols import Coordinate, Input, Parameter, Rate
from kane.interop.driven import GivenRates, New, spinning, turned_about, turned_freely
from kane.interop.imported import FreeNames, Remarks
from kane.interop.sympy_mechanics.names import Translation
from kane.interop.sympy_mechanics.states import COUNT, States
from kane.numeric.arrays import Array
from kane.numeric.sampling import SEED
from kane.numeric.scale import EQUAL, ROUNDED_CHAIN
from kane.space.attitude_formulas import cosines_of
from kane.space.frame import Frame
from kane.space.rotation import Basis
from kane.space.vector import Dyadic, Vector, axes

_SEQUENCES = [a + b + c for a, b, c in product("xyz", repeat=3) if a != b != c]
Entries = Sequence[Sequence[Expr]]


def euler_sets(parents: Mapping[Any, tuple[Any, bool]], known: Translation) -> dict[Any, tuple[Coordinate, ...]]:
    """The frames whose matrix is that of four coordinates as Euler parameters, the scalar first."""
    result: dict[Any, tuple[Coordinate, ...]] = {}
    for frame, (parent, oriented) in parents.items():
        if parent is None or not oriented:
            continue
        entries = [known.scalar(x) for x in parent._dcm_dict[frame]]
        moving = [s for s in free_symbols(entries) if not isinstance(s, Parameter)]
        own = [s for s in moving if isinstance(s, Coordinate)]
        if len(own) != 4 or len(moving) != 4:
            continue
        e = _unit(len(own))
        there = _values(entries, dict(zip(own, e, strict=True)))
        for order in permutations(range(4)):
            if np.allclose(there, cosines_of(e[list(order)].T, unit=True), rtol=0, atol=EQUAL):
                result[frame] = tuple(own[k] for k in order)
                break
    return result


def _unit(n: int) -> Array:
    e = np.random.default_rng(SEED).uniform(0.3, 1.2, (n, COUNT))
    return np.asarray(e / np.linalg.norm(e, axis=0))


def _values(entries: Sequence[Expr], values: Mapping[Any, Any]) -> Array:
    """Values of a matrix (states × 3 × 3)."""
    found = np.broadcast_arrays(*evaluate(list(entries), dict(values)), np.zeros(COUNT))[:-1]
    return np.stack(found, axis=-1).reshape(COUNT, 3, 3)


class Frames:
    """Frames of kane for those of SymPy, made on first use; converts vectors and dyadics."""

    def __init__(
        self, inertial: Any, parents: Mapping[Any, tuple[Any, bool]], sets: Mapping[Any, tuple[Coordinate, ...]],
        scaled: Mapping[Any, tuple[Coordinate, ...]], known: Translation, states: States, remarks: Remarks,
    ) -> None:  # fmt: skip
        self._parents, self._sets, self._scaled = parents, sets, scaled
        self._known, self._states, self._remarks = known, states, remarks
        self._names = FreeNames()
        self._made: dict[Any, Frame] = {inertial: Frame(self._names.free(inertial.name))}
        self.inertial = self._made[inertial]
        self.further: list[GivenRates] = []

    def frame(self, theirs: Any) -> Frame:
        """The frame of kane for one of SymPy."""
        line = [theirs]
        while line[-1] not in self._made:
            if line[-1] not in self._parents:
                raise ModelError(
                    f"Expected the frame {theirs} to be oriented in {self.inertial.name}, or to have an angular velocity there, got "
                    "one with neither. Orient it."
                )
            line.append(self._parents[line[-1]][0])
        for child in reversed(line[:-1]):
            parent, oriented = self._parents[child]
            name = self._names.free(child.name)
            made = self._oriented if oriented and not self._only_spun(parent, child) else self._spun
            self._made[child] = made(name, self._made[parent], parent, child)
        return self._made[theirs]

    def _only_spun(self, parent: Any, child: Any) -> bool:
        """Whether no equation determines the functions of time that orient a frame, and its angular velocity lacks their rates."""
        spin = child._ang_vel_dict.get(parent)
        functions = {s for s in free_symbols(map(self._known.scalar, parent._dcm_dict[child])) if isinstance(s, Input)}
        if spin is None or not functions:
            return False
        told = free_symbols(self._known.scalar(x) for m, _ in spin.args for x in m)
        return not any(isinstance(s, Rate) and s.place in functions for s in told)

    def vector(self, theirs: Any, by: Any = None) -> Vector:
        """The vector of kane for one of SymPy, or for its derivative with respect to a symbol."""
        total = Vector()
        for m, f in getattr(theirs, "args", ()):
            x, y, z = (self._known.scalar(e if by is None else e.diff(by)) for e in m)
            total = total + Vector(((self.frame(f), (x, y, z)),))
        return total

    def dyadic(self, theirs: Any, home: Frame) -> Dyadic:
        """The dyadic of kane for one of SymPy, along as few frames as possible."""
        rows: dict[Basis, list[list[Expr]]] = {}
        rest = Dyadic()
        for measure, a, b in getattr(theirs, "args", ()):
            left, right, size = self.vector(a), self.vector(b), self._known.scalar(measure)
            (f, v), (g, w) = left.parts[0], right.parts[0]
            if f is not g:
                rest = rest + (left * size).outer(right)
                continue
            own = rows.setdefault(f, [[ZERO] * 3 for _ in range(3)])
            for i, j in product(range(3), repeat=2):
                own[i][j] = own[i][j] + size * v[i] * w[j]
        for f, entries in rows.items():
            rest = rest + Dyadic.of(f, entries)
        return rest if len(rest.frames()) <= 1 else rest.express(home)

    def _oriented(self, name: str, ours: Frame, parent: Any, child: Any) -> Frame:
        if child in self._sets:
            self._remarks.say("read", f"{child} by the Euler parameters {', '.join(s.name for s in self._sets[child])}")
            frame = ours.rotate_euler_parameters(name, self._sets[child])
            assert frame.orientation is not None
            self._states.values.update(
                zip(frame.orientation.quasi, self._states.turning(self._sets[child]), strict=True)
            )
            return frame
        flat = [self._known.scalar(x) for x in parent._dcm_dict[child]]
        if child in self._scaled:  # orthogonal for any length of the parameters, and equal to the matrix for length 1
            square = sum((e * e for e in self._scaled[child]), ZERO)
            return ours.rotate_matrix(name, [[x / square for x in flat[k : k + 3]] for k in (0, 3, 6)])
        rows = [flat[k : k + 3] for k in (0, 3, 6)]
        wanted = self._states.of(flat).reshape(3, 3, -1)

        def same(other: Frame) -> bool:
            there = self._states.of(ours.dcm(other).entries).reshape(3, 3, -1)
            return bool(np.allclose(there, wanted, rtol=0, atol=ROUNDED_CHAIN))

        for turn in (_about_axis, _in_sequence):
            alike = next((x for x in turn(name, ours, rows) if same(x)), None)
            if alike is not None:
                return alike
        return ours.rotate_matrix(name, rows)

    def _spun(self, name: str, ours: Frame, parent: Any, child: Any) -> Frame:
        """A frame of which only the angular velocity is known; its orientation is integrated."""
        spin = child._ang_vel_dict[parent]
        own = [(m, f) for m, f in spin.args]
        k = [i for i in range(3) if own and own[0][0][i] != 0]
        alone = len(own) == 1 and own[0][1] in (parent, child) and len(k) == 1
        if not own or alone:
            size = self._known.scalar(own[0][0][k[0]]) if own else ZERO
            frame, driven = turned_about(ours, name, k[0] if own else 0, size, self._new(name, "", "angle"))
            self._states.enter(driven.coordinates[0], size)
            self.further.append(driven)
        else:
            frame = self._turned(name, ours, child, spin)
        self._remarks.say(
            "inferred", f"the orientation of {child} in {parent} from its angular velocity, as no orientation is given"
        )
        return frame

    def _turned(self, name: str, ours: Frame, child: Any, spin: Any) -> Frame:
        frame, e = turned_freely(ours, name, self._new(name, "1", "Euler parameter"))
        self._made[child] = frame
        w = self.vector(spin)
        self._states.enter_turning(e)
        driven = spinning(frame, [w.dot(a) for a in axes(frame)])
        quasi, sizes = zip(*driven.rates, strict=True)
        self._states.values.update(zip(quasi, self._states.of(sizes), strict=True))
        self.further.append(driven)
        return frame

    def _new(self, name: str, unit: str, what: str) -> New:
        free, said = self._known.names.free, f"{what} of a frame given by its angular velocity"
        return lambda of: Coordinate.declare(free(f"{of}_{name}"), None, unit, said)


def _arguments(entries: Iterable[Expr]) -> list[Expr]:
    """The arguments of sines and cosines."""
    return list(dict.fromkeys(node.args[0] for node in nodes(list(entries)) if node.op in (SIN, COS)))


def _about_axis(name: str, ours: Frame, rows: Entries) -> Iterable[Frame]:
    """Candidate simple rotations for the matrix."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        if rows[i][i] is not ONE or any(rows[a][b] is not ZERO for a, b in ((i, j), (i, k), (j, i), (k, i))):
            continue
        angles = _arguments([rows[k][j]])
        if not angles and (number := constant_value(rows[k][j])) is not None:
            c = constant_value(rows[j][j])
            quarter = {(0, 1): 0, (1, 0): 1, (0, -1): 2, (-1, 0): 3}.get((number, c)) if c is not None else None  # type: ignore[arg-type]
            if quarter is not None:
                yield ours.rotate(name, pi * quarter / 2 if quarter else 0, axes(ours)[i])
        for angle in angles:
            yield ours.rotate(name, angle, axes(ours)[i])
            yield ours.rotate(name, -angle, axes(ours)[i])


def _in_sequence(name: str, ours: Frame, rows: Entries) -> Iterable[Frame]:
    """Candidate sequences of three body-fixed rotations for the matrix."""
    angles = _arguments(x for row in rows for x in row)
    if len(angles) == 3:
        for order in permutations(angles):
            for sequence in _SEQUENCES:
                yield ours.rotate_body(name, order, sequence)
