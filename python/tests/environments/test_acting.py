"""Environments as agents of ``b2b train`` see them."""

import os
import pickle
import signal

import building2building as b2b
import gymnasium
import numpy as np
import pytest
from building2building.errors import SettingError
from building2building.evaluation.identity import identity_of
from building2building.learning.acting import acting_controller
from building2building.wrappers import PreviousStepVectorObservation

DAY = {"task": "operate", "run_period": "01-10..01-10"}


def test_a_supervisor_decides_every_hour_and_zeros_are_guideline36():
    env = b2b.make_env("OfficeSmall-0042", acting="supervisory:60", **DAY)
    observation, _ = env.reset(seed=0)
    assert observation.shape == env.observation_space.shape and observation.dtype == np.float32
    assert len(env.metadata["observation_names"]) == observation.size
    assert "heating setpoint shift" in env.metadata["action_names"]
    assert env.metadata["action_units"] == ["1"] * env.action_space.shape[0]
    assert env.metadata["observation_units"] == ["1"] * observation.size
    total, hours, truncated = 0.0, 0, False
    while not truncated:
        observation, reward, terminated, truncated, _ = env.step(np.zeros(env.action_space.shape))
        total, hours = total + reward, hours + 1
        assert not terminated and env.observation_space.contains(observation)
    assert hours == 24
    assert env.metadata["morphology"].nodes and env.metadata["zones"]
    copied = pickle.loads(pickle.dumps(env))
    assert copied.reset(seed=0)[0].tolist() == env.reset(seed=0)[0].tolist()
    with pytest.raises(SettingError, match=r"12 steps of the building.*acting_controller"):
        b2b.rollout(env, lambda _: np.zeros(env.action_space.shape))
    plain = b2b.make_env("OfficeSmall-0042", **DAY)
    plain.reset(seed=0)
    guideline = b2b.rollout(plain, b2b.Guideline36Controller(plain))
    assert total == pytest.approx(guideline.episode_return, rel=1e-9)
    colder = np.zeros(env.action_space.shape)
    colder[env.metadata["action_names"].index("heating setpoint shift")] = -1.0
    env.reset(seed=0)
    assert sum(env.step(colder)[1] for _ in range(24)) != pytest.approx(total, rel=1e-4)


def test_a_policy_for_an_acting_is_evaluated_as_it_acts():
    env = b2b.make_env("OfficeSmall-0042", acting="supervisory:60", **DAY)
    action = np.linspace(-0.5, 0.5, env.action_space.shape[0])
    env.reset(seed=0)
    total = sum(env.step(action * (hour > 6))[1] for hour in range(24))
    hours = []

    def policy(observation):
        assert observation.shape == env.observation_space.shape
        hours.append(len(hours))
        return action * (hours[-1] % 24 > 6)

    controller = acting_controller(policy, "supervisory:60")
    plain = b2b.make_env("OfficeSmall-0042", rescale_action=True, **DAY)
    trajectory = b2b.rollout(plain, controller(plain))
    (row,) = b2b.evaluate(controller, "OfficeSmall-0042", "operate", run_periods=DAY["run_period"]).rows
    assert len(hours) == 48 and row["policy"] == "policy"
    assert row["return"] == pytest.approx(total, rel=1e-12) == trajectory.episode_return


def test_the_results_of_a_policy_for_an_acting_are_not_another_one_s():
    def policy_of(scale):
        def policy(seen):
            return np.full(3, scale)

        return acting_controller(policy, "supervisory:60")

    identities = [identity_of(policy_of(scale), "") for scale in (0.0, 0.0, 0.5)]
    assert identities[0] == identities[1] != identities[2]


def test_a_batch_has_the_rewards_of_single_environments():
    envs = b2b.make_vec("OfficeSmall-0042", 2, acting="supervisory:30", **DAY)
    observations, _ = envs.reset(seed=0)
    assert observations.shape == envs.observation_space.shape
    assert envs.autoreset_mode == envs.metadata["autoreset_mode"] and len(envs.layout_of(1).action) > 0
    actions = np.stack([np.zeros(envs.single_action_space.shape), np.full(envs.single_action_space.shape, 0.5)])
    totals = np.zeros(2)
    for half_hour in range(48):
        observations, rewards, _, truncated, infos = envs.step(actions)
        totals += rewards
        assert truncated.all() == (half_hour == 47)
    assert infos["final_obs"][0].shape == envs.single_observation_space.shape
    single = b2b.make_env("OfficeSmall-0042", acting="supervisory:30", **DAY)
    for index, action in enumerate(actions):
        single.reset(seed=0)
        total = sum(single.step(action)[1] for _ in range(48))
        assert totals[index] == pytest.approx(total, rel=1e-3)
    envs.close()


