"""Training for a few hundred steps; run with --learners."""

import warnings

import building2building as b2b
import numpy as np
import pytest

pytestmark = pytest.mark.learners


@pytest.fixture(autouse=True)
def one_thread():
    """Small networks are slower with several threads, and the engine needs the other processors."""
    import torch

    torch.set_num_threads(1)


DAYS = {"run_period": "01-01..01-01", "timesteps_per_hour": 4, "task": "constant"}


@pytest.mark.parametrize("algorithm", ["PPO", "SAC"])
def test_sb3_learns_on_vector_environments(algorithm):
    import stable_baselines3
    from building2building.sb3 import make_sb3_vec

    envs = make_sb3_vec("SingleFamilyHouse", 2, **DAYS)
    options = {"n_steps": 64, "batch_size": 64} if algorithm == "PPO" else {"learning_starts": 300}
    model = getattr(stable_baselines3, algorithm)("MlpPolicy", envs, seed=0, device="cpu", **options)
    before = [each.clone() for each in model.policy.parameters()]
    model.learn(400)
    assert any((one != other).any() for one, other in zip(before, model.policy.parameters()))
    assert len(model.ep_info_buffer) >= 4 and all(np.isfinite(info["r"]) for info in model.ep_info_buffer)
    envs.close()


@pytest.mark.parametrize("algorithm", ["PPO", "SAC"])
def test_sb3_learns_on_a_single_environment(algorithm):
    import stable_baselines3

    env = b2b.wrap_env_for_rl(b2b.make_env("SingleFamilyHouse", **DAYS))
    options = {"n_steps": 64, "batch_size": 64} if algorithm == "PPO" else {"learning_starts": 200}
    getattr(stable_baselines3, algorithm)("MlpPolicy", env, seed=0, device="cpu", **options).learn(300)
    env.close()


def test_the_speed_of_training_is_measured_over_whole_rollouts():
    from building2building.bench import training

    measured = training("SingleFamilyHouse-0001", 2, 1)
    assert measured["steps"] == 2 * 672
    assert measured["steps_per_s"] > 0 and measured["steps_per_cpu_s"] > 0


def test_sb3_sees_the_last_observation_of_an_episode():
    from building2building.sb3 import make_sb3_vec

    envs = make_sb3_vec("SingleFamilyHouse", 2, normalize=False, run_period="01-01..01-01", timesteps_per_hour=1)
    env = b2b.make_env("SingleFamilyHouse", run_period="01-01..01-01", timesteps_per_hour=1, rescale_action=True)
    envs.reset()
    first, _ = env.reset()
    for step in range(24):
        action = np.full(env.action_space.shape, step / 24)
        observations, _, dones, infos = envs.step(np.stack([action] * 2))
        last, *_ = env.step(action)
    assert dones.all() and infos[0]["TimeLimit.truncated"]
    np.testing.assert_array_equal(infos[1]["terminal_observation"], last)
    np.testing.assert_array_equal(observations[1], first)
    env.close()
    envs.close()


