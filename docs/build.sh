#!/usr/bin/env bash
# Builds the documentation site into target/docs/html, from an installed package: `pip install '.[docs]'`, or after
# python/tests/run.sh and the installation of the extra [docs] there. A broken internal link fails the build, and so does
# a tutorial that raises. PYTHON is the interpreter of that environment; arguments are passed to sphinx-build.
# `docs/build.sh --check-links` also asks for every external link.
set -euo pipefail
cd "$(dirname "$0")/.."

external=false
if [ "${1:-}" = --check-links ]; then
  external=true
  shift
fi
folder=${CARGO_TARGET_DIR:-target}/docs
python=${PYTHON:-python3}
rm -rf "$folder/source"
mkdir -p "$folder/source"
cp -r docs/*.md docs/*.png docs/*.svg docs/*.txt docs/concepts docs/tutorials docs/figures docs/site/* "$folder/source"
# The pages are written for their places in the repository.
sed 's|](docs/|](|g' README.md > "$folder/source/README.md"
cp CHANGELOG.md "$folder/source/changelog.md"
"$python" docs/site/commands.py > "$folder/source/commands.md"
rm "$folder/source/commands.py"
sphinx() {
  "$python" -m sphinx --quiet --fail-on-warning --keep-going -d "$folder/doctrees" "$@"
}
sphinx "$@" "$folder/source" "$folder/html"
if $external; then
  sphinx -b linkcheck "$folder/source" "$folder/links"
fi
echo "$folder/html/index.html"
