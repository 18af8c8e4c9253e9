# SPDX-License-Identifier: BSD-3-Clause
"""Motions as programs of other languages: in C99, in WebAssembly."""
