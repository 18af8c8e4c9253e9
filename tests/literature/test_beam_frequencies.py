# SPDX-License-Identifier: BSD-3-Clause
"""Frequencies of beams at rest: tapered to a point, free at both ends, pinned at both ends, and by tabulated modes.

Kirchhoff, G. (1879), for the wedge and the cone; Blevins, R. D. (1979), Formulas for Natural Frequency and Mode Shape, table 8-1.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.systems.beams import frequencies, spinning

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
UNIT = {"length": 1.0, "mass_per_length": 1.0, "EI": 1.0}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mass", "stiffness", "expected"), [(1, 3, (5.3151, 15.207)), (2, 4, (8.7193, 21.146))], ids=["wedge", "cone"]
)
def test_tapered_to_a_point(mass: int, stiffness: int, expected: tuple[float, float]) -> None:
    _, system = spinning(
        mass_per_length=kn.tapered(1.0, lambda x: (1 - x) ** mass),
        EI=kn.tapered(1.0, lambda x: (1 - x) ** stiffness),
        modes=kn.mode_shapes("polynomials", 8),
    )
    np.testing.assert_allclose(frequencies(system)()[:2], expected, rtol=3e-5)


def test_tapers_that_are_none() -> None:
    with pytest.raises(kn.ModelError, match=r"a taper above zero from the root to the tip, got -0\.5 at ξ = 1"):
        kn.tapered(1.0, lambda x: 1 - 1.5 * x)
    with pytest.raises(kn.ModelError, match="a function of ξ = x/L as the taper, got 3"):
        kn.tapered(1.0, 3)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("support", ["free", "clamped"])
def test_free_at_both_ends(support: str) -> None:
    """In a frame that floats with it, by its own functions or by those of a beam that is clamped to the frame."""
    base = kn.planar("base", O, N, normal=N.z)
    A = base.frame
    modes = 2 if support == "free" else kn.mode_shapes("polynomials", 6)
    beam = kn.Beam("beam", base.point, frame=A, axis=A.x, modes=modes, support=support, **UNIT)
    found = frequencies(kn.System(N, bodies=[beam], joints=[base]))()
    np.testing.assert_allclose(found[found > 1][0], 22.3733, rtol=1e-5)


def test_pinned_at_both_ends() -> None:
    """n² π²: the frame turns about the first pin, and the second closes a loop."""
    hinge = kn.pin("hinge", O, N, axis=N.z)
    A = hinge.frame
    beam = kn.Beam("beam", hinge.point, frame=A, axis=A.x, modes=2, support="pinned", **UNIT)
    held = kn.coincident(beam.point_at(1), O.at("E", N.x), along=(N.y,))
    eom = kn.derive(kn.System(N, bodies=[beam], joints=[hinge], holonomic=held))
    zero = {"q": dict.fromkeys(eom.coordinates, 0.0), "u": dict.fromkeys(eom.speeds, 0.0)}
    found = np.sort(np.abs(kn.linearize(eom, **zero).eigenvalues.imag))
    np.testing.assert_allclose(found, np.repeat([1, 4], 2) * np.pi**2, rtol=1e-9)


@pytest.mark.parametrize("form", ["linearized", pytest.param("nonlinear", marks=pytest.mark.slow)])
def test_tabulated_modes(form: str) -> None:
    """Those of 20 elements with slopes, at a spin."""
    own, x = kn.mode_shapes("clamped-free", 2), np.linspace(0, 1, 21)
    table = kn.mode_shapes(table=(x, own.evaluate(x, 0), own.evaluate(x, 1)))
    found, exact = (frequencies(spinning(modes=m, form=form)[1])(Omega=2.0) for m in (table, own))
    np.testing.assert_allclose(found, exact, rtol=1e-5)
