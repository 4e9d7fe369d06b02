"""The code of the documentation runs, its figures match the script, and file formats are as described."""

import base64
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import building2building as b2b
import pytest
from texts import replaced

ROOT = Path(__file__).parents[3]
DOCS = ROOT / "docs"

#: Replacements that shorten the programs of pages, so that a page takes seconds.
SHORTER = {
    "tutorials/train_and_compare": {
        "steps=60_000, environments=4": "steps=1_200, environments=2",
        '"every": 15_000': '"every": 1_200',
        'run_periods=["02-06..02-07", "03-06..03-07"]': 'run_periods=["02-06..02-06"]',
    },
    "tutorials/transfer": {
        "steps=6_000": "steps=1_200",
        '"every": 6_000': '"every": 1_200',
        "n=4)": "n=1)",
    },
    "tutorials/planning": {"for _ in range(8):": "for _ in range(2):"},
}


#: A block of Python, without the tags of a cell.
BLOCK = re.compile(r"```(?:python|\{code-cell\}[^\n]*(?:\n:tags:[^\n]*)?)\n(.*?)```", re.S)


def blocks(page: Path) -> str:
    """Returns the Python of a page."""
    code = "\n".join(BLOCK.findall(page.read_text()))
    return replaced(code, SHORTER.get(str(page.relative_to(DOCS).with_suffix("")), {}))


def run(code: str, folder: Path) -> str:
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    command = [sys.executable, "-c", code]
    ran = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=900)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def test_examples_write_to_new_folders_and_read_results_that_a_clone_has():
    files = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")

    def is_tracked(path: str) -> bool:
        return any(file == path or file.startswith(path.rstrip("/") + "/") for file in files)

    written = read = 0
    for page in [ROOT / "README.md", *DOCS.rglob("*.md"), *(ROOT / "crates/cli/src").rglob("*.rs")]:
        # Maintainers regenerate the data below crates.
        for path in re.findall(r'(?:--out |folder=")(?!crates/)([\w./-]+)', page.read_text()):
            assert not is_tracked(path), f"{page.name}: an example writes to {path}, which a clone has"
            written += 1
        for path in re.findall(r"(?<![\w/.-])results/[a-z-]+", page.read_text()):
            assert is_tracked(path), f"{page.name}: a clone has no {path}"
            read += 1
    assert written > 50 and read > 5


PAGES = {
    "concepts/step": "temperature",
    "concepts/score": "energy ratio",
    "tutorials/own_reward": "best: ",
    "tutorials/own_building": "Kitchen",
    "tutorials/train_and_compare": "energy ratio",
    "tutorials/transfer": "interquartile mean: ",
    "tutorials/planning": "planned",
    "tutorials/demand_response": "shift",
    "logging": "1152",
}


def test_every_page_with_a_program_is_tested():
    tested = {f"{name}.md" for name in PAGES} | {"first_agent.md"}
    written = {
        str(page.relative_to(DOCS)) for folder in ("concepts", "tutorials") for page in (DOCS / folder).glob("*.md")
    }
    assert {page for page in written if blocks(DOCS / page)} <= tested


def page(name: str):
    """Returns the parameter of a page; most tutorials train or plan, too slowly for every change."""
    return pytest.param(name, marks=() if name.startswith("concepts/") else pytest.mark.nightly)


@pytest.mark.parametrize("name", [page(name) for name in PAGES])
def test_the_code_of_a_page_runs(name, tmp_path):
    page = DOCS / f"{name}.md"
    code = blocks(page)
    assert code
    printed = run(code, tmp_path)
    assert PAGES[name] in printed
    if name.startswith("tutorials/") and name not in SHORTER:
        assert "".join(re.findall(r"```text\n(.*?)```", page.read_text(), re.S)) == printed


def test_blocks_of_python_are_python():
    pages = [ROOT / "README.md", *DOCS.rglob("*.md")]
    for page in pages:
        for block in BLOCK.findall(page.read_text()):
            compile(block, str(page), "exec")


def test_the_figures_come_from_the_script():
    code = "import draw, json; print(json.dumps({name: each().svg() for name, each in draw.FIGURES.items()}))"
    drawn = json.loads(run(code, DOCS / "figures"))
    assert drawn == {path.stem: path.read_text() for path in (DOCS / "figures").glob("*.svg")}


