# SPDX-License-Identifier: BSD-3-Clause
"""The linearized equations: ẋ = A x + B r, y = C x + D r, their eigenvalues and modes, and M q̈ + C q̇ + K q = F r.

Normal modes of M ẍ + K x = 0: x = B η, BᵀM B = 1, BᵀK B = Λ (Kane & Levinson 1985, sec. 7.9).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kane import expect, show
from kane.equations.state import State
from kane.errors import ArgumentError, Attributes, SimulationError, ValueMissingError
from kane.numeric.arrays import Array, Complex, Mask, leading, ranks
from kane.numeric.rank import Spectrum, decays, singular, spectrum
from kane.numeric.sampling import names_in
from kane.numeric.scale import EPS, GIVEN, ROUNDED

_LINK = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Mode(Attributes):
    """A mode: an eigenvalue λ (1/s), Im λ ≥ 0, and its eigenvector, scaled so that the first of its largest components is 1.

    `shape` is the eigenvector by state, `frequency` |λ| (rad/s), `damping` the damping ratio −Re λ/|λ|.
    """

    eigenvalue: complex
    names: tuple[str, ...]
    vector: Complex

    @property
    def shape(self) -> dict[str, complex]:
        """The components of the eigenvector, by name of the state."""
        return dict(zip(self.names, self.vector.tolist(), strict=True))

    @property
    def frequency(self) -> float:
        """Undamped natural frequency |λ| (rad/s)."""
        return abs(self.eigenvalue)

    @property
    def damping(self) -> float:
        """Damping ratio −Re λ/|λ|: 1 decays without oscillation, 0 is undamped, negative values grow; 0 for λ = 0."""
        return 0.0 - self.eigenvalue.real / self.frequency if self.frequency else 0.0  # avoids −0

    def __repr__(self) -> str:
        return f"Mode(λ = {self.eigenvalue:.6g}, frequency {self.frequency:.4g} rad/s, damping {self.damping:.3g})"


@dataclass(frozen=True, slots=True, eq=False)
class SecondOrder(Attributes):
    """Linear equations M q̈ + C q̇ + K q = F r in perturbations q of the coordinates `names`, with `inputs` r."""

    names: tuple[str, ...]
    inputs: tuple[str, ...]
    M: Array
    C: Array
    K: Array
    F: Array


@dataclass(frozen=True, eq=False, repr=False)
class Linear(Attributes):
    """Linear equations ẋ = A x + B r, y = C x + D r for small perturbations x, r, y from the operating point `point`.

    `states` names x: perturbations of the independent coordinates (for Euler parameters three small angles `theta…` along the axes
    of the frame that they orient), then of the independent speeds, then of the states `further` from `kn.state`. `rates` is ẋ and
    `values` the outputs at the point, `mass` the mass matrix of the independent speeds, and `cyclic` the states on which no speed
    depends. `scale` are changes of x that go together, in any units: at one energy, and those of coordinates in 1/pace.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    coordinates: tuple[str, ...]
    A: Array
    B: Array
    C: Array
    D: Array
    point: State
    rates: Array
    values: Array
    mass: Array
    cyclic: tuple[str, ...]
    scale: Array
    further: tuple[str, ...] = ()

    @property
    def speeds(self) -> tuple[str, ...]:
        """Names of the independent speeds."""
        return self.states[len(self.coordinates) : len(self.states) - len(self.further)]

    @cached_property
    def eigenvalues(self) -> Complex:
        """Eigenvalues of A (1/s) in the order of decreasing real part, then, if these agree within rounding, imaginary part."""
        return self._spectrum.values

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """The modes in the order of the eigenvalues, one for each conjugate pair."""
        values, vectors, _ = self._spectrum
        shapes = vectors / vectors[leading(vectors), range(len(values))]
        return tuple(
            Mode(e, self.states, v) for e, v in zip(map(complex, values), shapes.T, strict=True) if e.imag >= 0
        )

    @cached_property
    def _spectrum(self) -> Spectrum:
        found = spectrum(self.A)
        order = np.lexsort((-found.values.real, -found.values.imag, ranks(-found.values.real, found.rounding)))
        return Spectrum(found.values[order] + 0.0, found.vectors[:, order], found.rounding[order])

    @property
    def stable(self) -> bool:
        """Whether every eigenvalue has a negative real part, beyond rounding: whether the operating point is asymptotically stable."""
        return decays(self.A, self._spectrum)

    def _indices(self, states: Any) -> list[int]:
        names = names_in("states", states)
        unknown = (n for n in names if n not in self.states)
        cure = "The others follow from the constraints; independent= chooses which."
        expect.none(unknown, f"states among {', '.join(self.states)}", cure=cure, error=ValueMissingError)
        return [self.states.index(n) for n in names]

    def without(self, *states: Any) -> "Linear":
        """The linear equations without some states, on which no other depends; `without("cyclic")` removes all cyclic ones.

        Raises
        ------
        SimulationError
            if a remaining state or an output depends on a removed one
        """
        cyclic = names_in("states", states) == ["cyclic"]
        gone = self._indices(self.cyclic if cyclic else states)
        keep = [i for i in range(len(self.states)) if i not in gone]
        own = [self.states[i] for i in keep]
        self._check_untied(self.A * self.scale / self.scale[:, None], keep, [] if cyclic else own, gone)
        self._check_untied(self.C * self.scale, slice(None), [f"the output {name}" for name in self.outputs], gone)
        held = [i for i in keep if i >= len(self.coordinates)]
        speeds = [i - len(self.coordinates) for i in held if self.states[i] not in self.further]
        kinds: Any = ("states", "coordinates", "cyclic", "further")
        left: dict[str, Any] = {kind: tuple(n for n in getattr(self, kind) if n in own) for kind in kinds}
        left |= {"A": self.A[np.ix_(keep, keep)], "B": self.B[keep], "C": self.C[:, keep]}
        left |= {"rates": self.rates[keep], "scale": self.scale[keep]}
        return replace(self, mass=self.mass[np.ix_(speeds, speeds)], **left)

    def _check_untied(self, a: Array, rows: Any, labels: Sequence[str], gone: Sequence[int]) -> None:
        tied = np.argwhere(_links(a)[rows][:, gone])
        if labels and len(tied):
            i, j = tied[0]
            raise SimulationError(
                f"Expected states that nothing depends on, got {self.states[gone[j]]}: {labels[i]} depends on it. Those on which no "
                f"speed depends are {', '.join(self.cyclic) or 'none'}."
            )

    def second_order(self, coordinates: Any = "all") -> SecondOrder:
        """The second-order form M q̈ + C q̇ + K q = F r of all coordinates, or of some that are decoupled from the others.

        With q̇ = G q + H u and u̇ = P q + Q u + B r,

            M = (H M_u⁻¹ Hᵀ)⁻¹,   C = −M (G + H Q H⁺),   K = −M (H P − H Q H⁺ G),   F = M H B

        where H⁺ = M_u⁻¹ Hᵀ M, and M_u is the mass matrix of the independent speeds. The result does not depend on the choice of
        these speeds; their components that leave the coordinates unchanged are free.

        Raises
        ------
        SimulationError
            if the rates of the coordinates are not independent, or the coordinates are coupled with others or with further speeds
        """
        expected = "coordinates and speeds alone for the second-order form"
        cure = "Use A and B, or leave out states on which nothing depends: linear.without(…)."
        expect.none(self.further, expected, "the further states {}", cure, error=SimulationError)
        count = len(self.coordinates)
        q = list(range(count)) if names_in("coordinates", coordinates) == ["all"] else self._indices(coordinates)
        wrong = (self.states[i] for i in q if i >= count)
        expect.none(wrong, "coordinates for the second-order form", "the speeds {}", error=SimulationError)
        u = slice(count, len(self.states))
        h = self.A[q, u]
        back = np.linalg.solve(self.mass, h.T)
        mobility = h @ back
        length = np.sqrt(np.diag(mobility))
        if not np.all(length > 0) or not singular(mobility / np.outer(length, length)).regular(_LINK):
            raise SimulationError(
                f"Expected as many speeds as coordinates, got {len(q)} coordinates ({', '.join(self.states[i] for i in q)}) "
                f"moved by {len(self.speeds)} independent speeds ({', '.join(self.speeds)}), which do not move each of them "
                "independently. Name the coordinates without the cyclic ones: second_order([…])."
            )
        m = np.linalg.inv(mobility)
        m = (m + m.T) / 2
        inverse = back @ m
        g, turn = self.A[np.ix_(q, q)], h @ self.A[u, u]
        one = np.eye(len(self.mass))
        self._check_closed(q, h, turn @ (one - inverse @ h), np.abs(turn) @ (one + np.abs(inverse) @ np.abs(h)))
        if np.abs(self.B[q]).max(initial=0) > 0:
            raise SimulationError("Expected rates of coordinates that depend on no input, got others. Use A and B.")
        damping, stiffness = g + turn @ inverse, h @ self.A[u, q] - turn @ inverse @ g
        names = tuple(self.states[i] for i in q)
        return SecondOrder(names, self.inputs, m, -m @ damping, -m @ stiffness, m @ h @ self.B[u])

    def _check_closed(self, q: Sequence[int], h: Array, hidden: Array, terms: Array) -> None:
        """Raise SimulationError if q̇ or q̈ depend on other coordinates, or q̈ on speeds in a way, `hidden`, that q̇ does not tell.

        `terms` are the absolute values of which `hidden` is the difference.
        """
        count = len(self.coordinates)
        rest = [j for j in range(count) if j not in q]
        own = self.scale[q][:, None]
        rates, changes = self.A[q] * self.scale / own, h @ self.A[count:] * self.scale / own
        most = np.abs(h) @ np.abs(self.A[count:]) * self.scale / own
        hidden, terms = hidden * self.scale[count:] / own, np.hstack([most, terms * self.scale[count:] / own])
        tied = np.vstack([_links(rates)[:, rest], _links(changes, most)[:, rest]])
        pairs = [
            *((i % len(q), self.states[rest[j]]) for i, j in np.argwhere(tied)),
            *((i, "speeds that are not rates of these") for i, _ in np.argwhere(_links(hidden, terms))),
        ]
        if pairs:
            i, other = pairs[0]
            raise SimulationError(
                f"Expected coordinates that do not depend on others, got {self.states[q[i]]}, which depends on {other}. Name "
                "all that depend on each other, or use A and B."
            )

    def state_space(self) -> Any:
        """The equations as `control.StateSpace` of python-control, by the same names with `_` for `.`; without outputs, all states.

        Raises
        ------
        SimulationError
            if python-control is not installed
        """
        lacking = "Expected python-control for a StateSpace, got none: pip install control. A, B, C and D are available without it."
        control = expect.package("control", SimulationError(lacking))
        n, nr = len(self.states), len(self.inputs)
        c, d, names = (self.C, self.D, self.outputs) if self.outputs else (np.eye(n), np.zeros((n, nr)), self.states)
        own = {"states": self.states, "inputs": self.inputs, "outputs": names}
        signals = {kind: [x.replace(".", "_") for x in listed] for kind, listed in own.items()}
        return control.StateSpace(self.A, self.B, c, d, **signals)

    _repr_html_ = show.html

    def __repr__(self) -> str:
        values = ", ".join(f"{v:.4g}" for v in self.eigenvalues)
        return f"Linear({', '.join(self.states)}; eigenvalues {values})"


