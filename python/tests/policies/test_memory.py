"""Policies that keep their memory over the episodes in a building."""

import json
import subprocess
from pathlib import Path

import building2building as b2b
import numpy as np
import pytest
from building2building.benchmarks import Problem
from building2building.wrappers import PreviousStepObservation, PreviousStepVectorObservation

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


class Remembering(b2b.ConstantController):
    """Notes how its episodes begin."""

    begun: list[str] = []

    def reset(self):
        self.begun.append("reset")
        super().reset()

    def next_episode(self):
        self.begun.append("next")
        super().next_episode()


class RememberingAgent(b2b.Agent):
    def controller(self, env):
        return Remembering(env)


@pytest.mark.parametrize("memory", ["building", "episode"])
def test_an_agent_keeps_its_memory_in_an_evaluation_where_the_problem_says_so(memory):
    Remembering.begun.clear()
    problem = Problem("adapt-house", memory=memory, **{**SMALL, "test": HOUSES[:1]})
    result = problem.evaluate(RememberingAgent(Path("agent"), {}))
    assert len(result.episodes) == 4 and all(each["score"] > 0 for each in result.episodes)
    second = "next" if memory == "building" else "reset"
    assert Remembering.begun == ["reset", second] * 2


class Climber:
    """Tries actions around the one with the best reward so far, and notes its steps when an episode begins."""

    firsts: list[int] = []

    def __init__(self):
        self.best, self.action, self.steps = -np.inf, np.zeros(2), 0

    def next_episode(self):
        pass

    def __call__(self, observation):
        assert observation.shape == (94,)
        action, reward, is_first = observation[-4:-2], observation[-2], observation[-1]
        if is_first:
            self.firsts.append(self.steps)
            assert not action.any() and reward == 0
        else:
            np.testing.assert_allclose(action, self.last, atol=1e-6)
            if reward > self.best:
                self.best, self.action = reward, action
        self.steps += 1
        self.last = np.clip(self.action + 0.2 * np.sin([self.steps, 2 * self.steps]), -1, 1)
        return self.last


@pytest.mark.nightly
def test_an_object_observes_the_previous_step(tmp_path, b2b_command):
    problem = Problem("adapt-house", **SMALL)
    policy = Climber()
    problem.run(policy, tmp_path / "entry", rescale_action=True, version="1", jobs=1)
    assert Climber.firsts == [0, 288] * 4 and policy.steps == 0, "a copy for every building and task"
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


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_a_training_batch_shows_the_previous_step_of_every_environment(mode):
    day = {"task": "constant", "run_period": "01-10..01-10", "timesteps_per_hour": 1}
    envs = PreviousStepVectorObservation(b2b.make_vec("SingleFamilyHouse", 2, autoreset_mode=mode, **day))
    low, high = envs.single_action_space.low, envs.single_action_space.high
    observations, _ = envs.reset(seed=0)
    assert observations.shape == envs.observation_space.shape and observations[0] in envs.single_observation_space
    assert envs.metadata["observation_names"][-2:] == ["previous reward", "first step"]
    first = [[0, 0, 0, 1]] * 2
    assert observations[:, -4:].tolist() == first
    shares = np.array([0.25, 1.0])
    actions = low + shares[:, None] * (high - low)
    for step in range(1, 28):
        observations, rewards, _, truncated, infos = envs.step(actions)
        last = np.column_stack([*[2 * shares - 1] * 2, rewards, [0, 0]])
        assert truncated.tolist() == [step == 24] * 2
        if step == 24 and mode == "SameStep":
            np.testing.assert_allclose([row[-4:] for row in infos["final_obs"]], last, atol=1e-6)
        begins = {"NextStep": 25, "SameStep": 24}.get(mode)
        np.testing.assert_allclose(observations[:, -4:], first if step == begins else last, atol=1e-6)
        if step == 24 and mode == "Disabled":
            observations, _ = envs.reset(options={"reset_mask": truncated})
            assert observations[:, -4:].tolist() == first
    envs.close()
