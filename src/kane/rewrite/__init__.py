# SPDX-License-Identifier: BSD-3-Clause
"""Layer 0: algebraic factorization of sums and products into fewer operations (Brayton & McMullen 1982): graph, rules, divisors."""
