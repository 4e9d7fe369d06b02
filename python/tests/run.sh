#!/usr/bin/env bash
# Builds the package from this clone, installs it into a virtual environment of its own, and tests it there. Needs Python
# 3.10 or later and Rust; all that is made is in cargo's target folder. Arguments go to pytest; with --learners, what
# trains comes too (torch and ray: some gigabytes).
set -euo pipefail
cd "$(dirname "$0")/../.."

extras=dev
for argument in "$@"; do
  if [ "$argument" = --learners ]; then extras=dev,learners; fi
done
folder=${CARGO_TARGET_DIR:-target}/python
venv=$folder/$extras
[ -x "$venv/bin/maturin" ] || {
  "${PYTHON:-python3}" -m venv --clear "$venv"
  "$venv/bin/python" -m pip install --quiet 'maturin>=1.9,<2'
}
# Not `pip install .`: it builds with another interpreter every time, and PyO3 would be compiled anew for each.
rm -rf "$folder/wheels"
"$venv/bin/maturin" build --quiet --release --interpreter "$venv/bin/python" --out "$folder/wheels"
wheel=("$folder"/wheels/*.whl)
"$venv/bin/python" -m pip install --quiet --force-reinstall --no-deps "${wheel[0]}"
"$venv/bin/python" -m pip install --quiet "${wheel[0]}[$extras]"
export PYTHONDONTWRITEBYTECODE=1
"$venv/bin/python" -m pytest --quiet -p no:cacheprovider python/tests "$@"
