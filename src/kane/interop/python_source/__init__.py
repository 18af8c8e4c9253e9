# SPDX-License-Identifier: BSD-3-Clause
"""Systems as Python files that declare them: what `kane convert` writes."""
