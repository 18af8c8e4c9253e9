# SPDX-License-Identifier: BSD-3-Clause
"""Simulations as programs in other languages: C99 and WebAssembly."""
