#!/usr/bin/env bash
# Installs the package from this clone into a virtual environment of its own and tests it there.
# Arguments go to pytest; with --learners, what trains comes too (torch: some gigabytes).
set -euo pipefail
cd "$(dirname "$0")/../.."

extras=dev
for argument in "$@"; do
  if [ "$argument" = --learners ]; then extras=dev,learners; fi
done
venv=target/python/$extras
[ -x "$venv/bin/python" ] || "${PYTHON:-python3}" -m venv "$venv"
"$venv/bin/python" -m pip install --quiet ".[$extras]"
"$venv/bin/python" -m pytest --quiet python/tests "$@"
