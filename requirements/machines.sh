#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The quick tests again as on older processors, and what is made of systems there compared with the golden file: equations, counts and texts
# must not depend on how BLAS, NumPy and the C library round. What another Python runs as on a Haswell (pythons.sh) is not run as on one here,
# nor as on a Nehalem what the lowest versions of packages run as on one (package.sh): expressions, programs, numbers and motions, which take
# most of the time. Where this processor is such a one itself, texts alone are compared. Needs an x86-64 processor.
set -euo pipefail
cd "$(dirname "$0")/.."
python=$PWD/.venv/bin/python

# what rests on the processor and runs nowhere else as on another: pages, formats and the command are the same on all
tests=(tests/analysis tests/contacts tests/dynamics tests/kinematics tests/laws tests/tree)
# and what the lowest versions do not run, without a package of an extra: many motions in lanes, but not files, stores and clusters
left=(tests/model tests/motion/many tests/motion/test_sundials.py --ignore=tests/motion/many/test_cluster.py --ignore=tests/motion/many/test_stores.py)
status=0
case $("$python" -c 'from numpy._core._multiarray_umath import __cpu_features__ as f; print([n for n in f if f[n]])') in
  *AVX512* | *X86_V4*) here= ;; *FMA3* | *X86_V3*) here=Haswell ;; *) here=Nehalem ;;
esac
for name in Nehalem Haswell; do
  echo "-- as $name"
  bash requirements/as_machine.sh "$name" "$python" -m tests.golden --random 100 --jobs "${JOBS:-2}" || status=1
  [ "$name" != "$here" ] || continue
  more=()
  [ "$name" = Haswell ] || more=("${left[@]}")
  bash requirements/as_machine.sh "$name" "$python" -m pytest -p no:cacheprovider -n "${JOBS:-2}" --dist worksteal \
    --hypothesis-profile=quick -q "${tests[@]}" "${more[@]}" || status=1
done
exit $status
