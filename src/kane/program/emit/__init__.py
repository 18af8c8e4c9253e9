# SPDX-License-Identifier: BSD-3-Clause
"""Emitters, one file a language."""
