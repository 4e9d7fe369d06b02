"""Trajectories of the controller ``guideline36`` under the rules of ConStrain."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

RULES = Path(__file__).parent / "constrain_rules.py"
TYPES = ("OfficeSmall", "OfficeMedium", "RetailStandalone", "RestaurantFastFood", "Warehouse", "SingleFamilyHouse")
# Mondays and Tuesdays in four seasons.
SEASONS = ("01-09..01-10", "04-10..04-11", "07-10..07-11", "10-16..10-17")
UNMET = "LocalLoopUnmetHours"


@pytest.fixture(scope="module")
def constrain():
    """A Python with the package, in a separate environment, because it has a hundred dependencies."""
    venv = Path(__file__).parents[3] / os.environ.get("CARGO_TARGET_DIR", "target") / "python/constrain"
    python = venv / "bin/python"
    if not (venv / "installed").exists():
        subprocess.run([sys.executable, "-m", "venv", "--clear", venv], check=True)
        packages = ["constrain==0.8.0", "pyarrow>=16"]
        subprocess.run([python, "-m", "pip", "install", "--quiet", *packages], check=True)
        (venv / "installed").touch()
    return python


@pytest.fixture(scope="module")
def verdicts(constrain, b2b_command, tmp_path_factory):
    """The verdicts of all rules: six types, two days in each of four seasons."""
    runs = tmp_path_factory.mktemp("runs")
    for building in TYPES:
        for season in SEASONS:
            command = [b2b_command, "run", building, "--period", season, "--out", runs / building / season, "--json"]
            subprocess.run(command, check=True, capture_output=True)
    judged = subprocess.run([constrain, RULES, runs], check=True, capture_output=True)
    return json.loads(judged.stdout)


@pytest.mark.nightly
def test_every_applicable_rule_of_constrain_passes_in_all_types_and_seasons(verdicts):
    assert [verdict for verdict in verdicts if verdict["passed"] is False and verdict["rule"] != UNMET] == []
    tested = {verdict["rule"] for verdict in verdicts if verdict["passed"] is not None}
    assert len(tested) == 17, tested


@pytest.mark.nightly
def test_one_zone_of_all_is_outside_its_band_for_more_than_a_twentieth_of_the_time(verdicts):
    """A sunny room on the ground floor in January, after the doors open at 7 and after lunch (docs/guideline36.md)."""
    outside = [verdict for verdict in verdicts if verdict["passed"] is False and verdict["rule"] == UNMET]
    assert [verdict["subject"] for verdict in outside] == ["Perimeter_bot_ZN_1"]
