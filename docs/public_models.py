"""Imports public EnergyPlus models and writes how they are controlled: public-models.txt, and the tables of
public-models.md and import.md.

Usage: python docs/public_models.py CHECKOUTS [B2B]

CHECKOUTS is a folder with the repositories of public_models.csv as OWNER/NAME, the engine's own models as `engine`
(`data/model` beside the library that `b2b doctor` prints) and the output of openstudio_models.py as `openstudio`. The
reports on every model are kept in CHECKOUTS/reports, so that an interrupted run continues; delete one to make it again.
Models of two seasons also run a week of July and the response check. A week in which a model is more than 1 K from 21
°C runs again under the model's own controls. Two models run at a time.
"""

import csv
import json
import re
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
WEEKS = {"january": "01-08..01-14", "july": "07-08..07-14"}
ENGINE = "25.2"
FAR = 1.0
PROTOTYPES = {
    "ApartmentHighRise": "high-rise apartments",
    "ApartmentMidRise MidriseApartment": "mid-rise apartments",
    "Hospital": "hospital",
    "HotelLarge LargeHotel": "large hotel",
    "HotelSmall SmallHotel": "small hotel",
    "OfficeLarge LargeOffice": "large office",
    "OfficeMedium MediumOffice": "medium office",
    "OfficeSmall SmallOffice": "small office",
    "OutPatientHealthCare OutPatient": "outpatient clinic",
    "RestaurantFastFood QuickServiceRestaurant": "fast food",
    "RestaurantSitDown FullServiceRestaurant": "sit-down restaurant",
    "RetailStandalone Stand-aloneRetail": "retail store",
    "RetailStripmall StripMall": "strip mall",
    "SchoolPrimary PrimarySchool": "primary school",
    "SchoolSecondary SecondarySchool": "secondary school",
    "Warehouse": "warehouse",
    "SuperMarket": "supermarket",
}


class Listed:
    """A model of the list, with the reports on it."""

    def __init__(self, row: dict[str, str], checkouts: Path, b2b: str) -> None:
        self.path = checkouts / row["repository"] / row["path"]
        if not self.path.exists():
            message = f"{self.path} is missing: check out {row['repository']} into {checkouts}"
            raise SystemExit(message)
        self.source = row["repository"]
        self.place = row["place"]
        self.reports = checkouts / "reports"
        self.slug = re.sub(r"[^\w.-]+", "_", f"{row['repository']} {row['path']}")
        self.b2b = b2b
        self.january = self.week("january")
        self.july: dict[str, Any] = {}
        self.authority: dict[str, Any] = {}
        if row["seasons"] == "2" and "error" not in self.january:
            self.july = self.week("july")
            self.authority = self.report("authority", ["doctor"], ["--authority"])

    def report(self, kind: str, command: list[str], last: list[str]) -> dict[str, Any]:
        """Returns the JSON that a command prints about the model, or its error."""
        kept = self.reports / f"{self.slug} {kind}.json"
        if not kept.exists():
            run = [self.b2b, *command, "--place", self.place, "--json", *last, str(self.path)]
            done = subprocess.run(run, capture_output=True, text=True, check=False)
            written = kept.with_suffix(".part")
            # Without the place of the checkouts on this machine.
            error = done.stderr.replace(f"{self.reports.parent}/", "")
            written.write_text(done.stdout or json.dumps({"error": error}))
            written.rename(kept)
        report: dict[str, Any] = json.loads(kept.read_text())
        return report

    def week(self, name: str) -> dict[str, Any]:
        """Returns the report on a week; far from the target, with the deviation under the model's own controls."""
        week = self.report(name, ["import"], ["--run", WEEKS[name]])
        if "error" in week or float(deviation(week["trial"])) < FAR:
            return week
        out = self.reports / f"{self.slug} {name}-own"
        own = ["--controller", "own", "--task", "constant", "--period", WEEKS[name], "--out", str(out)]
        run = self.report(f"{name}-own", ["run"], own)
        return week if "error" in run else {**week, "own": deviation(run)}

    def counts(self) -> list[int]:
        """Returns the number of zones driven by actuators, through setpoints, and by nothing."""
        zones, systems = self.january["zones"], self.january["systems"]
        through = {zone.lower() for each in systems if each["kind"] == "setpoints" for zone in each["zones"]}
        controlled = [zone["name"].lower() for zone in zones if zone["controlled"]]
        by_setpoints = sum(zone in through for zone in controlled)
        return [len(controlled) - by_setpoints, by_setpoints, len(zones) - len(controlled)]

    def row(self) -> list[str]:
        """Returns the cells of a January week."""
        name, report = f"{self.source}: {self.path.name}", self.january
        if "error" in report:
            return [name, *[""] * 7, reason(report["error"])]
        conversion, trial = report["notes"]["conversion"], report["trial"]
        version = conversion["from"] if conversion else ENGINE
        own = report.get("own", "")
        return [name, version, *map(str, self.counts()), deviation(trial), own, str(trial["severes"]), remark(report)]

    def row_of_seasons(self) -> list[str]:
        """Returns the cells of a model that is tried in both seasons."""
        weeks = [self.january, self.july]
        deviations = [cell for week in weeks for cell in (deviation(week["trial"]), week.get("own", ""))]
        verdicts = [each["verdict"] for each in self.authority["rows"]]
        at_capacity = sum(isinstance(each, dict) for each in verdicts)
        counts = [verdicts.count("follows"), at_capacity, verdicts.count("fails")]
        severes = sum(week["trial"]["severes"] for week in weeks)
        return [self.path.name, *deviations, str(severes), *map(str, counts)]

    def cells_of_prototype(self) -> list[str]:
        """Returns the zones that are driven, of all, and the deviations."""
        if "error" in self.january:
            return ["none", ""]
        trial = self.january["trial"]
        actuators, setpoints, neither = self.counts()
        driven = f"{actuators}+{setpoints}" if setpoints else str(actuators)
        return [
            f"{driven}/{actuators + setpoints + neither}",
            f"{deviation(trial)}, {trial['worst_zone_rms_k']:.2f}",
        ]


