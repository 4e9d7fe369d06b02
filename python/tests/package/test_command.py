"""The installed command ``b2b``, which runs the extension module."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import building2building as b2b
import pytest

SCRIPT = Path(sys.executable).with_name("b2b")


def command(*arguments, folder=None, interpreter=()):
    return subprocess.run([*interpreter, SCRIPT, *arguments], cwd=folder, capture_output=True, text=True)


def test_the_command_has_the_version_of_the_package():
    assert command("--version").stdout == f"b2b {b2b.__version__}\n"
    module = subprocess.run([sys.executable, "-m", "building2building", "--version"], capture_output=True, text=True)
    assert module.stdout == f"b2b {b2b.__version__}\n"


def test_the_command_does_not_load_numpy():
    imported = command("list", interpreter=[sys.executable, "-X", "importtime"])
    assert imported.returncode == 0
    assert "numpy" not in imported.stderr and "gymnasium" not in imported.stderr


def test_wrong_usage_exits_with_2_and_a_failure_with_1(tmp_path):
    wrong = command("run", "OfficeSmall", "--no-such-option")
    assert wrong.returncode == 2 and "--no-such-option" in wrong.stderr
    failed = command("run", "OfficeSmall", "--period", "01-01..01-01", "--task", "nothing", folder=tmp_path)
    assert failed.returncode in (1, 2) and "nothing" in failed.stderr
    assert list(tmp_path.iterdir()) == []


def test_an_invalid_argument_of_the_measurements_is_a_message(monkeypatch, capsys):
    from building2building import bench

    monkeypatch.setattr(bench, "importing", lambda: 0.0)
    for arguments, words in [
        (["OfficeSmall", "--days", "40"], "--days is 40; expected 1 to 31"),
        (["--resample", "dynamics-house", "--days", "400"], "expected 1 to 365"),
        (["OficeSmall", "--days", "1"], "OfficeSmall"),
    ]:
        monkeypatch.setattr(sys, "argv", ["bench", *arguments])
        with pytest.raises(SystemExit) as ended:
            bench.main()
        assert ended.value.code == 2 and words in capsys.readouterr().err


def test_a_run_of_the_command_is_the_rollout_of_the_package(tmp_path):
    ran = command("run", "OfficeSmall", "--period", "01-01..01-01", "--out", "run", "--json", folder=tmp_path)
    assert ran.returncode == 0, ran.stderr
    with b2b.make_env("OfficeSmall", run_period="01-01..01-01") as env:
        trajectory = b2b.rollout(env, b2b.Guideline36Controller(env))
    summary = json.loads(ran.stdout)
    assert (summary["task"], summary["controller"]) == ("operate", "guideline36")
    assert summary["trajectory_hash"] == trajectory.hash()
    assert (tmp_path / "run" / "trajectory.parquet").stat().st_size > 0


@pytest.mark.nightly
def test_the_command_starts_its_own_workers_and_children(tmp_path):
    arguments = ["--policy", "random", "--period", "01-01..01-01", "--jobs", "1", "--out", "results", "--json"]
    evaluated = command("evaluate", "OfficeSmall", *arguments, folder=tmp_path)
    assert evaluated.returncode == 0, evaluated.stderr
    checked = command("check", "OfficeSmall-0042", folder=tmp_path)
    assert checked.returncode == 0, checked.stderr


def test_an_interrupt_ends_the_command_with_130(tmp_path):
    process = subprocess.Popen([SCRIPT, "run", "OfficeSmall"], cwd=tmp_path, stderr=subprocess.PIPE)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(timeout=3)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 130
    assert list(tmp_path.iterdir()) == []


def test_no_code_of_the_current_folder_runs(tmp_path):
    ran = tmp_path / "ran"
    (tmp_path / "pip").mkdir()
    for module in ("pip.py", "pip/__init__.py", "pip/__main__.py", "token.py", "random.py", "sitecustomize.py"):
        (tmp_path / module).write_text(f"open({str(ran)!r}, 'a').close()\n")
    # EnergyPlus is needed, and a client is started for it.
    program = """
import building2building as b2b
try:
    b2b.make_env("OfficeSmall")
except b2b.errors.Error:
    pass
print("done")
"""
    environment = {**os.environ, "B2B_CACHE": str(tmp_path / "cache"), "PIP_NO_INDEX": "1"}
    command = [sys.executable, "-I", "-c", program]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.stdout == "done\n", done.stderr
    assert not ran.exists()
