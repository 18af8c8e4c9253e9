# SPDX-License-Identifier: BSD-3-Clause
"""Questions to equations that are no motions: assembly, linearization, trim, continuation, inverse dynamics."""
