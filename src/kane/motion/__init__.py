# SPDX-License-Identifier: BSD-3-Clause
"""Motions: start, steps, projection, events, Solution."""
