# SPDX-License-Identifier: BSD-3-Clause
"""Beams on hubs: one that spins about N.z, its motion prescribed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import kane as kn
from kane import Beam


def spinning(
    *, flap: bool = False, hub: float = 0.0, angle: Any = None, modes: Any = 5, **more: Any
) -> tuple[Beam, kn.System]:
    """A beam of unit length, mass and EI, clamped to a hub that turns by Ω t, or an `angle`."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    Omega = kn.parameter("Omega", 0.0, "rad/s")
    A = N.rotate("A", Omega * kn.time if angle is None else angle, N.z)
    root = O.at("R", hub * A.x) if hub else O
    more = {"length": 1.0, "mass_per_length": 1.0, "EI": 1.0, **more}
    beam = kn.Beam("beam", root, frame=A, axis=A.x, along=A.z if flap else A.y, modes=modes, **more)
    return beam, kn.System(N, bodies=[beam])


def frequencies(system: kn.System) -> Callable[..., np.ndarray]:
    """A function of parameters: imaginary parts of the eigenvalues about the straight beam, ascending."""
    linearizer = kn.linearizer(kn.derive(system))

    def at(**parameters: float) -> np.ndarray:
        rest = {"q": dict.fromkeys(system.coordinates, 0.0), "u": dict.fromkeys(system.speeds, 0.0)}
        eigenvalues = np.linalg.eigvals(linearizer(**rest, parameters=parameters, steady=False).A)
        assert np.abs(eigenvalues.real).max() < 1e-6 * np.abs(eigenvalues).max()
        return np.sort(eigenvalues.imag[eigenvalues.imag > 0])

    return at
