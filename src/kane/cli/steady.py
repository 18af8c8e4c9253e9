# SPDX-License-Identifier: BSD-3-Clause
"""The chapters of a report on steady motions: one near START, and a branch as a value changes."""

from typing import Any

import numpy as np

import kane as kn
from kane.cli.derive import inputs_at
from kane.cli.screen import Misuse

_POINTS = 41
"""Number of points of a branch."""


def steady_chapters(eom: kn.Equations, begin: Any, t: float, linearization: bool, locus: str | None) -> dict[str, Any]:
    """Arguments of `report`: the linearization at the steady motion or equilibrium near START; the branch NAME=LOW:HIGH.

    Inputs have their values at the time t.
    """
    guesses = {kind: {s: kn.guess(float(v)) for s, v in getattr(begin, kind).items()} for kind in ("q", "u", "states")}
    given: dict[str, Any] = {**guesses, "parameters": begin.parameters, "inputs": inputs_at(begin.inputs, t)}
    result: dict[str, Any] = {}
    if linearization:
        result["linearization"] = kn.linearize(eom, kn.trim(eom, **given))
    if locus is not None:
        name, low, high = _range(locus)
        result["root_locus"] = kn.analysis.continuation(eom, name, np.linspace(low, high, _POINTS).tolist(), **given)
    return result


def _range(text: str) -> tuple[str, float, float]:
    name, _, values = (part.strip() for part in text.partition("="))
    low, _, high = values.partition(":")
    try:
        return name, float(low), float(high)
    except ValueError:
        raise Misuse(f"Expected NAME=LOW:HIGH in --root-locus, got {text!r}.") from None
