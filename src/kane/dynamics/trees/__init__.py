# SPDX-License-Identifier: BSD-3-Clause
"""What goes along the segments of a tree once, whatever asks for it: motion, moments and forces."""
