# SPDX-License-Identifier: BSD-3-Clause
"""Systems with contacts: they stick or roll, slip, separate and hit."""
