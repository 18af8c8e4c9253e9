# SPDX-License-Identifier: BSD-3-Clause
"""Rotations and their representations: direction cosines, Euler and Rodrigues parameters, axis and angle, three angles.

Symbolic or numerical, of one rotation or of arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from kane import expect, show
from kane.errors import SpaceError, cut
from kane.expr.build import cos, sin
from kane.expr.evaluation import evaluate
from kane.expr.matrix import Matrix
from kane.expr.node import Expr, as_expr
from kane.expr.operators import atan2, sqrt
from kane.expr.ops import Immutable
from kane.numeric.arrays import Array, Entries
from kane.numeric.scale import GIVEN
from kane.space import attitude_formulas as formulas
from kane.space.frame import Frame, turned_about, turning_axes
from kane.space.rotation import doubt_degrees
from kane.space.vector import Vector

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation as ScipyRotation


class Rotation(Immutable):
    """The orientation of a frame B in a frame A: symbolic, numerical, or an array of numerical rotations.

    A `from_…` method makes it; `direction_cosines` ᴬCᴮ with v_A = ᴬCᴮ v_B, `euler_parameters`, `rodrigues_parameters`, `axis_angle`
    and `angles(sequence)` return it in any form. `R @ S` is R, then S about the axes of B: ᴬCᴮ ᴮC^C. Symbols give a Matrix and tuples
    of expressions, numbers give arrays: (…, 3, 3) and (…, n) for rotations of shape (…).

    Angles are in rad. Sources: Kane & Levinson 1985, sec. 1.2, appendices I and II; Kane, Likins & Levinson 1983, *Spacecraft
    Dynamics*, sec. 1.1 to 1.8.
    """

    _cosines_by: Callable[[], Entries] | None
    _parameters_by: Callable[[], tuple[Entries, bool]] | None
    _given: Mapping[str, Any]

    def __init__(self) -> None:
        raise SpaceError(
            "Expected Rotation.from_angles(…), .from_axis_angle(…) or another one of from_…, got Rotation(…)."
        )

    @classmethod
    def _of(
        cls, cosines: Callable[[], Entries] | None, parameters: Callable[[], tuple[Entries, bool]] | None, **given: Any
    ) -> Rotation:
        """By C, or by homogeneous Euler parameters and whether these are of length 1. `given` are read as such."""
        made: Rotation = object.__new__(cls)
        made.__dict__.update(_cosines_by=cosines, _parameters_by=parameters, _given=given)
        return made

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"A Rotation is frozen: {name!r} cannot be set.")

    def __reduce__(self) -> tuple[Callable[..., Rotation], tuple[Any, ...]]:
        cosines = None if self._cosines_by is None else self._cosines
        return _restored, (cosines, None if self._parameters_by is None else self._homogeneous, dict(self._given))

    # Made ----------------------------------------------------------------------------------------------------------------

    @classmethod
    def from_direction_cosines(cls, cosines: Any) -> Rotation:
        """From ᴬCᴮ, 3 × 3 or (…, 3, 3): column j is the j-th unit vector of B along the axes of A; numbers are made orthonormal.

        Raises
        ------
        SpaceError
            if a numerical matrix is not orthonormal and right-handed within 1e-8
        """
        c = _entries(cosines, (3, 3), "direction cosines")
        if formulas.symbolic(c):
            return cls._of(lambda: c, None)
        off = np.abs(c @ np.swapaxes(c, -1, -2) - np.eye(3)).max(initial=0)
        if not off <= GIVEN or np.any(np.linalg.det(c) < 0):
            why = "a left-handed one" if off <= GIVEN else f"one whose C Cᵀ differs from 1 by {off:.3g}"
            raise SpaceError(f"Expected a right-handed orthonormal matrix of direction cosines, got {why}.")
        return cls._of(None, lambda: (formulas.parameters_of(c), True))

    @classmethod
    def from_euler_parameters(cls, parameters: Any) -> Rotation:
        """From Euler parameters (e0, e1, e2, e3), e0 = cos θ/2 the scalar one, e0² + e1² + e2² + e3² = 1; four, or (…, 4)."""
        e = _entries(parameters, (4,), "Euler parameters")
        if not formulas.symbolic(e):
            e = formulas.upward(_unit(e, "Euler parameters"))
        return cls._of(None, lambda: (e, True))

    @classmethod
    def from_rodrigues_parameters(cls, parameters: Any) -> Rotation:
        """From Rodrigues parameters ρ = λ tan θ/2, three, or (…, 3); half turns (θ = π) have none."""
        rho = _entries(parameters, (3,), "Rodrigues parameters")
        one = np.ones_like(rho[..., :1])
        return cls._of(None, lambda: (np.concatenate([one, rho], axis=-1), False), rodrigues=rho)

    @classmethod
    def from_axis_angle(cls, axis: Any, angle: Any) -> Rotation:
        """From a simple rotation by `angle` (rad) about a unit vector λ fixed in A and B: three measure numbers, or (…, 3)."""
        n, theta = _entries(axis, (3,), "the axis"), _entries(angle, (), "the angle")
        if formulas.symbolic(n) or formulas.symbolic(theta):
            n, theta = n.astype(object), theta.astype(object)
            return cls._of(
                lambda: _about(n, theta), lambda: (_halved(n, theta), True), axis_angle=(_read(n), as_expr(theta[()]))
            )
        _check_alike("axes and angles", n.shape[:-1], theta.shape)
        if not theta.ndim:
            doubt_degrees("A rotation", [theta])
        n = _unit(n, "an axis")
        return cls._of(None, lambda: (formulas.upward(_halved(n, theta)), True))

    @classmethod
    def from_angles(cls, sequence: str, angles: Any, *, space: bool = False) -> Rotation:
        """From three successive rotations about axes "xyz", "zxz" or "123", "313", … of the turning frame, or of A with `space=True`.

        All 24 sequences of appendix I are known: body-three, body-two, space-three, space-two. `angles` (rad) are three, or (…, 3).
        """
        given = _entries(angles, (3,), "three angles")
        if given.ndim == 1:
            doubt_degrees("A rotation", given)
        axes = turning_axes(sequence, (0, 0, 0))
        turns = [(k, given[..., n]) for n, k in enumerate(axes)]
        if space:
            turns.reverse()

        def cosines() -> Entries:
            a, b, c = (formulas.about(k, x) for k, x in turns)
            return np.asarray(a @ (b @ c))

        def parameters() -> tuple[Entries, bool]:
            a, b, c = (formulas.half_about(k, x) for k, x in turns)
            return formulas.product(formulas.product(a, b), c), True

        return cls._of(cosines, parameters, **{_named(axes, space): given})

    @classmethod
    def from_frames(cls, a: Frame, b: Frame) -> Rotation:
        """The orientation of frame `b` in frame `a`."""
        c = np.array(a.dcm(b).rows, dtype=object)
        return cls._of(lambda: c, None)

    @classmethod
    def from_scipy(cls, rotation: ScipyRotation) -> Rotation:
        """SciPy's rotation of measure numbers, v_A = R v_B."""
        x, y, z, w = np.moveaxis(np.asarray(rotation.as_quat(), dtype=float), -1, 0)
        return cls.from_euler_parameters(np.stack([w, x, y, z], axis=-1))

    @classmethod
    def identity(cls) -> Rotation:
        """No rotation."""
        return cls.from_euler_parameters((1.0, 0.0, 0.0, 0.0))

    # Read ----------------------------------------------------------------------------------------------------------------

    @property
    def is_symbolic(self) -> bool:
        """Whether the rotation is symbolic."""
        return formulas.symbolic(self._cosines if self._parameters_by is None else self._homogeneous[0])

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of an array of rotations; () for a single rotation."""
        return self._cosines.shape[:-2] if self._parameters_by is None else self._homogeneous[0].shape[:-1]

    @cached_property
    def _cosines(self) -> Entries:
        return formulas.cosines_of(*self._homogeneous) if self._cosines_by is None else self._cosines_by()

    @cached_property
    def _homogeneous(self) -> tuple[Entries, bool]:
        return (formulas.parameters_of(self._cosines), True) if self._parameters_by is None else self._parameters_by()

    @cached_property
    def _parameters(self) -> Entries:
        p, unit = self._homogeneous
        if not unit:
            p = p / np.sqrt((p * p).sum(axis=-1, keepdims=True))
        return p if formulas.symbolic(p) else formulas.upward(p)

    @property
    def direction_cosines(self) -> Any:
        """Direction cosines ᴬCᴮ, v_A = ᴬCᴮ v_B: a Matrix of expressions, or an array (…, 3, 3)."""
        return Matrix(self._cosines) if self.is_symbolic else self._cosines.copy()

    @property
    def euler_parameters(self) -> Any:
        """Euler parameters (e0, e1, e2, e3) = (cos θ/2, λ sin θ/2); for numbers, the first nonzero one is positive.

        Expressions made from symbolic direction cosines are valid for θ < π, where e0 > 0.
        """
        return _read(self._parameters)

    @property
    def rodrigues_parameters(self) -> Any:
        """Rodrigues parameters ρ = λ tan θ/2 = (e1, e2, e3)/e0.

        Raises
        ------
        SpaceError
            if θ = π, where they do not exist
        """
        rho = self._given.get("rodrigues")
        if rho is None:
            p, _ = self._homogeneous
            if not formulas.symbolic(p) and np.any(p[..., 0] == 0):
                raise SpaceError(
                    "Expected a rotation by less than half a turn, got one by half a turn, whose Rodrigues parameters are infinite. "
                    "Read euler_parameters or axis_angle."
                )
            rho = p[..., 1:] / p[..., :1]
        return _read(rho)

    @property
    def axis_angle(self) -> tuple[Any, Any]:
        """Axis λ and angle θ (rad); for numbers 0 ≤ θ ≤ π, and λ = (1, 0, 0) where θ = 0."""
        if "axis_angle" in self._given:
            axis, angle = self._given["axis_angle"]
            return axis, angle
        if self.is_symbolic:
            p, _ = self._homogeneous
            sine = sqrt((p[1:] * p[1:]).sum())
            return tuple(p[1:] / sine), 2 * atan2(sine, p[0])
        p = self._parameters
        v = p[..., 1:]
        sine = np.linalg.norm(v, axis=-1, keepdims=True)
        axis = np.where(sine > 0, v / np.where(sine > 0, sine, 1.0), np.array([1.0, 0.0, 0.0]))
        return axis, 2 * np.arctan2(sine[..., 0], p[..., 0])

    def angles(self, sequence: str, *, space: bool = False) -> Any:
        """The angles (rad) of `sequence`, see `from_angles`: the second from −π/2 to π/2, or from 0 to π in sequences like "zxz".

        With the second angle at an end of its range (gimbal lock), only the sum or difference of the other two is determined:
        numerically, the first (body-fixed axes) or the last (space-fixed axes) is set to 0. Symbolic formulas are not valid there.
        """
        axes = turning_axes(sequence, (0, 0, 0))
        known = self._given.get(_named(axes, space))
        if known is None:
            known = formulas.angles_of(self._cosines, axes[::-1] if space else axes)
            known = known[..., ::-1] if space else known
        return _read(known)

    @property
    def small_angles(self) -> Any:
        """The rotation vector to first order in small angles: the antisymmetric part of ᴬCᴮ."""
        c = self._cosines
        parts = (c[..., 2, 1] - c[..., 1, 2], c[..., 0, 2] - c[..., 2, 0], c[..., 1, 0] - c[..., 0, 1])
        return _read(np.stack([x / 2 for x in map(np.asarray, parts)], axis=-1))

    def apply(self, v: Any) -> Any:
        """Measure numbers ᴬCᴮ v along A of a vector with the measure numbers v along B: three, or (…, 3)."""
        known = _entries(v, (3,), "measure numbers")
        _check_alike("rotations and vectors", self.shape, known.shape[:-1])
        return _read((self._cosines * known[..., None, :]).sum(axis=-1))

    def evaluate(self, values: Mapping[Any, Any]) -> Rotation:
        """The numerical rotation for given values of the symbols, by symbol or name as in `kane.evaluate`."""
        if not self.is_symbolic:
            return self
        numbers = np.broadcast_arrays(*evaluate([as_expr(x) for x in self._cosines.reshape(9)], values))
        c = np.stack(numbers, axis=-1).reshape(*numbers[0].shape, 3, 3)
        return Rotation.from_direction_cosines(c)

    # Made of others ------------------------------------------------------------------------------------------------------

    def __matmul__(self, other: Rotation) -> Rotation:
        expect.instance(
            other, Rotation, "two rotations in R @ S", "A vector is turned by R.apply(v).", error=SpaceError
        )
        mixed = self.is_symbolic or other.is_symbolic
        _check_alike("rotations in R @ S", self.shape, other.shape)
        alone = not mixed or self.shape == () == other.shape
        expect.that(alone, "one rotation in R @ S with one of symbols", came="an array", error=SpaceError)

        def cosines() -> Entries:
            return np.asarray(self._cosines @ other._cosines)

        def parameters() -> tuple[Entries, bool]:
            (p, unit), (q, also) = self._homogeneous, other._homogeneous
            return formulas.product(p, q), unit and also

        return Rotation._of(cosines if mixed else None, parameters)

    @property
    def inverse(self) -> Rotation:
        """The inverse: the orientation of A in B."""
        by, own = self._cosines_by, self._parameters_by

        def parameters() -> tuple[Entries, bool]:
            p, unit = self._homogeneous
            return formulas.conjugate(p), unit

        return Rotation._of(
            None if by is None else lambda: np.swapaxes(self._cosines, -1, -2), None if own is None else parameters
        )

    def to_scipy(self) -> ScipyRotation:
        """SciPy's rotation of measure numbers, v_A = R v_B."""
        if self.is_symbolic:
            raise SpaceError("Expected a rotation of numbers, got one of symbols. Use R.evaluate({…}).to_scipy().")
        from scipy.spatial.transform import Rotation as ScipyRotation

        return ScipyRotation.from_quat(self._parameters[..., [1, 2, 3, 0]])

    _repr_latex_ = show.latex

    def __repr__(self) -> str:
        if not self.is_symbolic and self.shape:
            return f"Rotation(array of {' × '.join(map(str, self.shape))})"
        return f"Rotation({Matrix(self._cosines)!r})" if self.is_symbolic else f"Rotation({self._cosines.tolist()})"