@pytest.mark.parametrize("lost_at", [2, 6])
def test_an_environment_that_is_lost_is_truncated_and_begins_again_with_a_decision(lost_at):
    envs = b2b.make_vec("SingleFamilyHouse-0042", 2, acting="supervisory:30", **DAY)
    first, _ = envs.reset(seed=0)
    batch, step, steps = envs.env, envs.env.step, []

    def losing(actions):
        steps.append(actions)
        if len(steps) == lost_at:
            os.kill(batch._core.processes()[1], signal.SIGKILL)
        return step(actions)

    batch.step = losing
    actions = np.zeros(envs.action_space.shape)
    observations, rewards, _, truncated, infos = envs.step(actions)
    assert truncated.tolist() == infos["_lost"].tolist() == infos["_final_obs"].tolist() == [False, True]
    assert infos["lost"][1] and infos["final_obs"][1].shape == first[1].shape and "final_info" in infos
    np.testing.assert_array_equal(observations[1], first[1])
    assert (observations[0] != first[0]).any() and rewards[1] > rewards[0]
    ends = [envs.step(actions)[3].tolist() for _ in range(48)]
    assert ends == [[False, False]] * 46 + [[True, False], [False, True]]
    envs.close()


def test_drawn_buildings_are_supervised():
    envs = b2b.make_vec("OfficeSmall", 1, acting="supervisory:60", resample=True, **DAY)
    observations, info = envs.reset(seed=0)
    assert envs.observation_space.contains(observations) and envs.layout_of(0).spaces.name == info["building"][0]
    envs.step(np.zeros(envs.action_space.shape))
    envs.close()


def test_a_supervisor_follows_a_change_of_the_building():
    env = b2b.make_env("OfficeSmall", acting="supervisory:60", **DAY)
    env.unwrapped.set_building("OfficeSmall-0042")
    own = b2b.make_env("OfficeSmall-0042", acting="supervisory:60", **DAY)
    np.testing.assert_array_equal(env.reset()[0], own.reset()[0])
    for _ in range(8):
        steps = [each.step(np.zeros(each.action_space.shape)) for each in (env, own)]
        np.testing.assert_array_equal(steps[0][0], steps[1][0])
    assert steps[0][1] == steps[1][1] < 0


def test_supervision_is_for_tasks_of_operation():
    arguments = {**DAY, "task": "occupancy", "acting": "supervisory:60"}
    for make in (b2b.make_env, lambda name, **others: b2b.make_vec(name, 2, **others)):
        with pytest.raises(b2b.errors.SettingError, match="the task is occupancy; choose `operate`"):
            make("OfficeSmall-0042", **arguments)


def test_an_id_takes_an_acting_as_make_env_does():
    arguments = {"building_id": "OfficeSmall-0042", "acting": "supervisory:60", **DAY}
    env = gymnasium.make("b2b/OfficeSmall-v1", **arguments)
    made = b2b.make_env("OfficeSmall-0042", acting="supervisory:60", **DAY)
    again = gymnasium.make(env.spec)
    rewards = []
    for each in (env, made, again):
        observation, _ = each.reset(seed=0)
        assert observation.shape == made.observation_space.shape and each.metadata == made.metadata
        rewards.append(each.step(np.full(each.action_space.shape, 0.5))[1])
        each.close()
    assert rewards[0] == rewards[1] == rewards[2]
    envs = gymnasium.make_vec("b2b/OfficeSmall-v1", 1, **arguments)
    assert envs.single_action_space == made.action_space
    envs.close()


def test_an_acting_that_is_not_possible_is_an_error():
    for arguments, said in [
        ({"acting": "supervisory:20"}, "15, 30 or 60"),
        ({"acting": "superviser"}, "unknown acting"),
        ({"acting": "supervisory", "rescale_action": True}, "rescale_action"),
        ({"observation": "features"}, "needs acting="),
    ]:
        with pytest.raises(SettingError, match=said):
            b2b.make_env("OfficeSmall-0042", **DAY, **arguments)
        with pytest.raises(SettingError, match=said):
            gymnasium.make("b2b/OfficeSmall-v1", building_id="OfficeSmall-0042", **DAY, **arguments)


def test_the_previous_decision_may_be_observed():
    envs = PreviousStepVectorObservation(b2b.make_vec("SingleFamilyHouse-0042", 2, acting="supervisory:60", **DAY))
    observations, _ = envs.reset(seed=0)
    assert observations.shape == envs.observation_space.shape and observations[:, -1].all()
    actions = np.full(envs.action_space.shape, 0.5, np.float32)
    observations, rewards, *_ = envs.step(actions)
    last = np.column_stack([actions, rewards, [0, 0]])
    np.testing.assert_allclose(observations[:, -last.shape[1] :], last, rtol=1e-6)
    envs.close()
