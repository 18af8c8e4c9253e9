# SPDX-License-Identifier: BSD-3-Clause
"""Plots of a motion as SVG inside a page, in the colours of its theme: coordinates, speeds, reactions, energy, paths of points."""

import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import is_color_like, to_hex
from matplotlib.figure import Figure

from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Symbol
from kane.model.bodies import parts_of
from kane.model.constraints import cut_of
from kane.model.system import System
from kane.motion.solution.solution import Solution
from kane.present.languages.catalogue import N_, tr
from kane.present.scene.default_shapes import upward
from kane.space.frame import Point
from kane.units.rules import unit_text
from kane.write.latex import latex_name, point_latex, symbol_latex

_UNKNOWN = frozenset('"&`#')
"""Characters that matplotlib's mathtext cannot display."""


def label_of(named: Symbol | Point | str) -> str:
    """A symbol, a point or another name as a label in a picture."""
    name = named if isinstance(named, str) else named.name
    if _UNKNOWN & set(name):
        return name.replace("$", r"\$")
    if isinstance(named, Symbol):
        return f"${symbol_latex(named)}$"
    return f"${point_latex(name) if isinstance(named, Point) else latex_name(name)}$"


INK, RULE, FAINT = "#010203", "#010204", "#010205"
SERIES = tuple(f"#0203{i:02x}" for i in range(1, 7))
"""Placeholders that `to_svg` replaces by the page's colours."""
COLOURS = ("#0b5cad", "#c2410c", "#1a7f37", "#7c3aad", "#b3266b", "#0e7490")
"""The page's colours of series on white, for figures outside of a page."""

_THEME = {INK: "currentColor", RULE: "var(--rule)", FAINT: "var(--faint)"} | {
    c: f"var(--series-{i})" for i, c in enumerate(SERIES, 1)
}
WIDTH = 5.4
"""Width of a figure in inches, for one column of the page and for a phone."""


