# SPDX-License-Identifier: BSD-3-Clause
"""Emitters, one module per target language."""
