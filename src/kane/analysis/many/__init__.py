# SPDX-License-Identifier: BSD-3-Clause
"""Questions to equations at many states at once: arrays in the places of numbers, a Dataset of xarray in that of an answer."""
