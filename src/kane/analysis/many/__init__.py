# SPDX-License-Identifier: BSD-3-Clause
"""Analyses at many states: arrays replace numbers in the arguments, and the result is an xarray Dataset."""
