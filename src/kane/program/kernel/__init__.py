# SPDX-License-Identifier: BSD-3-Clause
"""The kernel language, with loops, branches and memory around calls of Programs; steppers are written in it."""
