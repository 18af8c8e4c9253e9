#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The quick tests of what meets the interpreter and other packages, from declarations to motions and the command, on the newest other Python
# that is at hand, on PATH or under pyenv, at the versions of dev.txt, as on a Haswell; on those between, what depends most on the interpreter.
# What draws and documents is tried on one Python only, and so is the gallery but for contacts, which rounding would set moving: the golden
# file compares its systems on old processors. One run looks after two things, each of which the other tests leave alone: where it fails, run
# the test by hand on that Python, and as on a Haswell on this one (requirements/as_machine.sh).
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export UV_PYTHON_DOWNLOADS=never
[ -z "${PIP_INDEX_URL:-}" ] || export UV_DEFAULT_INDEX=$PIP_INDEX_URL

# A shim on PATH may stand for nothing: what counts is that it runs.
at_hand() {
  local python
  for python in "python$1" "$(pyenv prefix "$1" 2> /dev/null || true)/bin/python"; do
    if "$python" -c 'import venv' 2> /dev/null; then
      "$python" -c 'import sys; print(sys.executable)'
      return
    fi
  done
}

own=$(.venv/bin/python -c 'import sys; print("%d.%d" % sys.version_info[:2])')
ran=() absent=()
on_haswell=(bash requirements/as_machine.sh Haswell)
[ "$(uname -m)" = x86_64 ] || on_haswell=()
run() { "${on_haswell[@]}" "$1" -m pytest -p no:cacheprovider -n "${JOBS:-2}" --dist worksteal --hypothesis-profile=quick -q "${@:2}"; }
tests=(tests/expr tests/space tests/model tests/program tests/equations tests/motion tests/numeric tests/gallery/test_contacts.py
  tests/cli tests/test_api.py)
for version in 3.13 3.12 3.11; do
  [ "$version" != "$own" ] || continue
  python=$(at_hand "$version")
  if [ -z "$python" ]; then
    absent+=("$version")
    continue
  fi
  echo "-- Python $version"
  env=$work/$version
  "$python" -m venv "$env"
  .venv/bin/uv pip install --quiet --python "$env/bin/python" --requirement requirements/dev.txt
  .venv/bin/uv pip install --quiet --python "$env/bin/python" --no-deps --no-build-isolation .
  run "$env/bin/python" "${tests[@]}"
  tests=(tests/expr tests/program tests/cli tests/test_api.py) on_haswell=()
  ran+=("$version")
done
if ((!${#ran[@]} && ${#on_haswell[@]})); then run .venv/bin/python "${tests[@]}"; fi  # machines.sh leaves them to this
echo "Tested on Python $own and: ${ran[*]:-no other}. Not at hand: ${absent[*]:-none}."
