# SPDX-License-Identifier: BSD-3-Clause
"""The kernel language: loops, choices and memory around Programs; steppers are written in it."""
