# SPDX-License-Identifier: BSD-3-Clause
"""Flexible beams: assumed modes, modal integrals, and the beam as a body."""
