# SPDX-License-Identifier: BSD-3-Clause
"""Operation counts (deterministic, gating) and timed comparisons with peers."""
