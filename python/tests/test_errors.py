"""Hints about missing packages."""

import re
import sys
from pathlib import Path

import pytest
from building2building import errors

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("extra", ["plots", "train"])
def test_a_hint_names_packages_that_a_registry_has(extra, monkeypatch):
    text = (ROOT / "pyproject.toml").read_text()
    packages = re.findall(r'"([^"]+)"', re.search(rf"^{extra} = \[(.*)\]$", text, re.M)[1])
    monkeypatch.setitem(sys.modules, "missing_package", None)
    with pytest.raises(errors.MissingExtra) as raised:
        errors.need("missing_package", extra)
    expected = " ".join(f"'{each}'" for each in packages)
    assert str(raised.value) == f"missing_package is not installed; run: pip install {expected}"


@pytest.mark.parametrize("page", sorted((ROOT / "docs/tutorials").glob("*.md")), ids=lambda page: page.stem)
def test_a_tutorial_says_what_it_needs(page):
    text = page.read_text()
    # Plots are made when the site is built, and are not in the file.
    assert "`docs/build.sh` builds the pages" in text
    for package in ("matplotlib", "stable_baselines3"):
        if f"import {package}" in text:
            assert f"pip install {package.replace('_', '-')}" in text.partition(f"import {package}")[0]
