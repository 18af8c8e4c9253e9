# SPDX-License-Identifier: BSD-3-Clause
"""Plots by `kn.plot`: motions as runs, their quantities as traces in panels, and lines."""
