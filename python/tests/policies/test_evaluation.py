"""Evaluation of policies in Python: equality with the command, resuming, errors."""

import json
import signal
import subprocess
import sys
import time

import building2building as b2b
import numpy as np
import pytest
from building2building import errors

HOUSES = ["SingleFamilyHouse-0014", "SingleFamilyHouse-0042"]
DAYS = "01-10..01-11"


def table(folder) -> bytes:
    return (folder / "episodes.parquet").read_bytes()


class Integral:
    """An integral controller: a policy with state."""

    def __init__(self, context):
        self.low, self.high = context.layout.action_low, context.layout.action_high
        self.temperatures = context.layout.temperatures
        self.heat = 0.5

    def reset(self):
        self.heat = 0.5

    def __call__(self, observation):
        error = 21 - observation[self.temperatures].mean()
        self.heat = float(np.clip(self.heat + 0.05 * error, 0, 1))
        return self.low + self.heat * (self.high - self.low)


def test_the_reactive_controller_in_python_gives_the_bytes_of_the_command(b2b_command, tmp_path):
    """Here, every observation and action passes through Python."""
    command = [
        b2b_command,
        "evaluate",
        *HOUSES,
        "--policy",
        "reactive",
        "--task",
        "constant",
        "--period",
        DAYS,
        "--json",
    ]
    ran = subprocess.run([*command, "--out", tmp_path / "rust"], capture_output=True, text=True, check=True)
    folder = tmp_path / "python"
    ours = b2b.evaluate(b2b.ReactiveController, HOUSES, "constant", run_periods=DAYS, name="reactive", folder=folder)
    assert table(folder) == table(tmp_path / "rust")
    assert ours.summary == json.loads(ran.stdout)
    assert ours.column("score").tolist() == [1, 1] and ours.rows[0]["building"] == HOUSES[0]
    assert (folder / "report.html").stat().st_size > 1000


def test_evaluating_a_function_equals_its_rollout():
    env = b2b.make_env(building_id=HOUSES[0], run_period="01-10..01-10", task="occupancy", rescale_action=True)
    weights = np.random.default_rng(0).normal(0, 0.02, (env.action_space.shape[0], env.observation_space.shape[0]))

    def linear(observation):
        assert observation.dtype == np.float32
        return np.tanh(weights @ observation)

    ran = b2b.rollout(env, linear)
    env.close()
    ours = b2b.evaluate(linear, HOUSES[0], "occupancy", run_periods="01-10..01-10", rescale_action=True)
    assert ours.rows[0]["trajectory_hash"] == ran.hash() and ours.rows[0]["policy"] == "linear"
    assert ours.rows[0]["return"] == pytest.approx(ran.episode_return)
    assert ours.rows[0]["score"] > 1 and ours.folder is None


@pytest.mark.nightly
def test_an_interrupted_evaluation_resumes_and_gives_the_same_bytes(tmp_path):
    whole = b2b.evaluate(Integral, HOUSES, ["constant", "occupancy"], run_periods=DAYS, folder=tmp_path / "whole")
    assert len(whole) == 4 and not any(row["lost"] for row in whole.rows)

    class Failing(Integral):
        left = 700

        def __call__(self, observation):
            Failing.left -= 1
            if Failing.left < 0:
                raise KeyError("a mistake")
            return super().__call__(observation)

    def again():
        return b2b.evaluate(
            Failing,
            HOUSES,
            ["constant", "occupancy"],
            run_periods=DAYS,
            folder=tmp_path / "parts",
            name="Integral",
            # `left` differs from call to call.
            version="1",
            jobs=1,
        )

    with pytest.raises(KeyError, match="a mistake"):
        again()
    assert not (tmp_path / "parts/episodes.parquet").exists()
    Failing.left = 2 * 576 + 576
    assert again().reused == 1
    assert Failing.left == 0, "one of four episodes was kept"
    assert table(tmp_path / "parts") == table(tmp_path / "whole")
    with pytest.raises(errors.EvaluationError, match="identity"):
        b2b.evaluate(
            Integral, HOUSES, ["constant", "occupancy"], run_periods=DAYS, folder=tmp_path / "parts", version="2"
        )


