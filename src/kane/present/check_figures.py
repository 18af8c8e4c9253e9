# SPDX-License-Identifier: BSD-3-Clause
"""Checks with their figures, as the demo prints them and a report shows them; those of a motion use the motion alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.errors import Attributes
from kane.expr.evaluation import stacked
from kane.expr.matrix import Matrix
from kane.expr.symbols import rate
from kane.motion.solution.checks import EnergyCheck
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL, ROUNDED_CHAIN, SIX_DIGITS, SPEEDS_RANK
from kane.present.languages.catalogue import N_, tr


@dataclass(frozen=True, slots=True)
class Check(Attributes):
    """A check of equations for reports: its `name`, the `figure` found (NaN fails) and the `limit` that it must not exceed.

    `detail` describes the figure: for instance the two methods compared, and at how many states.
    """

    name: str
    figure: float
    limit: float
    detail: str = ""

    @property
    def passed(self) -> bool:
        """Whether `figure` is at most `limit`."""
        return self.figure <= self.limit

    def __str__(self) -> str:
        return f"{'pass' if self.passed else 'FAIL'}  {self.name}: {self.figure:.1e} (limit {self.limit:.0e})"


def energy_check(solution: Solution, *, of: str = "the loads", limit: float = SIX_DIGITS) -> Check:
    """The check that the energy changes only by the work done."""
    energy = solution.energy_check
    return Check(f"energy less the work of {of}, along the motion", energy.relative, limit, str(energy))


BY_LOADS = N_("energy less the work of the loads, along the motion")
"""The default name of that check."""


def energy_text(energy: EnergyCheck) -> str:
    """The text of an energy check, as by `str`, in the language of a report."""
    return tr(
        "energy minus work constant to %(drift)s J (%(relative)s of the energy present at t = %(at)s s)",
        drift=f"{energy.drift:.2e}", relative=f"{energy.relative:.1e}", at=f"{energy.at:.4g}",
    )  # fmt: skip


_SAMPLES = 101
"""Largest number of instants that are examined."""
_CONDITION = 1e10
_FAINT = ROUNDED_CHAIN / EQUAL
"""Ratio to the largest row below which a row is judged beside the largest, as it may consist of its rounding errors."""


def motion_checks(solution: Solution, others: Sequence[Check] = ()) -> tuple[Check, ...]:
    """The checks of a motion, without that of the energy if `others` contain it."""
    energy = replace(energy_check(solution), name=tr(BY_LOADS), detail=energy_text(solution.energy_check))
    checks = [] if any(c.detail == energy.detail for c in others) else [energy]
    few = _thinned(solution, np.arange(len(solution)))
    # reactions are undefined where the constraints lose rank
    told = _thinned(solution, np.flatnonzero(~solution.lost))
    residual = [max(map(_residual, _by_mode(told)), key=lambda c: c.figure)] if len(told) else []
    checks += [_power(few, solution.energy_check), *residual, _mass(few), _kinematical(few)]
    if len(solution.equations.b):
        checks.append(_constraints(solution))
    if len(solution.equations.reactions) > 1 and len(told):
        checks.append(_reactions(told))
    return tuple(checks)


def _thinned(solution: Solution, places: npt.NDArray[np.int_]) -> Solution:
    return taken(solution, places[np.unique(np.linspace(0, len(places) - 1, min(len(places), _SAMPLES)).astype(int))])


def taken(solution: Solution, at: npt.NDArray[np.int_]) -> Solution:
    """The motion at some of its samples."""
    equations = tuple(solution.samples[i] for i in at) if solution.samples else ()
    parts: dict[str, Any] = {what: getattr(solution, what)[at] for what in ("t", "states", "work", "phase")}
    return replace(solution, samples=equations, **parts)


def _by_mode(solution: Solution) -> list[Solution]:
    """The parts of a motion in each mode of contacts, with the equations of the mode; the whole motion without contacts."""
    modes = list(dict.fromkeys(eom for eom in solution.samples if eom.system.modes))
    at = [np.flatnonzero([own is eom for own in solution.samples]) for eom in modes]
    return [replace(taken(solution, k), equations=eom) for eom, k in zip(modes, at, strict=True)] or [solution]


def _at(solution: Solution) -> str:
    return tr("at %(n)s instants of the motion", n=len(solution))


def _power(solution: Solution, energy: EnergyCheck) -> Check:
    eom = solution.equations
    kinetic, potential = (eom.time_derivative(e) for e in (eom.kinetic_energy, eom.potential_energy))
    (k, v), p = solution[[kinetic, potential]], solution.power
    pace = energy.scale / (np.ptp(solution.t) or 1.0)
    scale = max(pace, *(np.abs(x).max() for x in (k, v, p)))
    detail = tr(
        "largest |dE/dt − P| over the largest of |dK/dt|, |dV/dt|, |P|, energy over duration, %(at)s", at=_at(solution)
    )
    return Check(tr("dE/dt less the power P"), _ratio(np.abs(k + v - p).max(), scale), EQUAL, detail)


def _residual(solution: Solution) -> Check:
    """The residual relative to the sizes of M u̇, F_r, F*_r and Aᵀλ in each row; rows near zero are judged beside the largest."""
    eom = solution.equations
    active, inertia = np.array(solution[list(eom.Fr)]), np.array(solution[list(eom.Fr_star)])
    u_dot = np.array(solution[[rate(u) for u in eom.speeds]])
    mass = _matrix(solution, Matrix([*eom.mass_matrix.rows, *eom.auxiliary_mass_matrix.rows]))
    held, terms = _constraint_balance(solution, active + inertia)
    size = (np.abs(active) + np.abs(inertia) + terms).T + np.einsum("nij,jn->ni", np.abs(mass), np.abs(u_dot))
    scale = size.max(axis=0)
    scale = np.maximum(scale, _FAINT * scale.max())
    off = np.abs(active + inertia + held).max(axis=1)
    detail = tr("Fᵣ and F*ᵣ from their terms, at the u̇ and reactions that were solved for, %(at)s", at=_at(solution))
    name = tr("residual of Fᵣ + F*ᵣ + Aᵀλ = 0") if len(eom.b) else tr("residual of Fᵣ + F*ᵣ = 0")
    return Check(name, max(map(_ratio, off, scale)), EQUAL, detail)


def _constraint_balance(solution: Solution, left: Array) -> tuple[Array, Array]:
    """Aᵀλ with the λ that balance the rows of speeds best, and the sizes of its terms."""
    eom, n = solution.equations, len(solution.equations.speeds)
    if not len(eom.b):
        return np.zeros_like(left), np.zeros_like(left)
    rows = [(*own, *more) for own, more in zip(eom.A.rows, eom.constraints.a_auxiliary, strict=True)]
    a = _matrix(solution, Matrix(rows, (len(eom.b), len(left))))
    forces = np.array(
        [np.linalg.lstsq(m[:, :n].T, -f, rcond=SPEEDS_RANK)[0] for m, f in zip(a, left[:n].T, strict=True)]
    )
    return np.einsum("nkr,nk->rn", a, forces), np.einsum("nkr,nk->rn", np.abs(a), np.abs(forces))


def _mass(solution: Solution) -> Check:
    mass = _permitted(solution, _matrix(solution, solution.equations.mass_matrix))
    diagonal = np.sqrt(np.abs(np.einsum("nii->ni", mass)))
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = mass / diagonal[:, :, None] / diagonal[:, None, :]
    regular = bool(np.isfinite(scaled).all())
    values = np.linalg.eigvalsh(scaled) if regular else np.full((1, 1), np.nan)
    least, most = float(values.min()), float(values.max())
    condition = float((values[:, -1] / values[:, 0]).max()) if least > 0 else np.inf
    detail = tr(
        "scaled to a unit diagonal; eigenvalues %(least)s to %(most)s, %(at)s",
        least=f"{least:.3g}",
        most=f"{most:.3g}",
        at=_at(solution),
    )
    held = tr("BᵀMB of the motions that the constraints permit is positive definite; its condition number")
    name = held if len(solution.equations.b) else tr("M is positive definite; its condition number")
    return Check(name, condition, _CONDITION, detail)


def _permitted(solution: Solution, mass: Array) -> Array:
    """M on the motions that satisfy the constraints, Nᵀ M N with A N = 0."""
    eom = solution.equations
    if not len(eom.b):
        return mass
    free = len(eom.independent_speeds)
    bases = [np.linalg.svd(a)[2][len(eom.speeds) - free :].T for a in _matrix(solution, eom.A)]
    return np.array([b.T @ m @ b for b, m in zip(bases, mass, strict=True)])


def _kinematical(solution: Solution) -> Check:
    y = _matrix(solution, solution.equations.Y)
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = y / np.linalg.norm(y, axis=2, keepdims=True)
    detail = tr("of Y, its inverse, with rows of unit length, %(at)s", at=_at(solution))
    return Check(tr("condition number of W in q̇ = W u + X"), _condition(scaled), _CONDITION, detail)


def _constraints(solution: Solution) -> Check:
    left = {c.name: float(np.abs(r).max()) for c, r in solution.constraint_residuals.items()}
    worst = max(left, key=left.__getitem__)
    return Check(
        tr("residual of the constraints"), left[worst], EQUAL, tr("largest at %(constraint)s", constraint=repr(worst))
    )


def _reactions(solution: Solution) -> Check:
    # the dependent speeds, which may change along the motion, are eliminated from the matrix
    size = len(solution.equations.reactions)
    matrix = stacked(solution.by_sample(lambda eom: eom.solved.reaction_matrix.entries), (size, size))
    return Check(tr("condition number of the reactions' equations"), _condition(matrix), _CONDITION, _at(solution))


def _condition(matrices: Array) -> float:
    return np.inf if not np.isfinite(matrices).all() else float(np.linalg.cond(matrices).max())


def _matrix(solution: Solution, matrix: Matrix) -> Array:
    """Values of a matrix (samples × rows × columns)."""
    values: Array = stacked(solution[matrix.entries], matrix.shape)
    return values


def _ratio(off: Any, scale: Any) -> float:
    return float(off / scale) if scale > 0 else float(off)
