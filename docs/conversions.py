"""Converts examples of EnergyPlus that exist in several versions, and prints their energy of a year beside each other.

Usage: python docs/conversions.py CHECKOUTS [B2B]

CHECKOUTS is a folder with the repositories of conversions.csv as OWNER/NAME, the engine's own models as `engine`
(`data/model` beside the library that `b2b doctor` prints), the models in the packages besos 2.2.3
(`data/example_idf.idf`) and besos_examples 0.1.0 (`Evaluators`) as `besos/examples`, and the output of
openstudio_models.py with openstudio 3.11.0 as `openstudio`, with 3.7.0 as `openstudio-3.7`. Every model keeps its own
controls, with weather of Chicago. Differences are from the newest version of the example. No
example of 8.9 or 9.1 could be had. Reports are kept in CHECKOUTS/conversions.
"""

import csv
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

YEAR = ["--place", "Chicago", "--period", "full_year", "--controller", "own", "--steps-per-hour", "6", "--json"]
ENERGY = ["electricity_wh_m2", "gas_wh_m2", "heating_wh_m2", "cooling_wh_m2", "fans_wh_m2"]


def year_of(model: Path, kept: Path, b2b: str) -> dict[str, Any]:
    """Returns what ``b2b run --json`` prints about a year of a model."""
    if not kept.exists():
        out = kept.with_suffix("")
        done = subprocess.run([b2b, "run", model, *YEAR, "--out", out], capture_output=True, text=True, check=False)
        kept.write_text(done.stdout or json.dumps({"error": done.stderr}))
    return json.loads(kept.read_text())


def cells(year: dict[str, Any], newest: dict[str, Any]) -> list[str]:
    """Returns the energy of a year, kWh/m², each with its difference from the newest version."""
    if "error" in year:
        return [year["error"].strip().splitlines()[-1][:200]]

    def cell(name: str) -> str:
        ours, theirs = year[name], newest[name]
        difference = f" ({100 * (ours / theirs - 1):+.2f} %)" if theirs > 0 and year is not newest else ""
        return f"{ours / 1000:.2f}{difference}"

    same = "same" if year["model_sha256"] == newest["model_sha256"] else "another"
    return [*map(cell, ENERGY), same]


def main(checkouts: Path, b2b: str) -> None:
    """Prints the table."""
    listed = list(csv.DictReader(Path(__file__).with_suffix(".csv").open()))
    folder = checkouts / "conversions"
    folder.mkdir(exist_ok=True)
    years = {
        (each["family"], each["version"]): year_of(
            checkouts / each["repository"] / each["path"], folder / f"{each['family']} {each['version']}.json", b2b
        )
        for each in listed
    }
    newest = {each["family"]: years[each["family"], each["version"]] for each in listed}
    print("| example | version | electricity (kWh/m²) | gas | heating | cooling | fans | model |")
    print("|---|---|--:|--:|--:|--:|--:|---|")
    for (family, version), year in years.items():
        print("| " + " | ".join([family, version, *cells(year, newest[family])]) + " |", flush=True)
    print("\nNo example of 8.9 or 9.1 could be had; their rules are among those that the files of 8.8 and 9.0 pass.")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "b2b")
