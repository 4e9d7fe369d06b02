"""Evaluation and training on a Ray cluster of two local nodes. Needs the extra [learners]."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import building2building as b2b
import pytest

pytestmark = pytest.mark.learners

ray = pytest.importorskip("ray")
cluster_utils = pytest.importorskip("ray.cluster_utils")

HOUSES = ["SingleFamilyHouse-0018", "SingleFamilyHouse-0064", "Warehouse-0001", "Warehouse-0004"]
ARGUMENTS: dict[str, Any] = {"tasks": ["constant", "occupancy"], "run_periods": "01-01..01-05", "seeds": [0, 1]}
TRAINING: dict[str, Any] = {
    "buildings": HOUSES[0],
    "run_period": "01-01..01-02",
    "window_days": 1,
    "environments": 2,
}


@pytest.fixture
def cluster() -> Any:
    nodes = cluster_utils.Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    nodes.add_node(num_cpus=1)
    ray.init(address=nodes.address, logging_level="error", log_to_driver=False)
    yield nodes
    ray.shutdown()
    nodes.shutdown()


def test_a_cluster_gives_the_bytes_of_one_machine_also_when_a_node_is_lost(cluster: Any, tmp_path: Path) -> None:
    from building2building.ray import Resources, evaluate

    here = b2b.evaluate("random", HOUSES, folder=tmp_path / "here", **ARGUMENTS)
    [lost] = [node for node in cluster.list_all_nodes() if node is not cluster.head_node]

    def lose_a_node() -> None:
        while not list((tmp_path / "there" / "episodes").glob("*.json")):
            time.sleep(0.1)
        cluster.remove_node(lost, allow_graceful=False)

    losing = threading.Thread(target=lose_a_node)
    losing.start()
    resources = Resources(memory_mb=100)
    there = evaluate("random", HOUSES, folder=tmp_path / "there", chunk=2, resources=resources, **ARGUMENTS)
    losing.join()
    assert len(cluster.list_all_nodes()) == 1
    assert there.rows == here.rows
    table = [(tmp_path / name / "episodes.parquet").read_bytes() for name in ("here", "there")]
    assert table[0] == table[1]

    # Everything is there: nothing runs again, and another evaluation in this folder is an error.
    began = time.monotonic()
    assert evaluate("random", HOUSES, folder=tmp_path / "there", **ARGUMENTS).rows == here.rows
    assert time.monotonic() - began < 10
    with pytest.raises(b2b.errors.EvaluationError):
        evaluate("reactive", HOUSES, folder=tmp_path / "there", **ARGUMENTS)


def test_agents_are_trained_as_on_one_machine(cluster: Any, tmp_path: Path) -> None:
    from building2building.ray import Resources, train

    runs = {f"seed-{seed}": {**TRAINING, "steps": 1000, "seed": seed} for seed in range(2)}
    agents = train(runs, folder=tmp_path / "runs", resources=Resources(memory_mb=100))
    here = b2b.train(**runs["seed-1"], out=tmp_path / "here")
    weights = [Path(agent.path, "weights.safetensors").read_bytes() for agent in (agents["seed-1"], here)]
    assert weights[0] == weights[1]
    assert train(runs, folder=tmp_path / "runs").keys() == agents.keys()


def test_a_policy_is_sent_to_the_nodes_as_files(tmp_path: Path) -> None:
    from building2building import ray as cluster

    onnx, agent = tmp_path / "Policy.ONNX", tmp_path / "agent"
    onnx.write_bytes(b"model")
    agent.mkdir()
    for name in ("agent.json", "weights.safetensors", "checkpoint"):
        (agent / name).write_text(name)
    sent = [cluster._policy_files(policy) for policy in (onnx, agent)]
    assert sent[0] == {"Policy.ONNX": b"model"}
    assert list(sent[1]) == ["agent/agent.json", "agent/weights.safetensors"]
    assert cluster._is_path(str(onnx)) and cluster._is_path(str(agent)) and not cluster._is_path("reactive")

    class Request:
        policy: Any = str(agent)

        def run_part(self, folder: Path, numbers: list[int], baselines: Path) -> dict[int, str]:
            place = Path(self.policy)
            assert place != agent and place.name == "agent"
            assert (place / "weights.safetensors").read_text() == "weights.safetensors"
            return {7: "seen"}

    request: Any = Request()
    assert cluster._evaluate_part([7], request, sent[1]) == ({"episodes": {}, "baselines": {}}, {7: "seen"})
    assert request.policy == str(agent)


def test_only_the_classes_asked_for_are_tuned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from building2building import ray as cluster

    asked: list[dict[str, Any]] = []

    def carry_out_all(_: str, orders: list[dict[str, Any]], *__: Any) -> list[dict[str, bytes]]:
        asked.extend(orders)
        texts = [(json.dumps([each["classes"]], indent=2) + "\n").encode() for each in orders]
        return [{"tuned.json": text, "energy_scale.json": text} for text in texts]

    monkeypatch.setattr(cluster, "_carry_out_all", carry_out_all)
    classes = [("Warehouse", 5), ("OfficeSmall", 7), ("OfficeSmall", 1)]
    cluster.tune([*classes, classes[0]], folder=tmp_path, evaluations=50)
    order = {name: number for number, name in enumerate(b2b.list_building_types())}
    ordered = sorted(classes, key=lambda each: (order[each[0]], each[1]))
    expected = [{"types": [name], "zones": [zone]} for name, zone in ordered]
    assert [each["evaluations"] for each in asked] == [50] * 3
    for name in ("tuned.json", "energy_scale.json"):
        text = (tmp_path / name).read_text()
        assert json.loads(text) == expected and text == json.dumps(expected, indent=2) + "\n"


def test_a_folder_with_the_name_of_an_experiment_is_not_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from building2building import ray as cluster

    ran: list[str] = []
    monkeypatch.setattr(
        cluster, "_carry_out_all", lambda _, orders, *__: ran.extend(each["experiment"] for each in orders)
    )
    monkeypatch.setattr(cluster._core, "carry_out", lambda _, order: ran.append(json.loads(order)["experiment"]))
    monkeypatch.chdir(tmp_path)
    Path("ppo").mkdir()
    cluster.experiment("ppo", folder="ppo", shards=1)
    cluster.experiment("own.toml", folder="own", shards=1)
    assert ran == ["ppo", "ppo", str(tmp_path / "own.toml"), str(tmp_path / "own.toml")]


def test_an_experiment_in_shards_gives_the_results_of_one_machine(cluster: Any, tmp_path: Path) -> None:
    from building2building.ray import Resources, experiment, tune

    file = tmp_path / "small.toml"
    file.write_text(
        """
        title = "Small"
        question = "Does it run?"
        paper = "not in it"
        report = "adaptation"
        types = ["SingleFamilyHouse"]
        tasks = ["occupancy"]
        periods = ["01-10..01-10"]
        reactive = true
        quick = { steps = 288, seeds = 1, buildings = 2 }
        full = { steps = 288, seeds = 1, buildings = 2 }
        """
    )
    arguments = [
        sys.executable,
        "-m",
        "building2building",
        "experiment",
        "run",
        str(file),
        "--out",
        str(tmp_path / "here"),
    ]
    subprocess.run(arguments, check=True, capture_output=True)
    resources = Resources(memory_mb=100)
    page = experiment(str(file), folder=tmp_path / "there", shards=2, budget="quick", resources=resources)
    assert page.is_file()
    results = [(tmp_path / name / "results.json").read_bytes() for name in ("here", "there")]
    assert results[0] == results[1]

    options = {"evaluations": 1, "buildings": 1, "validation": 1, "periods": ["01-01..01-01"]}
    tune([("SingleFamilyHouse", None)], folder=tmp_path / "tuning", resources=resources, **options)
    assert (tmp_path / "tuning" / "tuned.json").is_file()


def test_ray_tune_tries_options_and_a_trial_resumes_from_its_checkpoint(cluster: Any, tmp_path: Path) -> None:
    from building2building.ray import trainable
    from ray import tune

    house = {**TRAINING, "steps": 2400, "evaluation": {"every": 1000, "days": 1}, "ppo": {"gamma": 0.98}}
    interrupted, resumed = tmp_path / "interrupted", tmp_path / "resumed"

    def train_with_an_interruption(config: dict[str, Any]) -> None:
        """Loses the first trial after its first report."""
        original = tune.report

        def report(metrics: dict[str, Any], **arguments: Any) -> None:
            original(metrics, **arguments)
            if not interrupted.exists():
                interrupted.write_text(str(metrics["steps"]))
                raise RuntimeError("the node is lost")
            if not resumed.exists():
                resumed.write_text(str(metrics["steps"]))

        tune.report = report
        try:
            trainable(**house)(config)
        finally:
            tune.report = original

    results = tune.Tuner(
        train_with_an_interruption,
        param_space={"ppo": {"learning_rate": tune.grid_search([1e-4, 1e-3])}},
        tune_config=tune.TuneConfig(metric="score", mode="min", max_concurrent_trials=1),
        run_config=tune.RunConfig(
            storage_path=str(tmp_path / "study"), failure_config=tune.FailureConfig(max_failures=1), verbose=0
        ),
    ).fit()
    assert not results.errors and len(results) == 2
    # The second attempt continues after the first attempt's checkpoint.
    assert float(resumed.read_text()) > float(interrupted.read_text())
    for result in results:
        agent = b2b.Agent.load(result.checkpoint.path)
        assert agent.info["training"]["steps"] >= 2400 and agent.summary is not None
        assert result.metrics["resolved_score"] == agent.summary["resolved_score"]
        ppo = {"gamma": 0.98, "learning_rate": result.config["ppo"]["learning_rate"]}
        here = b2b.train(**{**house, "ppo": ppo}, out=tmp_path / f"here-{ppo['learning_rate']}", jobs=1)
        weights = [Path(each.path, "weights.safetensors").read_bytes() for each in (agent, here)]
        assert weights[0] == weights[1]
