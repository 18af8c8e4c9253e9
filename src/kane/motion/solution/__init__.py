# SPDX-License-Identifier: BSD-3-Clause
"""The result of a simulation: the Solution, its phases, accuracy, checks, files and tables."""
