# SPDX-License-Identifier: BSD-3-Clause
"""Formulations: ways from a derived system to u̇ and the reactions, and the search for the shortest one."""