def _links(a: Array, terms: Array | None = None) -> Mask:
    """Which entries are significant beside the largest of their row, or of `terms`, and above rounding beside the largest of all."""
    size = np.abs(a if terms is None else terms)
    least = np.maximum(_LINK * size.max(axis=1, keepdims=True, initial=0), ROUNDED * size.max(initial=0))
    return np.asarray(np.abs(a) > least)


_ROUNDING = 16 * EPS
"""Rounding residue of a zero λ, as a fraction of the largest λ, for each coordinate."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class NormalModes(Attributes):
    """Normal modes of M ẍ + K x = 0: x = B η with η̈_k + λ_k η_k = 0, from `kn.analysis.normal_modes`.

    Attributes
    ----------
    names : names of the coordinates x, perturbations from the equilibrium
    squares : λ (n) in ascending order: squared frequencies ω² (rad²/s²), negative for a growing mode, 0 without restoring force
    shapes : the modal matrix B (n × n), a column for each mode, BᵀM B = 1
    M, K : mass and stiffness matrix (n × n)
    """

    names: tuple[str, ...]
    squares: Array
    shapes: Array
    M: Array
    K: Array

    @property
    def frequencies(self) -> Array:
        """Natural frequencies ω (rad/s); NaN for modes that do not oscillate."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(self.squares))

    @property
    def stable(self) -> bool:
        """Whether every mode oscillates."""
        return bool((self.squares > 0).all())

    def normal_coordinates(self, x: Any) -> Array:
        """Normal coordinates η = BᵀM x of perturbations x (n, or n × m), or of their rates."""
        expected = f"{len(self.names)} values, of {', '.join(self.names)}"
        own = expect.floats(x, expected, error=ArgumentError)
        expect.that(own.shape[:1] == (len(self.names),), expected, came=f"shape {own.shape}", error=ArgumentError)
        return np.asarray(self.shapes.T @ self.M @ own)

    def motion(self, t: Any, x: Any, rates: Any) -> Array:
        """Perturbations at the times t (s), as (n_t × n), that start at t = 0 with `x` and `rates`, in closed form."""
        start, drift = self.normal_coordinates(x), self.normal_coordinates(rates)
        times = expect.floats(t, "times in numbers", error=ArgumentError)[..., None]
        angle = np.sqrt(self.squares.astype(complex)) * times  # imaginary for growing modes
        even, reach = np.cos(angle).real, times * np.sinc(angle / np.pi).real
        return np.asarray((start * even + drift * reach) @ self.shapes.T)

    def __repr__(self) -> str:
        shown = ", ".join(
            f"{w:.4g}" if s >= 0 else f"λ = {s:.3g}" for w, s in zip(self.frequencies, self.squares, strict=True)
        )
        return f"NormalModes({', '.join(self.names)}; {shown} rad/s)"


