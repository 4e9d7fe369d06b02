#!/usr/bin/env bash
# Checks the Python code with ruff and mypy, in the virtual environment that run.sh makes.
set -euo pipefail
cd "$(dirname "$0")/../.."

venv=${CARGO_TARGET_DIR:-target}/python/dev
[ -x "$venv/bin/mypy" ] || {
  echo "$venv has no mypy; run python/tests/run.sh first" >&2
  exit 1
}
"$venv/bin/ruff" check --no-cache python
"$venv/bin/ruff" format --no-cache --check python
"$venv/bin/mypy" --cache-dir "${CARGO_TARGET_DIR:-target}/python/mypy"
