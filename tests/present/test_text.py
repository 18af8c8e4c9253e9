# SPDX-License-Identifier: BSD-3-Clause
"""Steps as text: true, wrapped, with intermediates defined once and before use."""

from __future__ import annotations

import re

import numpy as np
import pytest

from kane import Vector, evaluate, free_symbols
from kane.present import WIDTH, formulas, step_text, wrapped
from tests.present.disk import derived

STEPS = range(7)


@pytest.mark.parametrize("i", STEPS)
def test_lines_are_short(i: int) -> None:
    _, eom = derived()
    assert all(len(line) <= WIDTH for line in step_text(eom.steps[i], eom).splitlines())


@pytest.mark.parametrize("i", STEPS)
def test_intermediates_are_defined_once_and_before_use(i: int) -> None:
    _, eom = derived()
    known: set[str] = set()
    flat = re.sub(r"\n {8,}", " ", step_text(eom.steps[i], eom))
    for line in flat.splitlines()[2:]:
        name, _, body = (part.strip() for part in line.partition(" = "))
        assert set(re.findall(r"\bZ\d+\b", body)) <= known, line
        assert name not in known
        known |= {name} if re.fullmatch(r"Z\d+", name) else set()


@pytest.mark.parametrize("i", range(1, 7))
def test_text_means_the_expression(i: int) -> None:
    """Read back as Python, the text has the value of what it prints."""
    _, eom = derived()
    rng = np.random.default_rng(i)
    names = [s.name for s in (*eom.coordinates, *eom.speeds, *eom.parameters, *eom.reactions)]
    values = {n: float(rng.uniform(0.3, 1.2)) for n in names}
    values |= {f"{s.name}_dot": float(rng.uniform(0.3, 1.2)) for s in (*eom.coordinates, *eom.speeds)}
    frames = {f.name: f for f in eom.frames}
    between, shown = formulas(eom.steps[i].items)
    scope: dict[str, object] = {**values, "sin": np.sin, "cos": np.cos, "tan": np.tan, "sqrt": np.sqrt}
    for z in between:
        scope[z.name] = _read(z.text, scope)
    for formula, (label, value) in zip(shown, eom.steps[i].items, strict=True):
        assert formula.name == label
        exprs = value.components(eom.system.inertial) if isinstance(value, Vector) else (value,)
        numbers = {s: values[s.name.replace("'", "_dot")] for s in free_symbols(exprs)}
        expected = np.array([float(x) for x in evaluate(list(exprs), numbers)])
        got = np.zeros_like(expected)
        if isinstance(value, Vector):
            for sign, factor, frame, axis in _vector_terms(formula.text):
                unit = getattr(frames[frame], axis).components(eom.system.inertial)
                direction = [float(x) for x in evaluate(list(unit), {s: values[s.name] for s in free_symbols(unit)})]
                got += sign * (float(_read(factor, scope)) if factor else 1.0) * np.array(direction)
        else:
            got[0] = float(_read(formula.text, scope))
        np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-12, err_msg=label)


def _read(text: str, scope: dict[str, object]) -> float:
    python = re.sub(r"\b([A-Za-z]\w*)'", r"\1_dot", text).replace("^", "**")
    return float(eval(python, {"__builtins__": {}}, scope))  # noqa: S307


def _vector_terms(text: str) -> list[tuple[float, str, str, str]]:
    found, rest = [], text
    while rest:
        m = re.match(r"\s*([+-]?)\s*(.*?)\s?\b([A-Z])\.([xyz])(?= [+-] |$)", rest)
        assert m, rest
        found.append((-1.0 if m[1] == "-" else 1.0, m[2], m[3], m[4]))
        rest = rest[m.end() :]
    return found


def test_wrapping_prefers_outermost_sums() -> None:
    assert wrapped("aaaa*(bb + cc) + dddd*(ee - ff)", width=24) == ["aaaa*(bb + cc)", "    + dddd*(ee - ff)"]
    assert wrapped("short", indent=2, width=10) == ["  short"]
    assert "".join(wrapped("x" * 50, width=20)) == "x" * 50
