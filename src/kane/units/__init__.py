# SPDX-License-Identifier: BSD-3-Clause
"""Units of measurement: a table, rules of their arithmetic, checks."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"rules": "conflict unit PLAIN PREFIXED parse RULES unit_text"})
