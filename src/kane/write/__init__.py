# SPDX-License-Identifier: BSD-3-Clause
"""How expressions, vectors and tables are printed: text, LaTeX, HTML."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "arrange": "layout Notation TEXT",
        "latex": "LATEX latex_name symbol_latex unit_vector_latex",
        "display": "natural",
    },
)