def _restored(cosines: Entries | None, parameters: tuple[Entries, bool] | None, given: Mapping[str, Any]) -> Rotation:
    """A rotation that was pickled."""
    c, p = cosines, parameters
    return Rotation._of(None if c is None else lambda: c, None if p is None else lambda: p, **given)


def small_rotation(angles: Any) -> Any:
    """ᴬCᴮ = 1 + θ× to first order in three small angles (rad), whatever their order (Kane, Likins & Levinson 1983, sec. 1.8)."""
    t = _entries(angles, (3,), "three small angles")
    one, (x, y, z) = np.ones_like(t[..., 0]), np.moveaxis(t, -1, 0)
    rows = [[one, -z, y], [z, one, -x], [-y, x, one]]
    c = np.stack([np.stack([np.asarray(e) for e in row], axis=-1) for row in rows], axis=-2)
    return Matrix(c) if formulas.symbolic(c) else c


def _named(axes: Sequence[int], space: bool) -> str:
    return f"{'space' if space else 'body'} {''.join('xyz'[k] for k in axes)}"


def _read(entries: Entries) -> Any:
    return tuple(map(as_expr, entries)) if formulas.symbolic(entries) else np.array(entries)


def _entries(given: Any, shape: tuple[int, ...], what: str) -> Entries:
    """An array of floats (…, *shape), or of expressions of this shape."""
    if isinstance(given, Vector):
        raise SpaceError(f"Expected {what} as numbers or expressions, got a Vector. Take v.components(frame).")
    rows = given.rows if isinstance(given, Matrix) else given
    try:
        e = np.asarray(rows)
        wanted = object if e.dtype == object else float
        e = e if wanted is object else expect.reals(e)
    except (TypeError, ValueError) as error:
        raise SpaceError(f"Expected {what} as numbers or expressions, got {cut(repr(given))}.") from error
    if e.shape[e.ndim - len(shape) :] != shape or e.ndim < len(shape):
        raise SpaceError(f"Expected {what} of shape {shape} or (…, {', '.join(map(str, shape))}), got shape {e.shape}.")
    if wanted is object:
        if e.shape != shape:
            raise SpaceError(f"Expected one rotation of symbols, got {what} of shape {e.shape}: arrays are of numbers.")
        found = np.empty(shape, dtype=object)
        for place in np.ndindex(shape):
            found[place] = as_expr(e[place])
        return found if any(isinstance(x, Expr) for x in e.flat) else found.astype(float)
    if not np.isfinite(e).all():
        raise SpaceError(f"Expected {what} that are finite, got {cut(repr(given))}.")
    return e


def _check_alike(what: str, first: tuple[int, ...], other: tuple[int, ...]) -> None:
    """Arrays of rotations, axes or vectors have shapes that go together."""
    try:
        np.broadcast_shapes(first, other)
    except ValueError as error:
        came = f"{first} and {other}"
        raise expect.refusal(SpaceError, f"{what} of one shape, or a single one of either", came) from error


def _unit(v: Array, what: str) -> Array:
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    off = np.abs(length - 1).max(initial=0)
    if not off <= GIVEN:
        raise SpaceError(
            f"Expected {what} of length 1, got one whose length differs from it by {off:.3g}. Divide by the length."
        )
    return np.asarray(v / length)


def _about(n: Entries, theta: Entries) -> Entries:
    """C = c 1 + (1 − c) λ λᵀ + s λ× of expressions."""
    angle = as_expr(theta[()])
    x, y, z = map(as_expr, n)
    return np.array(turned_about((x, y, z), cos(angle), sin(angle)), dtype=object)


def _halved(n: Entries, theta: Entries) -> Entries:
    n, half = np.broadcast_arrays(n, theta[..., None] / 2)
    return np.concatenate([np.cos(half[..., :1]), n * np.sin(half)], axis=-1)
