# SPDX-License-Identifier: BSD-3-Clause
"""Chapters of a report on a steady motion, on its linearization, and on branches of steady motions."""
