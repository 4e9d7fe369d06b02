#!/usr/bin/env bash
# Builds the package from this clone, installs it into a virtual environment in cargo's target folder, and runs its tests.
# Needs Python 3.10 or later and Rust. Arguments are passed to pytest; --learners adds the tests that train (torch and ray,
# several gigabytes).
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
# Not `pip install .`, which builds with a new interpreter every time, so that PyO3 would be compiled again.
rm -rf "$folder/wheels"
"$venv/bin/maturin" build --quiet --profile gate --interpreter "$venv/bin/python" --out "$folder/wheels"
wheel=("$folder"/wheels/*.whl)
"$venv/bin/python" -m pip install --quiet --force-reinstall --no-deps "${wheel[0]}"
"$venv/bin/python" -m pip install --quiet "${wheel[0]}[$extras]"
export PYTHONDONTWRITEBYTECODE=1
# The tests of a file share what they trained, and so a process.
"$venv/bin/python" -m pytest --quiet -p no:cacheprovider --numprocesses "$(($(getconf _NPROCESSORS_ONLN) + 1))" --dist loadfile python/tests "$@"
