# SPDX-License-Identifier: BSD-3-Clause
"""Units of measurement: a table, rules of their arithmetic, checks."""
