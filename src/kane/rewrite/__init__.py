# SPDX-License-Identifier: BSD-3-Clause
"""Layer 0: sums and products with fewer operations: one graph, rules as rows of tables, one price, one heap of divisors."""
