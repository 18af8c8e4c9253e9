# SPDX-License-Identifier: BSD-3-Clause
"""The plots of a motion: coordinates, speeds, reactions, energy, and the paths of points."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.model.bodies import parts_of
from kane.model.reactions import cut_of
from kane.motion.solution.solution import Solution
from kane.present.labels import label as label_of
from kane.present.svg import FAINT, INK, SERIES, legend, panels, to_svg
from kane.space.point import Point
from kane.units.text import unit_text
from kane.write.latex import place_latex

_FAINT = 1e-3
"""Share of the absolute tolerance below which values are what rounding leaves."""
_PANELS = 7
"""Quantities beyond which those of one unit share a panel."""
_LABELS = 12


@dataclass(frozen=True, slots=True)
class Plot:
    """A titled figure as SVG, with a sentence that says what is seen."""

    name: str
    title: str
    caption: str
    svg: str


def plots(solution: Solution) -> list[Plot]:
    """The plots that apply to the motion."""
    eom = solution.equations
    drawn = [
        paths(solution),
        _traces("coordinates", "Generalized coordinates", eom.coordinates, solution.q.T, solution),
        _traces("speeds", "Generalized speeds", eom.speeds, solution.u.T, solution),
        _traces("states", "Further states", eom.states, solution.a.T, solution),
        _traces("reactions", "Reactions brought into evidence", eom.reactions, solution[list(eom.reactions)], solution),
        balance(solution),
    ]
    return [p for p in drawn if p is not None]


def _traces(name: str, title: str, symbols: Sequence[Any], values: Any, solution: Solution) -> Plot | None:
    if not symbols:
        return None
    groups: list[list[int]] = [[i] for i in range(len(symbols))]
    units = [solution.equations.unit(s) for s in symbols]
    if len(symbols) > _PANELS:
        groups = [[i for i, own in enumerate(units) if own == unit] for unit in dict.fromkeys(units)]
    alone = len(groups) == len(symbols)
    figure, axes = panels(len(groups), 2.6 if len(groups) == 1 else 1.05 if alone else 2.2, sharex=True)
    for a, group in zip(axes, groups, strict=True):
        for k, i in enumerate(group):
            a.plot(solution.t, values[i], color=SERIES[k % len(SERIES)], label=label_of(symbols[i].name))
        level(a, [values[i] for i in group], solution)
        left = f"{label_of(symbols[group[0]].name)} " if alone else ""
        a.set_ylabel(f"{left}[{unit_text(units[group[0]]) or '–'}]")
        if not alone and len(group) <= _LABELS:
            legend(a, ncols=4, loc="best")
    axes[-1].set_xlabel("t [s]")
    meanings = [f"{s.name}: {s.description}" for s in symbols if s.description]
    if not all(units):
        meanings.append("[–]: no unit declared")
    return Plot(name, title, "; ".join(meanings), to_svg(figure, name))


def level(axes: Any, values: Sequence[Any], solution: Solution) -> None:
    """What is far below the absolute tolerance of a motion is drawn as zero: rounding errors are not to fill the panel."""
    if solution.atol > 0 and np.abs(np.asarray(values, dtype=float)).max(initial=0) < _FAINT * solution.atol:
        axes.set_ylim(-solution.atol, solution.atol)


def balance(solution: Solution) -> Plot:
    """Energies; power against dE/dt; what is left of E − E(0) − ∫P dt."""
    eom, t = solution.equations, solution.t
    kinetic, potential, total = solution[[eom.kinetic_energy, eom.potential_energy, eom.energy]]
    power, rate = solution[[eom.power, eom.time_derivative(eom.energy)]]
    figure, axes = panels(3, 1.6, sharex=True)
    for k, (y, label) in enumerate([(kinetic, "K"), (potential, "V"), (total, "E = K + V")]):
        axes[0].plot(t, y, color=SERIES[k], label=label)
    axes[0].plot(t, total - solution.work, color=INK, linewidth=1, linestyle="--", label="E − ∫P dt")
    axes[0].set_ylabel("energy [J]")
    legend(axes[0], ncols=2, loc="best")
    axes[1].plot(t, power, color=SERIES[3], label="P")
    axes[1].plot(t, rate, color=INK, linewidth=1, linestyle="--", label="dE/dt")
    axes[1].set_ylabel("power [W]")
    least = 1e-6 * solution.energy_check.scale / np.ptp(t)
    if max(np.abs(power).max(), np.abs(rate).max()) < least:  # rounding errors are not to fill the panel
        axes[1].set_ylim(-least, least)
    legend(axes[1], ncols=2, loc="best")
    axes[2].plot(t, solution.energy_drift, color=SERIES[4])
    axes[2].set_ylabel("E − E(0) − ∫P dt [J]", fontsize=8)
    axes[2].set_xlabel("t [s]")
    caption = (
        "Kinetic energy K, potential energy V, and their sum E; P is the power of the loads that have no potential. Below, the "
        "difference that must vanish."
    )
    return Plot("energy", "Energy and power", caption, to_svg(figure, "energy"))


def paths(solution: Solution) -> Plot | None:
    """Paths of all mass centres, and of the points of reactions, in the inertial plane of largest motion."""
    system = solution.equations.system
    points: dict[Point, bool] = {part.mass_center: True for part in parts_of(system.bodies)}
    for r in system.reactions:
        cut = cut_of(r)
        if cut is not None and isinstance(cut.at, Point):
            points.setdefault(cut.at, False)
    tracks = {p: solution[p.position(p.root())] for p in points}
    spread = np.ptp(np.concatenate([tracks[p] for p, center in points.items() if center]), axis=0)
    if not spread.max() > 0:
        return None
    first, second = sorted(np.argsort(spread)[-2:])
    figure, (a,) = panels(1, 4.2)
    for k, (p, center) in enumerate(points.items()):
        x, y = tracks[p][:, first], tracks[p][:, second]
        if not max(np.ptp(x), np.ptp(y)) > 0:
            continue
        colour = SERIES[k % len(SERIES)]
        style: dict[str, Any] = {} if center else {"linestyle": (0, (4, 2)), "linewidth": 1.2}
        a.plot(x, y, color=colour, label=label_of(p.name, place_latex) if len(points) <= _LABELS else None, **style)
        a.plot(x[:1], y[:1], marker="o", color=colour, markersize=5, markerfacecolor="none")
        a.plot(x[-1:], y[-1:], marker="o", color=colour, markersize=5)
    a.set_aspect("equal", adjustable="datalim")
    inertial = system.inertial.name.lower()
    for label, i in ((a.set_xlabel, first), (a.set_ylabel, second)):
        label(f"along $\\hat{{{inertial}}}_{'xyz'[i]}$ [m]" if len(inertial) == 1 else f"{'xyz'[i]} [m]")
    if len(points) <= _LABELS:
        legend(a, loc="best")
    a.axhline(0, color=FAINT, linewidth=0.6)
    caption = "Paths of the mass centres (full) and of the points where reactions act (dashed); start ○, end ●."
    return Plot("paths", "Paths", caption, to_svg(figure, "paths"))
