# SPDX-License-Identifier: BSD-3-Clause
"""Passes over a Program."""
