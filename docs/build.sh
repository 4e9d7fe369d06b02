#!/usr/bin/env bash
# Builds the documentation site into target/docs/html, from an installed package: `pip install '.[docs]'`, or after
# python/tests/run.sh. PYTHON is the interpreter of that environment; arguments are passed to sphinx-build.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${CARGO_TARGET_DIR:-target}/docs
python=${PYTHON:-python3}
rm -rf "$folder/source"
mkdir -p "$folder/source"
cp docs/*.md docs/*.png docs/site/* "$folder/source"
# The pages are written for their places in the repository.
sed 's|](docs/|](|g' README.md > "$folder/source/README.md"
cp CHANGELOG.md "$folder/source/changelog.md"
"$python" docs/site/commands.py > "$folder/source/commands.md"
rm "$folder/source/commands.py"
"$python" -m sphinx --quiet --fail-on-warning --keep-going -d "$folder/doctrees" "$@" "$folder/source" "$folder/html"
echo "$folder/html/index.html"
