# SPDX-License-Identifier: BSD-3-Clause
"""The appearance of a system: shapes, points, coordinates and loads as one frozen `Scene`, with one routine for all its poses."""
