# SPDX-License-Identifier: BSD-3-Clause
"""Export of systems as Python source, as `kane convert` writes it."""
