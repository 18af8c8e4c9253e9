# SPDX-License-Identifier: BSD-3-Clause
"""Forms of expressions that are shorter or say more: collected, expanded, scaled, as series, antiderivatives."""
