# SPDX-License-Identifier: BSD-3-Clause
"""Constraints: closure, rank, choice of dependent speeds, embedding."""
