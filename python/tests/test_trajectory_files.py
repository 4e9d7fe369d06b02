"""Files of a rollout: the same as `b2b run` writes, and damaged ones."""

import copy
import json
import pickle
import subprocess
import sys
import zipfile

import building2building as b2b
import numpy as np
import pytest
from building2building import errors

DAY = "01-09..01-09"
TIMES = {"cpu_s", "environment_cpu_s", "steps_per_s", "files", "summary_sha256"}


def command(*arguments) -> str:
    ran = subprocess.run(
        [sys.executable, "-m", "building2building", *map(str, arguments)], capture_output=True, text=True, timeout=300
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def test_a_written_rollout_equals_the_command_s_run(tmp_path, make):
    ours, theirs, other = tmp_path / "python", tmp_path / "command", tmp_path / "mine"
    command("run", "OfficeSmall", "--period", DAY, "--task", "occupancy", "--out", theirs)
    env = make("OfficeSmall", run_period=DAY, task="occupancy")
    files = b2b.rollout(env, b2b.ReactiveController(env)).write(ours)
    assert [path.name for path in files] == ["trajectory.parquet", "summary.json", "picture.html"]
    assert (ours / "trajectory.parquet").read_bytes() == (theirs / "trajectory.parquet").read_bytes()
    written, printed = (json.loads((folder / "summary.json").read_text()) for folder in (ours, theirs))
    assert written.keys() == printed.keys()
    assert {name: written[name] for name in written.keys() - TIMES} == {
        name: printed[name] for name in printed.keys() - TIMES
    }
    assert written["steps_per_s"] > 0 and written["engine_warnings"] > 0
    assert b"Core_ZN" in (ours / "picture.html").read_bytes()

    def mine(observation):
        return env.action_space.low

    trajectory = b2b.rollout(env, mine)
    trajectory.write(other)
    compared = json.loads(command("compare", theirs, other, "--json", "--out", tmp_path / "compare.html"))
    assert [run["name"] for run in compared["runs"]] == ["reactive", "mine"]
    score = json.loads(command("score", other / "trajectory.parquet", "--json"))
    assert score["return"] == pytest.approx(trajectory.episode_return) and score["controller"] == "mine"
    ours = b2b.compute_normalized_score(trajectory.episode_return, "OfficeSmall", "occupancy", DAY)
    assert score["score"] == pytest.approx(ours)


def test_a_written_window_is_scored_as_an_episode_of_its_days(tmp_path, make):
    env = make("OfficeSmall", run_period="winter", window_days=1, window_starts=5, timesteps_per_hour=1)
    trajectory = b2b.rollout(env, b2b.ConstantController(env), seed=3)
    trajectory.write(tmp_path / "run", controller="middle", seed=5)
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    first, last = summary["period"].split("..")
    assert (summary["controller"], summary["seed"], summary["steps"]) == ("middle", 5, 24) and first == last
    assert json.loads(command("score", tmp_path / "run/trajectory.parquet", "--json"))["period"] == summary["period"]


def test_a_partial_episode_is_written_with_its_steps(tmp_path, make):
    env = make(timesteps_per_hour=1)
    files = b2b.rollout(env, b2b.ReactiveController(env), steps=5).write(tmp_path / "part")
    assert [path.name for path in files] == ["trajectory.parquet"]
    pyarrow = pytest.importorskip("pyarrow.parquet")
    table = pyarrow.read_table(files[0])
    assert table["hour"].to_pylist() == [1, 2, 3, 4, 5] and table["day"].to_pylist() == [1] * 5


def test_an_environment_in_this_process_is_written_too(tmp_path, make):
    env = make(in_process=True, timesteps_per_hour=1)
    files = b2b.rollout(env, b2b.ReactiveController(env)).write(tmp_path)
    assert json.loads(files[1].read_text())["steps"] == 24


def test_a_copy_of_a_trajectory_cannot_be_written(tmp_path, make):
    env = make(timesteps_per_hour=1)
    trajectory = b2b.rollout(env, b2b.ReactiveController(env))
    trajectory.save(tmp_path / "x.npz")
    for other in (
        b2b.Trajectory.load(tmp_path / "x.npz"),
        pickle.loads(pickle.dumps(trajectory)),
        copy.deepcopy(trajectory),
    ):
        assert other.hash() == trajectory.hash() and other.controller == "reactive"
        with pytest.raises(errors.SettingError, match="loaded or copied"):
            other.write(tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_the_representation_of_a_trajectory_is_a_line(make):
    env = make(timesteps_per_hour=1)
    text = repr(b2b.rollout(env, b2b.ReactiveController(env)))
    assert text.startswith("<Trajectory of OfficeSmall: 24 steps, return -") and len(text) < 80
    assert "before the end" in repr(b2b.rollout(env, b2b.ReactiveController(env), steps=2))


@pytest.fixture(scope="module")
def saved(tmp_path_factory, office):
    path = tmp_path_factory.mktemp("saved") / "x.npz"
    b2b.rollout(office, b2b.ReactiveController(office), steps=3).save(path)
    return path


def rewritten(saved, path, **changes):
    """A saved trajectory with other members."""
    with np.load(saved) as file:
        members = {name: file[name] for name in file.files}
    np.savez(path, **{**members, **changes})


@pytest.mark.parametrize("kind", ["missing", "folder", "empty", "text", "npy", "zip", "cut", "shape", "names", "bits"])
def test_a_file_that_is_not_a_trajectory_raises_this_package_s_error(kind, saved, tmp_path):
    path = tmp_path / "x.npz"
    match kind:
        case "folder":
            path.mkdir()
        case "empty":
            path.touch()
        case "text":
            path.write_text("not a trajectory")
        case "npy":
            with open(path, "wb") as file:
                np.save(file, np.zeros(3))
        case "zip":
            with zipfile.ZipFile(path, "w") as file:
                file.writestr("observations.npy", b"x")
        case "cut":
            path.write_bytes(saved.read_bytes()[:-50])
        case "shape":
            rewritten(saved, path, rewards=np.zeros(7))
        case "names":
            rewritten(saved, path, described=np.array('{"truncated": true, "metadata": {}}'))
        case "bits":
            data = bytearray(saved.read_bytes())
            data[200:260] = bytes(60)
            path.write_bytes(data)
    with pytest.raises(b2b.Error, match="x.npz") as raised:
        b2b.Trajectory.load(path)
    assert isinstance(raised.value, errors.SettingError)
