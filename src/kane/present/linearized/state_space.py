# SPDX-License-Identifier: BSD-3-Clause
"""The chapter on the linearized equations: what the deviations are, and the matrices in numbers."""

from collections.abc import Iterator, Sequence

from kane.analysis.linear import Linear
from kane.equations.equations import Equations
from kane.present.languages.catalogue import tr
from kane.present.linearized.chapter import Part, Section, latex_of, matrix
from kane.present.overview import Tex

_WIDE = 10
"""States, inputs or outputs beyond which a matrix is not laid out."""


def state_space(eom: Equations, linear: Linear) -> Section:
    """ẋ = A x + B r, y = C x + D r."""
    return Section("linearization", tr("Linearization"), tuple(_parts(eom, linear)))


def _parts(eom: Equations, linear: Linear) -> Iterator[Part]:
    laws = [r"\dot{x} = A x + B r" if linear.inputs else r"\dot{x} = A x"]
    if linear.outputs:
        laws.append("y = C x + D r" if linear.inputs else "y = C x")
    yield tr(
        "Small deviations $x$ of the states from the operating point obey $%(laws)s$; what depends on them by a constraint is "
        "eliminated.",
        laws=r",\; ".join(laws),
    )
    yield from _vector("x", latex_of(eom, linear.states))
    yield from _vector("r", latex_of(eom, linear.inputs))
    yield from _vector("y", latex_of(eom, linear.outputs))
    if linear.cyclic:
        names = latex_of(eom, linear.cyclic)
        yield tr("No speed depends on $%(names)s$.", names=r",\, ".join(names))
    shown = {"A": linear.A, "B": linear.B, "C": linear.C, "D": linear.D}
    for name, values in shown.items():
        if not values.size:
            continue
        if max(values.shape) > _WIDE:
            size = " × ".join(map(str, values.shape))
            yield tr("$%(name)s$ has %(size)s entries and is left out here.", name=name, size=size)
        else:
            yield Tex(f"{name} = {matrix(values)}")


def _vector(name: str, entries: Sequence[str]) -> Iterator[Part]:
    """What a vector of deviations holds."""
    if 0 < len(entries) <= _WIDE:
        within = " & ".join(rf"\delta {e}" for e in entries)
        yield Tex(rf"{name} = \begin{{bmatrix}} {within} \end{{bmatrix}}^{{T}}")
