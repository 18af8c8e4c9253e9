# SPDX-License-Identifier: BSD-3-Clause
"""Names in pictures: as formulas where matplotlib can set them, else as they are."""

from collections.abc import Callable

from kane.write.latex import latex_name

_UNKNOWN = frozenset('"&`#')
"""Characters that matplotlib's formulas do not know."""


def label(name: str, latex: Callable[[str], str] = latex_name) -> str:
    """A name as a picture shows it."""
    return name.replace("$", r"\$") if _UNKNOWN & set(name) else f"${latex(name)}$"
