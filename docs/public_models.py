"""Imports public EnergyPlus models and prints how they are controlled: public-models.txt, and a table of public-models.md.

Usage: python docs/public_models.py CHECKOUTS [B2B]

CHECKOUTS is a folder with the repositories of public_models.csv as OWNER/NAME. The reports on every model are kept in
CHECKOUTS/reports; delete one to make it again. Models of two seasons also run a week of July and the response check.
"""

import csv
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

PLACE = ["--place", "Chicago", "--json"]
JANUARY = ["import", "--run", "01-08..01-14", *PLACE]
JULY = ["import", "--run", "07-08..07-14", *PLACE]
AUTHORITY = ["doctor", *PLACE, "--authority"]
ENGINE = "25.2"


def report_on(command: list[str], model: Path, kept: Path, b2b: str) -> dict[str, Any]:
    """Returns the JSON that a command prints about a model, or its error."""
    if not kept.exists():
        done = subprocess.run([b2b, *command, model], capture_output=True, text=True, check=False)
        kept.write_text(done.stdout or json.dumps({"error": done.stderr}))
    return json.loads(kept.read_text())


def reason(error: str) -> str:
    """Returns the line of an error that says what was wrong."""
    lines = [line.strip() for line in error.splitlines() if line.strip()]
    wrong = [line for line in lines if line.startswith(("fatal:", "severe:"))] or lines[-1:]
    return wrong[0].replace("|", "/")[:240]


def remark(report: dict[str, Any]) -> str:
    """Returns the zone that is far from its target, and the schedules that switch its equipment off."""
    trial = report["trial"]
    if trial["worst_zone_rms_k"] < 1:
        return ""
    off = [each for each in report["notes"].get("switched_off", []) if trial["worst_zone"] in each["zones"]]
    schedules = [f"`{each['schedule']}` switches off {100 * each['share']:.0f} % of the year" for each in off]
    return "; ".join([f"{trial['worst_zone']} {trial['worst_zone_rms_k']:.1f} K", *schedules[:2]]).replace("|", "/")


def deviation(trial: dict[str, Any]) -> str:
    """Returns the RMS deviation, of zones without cooling if there are no others."""
    return f"{(trial['rms_deviation_k'] or trial['rms_heating_only_k']) + 0.0:.2f}"


def row(name: str, report: dict[str, Any]) -> list[str]:
    """Returns the cells of a model."""
    if "error" in report:
        return [name, "", "", "", "", "", "", reason(report["error"])]
    zones, trial = report["zones"], report["trial"]
    conversion = report["notes"]["conversion"]
    through = {zone.lower() for each in report["systems"] if each["kind"] == "setpoints" for zone in each["zones"]}
    controlled = [zone["name"].lower() for zone in zones if zone["controlled"]]
    by_setpoints = sum(zone in through for zone in controlled)
    counts = [len(controlled) - by_setpoints, by_setpoints, len(zones) - len(controlled)]
    version = conversion["from"] if conversion else ENGINE
    return [name, version, *map(str, counts), deviation(trial), str(trial["severes"]), remark(report)]


def row_of_seasons(name: str, january: dict[str, Any], july: dict[str, Any], authority: dict[str, Any]) -> list[str]:
    """Returns the cells of a model that is tried in both seasons."""
    deviations = [deviation(week["trial"]) for week in (january, july)]
    verdicts = [each["verdict"] for each in authority["rows"]]
    counts = [verdicts.count("follows"), sum(isinstance(each, dict) for each in verdicts), verdicts.count("fails")]
    severes = january["trial"]["severes"] + july["trial"]["severes"]
    return [name, *deviations, str(severes), *map(str, counts)]


def print_aligned(rows: list[list[str]]) -> None:
    """Prints rows in columns; the last column is as wide as it is."""
    widths = [max(len(cells[column]) for cells in rows) for column in range(len(rows[0]) - 1)]
    for *cells, last in rows:
        print("  ".join([*(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)), last]).rstrip())


def main(checkouts: Path, b2b: str) -> None:
    """Prints the tables."""
    listed = list(csv.DictReader(Path(__file__).with_suffix(".csv").open()))
    folder = checkouts / "reports"
    folder.mkdir(exist_ok=True)
    rows = [["model", "version", "by actuators", "by setpoints", "neither", "RMS (K)", "severe", "note"]]
    usable, seasons = 0, []
    for number, model in enumerate(listed):
        path = checkouts / model["repository"] / model["path"]
        name = f"{model['repository']}: {path.name}"
        january = report_on(JANUARY, path, folder / f"{number}.json", b2b)
        print(name, file=sys.stderr, flush=True)
        rows.append(row(name, january))
        if "error" in january:
            continue
        usable += 1
        if model["seasons"] == "2":
            july = report_on(JULY, path, folder / f"{number}-july.json", b2b)
            authority = report_on(AUTHORITY, path, folder / f"{number}-authority.json", b2b)
            seasons.append(row_of_seasons(path.name, january, july, authority))
    print_aligned(rows)
    print(f"\n{usable} of {len(listed)} can be used.\n")
    print("| model | January: RMS (K) | July | severe | commands that follow | at capacity | fail |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for cells in seasons:
        print("| " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "b2b")
