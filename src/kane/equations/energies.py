# SPDX-License-Identifier: BSD-3-Clause
"""Energies, power, momenta and integrals, as attributes of equations; and whether declared potentials are those of their forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.dynamics.derivation import Derived, Exprs
from kane.dynamics.in_rates import InRates
from kane.dynamics.lazy import read
from kane.dynamics.readings import energy
from kane.dynamics.readings.contributions import by_rates, states
from kane.dynamics.readings.energy import Impulse, KineticParts
from kane.dynamics.readings.integrals import Integral, integrals
from kane.dynamics.readings.potential import FoundPotential, find_potential
from kane.dynamics.solved import Solved
from kane.errors import warn
from kane.expr.differentiation import gradient
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate
from kane.model.loads import Load
from kane.numeric.scale import SIX_DIGITS, bounded
from kane.space.frame import Point
from kane.space.vector import Vector


class Energies:
    """What `Equations` say of energies and momenta (Kane & Levinson 1985, ch. 5, sec. 6.8, 7.1 to 7.4)."""

    solved: Solved

    kinetic_energy = read[Expr](lambda e: energy.whole_kinetic_energy(e.solved), "K = ½ Σ m v·v + ω·I·ω.")
    kinetic_energy_parts = read[KineticParts](
        lambda e: energy.kinetic_energy_parts(e.bodies, e.speeds),
        "K₂, K₁ and K₀, of degree 2, 1 and 0 in the speeds; K₂ = ½ Σ M_rs u_r u_s. Their sum is K.",
    )
    potential_energy = read[Expr](
        lambda e: energy.potential_energy(e.loads),
        "V, the sum of the loads' potentials; gravity's is zero at the root point's height.",
    )
    energy = read[Expr](lambda e: e.kinetic_energy + e.potential_energy, "E = K + V.")
    power = read[Expr](
        lambda e: energy.power(e.solved),
        "P with dE/dt = P: the power of the loads without a potential and of prescribed motions.",
    )
    load_powers = read[Mapping[Load, Expr]](
        lambda e: energy.load_powers(e._shown, dict(zip((*e.system.gravities, *e.system.loads), e.loads, strict=True))),
        "Σ F·v + Σ T·ω of each load, by the load or its name.",
    )
    gibbs_function = read[Expr](
        lambda e: energy.gibbs_function(e.bodies),
        "G = ½ Σ m a·a + α·I·α + 2 α·(ω × I·ω), with ∂G/∂u̇_r = −F*_r: Gibbs's function, in u̇.",
    )
    Fr_star_by_energy = read[Exprs](
        lambda e: energy.inertia_forces_by_energy(e._shown),
        "F*_r = −Σ_s (d/dt ∂K/∂q̇_s − ∂K/∂q_s) W_sr: a second way to the generalized inertia forces of all speeds.",
    )
    generalized_momenta = read[Exprs](
        lambda e: energy.generalized_momenta(e.bodies, e.speeds), "p_r = Σ m v_r·v + ω_r·I·ω, one a speed."
    )
    generalized_momenta_nh = read[Exprs](
        lambda e: energy.generalized_momenta(e.solved.nonholonomic.bodies, e.independent_speeds),
        "Σ m ṽ_r·v + ω̃_r·I·ω, one for each independent speed.",
    )
    conjugate_momenta = read[Exprs](
        lambda e: energy.conjugate_momenta(e._shown), "p_s = ∂K/∂q̇_s, one a coordinate, in speeds."
    )
    cyclic_coordinates = read[tuple[Coordinate, ...]](
        lambda e: energy.cyclic_coordinates(e._shown),
        "Coordinates on which neither K nor forces nor constraints depend, and along which none acts: their momenta are constant.",
    )
    central_angular_momentum = read[Vector](
        lambda e: energy.central_angular_momentum(e.bodies), "Σ I·ω + r × m v about the mass centre."
    )
    integrals = read[tuple[Integral, ...]](
        lambda e: integrals(e.solved),
        "Integrals of the equations of motion, each with its name, value and reason: energy, Hamiltonian, momenta, speeds.",
    )

    def find_potential(self, loads: Sequence[Any] | None = None) -> FoundPotential:
        """V found from F_r = −Σ_s ∂V/∂q_s W_sr, whatever the speeds, also under constraints (Kane & Levinson 1985, sec. 5.1).

        Parameters
        ----------
        loads : some of the system's loads, themselves or by name; all of them if left out

        Returns
        -------
        FoundPotential
            `.value` is V, and `.how` says how it was integrated

        Raises
        ------
        PotentialError
            if there is none, or none was found: says which forces depend on rates, or which coordinates' derivatives disagree where
        """
        return find_potential(self.solved.derived, loads)

    def generalized_impulses(self, impulses: Sequence[Impulse]) -> Exprs:
        """I_r = Σ v_r·∫F dt + ω_r·∫T dt, one a speed, of impulses (point, vector) and impulses of torques (frame, vector)."""
        return energy.generalized_impulses(self.solved.derived, impulses, self.solved.derived.speeds)

    def mass_center(self, origin: Point) -> Vector:
        """Position of the system's mass centre from `origin`."""
        return energy.mass_center(self.solved.derived.as_declared.bodies, origin)

    def linear_momentum(self) -> Vector:
        """Σ m v."""
        return energy.linear_momentum(self.solved.derived.as_declared.bodies)

    def angular_momentum(self, about: Point) -> Vector:
        """Σ I·ω + r × m v about a point fixed in the inertial frame."""
        return energy.angular_momentum(self.solved.derived.as_declared.bodies, about)


def check_potentials(derived: Derived) -> None:
    """Warn of each load whose potential is not that of its forces: its work would be wrong, and so the energy."""
    for load in derived.system.loads:
        if load.potential is not None and _differs(derived, load, load.potential):
            warn(
                f"Expected the potential of {load.name!r} to be that of its forces, F·v + T·ω = −dV/dt, got another one: they differ "
                "at random states. The motion is right, its energy and work are not. Correct the potential's sign or factor, or leave "
                "it out: the work of the forces then counts as power."
            )


def _differs(derived: Derived, load: Load, v: Expr) -> bool:
    """Whether −∂V/∂q are others than the load's forces at some state, but for what is along a constraint's force."""
    q, rows = derived.system.coordinates, InRates(derived).rows
    exprs = [*by_rates(derived, [load]), *gradient(v, q), *rows.entries]
    at = states(derived, exprs, varied=False)
    values = {x: np.array([place[x] for place in at]) for x in at[0]}
    found = [[np.broadcast_to(x, len(at)) for x in pair] for pair in bounded(exprs, values)]
    for numbers, errors in np.moveaxis(np.array(found), -1, 0).swapaxes(1, 2):
        (pushed, steep), c = numbers[: 2 * len(q)].reshape(2, -1), numbers[2 * len(q) :].reshape(rows.shape)
        gap, whole = pushed + steep, SIX_DIGITS * (np.abs(pushed) + np.abs(steep))
        whole += np.nan_to_num(errors[: 2 * len(q)].reshape(2, -1).sum(axis=0), posinf=0.0)
        if not np.isfinite(numbers).all():
            continue
        if len(c):
            gap, whole = gap - np.linalg.lstsq(c.T, gap, rcond=None)[0] @ c, whole.max(initial=0)
        if (np.abs(gap) > whole).any():
            return True
    return False
