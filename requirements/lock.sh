#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Resolve the groups of pyproject.toml in a fresh environment and pin what was found:
# dev.txt holds everything, run.txt the part that `kane` itself needs. Usage: requirements/lock.sh [python]
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

header() {
  echo "# Made by \`make lock\` with Python $("$work/dev/bin/python" -c 'import platform as p; print(p.python_version(), p.system(), p.machine())')."
  echo "# $1"
}
# the members of dependency groups, includes resolved: one requirement a line
wanted() {
  "$work/dev/bin/python" - "$@" <<'PY'
import sys, tomllib
data = tomllib.load(open("pyproject.toml", "rb"))
groups = data["dependency-groups"]
def members(name):
    for item in groups[name]:
        yield from members(item["include-group"]) if isinstance(item, dict) else [item]
print("\n".join([*data["project"]["dependencies"], *(m for g in sys.argv[1:] for m in members(g))]))
PY
}
freeze() { "$1/bin/python" -m pip freeze --all | grep -viE '^(pip|setuptools|wheel)==' | LC_ALL=C sort -f; }

for which in dev run; do "${1:-python3}" -m venv "$work/$which"; done
wanted dev > "$work/dev.in"
"$work/dev/bin/python" -m pip install --quiet -r "$work/dev.in"
freeze "$work/dev" > "$work/dev.txt"
wanted build > "$work/run.in"
"$work/run/bin/python" -m pip install --quiet -r "$work/run.in" -c "$work/dev.txt"
freeze "$work/run" > "$work/run.txt"
if grep -nE '@|://' "$work"/{dev,run}.txt; then echo "a pin is not a plain version" >&2; exit 1; fi
{ header "Everything the repository's checks need."; cat "$work/dev.txt"; } > requirements/dev.txt
{ header "What kane itself needs, and its build back end: a part of dev.txt."; cat "$work/run.txt"; } > requirements/run.txt
