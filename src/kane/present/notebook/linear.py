# SPDX-License-Identifier: BSD-3-Clause
"""A Linear in a notebook: its modes, A and B."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from kane.analysis.linear import Linear
from kane.errors import cut
from kane.present.notebook.typeset import either, escaped, listed, math, paragraph, table
from kane.write.latex import latex_name


def linear_html(linear: Linear) -> str:
    """What was linearized, the modes, the matrices."""
    return "".join(either(make, linear) for make in (_summary, _modes, _matrices))


def _summary(linear: Linear) -> str:
    at = escaped(f"{cut(repr(linear.point), 300)}")
    left = f"; no speed depends on {listed(list(linear.cyclic))}" if linear.cyclic else ""
    return paragraph(f"<b>Linear</b>: {len(linear.states)} states, {len(linear.inputs)} inputs{left}") + paragraph(at)


def _modes(linear: Linear) -> str:
    rows = [
        (_number(m.eigenvalue), f"{m.frequency:.5g} rad/s", f"{m.damping:.4g}", escaped(_largest(m.shape)))
        for m in linear.modes
    ]
    return table(("eigenvalue", "frequency", "damping", "mode"), rows)


def _number(value: complex) -> str:
    return f"{value.real:.6g}" if not value.imag else f"{value.real:.6g} ± {value.imag:.6g} i"


def _largest(shape: dict[str, complex]) -> str:
    chosen = sorted(shape.items(), key=lambda pair: -abs(pair[1]))[:4]
    return ", ".join(f"{name} {abs(v):.3g}∠{np.degrees(np.angle(v)):.0f}°" for name, v in chosen if abs(v) > 1e-3)


def _matrices(linear: Linear) -> str:
    shown = _matrix("A", linear.A, linear.states, linear.states)
    return shown + (_matrix("B", linear.B, linear.states, linear.inputs) if linear.inputs else "")


def _matrix(name: str, a: npt.NDArray[np.float64], rows: Sequence[str], columns: Sequence[str]) -> str:
    if a.size > 400:
        return paragraph(f"{name}: {a.shape[0]} × {a.shape[1]}")
    head = (name, *(math(latex_name(c)) for c in columns))
    return table(head, [(math(latex_name(r)), *(f"{v:.6g}" for v in row)) for r, row in zip(rows, a, strict=True)])
