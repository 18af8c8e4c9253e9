# SPDX-License-Identifier: BSD-3-Clause
"""The page on the textbook: what it names is there, under the name it gives."""

from __future__ import annotations

import re

import pytest

import kane as kn
from tests.docs.snippets import ROOT

PAGE = (ROOT / "docs" / "textbook.md").read_text(encoding="utf-8")
ROWS = [line for line in PAGE.splitlines() if line.startswith("| ") and not line.startswith("| section")]
KINDS = {
    "kn": kn,
    "eom": kn.Equations,
    "sol": kn.Solution,
    "R": kn.Rotation,
    "m": kn.Motions,
    **dict.fromkeys(("A", "B", "N", "C"), kn.Frame),
    **dict.fromkeys(("P", "Q", "O"), kn.Point),
    "v": kn.Vector,
}
"""What the letters on the page stand for."""


def named():
    """Letter and attribute of every name on the page."""
    for row in ROWS:
        for code in re.findall(r"`([^`]+)`", row):
            yield from re.findall(r"\b(kn|eom|sol|[A-Zmv])\.(\w+)", code)


def test_names_on_the_page_are_there():
    found = sorted({(letter, name) for letter, name in named() if letter in KINDS})
    assert len(found) > 60
    unit = {"x", "y", "z"}
    missing = [f"{letter}.{name}" for letter, name in found if not (hasattr(KINDS[letter], name) or name in unit)]
    assert not missing


@pytest.mark.parametrize("row", [r for r in ROWS if "`kn." in r or "`eom." in r], ids=lambda r: r[:40])
def test_functions_have_docstrings(row):
    for letter, name in re.findall(r"`(kn|eom)\.(\w+)", row):
        assert (getattr(KINDS[letter], name).__doc__ or "").strip(), name


TERMS = """
acceleration; angular acceleration; angular momentum; angular velocity; auxiliary generalized speeds; bound vector; central axis;
central inertia; checking functions; collisions; configuration constraints; conservation of energy; constraint forces;
contributing forces; couple; cyclic coordinates; degrees of freedom; derivative of a vector; direction cosines; dissipation
functions; dynamical equations; energy integral; equivalence; Euler parameters; friction; generalized active forces; generalized
coordinates; generalized impulses; generalized inertia forces; generalized momenta; generalized speeds; Gibbs function;
gravitational forces; Hamiltonian; inertia coefficients; inertia dyadic; inertia ellipsoid; inertia force; inertia matrix; inertia
torque; inertia vector; integrals of the equations of motion; kinematical differential equations; kinetic energy; linearization;
mass centre; mass matrix; modes; moment of inertia; motion constraints; noncontributing forces; nonholonomic partial velocities;
normal coordinates; numerical integration; parallel axes; partial angular velocities; partial velocities; potential energy;
principal axes; principal moments; product of inertia; radius of gyration; reaction; reference frame; restitution; resultant;
Rodrigues parameters; rolling; secondary Newtonian reference frames; simple angular velocity; simple rotation; small rotations;
steady motion; successive rotations; systems at rest; torque; velocity; work; wrench
"""
"""The book's index, as far as its terms are functions."""


@pytest.mark.parametrize("term", [" ".join(t.split()) for t in TERMS.split(";")])
def test_each_term_of_the_index_has_its_function(term):
    """Every word of the term begins a word of what a row tells, or of the names that it gives."""
    words = [w.lower().removesuffix("s") for w in term.split() if w not in ("of", "a", "the", "at")]
    rows = [re.sub(r"[_`.,()]", " ", row).lower().split() for row in ROWS if "`" in row]
    assert any(all(any(told.startswith(w) for told in row) for w in words) for row in rows), term
