# SPDX-License-Identifier: BSD-3-Clause
"""The chapter on eigenvalues: frequency, damping and shape of each mode."""

import math
from collections.abc import Iterator

import numpy as np

from kane.analysis.linear import Linear, Mode
from kane.equations.equations import Equations
from kane.numeric.scale import SIX_DIGITS
from kane.present.languages.catalogue import tr, trn
from kane.present.linearized.chapter import Part, Section, latex_of, number
from kane.present.overview import Cell, PageTable, Tex

_SHOWN = 0.05
"""Smallest component of a mode that is listed, relative to the largest."""
_FEW = 3
"""Largest number of components of a mode that are listed."""
_NONE = "–"


def eigenvalues(eom: Equations, linear: Linear) -> Section:
    """A table row for each mode, with one for a conjugate pair, by decreasing real part and increasing frequency."""
    return Section("eigenvalues", tr("Eigenvalues"), tuple(_parts(eom, linear)))


def _parts(eom: Equations, linear: Linear) -> Iterator[Part]:
    size = max((m.frequency for m in linear.modes), default=0.0)
    least = SIX_DIGITS * size  # multiple zero eigenvalues are less accurate
    yield _verdict(linear, least)
    head = (r"$\lambda$ (1/s)", r"$|\lambda|$ (rad/s)", tr("frequency (Hz)"), tr("damping"), tr("mode"))
    ordered = sorted(linear.modes, key=lambda m: (-m.eigenvalue.real * (abs(m.eigenvalue.real) > least), m.frequency))
    yield PageTable("", head, tuple(_row(eom, m, len(linear.coordinates), least) for m in ordered))
    yield tr(
        r"The frequency is $|\mathrm{Im}\,\lambda|/2\pi$, the damping $-\mathrm{Re}\,\lambda/|\lambda|$. Each mode lists the "
        "coordinates that take part most, compared by their numbers, with their phases; speeds, where no coordinate does."
    )


def _verdict(linear: Linear, least: float) -> str:
    growing = sum(m.eigenvalue.real > least for m in linear.modes)
    staying = sum(abs(m.eigenvalue.real) <= least for m in linear.modes)
    if growing:
        return trn("%(n)s mode grows: unstable.", "%(n)s modes grow: unstable.", growing)
    if staying:
        return trn(
            "No mode grows; %(n)s neither grows nor decays.", "No mode grows; %(n)s neither grow nor decay.", staying
        )
    return tr("Every mode decays: stable.")


def _row(eom: Equations, mode: Mode, coordinates: int, least: float) -> tuple[Cell, ...]:
    real, imaginary = mode.eigenvalue.real, mode.eigenvalue.imag
    real = real if abs(real) > least else 0.0
    still = mode.frequency <= least
    swings = imaginary > least
    told = rf"{number(real) if real else ''} \pm {number(imaginary)}\,\mathrm{{i}}" if swings else number(real)
    return (
        Tex(told.strip()), "0" if still else f"{mode.frequency:.5g}", f"{imaginary / (2 * math.pi):.5g}" if swings else _NONE,
        _NONE if still else f"{-real / mode.frequency + 0.0:.4g}", Tex(_shape(eom, mode, coordinates)),
    )  # fmt: skip


def _shape(eom: Equations, mode: Mode, coordinates: int) -> str:
    """The largest components in decreasing size, scaled so that the first is 1."""
    own = mode.vector[:coordinates]
    moves = np.abs(own).max(initial=0.0) > SIX_DIGITS * np.abs(mode.vector).max(initial=0.0)
    vector, names = (own, mode.names[:coordinates]) if moves else (mode.vector, mode.names)
    order = np.argsort(-np.abs(vector), kind="stable")
    relative = vector / vector[order[0]]
    kept = [k for k in order.tolist() if abs(relative[k]) >= _SHOWN]
    latex = latex_of(eom, names)
    told = [rf"{latex[k]}\; {_component(complex(relative[k]))}" for k in kept[:_FEW]]
    return r",\;\; ".join([*told, *([r"\dots"] if len(kept) > _FEW else [])])


def _component(value: complex) -> str:
    """Amplitude and phase; a sign for components in phase or in antiphase."""
    degrees = round(math.degrees(math.atan2(value.imag, value.real)))
    if degrees % 180 == 0:
        return number(abs(value) if degrees == 0 else -abs(value), 3)
    return rf"{number(abs(value), 3)}\angle {degrees}^{{\circ}}"
