# SPDX-License-Identifier: BSD-3-Clause
"""Constraints: the manifold of configurations, rank, choice of dependent speeds, constraint embedding."""
