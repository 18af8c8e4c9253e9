# SPDX-License-Identifier: BSD-3-Clause
"""Results to read and look at: steps as text, the report, plots."""