def normal_modes(linear: Linear | SecondOrder) -> NormalModes:
    """Normal modes of a linear system without damping and gyroscopic terms.

    Parameters
    ----------
    linear : the result of `kn.linearize` at an equilibrium, or of its `second_order()`

    Returns
    -------
    NormalModes
        frequencies, the modal matrix, normal coordinates, motions in closed form

    Raises
    ------
    SimulationError
        if there are velocity-dependent terms, or K is not symmetric: use the complex modes `linear.modes`
    """
    cure = "Linearize first: kn.linearize(eom, q=…)."
    expect.instance(linear, (Linear, SecondOrder), "what kn.linearize gives", cure, error=ArgumentError)
    second = linear.second_order() if isinstance(linear, Linear) else linear
    m, c, k = second.M, second.C, second.K
    scale = np.sqrt(np.diag(m))
    unit = np.outer(scale, scale)
    stiff = np.abs(k / unit).max(initial=0.0)
    undamped, cure = np.abs(c / unit).max(initial=0.0) <= GIVEN * np.sqrt(stiff), "linear.modes has the complex modes"
    expected, came = "equations without damping and gyroscopic terms for normal modes", f"C with {np.abs(c).max():.3g}"
    expect.that(undamped, expected, came=came, cure=f"{cure}; second_order() has C.", error=SimulationError)
    symmetric = np.abs((k - k.T) / unit).max(initial=0.0) <= GIVEN * stiff
    came = "one of forces without a potential energy"
    expect.that(symmetric, "a symmetric K for normal modes", came=came, cure=f"{cure}.", error=SimulationError)
    from scipy.linalg import eigh  # slow to import

    squares, shapes = eigh((k + k.T) / 2, m)
    squares[np.abs(squares) <= _ROUNDING * len(m) * np.abs(squares).max(initial=0.0)] = 0.0
    signs = np.sign(shapes[leading(shapes), range(len(m))])
    return NormalModes(second.names, squares, shapes * signs, m, k)
