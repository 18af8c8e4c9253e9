# SPDX-License-Identifier: BSD-3-Clause
"""Systems as files and back: what both must have in common."""

from __future__ import annotations

import importlib.util

import numpy as np

import kane as kn
from kane.expr import digest


def imported(path, text):
    """The module that a file with this text is."""
    path.write_text(text, "utf-8")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def coefficients(c):
    """The expressions of a contact."""
    return [*(row.expr for row in c.rows), *c.numbers, c.viscous, c.kinetic_at(kn.parameter("v"))]


def assert_alike(system, other, signs=True):
    """Both have the same symbols and names, the same operations, and accelerations equal to rounding.

    Without `signs` additions and subtractions are counted together: numbers in a text carry no bounds of their rounding, and a
    comparison of sizes may fall otherwise.
    """
    for what in ("coordinates", "speeds", "parameters", "inputs", "reactions", "states", "dependent_speeds"):
        assert [s.declaration()[:4] for s in getattr(system, what)] == [
            s.declaration()[:4] for s in getattr(other, what)
        ]
    for what in ("bodies", "joints", "loads", "constraints", "events", "gravities", "contacts"):
        assert [x.name for x in getattr(system, what)] == [x.name for x in getattr(other, what)]
    for c, d in zip(system.contacts, other.contacts, strict=True):
        assert (c.law, *map(digest, coefficients(c))) == (d.law, *map(digest, coefficients(d)))
    for k in range(len(system.contacts)):  # in modes where one after the other acts, and nothing else sticks
        slips = [
            {c.name: "slip" if c.slips else "stick" for c in s.contacts if c.gap is None or c is s.contacts[k]}
            for s in (system, other)
        ]
        pair = (s.in_modes(m) for s, m in zip((system, other), slips, strict=True))
        assert len({kn.derive(s).compile().operations for s in pair}) == 1
    a, b = kn.derive(system), kn.derive(other)
    first, second = (e.compile().operations for e in (a, b))
    if signs:
        assert first == second
    else:
        assert [(n, o.state, o.parameter) for n, o in first.routines] == [
            (n, o.state, o.parameter) for n, o in second.routines
        ]
    if [digest(e) for e in a.accelerations] == [digest(e) for e in b.accelerations]:
        return
    rng = np.random.default_rng(1)
    named = {"q": a.coordinates, "u": a.independent_speeds, "inputs": a.system.inputs}
    values = {kind: {s.name: rng.uniform(0.2, 0.8, 5) for s in symbols} for kind, symbols in named.items()}
    before, after = (np.array(e.evaluate([s.name + "'" for s in e.speeds], **values)) for e in (a, b))
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-11 * np.abs(before).max())
