# SPDX-License-Identifier: BSD-3-Clause
"""What a system looks like: shapes, places, coordinates and loads as one frozen `Scene`, with one routine for all its poses."""
