# SPDX-License-Identifier: BSD-3-Clause
"""Native code: compilation, cache, handles."""
