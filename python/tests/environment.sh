#!/usr/bin/env bash
# Makes the virtual environment of the Python tests in cargo's target folder, with everything but the package, which may
# still be building. Argument: the extras of the package, such as dev,learners.
set -euo pipefail
cd "$(dirname "$0")/../.."

extras=$1
venv=${CARGO_TARGET_DIR:-target}/python/$extras
[ -x "$venv/bin/maturin" ] && exit
"${PYTHON:-python3}" -m venv --clear "$venv"
# Without compiling bytecode: tests import only a small part, which is compiled on first import.
"$venv/bin/python" -m pip install --quiet --no-compile -r <("$venv/bin/python" - "$extras" <<'REQUIREMENTS'
import sys

try:
    import tomllib
except ImportError:
    from pip._vendor import tomli as tomllib

with open("pyproject.toml", "rb") as file:
    project = tomllib.load(file)["project"]
extras = [project["optional-dependencies"][extra] for extra in sys.argv[1].split(",")]
print("maturin>=1.9,<2", *project["dependencies"], *sum(extras, []), sep="\n")
REQUIREMENTS
)
