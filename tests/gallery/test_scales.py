# SPDX-License-Identifier: BSD-3-Clause
"""The same mechanisms in other units: lengths, masses and times a million times as large or as small decide alike."""

from __future__ import annotations

import warnings

import pytest

import kane as kn
from kane.gallery import GALLERY, load
from kane.units.parse import parse

BIG, SMALL = 1e6, 1e-6
SCALES = [(BIG, 1, 1), (SMALL, 1, 1), (1, SMALL, BIG), (BIG, BIG, SMALL)]
"""How many of its units metre, kilogram and second become."""
HELD = [name for name in GALLERY if load(name).system().constraints]


def decided(name, monkeypatch, scale=(1, 1, 1), **options):
    """Dependent speeds, the number of redundant constraints, the route, and how much was said."""
    plain, (metre, kilogram, second) = kn.parameter, scale

    def parameter(symbol, default=None, unit="", *more):
        e = [float(x) for x in parse(unit).exponents] if unit else [0.0] * 3
        size = kilogram ** e[0] * metre ** e[1] * second ** e[2]
        return plain(symbol, None if default is None else default * size, unit, *more)

    with monkeypatch.context() as patched, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        patched.setattr(kn, "parameter", parameter)
        eom = kn.derive(load(name).system(**options))
    return {u.name for u in eom.dependent_speeds}, len(eom.redundant), eom.solved.route, len(said)


@pytest.mark.parametrize("name", HELD)
def test_dependent_speeds_and_rank_do_not_depend_on_units(name, monkeypatch):
    expected = decided(name, monkeypatch)
    for scale in SCALES:
        assert decided(name, monkeypatch, scale) == expected, scale


@pytest.mark.slow
def test_how_many_constraints_are_redundant_does_not_depend_on_units(monkeypatch):
    """Which one of them is left out may."""
    expected = decided("bricard", monkeypatch, redundant=True)
    for scale in SCALES:
        found = decided("bricard", monkeypatch, scale, redundant=True)
        assert (len(found[0]), *found[1:]) == (len(expected[0]), *expected[1:]), scale
