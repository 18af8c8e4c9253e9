# SPDX-License-Identifier: BSD-3-Clause
"""The chapter on root loci: eigenvalues along a branch of steady motions, onset of growth of modes, turning points."""

from collections.abc import Iterator

from kane.analysis.solution_branches import Branch, Crossing
from kane.present.languages.catalogue import tr
from kane.present.linearized.branch_figures import Inks, against, grow, label_along, plane, through_meetings
from kane.present.linearized.chapter import Part, Section, number
from kane.present.motion_plots import FAINT, INK, SERIES, Plot, panels
from kane.present.overview import PageTable, Tex
from kane.units.rules import unit_text
from kane.write.latex import symbol_latex

_INKS = Inks(SERIES[0], FAINT, INK, SERIES[1], SERIES[0], INK)
"""Placeholders for the colours of a page."""


def root_loci(branch: Branch) -> Section:
    """Eigenvalues against the varied value and in the complex plane, crossings of the imaginary axis, turning points."""
    return Section("loci", tr("Root loci"), tuple(_along_branch(branch)), tuple(_branch_plots(branch)))


def _along_branch(branch: Branch) -> Iterator[Part]:
    symbol, unit = symbol_latex(branch.symbol), unit_text(branch.symbol.unit)
    begin, *turns, end = (
        f"{x:.5g} {unit}".rstrip() for x in (branch.values[0], *branch.turning_points, branch.values[-1])
    )
    yield tr(
        "Eigenvalues of %(n)s steady motions as $%(symbol)s$ goes from %(begin)s to %(end)s.",
        n=len(branch), symbol=symbol, begin=begin, end=end,
    )  # fmt: skip
    if turns:
        yield tr("The branch turns back at $%(symbol)s$ = %(values)s.", symbol=symbol, values=", ".join(turns))
    if branch.crossings:
        rows = ((Tex(number(c.value, 7)), Tex(_crossed(c)), _change(c)) for c in branch.crossings)
        head = (f"${symbol}$" + (f" ({unit})" if unit else ""), r"$\lambda$ (1/s)", tr("from there on"))
        yield PageTable(tr("Where the stability changes"), head, tuple(rows))
    else:
        yield tr("No mode changes between growth and decay in this range.")


def _crossed(crossing: Crossing) -> str:
    real, imaginary = crossing.eigenvalue.real, abs(crossing.eigenvalue.imag)
    return (number(real) if real or not imaginary else "") + (
        rf" \pm {number(imaginary)}\,\mathrm{{i}}" if imaginary else ""
    )


def _change(crossing: Crossing) -> str:
    if crossing.eigenvalue.imag:
        return tr("a swinging mode grows") if crossing.grows else tr("a swinging mode decays")
    return tr("a mode grows without swinging") if crossing.grows else tr("a mode decays without swinging")


def _branch_plots(branch: Branch) -> Iterator[Plot]:
    values, roots, _ = through_meetings(branch.values, branch.eigenvalues)
    figure, (above, below) = panels(2, 1.7, sharex=True)
    against(above, branch, values, roots.real, "Re λ [1/s]", _INKS)
    against(below, branch, values, roots.imag, "Im λ [1/s]", _INKS)
    grow(above, values, roots, _INKS)
    below.set_xlabel(label_along(branch))
    title = tr("Eigenvalues over the value")
    yield Plot(
        "loci",
        title,
        tr("Real parts above zero are drawn twice as thick: there a mode grows. Dashed: turning points."),
        figure,
    )
    figure, (whole,) = panels(1, 3.4)
    plane(whole, branch, roots, _INKS)
    yield Plot("plane", tr("In the complex plane"), tr("Start ○, end ●."), figure)
