#!/usr/bin/env bash
# Builds the package from this clone, installs it into a virtual environment in cargo's target folder, and runs its
# tests. Needs Python 3.10 or later and Rust. Arguments are passed to pytest; --learners adds the tests that train
# (torch and ray, several gigabytes).
set -euo pipefail
cd "$(dirname "$0")/../.."

extras=dev
for argument in "$@"; do
  if [ "$argument" = --learners ]; then extras=dev,learners; fi
done
folder=${CARGO_TARGET_DIR:-target}/python
venv=$folder/$extras
python/tests/environment.sh "$extras"
# Not `pip install .`, which builds with a new interpreter every time, so that PyO3 would be compiled again.
rm -rf "$folder/wheels"
"$venv/bin/maturin" build --quiet --profile gate --interpreter "$venv/bin/python" --out "$folder/wheels"
wheel=("$folder"/wheels/*.whl)
"$venv/bin/python" -m pip install --quiet --no-compile --force-reinstall --no-deps "${wheel[0]}"
"$venv/bin/python" -m pip install --quiet --no-compile "${wheel[0]}[$extras]"
# Large pages for the engine, as in `.ci/rust-tests`.
export GLIBC_TUNABLES=${GLIBC_TUNABLES:-glibc.malloc.hugetlb=1}
# Keeps bytecode out of the source folders.
PYTHONPYCACHEPREFIX=$(realpath "$folder")/compiled
export PYTHONPYCACHEPREFIX
# The tests of a file share trained agents, so a file runs in one process.
"$venv/bin/python" -m pytest --quiet -p no:cacheprovider --numprocesses "$(($(getconf _NPROCESSORS_ONLN) + 1))" --dist loadfile python/tests "$@"