def panels(rows: int, height: float, **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure with `rows` panels one above the other, styled, `height` inches each."""
    total = height * rows + 0.45
    figure = Figure(figsize=(WIDTH, total))
    figure.patch.set_visible(False)
    # fixed margins: a layout engine draws everything twice
    figure.subplots_adjust(left=0.15, right=0.985, top=1 - 0.14 / total, bottom=0.46 / total, hspace=0.27 / height)
    grid = figure.subplots(rows, 1, squeeze=False, **options)
    axes: list[Axes] = list(grid[:, 0])
    for a in axes:
        _style(a)
    return figure, axes


def _style(a: Axes) -> None:
    a.patch.set_visible(False)
    a.grid(True, color=RULE, linewidth=0.6)
    a.set_axisbelow(True)
    a.tick_params(colors=INK, labelsize=9, length=0)
    for side, spine in a.spines.items():
        spine.set_color(FAINT)
        spine.set_visible(side in ("left", "bottom"))
    for label in (a.xaxis.label, a.yaxis.label):
        label.set_color(INK)
        label.set_fontsize(10)
        label.set_math_fontfamily("cm")
    a.yaxis.set_label_coords(-0.115, 0.5)


def legend(a: Axes, **options: Any) -> None:
    """A legend without a box."""
    box = a.legend(frameon=False, fontsize=9, labelcolor=INK, **options)
    for text in box.get_texts():
        text.set_math_fontfamily("cm")


def to_svg(figure: Figure, prefix: str) -> str:
    """The figure as an `<svg>` element, with `prefix` in its identifiers."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = out.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    for stand_in, colour in _THEME.items():
        text = text.replace(stand_in, colour)
    identifiers: dict[str, str] = {}
    for name in re.findall(r'\bid="([^"]+)"', text):
        identifiers.setdefault(name, f"{prefix}-{len(identifiers)}")
    text = re.sub(r'\bid="([^"]+)"', lambda m: f'id="{identifiers[m[1]]}"', text)
    return _lean(re.sub(r"#([\w.-]+)(?=[\")])", lambda m: f"#{identifiers.get(m[1], m[1])}", text))


def _lean(svg: str) -> str:
    """The same picture in half the text: without comments, unused identifiers, invisible digits and spaces."""
    used = set(re.findall(r"#([\w.-]+)(?=[\")])", svg))
    svg = re.sub(
        r' id="([^"]+)"', lambda m: m[0] if m[1] in used else "", re.sub(r"<!--.*?-->", "", svg, flags=re.DOTALL)
    )
    svg = re.sub(r"(?<![\w.#])-?\d+\.\d{3,}", _shorter, re.sub(r">\s+<", "><", svg))
    svg = re.sub(r"\s+", " ", svg)
    while svg != (fewer := svg.replace("<g/>", "").replace("<g></g>", "")):
        svg = fewer
    return re.sub(r' d="[^"]*"', lambda m: " " + re.sub(r" ?([MLQCz]) ?| (?=-|\"$)", r"\1", m[0][1:]), svg)


def _shorter(number: re.Match[str]) -> str:
    """A number rounded to a hundredth of a point (1/72 inch); numbers below 1, such as scales, to four digits."""
    value = float(number[0])
    return f"{value:.2f}".rstrip("0").rstrip(".") if abs(value) >= 1 else f"{value:.4g}"


_PRINTED = {INK: "#1b1d21", RULE: "#d9dce1", FAINT: "#9aa0a8"} | dict(zip(SERIES, COLOURS, strict=True))
_COLOURED = ("color", "edgecolor", "facecolor", "markeredgecolor", "markerfacecolor")


def to_print(figure: Figure) -> Figure:
    """The figure in colours for white paper."""
    figure.draw_without_rendering()  # ticks are made when they are drawn
    for artist in figure.findobj():
        for what in _COLOURED:
            colour = getattr(artist, f"get_{what}", lambda: None)()
            if colour is not None and is_color_like(colour) and (printed := _PRINTED.get(to_hex(colour))):
                getattr(artist, f"set_{what}")(printed)
    figure.patch.set(visible=True, facecolor="white")
    return figure


_FAINT = 1e-3
"""Fraction of the absolute tolerance below which values are rounding residues."""
_PANELS = 7
"""Number of quantities beyond which those of one unit share a panel."""
_LABELS = 12


@dataclass(frozen=True, slots=True)
class Plot:
    """A titled figure in placeholder colours, with a caption."""

    name: str
    title: str
    caption: str
    figure: Figure

    @property
    def svg(self) -> str:
        """The figure in the colours of a page."""
        return to_svg(self.figure, self.name)


def plots(solution: Solution, drawn: Iterable[Expr] = ()) -> list[Plot]:
    """The plots that apply to the motion, without those of quantities that are all `drawn` elsewhere."""
    eom, elsewhere = solution.equations, set(drawn)
    traced: list[tuple[str, str, Sequence[Any], Any]] = [
        ("coordinates", N_("Generalized coordinates"), eom.coordinates, solution.q.T),
        ("speeds", N_("Generalized speeds"), eom.speeds, solution.u.T),
        ("states", N_("Further states"), eom.states, solution.a.T),
        ("reactions", N_("Reactions brought into evidence"), eom.reactions, solution[list(eom.reactions)]),
    ]
    traces = [_traces(*of, solution) for of in traced if not elsewhere.issuperset(of[2])]
    return [p for p in (paths(solution), *traces, balance(solution)) if p is not None]


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
            a.plot(solution.t, values[i], color=SERIES[k % len(SERIES)], label=label_of(symbols[i]))
        level(a, [values[i] for i in group], solution)
        left = f"{label_of(symbols[group[0]])} " if alone else ""
        a.set_ylabel(f"{left}[{unit_text(units[group[0]]) or '–'}]")
        if not alone and len(group) <= _LABELS:
            legend(a, ncols=4, loc="best")
    axes[-1].set_xlabel("t [s]")
    meanings = [f"{s.name}: {s.description}" for s in symbols if s.description]
    if not all(units):
        meanings.append(tr("[–]: no unit declared"))
    return Plot(name, tr(title), "; ".join(meanings), figure)


def level(axes: Any, values: Sequence[Any], solution: Solution) -> None:
    """Draw values far below the absolute tolerance of a motion as zero, so that rounding errors do not fill the panel."""
    if solution.atol > 0 and np.abs(np.asarray(values, dtype=float)).max(initial=0) < _FAINT * solution.atol:
        axes.set_ylim(-solution.atol, solution.atol)


def balance(solution: Solution) -> Plot:
    """Plots of energies, of power and dE/dt, and of the residual E − E(0) − ∫P dt."""
    eom, t = solution.equations, solution.t
    kinetic, potential, total = solution[[eom.kinetic_energy, eom.potential_energy, eom.energy]]
    power, rate = solution.power, solution[eom.time_derivative(eom.energy)]
    figure, axes = panels(3, 1.6, sharex=True)
    for k, (y, label) in enumerate([(kinetic, "K"), (potential, "V"), (total, "E = K + V")]):
        axes[0].plot(t, y, color=SERIES[k], label=label)
    axes[0].plot(t, total - solution.work, color=INK, linewidth=1, linestyle="--", label="E − ∫P dt")
    axes[0].set_ylabel(tr("energy [J]"))
    legend(axes[0], ncols=2, loc="best")
    axes[1].plot(t, power, color=SERIES[3], label="P")
    axes[1].plot(t, rate, color=INK, linewidth=1, linestyle="--", label="dE/dt")
    axes[1].set_ylabel(tr("power [W]"))
    least = 1e-6 * solution.energy_check.scale / (np.ptp(t) or 1.0)
    if max(np.abs(power).max(), np.abs(rate).max()) < least:  # rounding errors must not fill the panel
        axes[1].set_ylim(-least, least)
    legend(axes[1], ncols=2, loc="best")
    axes[2].plot(t, solution.energy_drift, color=SERIES[4])
    axes[2].set_ylabel("E − E(0) − ∫P dt [J]", fontsize=8)
    axes[2].set_xlabel("t [s]")
    caption = tr(
        "Kinetic energy K, potential energy V, and their sum E; P is the power of the loads that have no potential. Below, the "
        "difference that must vanish."
    )
    return Plot("energy", tr("Energy and power"), caption, figure)


def _plane(spread: Any, system: System) -> tuple[int, int]:
    """The two axes with the largest motion, to the right and up, the earlier ones for equal motion; a vertical axis points up."""
    first, second = sorted(sorted(range(3), key=lambda i: -spread[i])[:2])
    upright = [c is not ZERO for c in upward(system).components(system.inertial)]
    return (second, first) if upright == [i == first for i in range(3)] else (first, second)


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
    first, second = _plane(spread, system)
    figure, (a,) = panels(1, 4.2)
    for k, (p, center) in enumerate(points.items()):
        x, y = tracks[p][:, first], tracks[p][:, second]
        if not max(np.ptp(x), np.ptp(y)) > 0:
            continue
        colour = SERIES[k % len(SERIES)]
        style: dict[str, Any] = {} if center else {"linestyle": (0, (4, 2)), "linewidth": 1.2}
        a.plot(x, y, color=colour, label=label_of(p) if len(points) <= _LABELS else None, **style)
        a.plot(x[:1], y[:1], marker="o", color=colour, markersize=5, markerfacecolor="none")
        a.plot(x[-1:], y[-1:], marker="o", color=colour, markersize=5)
    a.set_aspect("equal", adjustable="datalim")
    inertial = system.inertial.name.lower()
    for label, i in ((a.set_xlabel, first), (a.set_ylabel, second)):
        along = tr("along %(axis)s [m]", axis=f"$\\hat{{{inertial}}}_{'xyz'[i]}$")
        label(along if len(inertial) == 1 else f"{'xyz'[i]} [m]")
    if len(points) <= _LABELS:
        legend(a, loc="best")
    a.axhline(0, color=FAINT, linewidth=0.6)
    caption = tr("Paths of the mass centres (full) and of the points where reactions act (dashed); start ○, end ●.")
    return Plot("paths", tr("Paths"), caption, figure)