def keys(kind: str) -> set[str]:
    """Returns the names that the page of file formats lists after a marker."""
    _, rest = (DOCS / "formats.md").read_text().split(f"<!-- keys: {kind} -->")
    if rest.startswith("\n"):
        table = rest.strip().split("\n\n")[0].splitlines()[2:]
        return {name for row in table for name in re.findall(r"`(\w+)`", row.split("|")[1])}
    return set(re.findall(r"`(\w+)`", rest.split("<!-- end -->")[0]))


def test_the_files_of_a_run_are_as_described(tmp_path):
    command = [sys.executable, "-m", "building2building", "run", "SingleFamilyHouse", "--period", "01-09..01-09"]
    subprocess.run([*command, "--out", tmp_path / "run"], check=True, capture_output=True)
    table = (DOCS / "tasks.md").read_text().split("| metric | unit |")[1].split("\n\n")[0]
    metrics = set(re.findall(r"^\| `(\w+)`", table, re.M))
    assert set(json.loads((tmp_path / "run/summary.json").read_text())) == keys("summary") | metrics | {"currency"}
    text = (DOCS / "formats.md").read_text()
    footer = (tmp_path / "run/trajectory.parquet").read_bytes()
    # Arrow's schema, with the metadata, is in base64. The last byte of the length before it may look like base64, too.
    schema = re.search(rb"[A-Za-z0-9+/]{1000,}=*", footer)
    assert schema
    footer += base64.b64decode(schema[0][len(schema[0]) % 4 :])
    columns = [
        "step",
        "month",
        "minute",
        "outdoor air temperature",
        "Living supply air flow",
        "energy penalty",
        "reward",
    ]
    for name in [*columns, "metadata_sha256", "trajectory_hash", "task_definition", "observations"]:
        assert f"`{name}`" in text and name.encode() in footer, name


def test_the_files_of_an_evaluation_and_an_agent_are_as_described(tmp_path):
    house = "SingleFamilyHouse-0042"
    b2b.evaluate("constant", [house], run_periods="01-09..01-09", folder=tmp_path / "evaluation")
    written = {path.name for path in (tmp_path / "evaluation").iterdir()}
    files = {"episodes", "episodes.parquet", "evaluation.json", "report.html", "summary.json", "SHA256SUMS"}
    assert written == files
    assert set(json.loads((tmp_path / "evaluation/summary.json").read_text())) == keys("evaluation")
    options = {"run_period": "01-09..01-15", "window_days": 1, "environments": 1, "steps": 288}
    agent = b2b.train(house, evaluation={"days": 1}, out=tmp_path / "run", **options)
    assert set(json.loads((tmp_path / "run/agent.json").read_text())) == keys("agent")
    # The file's own SHA-256 is not part of the agent.
    assert set(agent.info) == keys("agent") - {"sha256"}


def test_every_claim_of_the_paper_has_its_place_and_its_numbers():
    rows = re.findall(r"^\| (\d+) (.*?) \| (.*?) \| (.*?) \|$", (DOCS / "paper.md").read_text(), re.M)
    assert [int(number) for number, *_ in rows] == list(range(1, 91))
    for number, _, here, where in rows:
        assert re.match("holds|differs", here), number
        pages = [DOCS / link.split("#")[0] for link in re.findall(r"\]\((.*?)\)", where)]
        files = [ROOT / name for name in re.findall(r"`(crates/.*?)`", where)]
        assert all(path.exists() for path in pages + files), number
        assert pages or files or "`" in where, number
    here = {number: here for number, _, here, _ in rows}
    counts = {"nine": 9, "ten": 10, "eleven": 11, "twelve": 12}
    assert counts[re.search(r"(\w+) types", here["37"]).group(1)] == len(b2b.NodeType)
    listed = subprocess.run(
        [sys.executable, "-m", "building2building", "list", "--sizes", "--task", "constant"],
        capture_output=True,
        text=True,
        check=True,
    )
    sizes = {line.split()[0]: re.findall(r" (\d+)", line)[:3] for line in listed.stdout.splitlines()[1:]}
    types = ("RestaurantFastFood", "Warehouse", "RetailStandalone", "OfficeSmall", "OfficeMedium")
    for (_, claim, _, _), building_type in zip(rows[11:16], types, strict=True):
        zones, action, observation = re.findall(r"\d+", claim)[:3]
        assert sizes[building_type] == [zones, observation, action], claim