def midpoint(share: float, sign: float = 1.0):
    def policy(observation):
        return np.full(2, sign * share)

    return policy


def test_an_edited_policy_is_not_answered_with_the_results_of_the_old_one(tmp_path, capsys):
    def evaluate(policy, **options):
        return b2b.evaluate(
            policy, HOUSES[0], run_periods="01-10..01-10", rescale_action=True, folder=tmp_path, **options
        )

    first = evaluate(midpoint(0.1))
    assert first.reused == 0 and capsys.readouterr().err == ""
    again = evaluate(midpoint(0.1))
    assert again.reused == 1 and again.rows == first.rows
    assert capsys.readouterr().err == f"{tmp_path}: 1 of 1 episodes had finished before and are reused\n"
    with pytest.raises(errors.EvaluationError, match="policy_identity.*code and values"):
        evaluate(midpoint(0.2))
    with pytest.raises(errors.EvaluationError, match="policy_identity"):
        evaluate(midpoint(0.1), version="2")


def test_an_evaluation_in_which_nothing_finished_does_not_block_the_next(tmp_path):
    def wrong(observation):
        raise KeyError("a mistake")

    with pytest.raises(KeyError, match="a mistake"):
        b2b.evaluate(wrong, HOUSES, run_periods="01-10..01-10", folder=tmp_path)
    evaluated = b2b.evaluate(midpoint(0.1), HOUSES[0], run_periods="01-10..01-10", rescale_action=True, folder=tmp_path)
    assert len(evaluated) == 1 and evaluated.reused == 0


def test_the_other_name_of_the_run_period_is_answered_with_the_right_one():
    with pytest.raises(TypeError, match=r"evaluate\(\) has no argument `run_period`; did you mean `run_periods`"):
        b2b.evaluate("reactive", HOUSES[0], run_period=DAYS)
    with pytest.raises(TypeError, match=r"make_env\(\) has no argument `run_periods`; did you mean `run_period`"):
        b2b.make_env("OfficeSmall", run_periods=DAYS)
    with pytest.raises(TypeError, match="`run_period` and `task`"):
        b2b.train(HOUSES[0], out="nowhere", run_periods=DAYS)


def test_ctrl_c_stops_an_evaluation_and_keeps_finished_episodes(tmp_path):
    # Shells make background processes ignore the signal.
    code = f"""
import signal
import building2building as b2b
signal.signal(signal.SIGINT, signal.default_int_handler)
calls = 0
def middle(observation):
    global calls
    calls += 1
    if calls == 1:
        print("ready", flush=True)
    return [0.0, 0.0]
try:
    b2b.evaluate(middle, {HOUSES!r}, run_periods="winter", rescale_action=True, folder={str(tmp_path / "out")!r})
except KeyboardInterrupt:
    print("stopped", flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert (out, err, process.returncode) == ("stopped\n", "", 0)
    assert {each.name for each in (tmp_path / "out").iterdir()} == {"evaluation.json", "episodes"}


def endless_network() -> bytes:
    """Returns a policy in the format of ONNX: a product of thousands of large matrices."""

    def number(value: int) -> bytes:
        low, rest = value & 127, value >> 7
        return bytes([low | 128]) + number(rest) if rest else bytes([low])

    def integer(field: int, value: int) -> bytes:
        return number(field << 3) + number(value)

    def part(field: int, content: bytes | str) -> bytes:
        content = content.encode() if isinstance(content, str) else content
        return number(field << 3 | 2) + number(len(content)) + content

    def node(kind: str, output: str, *inputs: str) -> bytes:
        return part(1, b"".join(part(1, each) for each in inputs) + part(2, output) + part(4, kind))

    sizes = integer(1, 2) + integer(2, 7) + part(8, "sizes") + part(9, (4096).to_bytes(8, "little") * 2)
    nodes = [node("ReduceSum", "sum", "observation"), node("Expand", "0", "sum", "sizes")]
    nodes += [node("MatMul", str(place + 1), str(place), "0") for place in range(2000)]
    ends = [
        part(11, part(1, "observation") + part(2, part(1, integer(1, 1)))),
        part(12, part(1, "2000") + part(2, part(1, integer(1, 1)))),
    ]
    graph = b"".join([*nodes, part(2, "endless"), part(5, sizes), *ends])
    return integer(1, 8) + part(7, graph) + part(8, part(1, "") + integer(2, 17))


@pytest.mark.nightly
def test_a_network_that_never_ends_is_an_error_and_ctrl_c_does_not_wait_for_it(tmp_path):
    (tmp_path / "p.onnx").write_bytes(endless_network())
    code = f"""
