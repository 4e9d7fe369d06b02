"""Policies that keep their memory over the episodes in a building."""

import json
import runpy
import subprocess
from pathlib import Path

import building2building as b2b
import numpy as np
import pytest
from building2building.benchmarks import Problem
from building2building.wrappers import PreviousStepObservation

HOUSES = ["SingleFamilyHouse-0018", "SingleFamilyHouse-0387"]
DAYS = ["01-10..01-10", "01-11..01-11"]
SMALL = {"test": HOUSES, "test_tasks": ["occupancy", "random"], "windows": DAYS}

#: Steps by episode and rewards of every controller, by building and seed.
seen: dict[tuple[str, int], list[tuple[list[int], list[float]]]] = {}


class Counting:
    """Counts its steps, and acts by their number."""

    def __init__(self, context):
        self.steps, self.rewards = [0], []
        seen.setdefault((context.building.name, context.seed), []).append((self.steps, self.rewards))
        self.low, self.high = context.layout.action_low, context.layout.action_high

    def next_episode(self):
        self.steps.append(0)

    def reward(self, value):
        self.rewards.append(value)

    def __call__(self, observation):
        self.steps[-1] += 1
        return self.low + (sum(self.steps) % 7) / 7 * (self.high - self.low)


def test_a_class_keeps_its_memory_in_a_building_and_nowhere_else(tmp_path):
    seen.clear()
    problem = Problem("adapt-house", seeds=[0, 1], **SMALL)
    result = problem.run(Counting, tmp_path / "entry", by_seed=True, jobs=2)
    assert set(seen) == {(building, seed) for building in HOUSES for seed in (0, 1)}
    for controllers in seen.values():
        assert len(controllers) == 2, "one for each task"
        for steps, rewards in controllers:
            assert steps == [288, 288] and len(rewards) == 576 and max(rewards) <= 0
    points = result["measures"]["by_episode"]["points"]
    assert [point["days_before"] for point in points] == [0, 1]
    seen.clear()
    Problem("adapt-house", memory="episode", seeds=[0, 1], **SMALL).run(Counting, tmp_path / "reset", by_seed=True)
    assert all(steps == [288] for group in seen.values() for steps, _ in group)
    with pytest.raises(b2b.errors.SettingError, match="next_episode.*call Problem.run"):
        problem.evaluate(Counting, n=1)


def test_an_object_observes_the_previous_step(tmp_path, b2b_command):
    """The one of the example."""
    names = runpy.run_path(str(Path(__file__).parents[3] / "python/examples/memory.py"))
    firsts = []

    class Climber(names["Climber"]):
        def __call__(self, observation):
            assert observation.shape == (94,)
            if observation[-1]:
                firsts.append(self.steps)
                assert not observation[-4:-1].any()
            else:
                np.testing.assert_allclose(observation[-4:-2], self.last, atol=1e-6)
            self.last = super().__call__(observation)
            return self.last

    problem = Problem("adapt-house", **SMALL)
    policy = Climber()
    problem.run(policy, tmp_path / "entry", rescale_action=True, version="1", jobs=1)
    assert firsts == [0, 288] * 4 and policy.steps == 0, "a copy for every building and task"
    verified = subprocess.run(
        [b2b_command, "benchmark", "verify", tmp_path / "entry", "--json"], capture_output=True, text=True
    )
    checks = {each["check"]: each for each in json.loads(verified.stdout)["checks"]}
    again = checks.pop("episodes run again")
    assert all(each["passed"] for each in checks.values()), verified.stdout
    assert again["unverified"]


def test_a_training_environment_shows_the_previous_step():
    (made,) = Problem("adapt-house", train_tasks="random", **SMALL).make_train_envs(1, run_period="01-10..01-10")
    env = PreviousStepObservation(made)
    observation, _ = env.reset()
    assert observation.shape == env.observation_space.shape == (94,) and observation in env.observation_space
    assert observation[-4:].tolist() == [0, 0, 0, 1]
    low, high = env.action_space.low, env.action_space.high
    for share in (0.25, 1.0):
        observation, reward, *_ = env.step(low + share * (high - low))
        np.testing.assert_allclose(observation[-4:], [2 * share - 1] * 2 + [reward, 0], atol=1e-6)
        assert observation in env.observation_space
    assert env.metadata["observation_names"][-2:] == ["previous reward", "first step"]
    assert env.reset()[0][-4:].tolist() == [0, 0, 0, 1]
    env.close()
