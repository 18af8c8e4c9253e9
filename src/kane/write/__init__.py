# SPDX-License-Identifier: BSD-3-Clause
"""How expressions, vectors and tables are printed: text, LaTeX, HTML."""
