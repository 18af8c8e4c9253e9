# SPDX-License-Identifier: BSD-3-Clause
"""Systems with flexible beams."""
