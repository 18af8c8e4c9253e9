# SPDX-License-Identifier: BSD-3-Clause
"""The functions that users call on expressions and numbers."""

from kane.expr.node import BUILDERS

sqrt, sin, cos, tan = (BUILDERS[k] for k in ("sqrt", "sin", "cos", "tan"))
asin, acos, atan, atan2 = (BUILDERS[k] for k in ("asin", "acos", "atan", "atan2"))
sinh, cosh, tanh = (BUILDERS[k] for k in ("sinh", "cosh", "tanh"))
exp, log, sign, where, less = (BUILDERS[k] for k in ("exp", "log", "sign", "where", "less"))
abs, min, max = (BUILDERS[k] for k in ("abs", "min", "max"))
