# SPDX-License-Identifier: BSD-3-Clause
"""What "auto" takes where rates are smooth: collocation has its stages side by side and wants vectors of four doubles at least."""

from kane.program import target

SMOOTH = ("gauss16",) if target().lanes >= 4 else ("vern9", "tsitpap8")
