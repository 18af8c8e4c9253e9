# SPDX-License-Identifier: BSD-3-Clause
"""Layer 0: Programs (straight-line code) and kernels (code with loops), compiled to machine code or printed in C, NumPy and others."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "from_expressions": "Task build_program Bundle shaped receipt",
        "emit.": "targets",
        "emit.c": "emit_c emit_header",
        "emit.c_kernels": "emit_kernel_c",
        "emit.llvm": "emit_llvm",
        "emit.llvm_printer": "REACH pointed",
        "emit.identifiers": "is_free_in_c local_names",
        "emit.languages.numpy": "emit_numpy",
        "emit.sincos": "C_SINCOS CONSTANTS LIMIT llvm_sincos sine_cosine",
        "emit.wasm": "emit_wasm",
        "emit.wasm_kernels": "add_kernel in_pairs",
        "emit.wasm_module": "Module",
        "emit.walk": "NamedPrinter Style VECTORS function_of hoisting pieces statements",
        "kernel.": "language",
        "kernel.language": (
            "ArrayOf Callee Compute For Immediate FLOAT INT If Kernel Read Integer Put SinCos Write Type Value verified_kernel"
        ),
        "kernel.rewriting": "narrowed specialized",
        "kernel.writer": "Writer decompose factor invert solve substitute",
        "native.": "machine store",
        "native.compiled_routine": "BundleRoutine CompiledRoutine",
        "native.entry": "Bound CompiledKernel aligned entry hoisted masked_entries wide_entry",
        "native.machine": "Library Processor compile_text host object_code target",
        "passes.": "limbs optimize",
        "passes.limbs": "gathered",
        "passes.graphs": "written",
        "passes.optimize": "RULES optimized rewritten starts rounding",
        "program": "Code Port Program Routine assembled explain live_ranges split values verified",
    },
)
