# SPDX-License-Identifier: BSD-3-Clause
"""Languages in which Programs, not kernels, are printed, one module each; shared code is in `straight`."""
