#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A Python as on an older processor: what OpenBLAS, LLVM, glibc and NumPy would use of this one beyond it is left.
# Usage: requirements/as_machine.sh Nehalem|Haswell python argument …
set -euo pipefail
case $1 in
  Nehalem) level=x86-64-v2 without=-AVX_Usable,-AVX2_Usable,-FMA_Usable,-AVX2,-FMA,-AVX512F,-AVX512VL ;;
  Haswell) level=x86-64-v3 without=-AVX512F,-AVX512VL ;;
  *) echo "Expected Nehalem or Haswell, got $1." >&2 && exit 2 ;;
esac

# What this NumPy would use of the processor and can be told to leave.
features=$("$2" - <<'PY'
from numpy._core._multiarray_umath import __cpu_dispatch__ as known, __cpu_features__ as here
print(" ".join(f for f in known if here[f]))
PY
)
exec env OPENBLAS_CORETYPE="$1" KANE_CPU="$level" GLIBC_TUNABLES="glibc.cpu.hwcaps=$without" NPY_DISABLE_CPU_FEATURES="$features" "${@:2}"