def reason(error: str) -> str:
    """Returns the line of an error that says what was wrong."""
    lines = [line.strip() for line in error.splitlines() if line.strip()]
    wrong = [line for line in lines if line.startswith(("fatal:", "severe:"))] or lines[-1:]
    return wrong[0].replace("|", "/")[:240]


def remark(report: dict[str, Any]) -> str:
    """Returns the zone that is far from its target, and the schedules that switch its equipment off."""
    trial = report["trial"]
    if trial["worst_zone_rms_k"] < FAR:
        return ""
    off = [each for each in report["notes"].get("switched_off", []) if trial["worst_zone"] in each["zones"]]
    schedules = [f"`{each['schedule']}` switches off {100 * each['share']:.0f} % of the year" for each in off]
    return "; ".join([f"{trial['worst_zone']} {trial['worst_zone_rms_k']:.1f} K", *schedules[:2]]).replace("|", "/")


def deviation(trial: dict[str, Any]) -> str:
    """Returns the RMS deviation, of zones without cooling if there are no others."""
    return f"{(trial['rms_deviation_k'] or trial['rms_heating_only_k']) + 0.0:.2f}"


def aligned(rows: list[list[str]]) -> str:
    """Returns rows in columns; the last column is as wide as it is."""
    widths = [max(len(cells[column]) for cells in rows) for column in range(len(rows[0]) - 1)]
    lines = [
        "  ".join([*(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)), last]).rstrip()
        for *cells, last in rows
    ]
    return "\n".join(lines) + "\n"


def edit(page: str, *edits: Callable[[str], str]) -> None:
    """Changes a page."""
    path = DOCS / page
    text = path.read_text()
    for each in edits:
        text = each(text)
    path.write_text(text)


def table(first: str, rows: list[list[str]]) -> Callable[[str], str]:
    """Replaces the rows of the table whose header begins with these words."""
    body = "".join(f"| {' | '.join(cells)} |\n" for cells in rows)
    return replaced(rf"(?<=\n)(\| {re.escape(first)}[^\n]*\n\|[-:|]+\n)(?:\|[^\n]*\n)*", lambda found: found[1] + body)


def replaced(pattern: str, by: Callable[[re.Match[str]], str]) -> Callable[[str], str]:
    """Replaces the one place of a page that matches."""

    def change(text: str) -> str:
        text, count = re.subn(pattern, by, text)
        if count != 1:
            message = f"the page has {count} places of {pattern!r}; one is needed"
            raise SystemExit(message)
        return text

    return change


def prototypes(models: list[Listed]) -> list[list[str]]:
    """Returns the rows of the models that ship with the engine, by type, those of 2019 beside those of 2004."""
    shipped = [model for model in models if model.source == "engine"]
    rows = []
    for words, name in PROTOTYPES.items():
        cells = [name]
        for prefix in ("ASHRAE901_", "RefBldg"):
            files = tuple(prefix + word for word in words.split())
            of_type = [model for model in shipped if model.path.name.startswith(files)]
            cells += of_type[0].cells_of_prototype() if of_type else ["", ""]
        rows.append(cells)
    return rows


def main(checkouts: Path, b2b: str) -> None:
    """Makes the reports that are missing, and writes the tables."""
    listed = list(csv.DictReader(Path(__file__).with_suffix(".csv").open()))
    (checkouts / "reports").mkdir(exist_ok=True)

    def report(row: dict[str, str]) -> Listed:
        model = Listed(row, checkouts, b2b)
        print(model.slug, file=sys.stderr, flush=True)
        return model

    with ThreadPoolExecutor(2) as pool:
        models = list(pool.map(report, listed))
    header = ["model", "version", "by actuators", "by setpoints", "neither", "RMS (K)", "own (K)", "severe", "note"]
    (DOCS / "public-models.txt").write_text(aligned([header, *(model.row() for model in models)]))
    public = [model for model in models if model.source != "engine"]
    usable = [model for model in public if "error" not in model.january]
    driven = [sum(counts) for counts in zip(*(model.counts() for model in usable), strict=True)]
    edit(
        "public-models.md",
        table("model | January", [model.row_of_seasons() for model in usable if model.authority]),
        replaced(r"\d+ of \d+ can be\s+used", lambda _: f"{len(usable)} of {len(public)} can be used"),
        replaced(
            r"\d+ are driven by actuators, \d+ through setpoints,\s+and \d+ \(",
            lambda _: (f"{driven[0]} are driven by actuators, {driven[1]} through setpoints, and {driven[2]} ("),
        ),
    )
    edit(
        "import.md",
        table("model | 2019", prototypes(models)),
        replaced(
            r"lists \d+ public files: \d+ can be used",
            lambda _: (f"lists {len(public)} public files: {len(usable)} can be used"),
        ),
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "b2b")
