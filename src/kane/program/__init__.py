# SPDX-License-Identifier: BSD-3-Clause
"""Layer 5: equations as Programs, and Programs as machine code, C and NumPy."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "build": "Task build_program",
        "bundle": "Bundle shaped",
        "emit.": "targets",
        "emit.c": "C_SINCOS emit_c emit_header",
        "emit.kernel_c": "emit_kernel_c",
        "emit.llvm": "emit_llvm",
        "emit.llvm_near": "REACH pointed",
        "emit.llvm_sincos": "llvm_sincos",
        "emit.names": "is_free_in_c local_names",
        "emit.numpy": "emit_numpy",
        "emit.sincos": "CONSTANTS LIMIT sine_cosine",
        "emit.walk": "Assign Read SinCos Style VECTORS Write function_of hoisting pieces statements",
        "kernel.interpret": "interpret",
        "kernel.language": "ArrayOf Compute Constant FLOAT INT If Kernel Number Put Store Type Value",
        "kernel.verify": "verified_kernel",
        "kernel.write": "Writer",
        "native.": "machine_code store",
        "native.compiled_kernel": "CompiledKernel",
        "native.compiled_routine": "BundleRoutine CompiledRoutine",
        "native.entry": "aligned entry hoisted wide_entry",
        "native.machine_code": "Library Target compile_text host object_code target",
        "operation_count": "receipt",
        "passes.": "limbs optimize",
        "passes.gather": "gathered",
        "passes.graphs": "written",
        "passes.optimize": "optimized rewritten starts",
        "passes.rounding": "rounding",
        "passes.split": "split",
        "passes.tiers": "assembled live_ranges",
        "passes.verify": "verified",
        "program": "Code Port Program Routine",
        "reference": "explain values",
    },
)