import signal
import building2building as b2b
signal.signal(signal.SIGINT, signal.default_int_handler)
print("ready", flush=True)
try:
    b2b.evaluate("p.onnx", {HOUSES[0]!r}, run_periods="01-10..01-10", folder="out")
except KeyboardInterrupt:
    print("stopped", flush=True)
"""
    command = [sys.executable, "-c", code]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": tmp_path}
    ran = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert ran.returncode == 1 and "EvaluationError: p.onnx" in ran.stderr and "within 5 s" in ran.stderr
    for sent, printed, code in [(signal.SIGINT, "stopped\n", 0), (signal.SIGTERM, "", -signal.SIGTERM)]:
        process = subprocess.Popen(command, **pipes)
        assert process.stdout.readline() == "ready\n"
        time.sleep(2)
        process.send_signal(sent)
        out, err = process.communicate(timeout=10)
        assert (out, err, process.returncode) == (printed, "", code)


def test_a_return_is_scored_by_the_shipped_and_the_computed_baseline():
    env = b2b.make_env(building_id=HOUSES[0], task="occupancy+energy0.5", run_period="01-10..01-10")
    episode_return = b2b.rollout(env, b2b.ReactiveController(env)).episode_return
    asked = HOUSES[0], "occupancy+energy0.5", "01-10..01-10"
    assert b2b.compute_normalized_score(episode_return, *asked) == pytest.approx(1.0, abs=1e-12)
    assert b2b.compute_normalized_score(2 * episode_return, *asked) == pytest.approx(2.0, abs=1e-12)
    assert b2b.compute_normalized_score(-1.0, "SingleFamilyHouse-0018") < 1.0, "the baseline of a winter is shipped"
    with pytest.raises(b2b.Error, match="occupied"):
        b2b.compute_normalized_score(-1.0, HOUSES[0], "occupied")
    with pytest.raises(errors.SettingError, match="cost at comfort"):
        b2b.compute_normalized_score(-1.0, HOUSES[0], "operate")


def test_an_evaluation_is_represented_by_a_line():
    result = b2b.evaluate("constant", HOUSES[0], "constant", run_periods="01-10..01-10")
    assert repr(result) == f"<Evaluation of constant: 1 episodes, mean score {result.rows[0]['score']:.3f}>"


def test_invalid_policies_and_buildings_raise():
    day = {"run_periods": "01-10..01-10"}
    with pytest.raises(errors.EvaluationError, match="onnx"):
        b2b.evaluate("reactiv", HOUSES[0], **day)
    with pytest.raises(errors.SettingError, match="not a policy"):
        b2b.evaluate(3, HOUSES[0], **day)
    with pytest.raises(errors.SettingError, match="name="):
        b2b.evaluate(lambda observation: None, HOUSES[0], **day)
    with pytest.raises(errors.ActionError, match="expected 2"):
        b2b.evaluate(lambda observation: [0.0] * 7, HOUSES[0], name="seven", **day)
    with pytest.raises(errors.SettingError, match="to_epjson"):
        b2b.evaluate("reactive", b2b.generate("SingleFamilyHouse")[0], **day)
    with pytest.raises(errors.SettingError, match="list of episodes is empty"):
        b2b.evaluate("reactive", [], **day)
    for options, words in [
        ({"normalize": True, "version": "2"}, "normalize and version: .* reactive is not one"),
        ({"rescale_action": True}, "rescale_action: .* omit it"),
    ]:
        with pytest.raises(errors.SettingError, match=words):
            b2b.evaluate("reactive", HOUSES[0], **day, **options)
    with pytest.raises(errors.SettingError, match="ReactiveController .* physical units"):
        b2b.evaluate(b2b.ReactiveController, HOUSES[0], **day, rescale_action=True)
