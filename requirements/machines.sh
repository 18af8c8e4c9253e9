#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The quick tests again as on older processors, and what is made of systems there compared with the golden file: equations, counts and texts
# must not depend on how BLAS, NumPy and the C library round. Where this processor is of that level itself, the tests ran in `make test`, and
# texts alone are compared. Needs an x86-64 processor.
set -euo pipefail
cd "$(dirname "$0")/.."
python=$PWD/.venv/bin/python

# What NumPy would use of this processor and can be told to leave.
features=$("$python" - <<'PY'
from numpy._core._multiarray_umath import __cpu_dispatch__ as known, __cpu_features__ as here
print(" ".join(f for f in known if here[f]))
PY
)

as_machine() {  # name, OpenBLAS's kernels, level of x86-64, glibc's variants to leave out, then a command
  env OPENBLAS_CORETYPE="$2" KANE_CPU="$3" GLIBC_TUNABLES="glibc.cpu.hwcaps=$4" NPY_DISABLE_CPU_FEATURES="$features" "${@:5}"
}

# what rests on the processor: pages, formats and the command are the same on all
tests=(tests/analysis tests/contacts tests/dynamics tests/equations tests/expr tests/kinematics tests/laws tests/model tests/motion tests/numeric tests/program tests/tree)
status=0
case " $features " in *X86_V4* | *AVX512*) same=none ;; *X86_V3* | *FMA3*) same=x86-64-v3 ;; *) same=x86-64-v2 ;; esac
while read -r name blas level without; do
  echo "-- as $name"
  as_machine "$name" "$blas" "$level" "$without" "$python" -m tests.golden --random 100 --jobs "${JOBS:-2}" || status=1
  [ "$level" != "$same" ] || continue
  as_machine "$name" "$blas" "$level" "$without" "$python" -m pytest -p no:cacheprovider -n "${JOBS:-2}" --dist worksteal \
    --hypothesis-profile=quick -q "${tests[@]}" || status=1
done <<'MACHINES'
Nehalem Nehalem x86-64-v2 -AVX_Usable,-AVX2_Usable,-FMA_Usable,-AVX2,-FMA,-AVX512F,-AVX512VL
Haswell Haswell x86-64-v3 -AVX512F,-AVX512VL
MACHINES
exit $status
