# SPDX-License-Identifier: BSD-3-Clause
"""Languages that print Programs alone, one file each; what they share is in `straight` and `reserved`."""
