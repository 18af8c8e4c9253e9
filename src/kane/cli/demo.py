# SPDX-License-Identifier: BSD-3-Clause
"""`kane demo`: the worked example from declaration to report."""

import time
from pathlib import Path

from rich.console import Console
from rich.text import Text

import kane as kn
from kane.cli.models import STARTS
from kane.cli.screen import columns, shown
from kane.gallery.contacts import skidding_disk
from kane.gallery.rolling import rolling_disk
from kane.gallery.rolling.rolling_disk_check import checks
from kane.present.check_figures import Check, energy_check
from kane.present.formula_list import step_text, wrapped
from kane.present.report import report

FRICTION = 0.1
ENERGY_LIMIT = 1e-8
SPAN = 3.6
_DOES = {"slip": "slides", "stick": "rolls"}


def run(out: Path) -> bool:
    """Derive, print, check, simulate and report; returns whether every check passed."""
    screen = Console(highlight=False)
    began = time.perf_counter()
    disk = rolling_disk.model()
    eom = kn.derive(disk.system)
    took = time.perf_counter() - began
    _heading(screen, f"The {rolling_disk.TITLE}")
    for step in eom.steps:
        title, _, body = step_text(step, eom, columns()).partition("\n")
        _line(screen, title, "bold")
        _line(screen, body)
        screen.line()
    _prose(screen, f"Derived in {took * 1e3:.0f} ms. One evaluation, solution included: {eom.operations}")

    _heading(screen, "Checks")
    results = list(checks(disk, eom))
    for check in results:
        _check(screen, check)

    _heading(screen, f"Motion, thrown forward with backspin, {disk.mu} = {FRICTION:g}")
    start = STARTS["rolling_disk"]
    whole = kn.derive(skidding_disk.system())  # the same friction as a contact, which can also stick
    sol = kn.simulate(whole, (0, SPAN), q=start["q"], u=start["u"], parameters={disk.mu: FRICTION})
    for t, modes in sol.mode_history:
        _line(screen, f"t = {t:.6f} s: the disk {_DOES[modes['ground']]}")
    _line(screen, f"{len(sol)} samples, {sol.steps} steps, {sol.evaluations} evaluations")
    results.append(energy_check(sol, of="friction", limit=ENERGY_LIMIT))
    _check(screen, results[-1])

    place, title, sources = out / "rolling_disk" / "report.html", skidding_disk.TITLE.capitalize(), rolling_disk.SOURCES
    report(whole, place, solution=sol, title=title, sources=sources, checks=results)
    screen.line()
    passed = sum(c.passed for c in results)
    _line(screen, f"{passed} of {len(results)} checks passed", "green" if passed == len(results) else "bold red")
    _line(screen, f"Report: {place}")
    return passed == len(results)


def _line(screen: Console, text: str, style: str = "") -> None:
    screen.print(Text(text, style), soft_wrap=True)


def _prose(screen: Console, text: str) -> None:
    for line in wrapped(text, hang=0, width=columns()):
        _line(screen, line)


def _heading(screen: Console, text: str) -> None:
    screen.line()
    _line(screen, text, "bold underline")
    screen.line()


def _check(screen: Console, check: Check) -> None:
    _line(screen, shown(str(check)), "green" if check.passed else "bold red")
    _line(screen, shown(f"      {check.detail}"), "dim")