def test_a_setting_that_would_have_no_effect_is_an_error():
    import stable_baselines3
    from building2building.sb3 import make_sb3_vec

    for normalize in (True, False):
        with pytest.raises(b2b.Error, match="own scales"):
            make_sb3_vec("OfficeSmall-0042", 1, acting="supervisory:60", normalize=normalize)
    envs = b2b.make_vec("OfficeSmall-0042", 1, acting="supervisory:60", run_period="01-01..01-01")
    with pytest.raises(b2b.Error, match="no effect: task"):
        make_sb3_vec(envs, task="constant")
    with pytest.raises(b2b.Error, match="no effect: num_envs"):
        make_sb3_vec(envs, 2)
    made = make_sb3_vec(envs)
    assert made.scale is None and made.action_space.low.tolist() == [-1] * made.action_space.shape[0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        learner = stable_baselines3.PPO("MlpPolicy", made, n_steps=24, batch_size=24, seed=0, device="cpu").learn(48)
    assert [each["l"] for each in learner.ep_info_buffer] == [24, 24]
    made.close()


def test_sb3_reads_attributes_and_accepts_the_episodes_as_monitored():
    import gymnasium
    from building2building.sb3 import make_sb3_vec
    from stable_baselines3 import PPO
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.monitor import Monitor

    envs = make_sb3_vec("SingleFamilyHouse", 2, **DAYS)
    assert envs.get_attr("action_space") == [envs.action_space] * 2
    assert [layout.controlled_zones for layout in envs.get_attr("layout", [1])] == [["Living"]]
    with pytest.raises(AttributeError, match="no_such"):
        envs.get_attr("no_such")
    with pytest.raises(AttributeError, match="reward_range"):
        envs.set_attr("reward_range", (0, 1))
    assert envs.env_is_wrapped(Monitor) == [True, True]
    assert envs.env_is_wrapped(gymnasium.wrappers.TimeLimit, 0) == [False]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        evaluate_policy(PPO("MlpPolicy", envs, n_steps=8, batch_size=16, device="cpu"), envs, n_eval_episodes=2)
    envs.close()


def test_a_minari_dataset_recovers_its_environment(tmp_path, monkeypatch):
    import minari

    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    rewards = []

    class Listening(b2b.ReactiveController):
        def reward(self, reward):
            rewards.append(reward)

    b2b.collect(Listening, ["SingleFamilyHouse"], "b2b/house-v0", episodes=2, **DAYS)
    dataset = minari.load_dataset("b2b/house-v0")
    assert dataset.total_episodes == 2 and dataset.total_steps == 2 * 96
    np.testing.assert_allclose(np.concatenate([episode.rewards for episode in dataset]), rewards, rtol=1e-6)
    env = dataset.recover_environment()
    observation, _ = env.reset()
    np.testing.assert_allclose(observation, dataset[0].observations[0])
    for action, expected in zip(dataset[0].actions[:20], dataset[0].observations[1:]):
        np.testing.assert_allclose(env.step(action)[0], expected, rtol=1e-5)
    env.close()


def test_minari_reads_a_dataset_of_the_command_line(b2b_command, tmp_path, monkeypatch):
    import subprocess

    import minari

    pytest.importorskip("PIL")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    arguments = "collect b2b/small-v0 OfficeSmall-0042 --task occupancy --period 01-10..01-10"
    subprocess.run([b2b_command, *arguments.split()], check=True)
    dataset = minari.load_dataset("b2b/small-v0")
    assert (dataset.total_episodes, dataset.total_steps) == (1, 288)
    assert dataset[0].truncations[-1] and not dataset[0].truncations[:-1].any()
    env = dataset.recover_environment()
    observation, _ = env.reset()
    np.testing.assert_array_equal(observation, dataset[0].observations[0])
    for action, expected in zip(dataset[0].actions[:50], dataset[0].observations[1:]):
        # The actions of the dataset are rounded to f32.
        np.testing.assert_allclose(env.step(action)[0], expected, rtol=1e-6)
    env.close()


def test_a_trajectory_is_written_as_parquet(office, tmp_path):
    import pyarrow.parquet

    trajectory = b2b.rollout(office, b2b.ReactiveController(office), steps=10)
    trajectory.to_parquet(tmp_path / "t.parquet")
    table = pyarrow.parquet.read_table(tmp_path / "t.parquet")
    assert table.num_rows == 10 and "outdoor air temperature" in table.column_names
    assert [each.name for each in tmp_path.iterdir()] == ["t.parquet"]


@pytest.mark.parametrize("algorithm", ["PPO", "SAC"])
def test_a_policy_is_exported_and_evaluated_without_python(algorithm, b2b_command, tmp_path):
    """In Rust, the network adds in another order, so the returns agree up to the rounding of f32."""
    import json
    import subprocess

    import stable_baselines3
    from building2building.sb3 import export_onnx, make_sb3_vec
    from building2building.wrappers import NormalizeObservation

    building, period = "SingleFamilyHouse-0042", "01-10..01-10"
    envs = make_sb3_vec(None, 2, building_id=building, run_period=period)
    options = {"n_steps": 64, "batch_size": 64} if algorithm == "PPO" else {"learning_starts": 100}
    model = getattr(stable_baselines3, algorithm)("MlpPolicy", envs, seed=0, device="cpu", **options)
    model.learn(256)
    export_onnx(model, tmp_path / "policy.onnx")
    env = NormalizeObservation(b2b.make_env(building_id=building, run_period=period, rescale_action=True))
    rolled = b2b.rollout(env, lambda observation: model.predict(observation, deterministic=True)[0])
    env.close()
    envs.close()

    command = [b2b_command, "evaluate", building, "--policy", tmp_path / "policy.onnx", "--period", period, "--json"]
    ran = subprocess.run([*command, "--out", tmp_path / "rust"], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout)["episodes"] == 1
    (row,) = b2b.evaluate(tmp_path / "policy.onnx", building, run_periods=period, folder=tmp_path / "rust").rows
    assert row["return"] == pytest.approx(rolled.episode_return, rel=1e-4)
    assert row["clamped_actions"] == 0


def test_a_policy_trained_on_many_buildings_is_exported_with_its_normalization(tmp_path):
    import stable_baselines3
    from building2building.benchmarks import DynamicsAdaptation
    from building2building.sb3 import export_onnx, make_sb3_vec

    problem = DynamicsAdaptation("house", windows=["01-10..01-10"])
    envs = make_sb3_vec(problem.make_train_vec(2, autoreset_mode="SameStep"))
    model = stable_baselines3.PPO("MlpPolicy", envs, seed=0, device="cpu", n_steps=320, batch_size=64)
    model.learn(640)
    assert len({*envs.envs.reset()[1]["building"], *envs.envs.reset()[1]["building"]}) > 1
    export_onnx(model, tmp_path / "policy.onnx")
    raw, _ = envs.envs.reset(seed=1)
    expected, _ = model.predict(envs.scale(raw), deterministic=True)
    from onnx.reference import ReferenceEvaluator

    session = ReferenceEvaluator(str(tmp_path / "policy.onnx"))
    actions = np.concatenate([session.run(None, {"observation": each[None]})[0] for each in raw])
    np.testing.assert_allclose(actions, expected, atol=1e-5)
    envs.close()
