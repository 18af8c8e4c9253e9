# SPDX-License-Identifier: BSD-3-Clause
"""Native code: compilation through LLVM, the cache of object code, callable routines and kernels."""
