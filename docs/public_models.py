"""Imports public EnergyPlus models and prints a Markdown table of how they are controlled.

Usage: python docs/public_models.py CHECKOUTS [B2B]

CHECKOUTS is a folder with the repositories of public_models.csv as OWNER/NAME. The report on every model is kept in
CHECKOUTS/reports; delete it to import the model again.
"""

import csv
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

OPTIONS = ["--place", "Chicago", "--run", "01-08..01-14", "--json"]
ENGINE = "25.2"


def report_on(model: Path, kept: Path, b2b: str) -> dict[str, Any]:
    """Returns what ``b2b import --json`` prints, or its error."""
    if not kept.exists():
        done = subprocess.run([b2b, "import", model, *OPTIONS], capture_output=True, text=True, check=False)
        said = done.stdout if done.returncode == 0 else json.dumps({"error": done.stderr})
        kept.write_text(said)
    return json.loads(kept.read_text())


def reason(error: str) -> str:
    """Returns the last line of an error that says what was wrong."""
    lines = [line.strip() for line in error.splitlines() if line.strip()]
    wrong = [line for line in lines if line.startswith(("fatal:", "severe:"))] or lines[-1:]
    return wrong[0].replace("|", "/")[:240]


def row(repository: str, path: str, report: dict[str, Any]) -> list[str]:
    """Returns the cells of a model."""
    name = f"{repository}: {Path(path).name}"
    if "error" in report:
        return [name, "", "", "", "", "", "", reason(report["error"])]
    zones, trial = report["zones"], report["trial"]
    conversion = report["notes"]["conversion"]
    through = {zone.lower() for each in report["systems"] if each["kind"] == "setpoints" for zone in each["zones"]}
    controlled = [zone["name"].lower() for zone in zones if zone["controlled"]]
    by_setpoints = sum(zone in through for zone in controlled)
    return [
        name,
        conversion["from"] if conversion else ENGINE,
        str(len(controlled) - by_setpoints),
        str(by_setpoints),
        str(len(zones) - len(controlled)),
        f"{trial['rms_deviation_k']:.2f}",
        str(trial["severes"]),
        f"{trial['worst_zone']} {trial['worst_zone_rms_k']:.1f} K" if trial["worst_zone_rms_k"] >= 1 else "",
    ]


def main(checkouts: Path, b2b: str) -> None:
    """Prints the table."""
    listed = list(csv.DictReader(Path(__file__).with_suffix(".csv").open()))
    folder = checkouts / "reports"
    folder.mkdir(exist_ok=True)
    print("| model | version | zones: actuators | setpoints | neither | RMS (K) | severe | note |")
    print("|---|---|--:|--:|--:|--:|--:|---|")
    usable = 0
    for number, model in enumerate(listed):
        repository, path = model["repository"], model["path"]
        report = report_on(checkouts / repository / path, folder / f"{number}.json", b2b)
        usable += "error" not in report
        print("| " + " | ".join(row(repository, path, report)) + " |", flush=True)
    print(f"\n{usable} of {len(listed)} can be used.")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "b2b")
