"""Examples run, and the README's snippet prints what the README shows."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "python/examples"


def run(*arguments) -> str:
    ran = subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@pytest.mark.parametrize(
    "name, words",
    [
        ("first_steps", "reactive"),
        ("transfer", "OfficeMedium"),
        ("own_building", "driven:"),
    ],
)
def test_an_example_runs(name, words):
    assert words in run(EXAMPLES / f"{name}.py")


def test_the_notebook_runs():
    cells = json.loads((EXAMPLES / "a_cold_day.ipynb").read_text())["cells"]
    code = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    run("-c", "import matplotlib\nmatplotlib.use('agg')\n" + code)


def test_planning_on_snapshots_is_no_worse_than_not_planning():
    alone, planned = re.findall(r"-\d+\.\d+", run(EXAMPLES / "plan.py"))
    assert float(planned) > float(alone)


def test_the_readme_shows_what_it_prints():
    text = (ROOT / "README.md").read_text()
    code, shown = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", text, re.S).groups()

    def but_for_decimals(text):
        # Which move with the tuning of controllers.
        return re.sub(r"\d+\.\d+", "#", text)

    assert but_for_decimals(run("-c", code)) == but_for_decimals(shown)


@pytest.mark.learners
@pytest.mark.parametrize("name, steps, words", [("train_ppo", 1024, "a second"), ("cleanrl_ppo", 1024, "mean reward")])
def test_an_example_learns(name, steps, words):
    assert words in run(EXAMPLES / f"{name}.py", steps)
