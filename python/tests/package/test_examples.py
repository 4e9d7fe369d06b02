"""The examples run, and the README's snippet prints what the README shows."""

import re
import subprocess
import sys
from pathlib import Path

import building2building as b2b
import pytest
from texts import replaced

ROOT = Path(__file__).parents[3]
EXAMPLES = ROOT / "python/examples"


def run(*arguments) -> str:
    ran = subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@pytest.mark.parametrize(
    "name, words",
    [
        ("first_steps", "reactive"),
        pytest.param("transfer", "OfficeMedium", marks=pytest.mark.nightly),
        ("own_building", "actuators:"),
    ],
)
def test_an_example_runs(name, words):
    assert words in run(EXAMPLES / f"{name}.py")


def test_a_client_in_the_sequence_of_boptest_runs(tmp_path):
    script = Path(sys.executable).with_name("b2b")
    command = [script, "serve", "OfficeSmall", "--port", "0"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as server:
        try:
            url = re.search(r"http://[\d.:]+", server.stdout.readline()).group()
            printed = run(EXAMPLES / "boptest_client.py", url, 6)
        finally:
            server.terminate()
    assert "time of the last result: 21600.0 s" in printed and "stop: OK" in printed
    values = dict(line.split(": ") for line in printed.splitlines() if line.count(": ") == 1)
    assert float(values["ener_tot"]) > 0 and values["idis_tot"] == "None"
    assert server.returncode == 0 and list(tmp_path.iterdir()) == []


@pytest.mark.nightly
def test_the_notebook_runs_and_plots():
    """In its own kernel, with an event loop around the cells, as in Jupyter."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(EXAMPLES / "a_cold_day.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2


@pytest.mark.nightly
def test_a_policy_with_memory_is_scored_by_week(tmp_path):
    printed = run(EXAMPLES / "memory.py", tmp_path / "entry", "SingleFamilyHouse-0018")
    assert re.findall(r"after (\d+) days in the building: score \d", printed) == [str(7 * week) for week in range(8)]


@pytest.mark.nightly
def test_planning_on_snapshots_is_no_worse_than_not_planning():
    alone, planned = re.findall(r"-\d+\.\d+", run(EXAMPLES / "plan.py"))
    assert float(planned) > float(alone)


def test_the_readme_shows_what_it_prints():
    text = (ROOT / "README.md").read_text()
    code, shown = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", text, re.S).groups()
    assert run("-c", code) == shown


@pytest.mark.nightly
def test_the_first_agent_of_the_documentation_is_trained_and_evaluated(tmp_path, monkeypatch):
    """With few steps."""
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/first_agent.md").read_text(), re.S)
    shorter = {"steps=60_000, environments=4": "steps=1_200, environments=2"}
    printed = run("-c", replaced("\n".join(blocks), shorter))
    for words in ["Core_ZN air temperature", "ReactiveController", "SingleFamilyHouse-0018 {'score'"]:
        assert words in printed
    assert (tmp_path / "runs/first/agent.json").is_file()


@pytest.mark.parametrize(
    "name, arguments, words",
    [
        ("log_wandb", [1_200], "logged"),
        ("log_mlflow", [1_200], "logged"),
        ("study_optuna", [2, 1_200], "best resolved score"),
    ],
)
def test_a_training_is_logged_and_studied(name, arguments, words, tmp_path):
    """With packages that are not among the extras."""
    pytest.importorskip(name.split("_")[1])
    assert words in run(EXAMPLES / f"{name}.py", tmp_path, *arguments)


@pytest.mark.nightly
def test_the_configuration_of_the_documentation_is_the_example_and_trains(tmp_path):
    tomllib = pytest.importorskip("tomllib")
    text = (EXAMPLES / "train.toml").read_text()
    assert text in (ROOT / "docs/logging.md").read_text()
    options = tomllib.loads(text) | {"steps": 288, "environments": 1, "window_days": 1}
    options |= {"run_period": "01-09..01-12", "evaluation": {"days": 1, "buildings": 1}}
    agent = b2b.train(out=tmp_path / "run", **options)
    assert agent.info["task"] and agent.summary["task"] == "occupancy+energy0.5"


SHORT = ["--steps", 1, "--envs", 2, "--n-steps", 336, "--period", "01-01..01-14"]
SUPERVISED = [
    "--building",
    "OfficeSmall-0042",
    "--decisions",
    576,
    "--every",
    576,
    "--evaluated",
    "01-10..01-10",
    "--test",
]


@pytest.mark.learners
@pytest.mark.parametrize(
    "name, arguments, words",
    [
        ("train_ppo", SHORT, "after training: return"),
        ("torchrl_masked", ["--steps", 1, "--envs", 2, "--rollout", 64, "--tests", 1], "mean reward -"),
        ("supervise_sb3", SUPERVISED, "01-01..01-31: cost "),
        ("cleanrl_ppo", SUPERVISED, "01-01..01-31: cost "),
        ("rllib_ppo", SUPERVISED, "01-01..01-31: cost "),
        ("torchrl_ppo", SUPERVISED, "01-01..01-31: cost "),
    ],
)
def test_an_example_learns(name, arguments, words):
    printed = run(EXAMPLES / f"{name}.py", *arguments)
    assert words in printed
    assert "--every" not in arguments or re.search(r"\d+ decisions: cost .*, weight ", printed)


@pytest.mark.learners
def test_amago_stays_in_a_house_for_days(tmp_path):
    """With a package that is not in the registry."""
    pytest.importorskip("amago")
    printed = run(EXAMPLES / "amago_rl2.py", tmp_path, "--epochs", 1, "--batches", 1, "--days", 2, "--envs", 2)
    assert "Average Return : -" in printed and "384 steps in" in printed


@pytest.mark.learners
def test_a_transformer_learns_from_a_corpus_and_is_entered_with_its_memory(b2b_command, tmp_path):
    one = replaced((EXAMPLES / "houses.toml").read_text(), {"buildings = 52": "buildings = 1"})
    (tmp_path / "one.toml").write_text(one)
    command = [b2b_command, "collect", "--corpus", "one.toml", "b2b/one-v0", "--out", "."]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    short = ["--updates", 8, "--batch", 2, "--test", "SingleFamilyHouse-0018", "--windows", "01-01..01-07"]
    printed = run(EXAMPLES / "decision_pretrained.py", tmp_path / "b2b/one-v0", tmp_path / "entries", *short)
    assert re.findall(r"(\w+): median resolved scores: operate\+preview \d", printed) == ["cloned", "transformer"]


@pytest.mark.learners
def test_both_implementations_of_ppo_are_compared(tmp_path):
    arguments = ["--steps", 1, "--seeds", 1, "--period", "01-01..01-14"]
    printed = run(EXAMPLES / "native_and_sb3.py", tmp_path, *arguments)
    assert len(re.findall(r"interquartile mean \d+, 95 % interval", printed)) == 2
    assert (tmp_path / "curves.svg").is_file()
