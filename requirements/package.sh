#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Build the source distribution, from it the wheel, and try the wheel as a user has it: installed alone, first at the versions of run.txt,
# then at the lowest versions that pyproject.toml allows, where PATH holds no compiler and no node. At the lowest versions the tests
# that need no other tool run too, warnings being errors, as on a Nehalem where this processor can be one: machines.sh leaves to this run what
# it runs of them. One run looks after two things: where it fails, run the test by hand at these versions, and at those of dev.txt as on a
# Nehalem (requirements/as_machine.sh). Usage: requirements/package.sh [python]
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD bin=$PWD/.venv/bin python=${1:-python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export UV_PYTHON_DOWNLOADS=never
[ -z "${PIP_INDEX_URL:-}" ] || export UV_DEFAULT_INDEX=$PIP_INDEX_URL

install() { "$bin/uv" pip install --quiet --python "$1/bin/python" "${@:2}"; }

# The command from a folder of its own, with nothing around it: $1 is the environment.
alone() { (cd "$work/out" && env -i PATH="$1/bin" HOME="$work/home" "${@:2}"); }

try() {
  local env=$1 tool
  rm -rf "$work/out" "$work/home" && mkdir "$work/out" "$work/home"
  for tool in cc gcc g++ clang c++ node nodejs; do
    if alone "$env" "$env/bin/python" -c "import shutil, sys; sys.exit(shutil.which('$tool') is None)"; then
      echo "Expected no $tool on PATH, got one in $env/bin." >&2 && return 1
    fi
  done
  alone "$env" kane demo --out out | tail -n 2
  alone "$env" kane new x.py
  alone "$env" kane check x.py > /dev/null
  alone "$env" kane report x.py
  [ -s "$work/out/out/rolling_disk/report.html" ] && [ -s "$work/out/x.html" ]
}

"$bin/uv" build --quiet --no-build-isolation --python "$bin/python" --out-dir "$work/dist"
wheel=$(echo "$work"/dist/kane-*.whl)
echo "Built: ${wheel##*/} from $(cd "$work/dist" && echo kane-*.tar.gz)"

echo "-- at the versions of run.txt"
"$python" -m venv "$work/clean"
install "$work/clean" --constraint requirements/run.txt "$wheel"
try "$work/clean"

echo "-- at the lowest versions allowed"
"$python" -m venv "$work/lowest"
"$bin/uv" pip compile --quiet --no-header --no-annotate --resolution lowest-direct --python "$work/lowest/bin/python" \
  --output-file "$work/lowest.txt" pyproject.toml > /dev/null
install "$work/lowest" --requirement "$work/lowest.txt" "$wheel"
grep -E "^($("$bin/python" - <<'PY'
import re, tomllib
wanted = tomllib.load(open("pyproject.toml", "rb"))["project"]["dependencies"]
print("|".join(re.match(r"[\w.-]+", line)[0] for line in wanted))
PY
))==" "$work/lowest.txt" | paste -sd ' '
try "$work/lowest"
grep -E '^(pytest|pytest-xdist|pytest-timeout|hypothesis)==' requirements/dev.txt > "$work/tools.txt"
install "$work/lowest" --constraint "$work/lowest.txt" --requirement "$work/tools.txt"
found=$("$work/lowest/bin/python" -c 'import kane; print(kane.__file__)')
case $found in
  "$work/lowest/"*) ;;
  *) echo "Expected the tests to import the wheel, got $found." >&2 && exit 1 ;;
esac
cd "$root"
# peers and what extras bring are absent here on purpose: their tests are skipped, and fail for want of them in `make test` alone
on_nehalem=(bash requirements/as_machine.sh Nehalem)
[ "$(uname -m)" = x86_64 ] || on_nehalem=()
env -u CI -u KANE_FULL "${on_nehalem[@]}" "$work/lowest/bin/python" -m pytest -p no:cacheprovider -n "${JOBS:-2}" --dist worksteal \
  --hypothesis-profile=quick -q tests/expr tests/program tests/equations tests/analysis tests/motion tests/numeric tests/interop
