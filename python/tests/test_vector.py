"""The contract of a Gymnasium vector environment."""

import warnings

import building2building as b2b
import gymnasium
import numpy as np
import pytest
from building2building import errors
from gymnasium.vector import AutoresetMode, SyncVectorEnv

DAY = {"run_period": "01-01..01-01", "timesteps_per_hour": 1}


@pytest.fixture
def make_vec():
    made = []

    def make(*arguments, **options):
        made.append(b2b.make_vec(*arguments, **{**DAY, **options}))
        return made[-1]

    yield make
    for envs in made:
        envs.close()


def test_make_vec_returns_a_building_vector_environment():
    envs = gymnasium.make_vec("b2b/OfficeSmall-v0", num_envs=2, **DAY)
    assert isinstance(envs, b2b.BuildingVectorEnv)
    assert envs.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    observations, _ = envs.reset(seed=1)
    assert observations.dtype == np.float32 and envs.observation_space.contains(observations)
    again = gymnasium.make_vec(envs.spec)
    assert again.num_envs == 2
    again.close()
    envs.close()


@pytest.mark.parametrize("building_type", b2b.list_building_types())
def test_every_id_is_a_vector_environment_without_a_warning(building_type):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        envs = gymnasium.make_vec(f"b2b/{building_type}-v0", num_envs=2, **DAY)
        assert envs.action_space.shape == (2, *envs.single_action_space.shape)
        envs.reset(seed=1)
        ends = []
        for _ in range(26):
            observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
            assert envs.observation_space.contains(observations)
            assert rewards.shape == terminated.shape == truncated.shape == (2,) and rewards.dtype == np.float64
            ends.append(truncated.all())
        assert ends.index(True) == 23 and ends.count(True) == 1 and "reward_terms" in infos
        envs.close()


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_it_equals_gymnasium_s_sync_vector_environment(mode, make_vec):
    def single():
        return b2b.make_env("OfficeSmall", rescale_action=True, **DAY)

    ours = make_vec("OfficeSmall", 2, rescale_action=True, autoreset_mode=mode)
    theirs = SyncVectorEnv([single, single], autoreset_mode=mode)
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.single_action_space == theirs.single_action_space
    assert ours.action_space == theirs.action_space
    np.testing.assert_array_equal(ours.reset(seed=0)[0], theirs.reset(seed=0)[0])
    ours.action_space.seed(0)
    for _ in range(60):
        actions = ours.action_space.sample()
        (a, ra, ta, ua, ia), (b, rb, tb, ub, ib) = ours.step(actions), theirs.step(actions)
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(ra, rb)
        np.testing.assert_array_equal(ua, ub)
        assert ("final_obs" in ia) == ("final_obs" in ib) and not ta.any() and not tb.any()
        if "final_obs" in ia:
            assert ia["_final_obs"].tolist() == ib["_final_obs"].tolist()
            for one, other in zip(ia["final_obs"], ib["final_obs"]):
                np.testing.assert_array_equal(one, other)
            assert ia["final_info"]["metrics"][0]["return"] == ib["final_info"]["metrics"]["return"][0]
    theirs.close()


def test_without_autoreset_a_mask_selects_the_environments_to_reset(make_vec):
    envs = make_vec("OfficeSmall", 2, autoreset_mode="Disabled")
    envs.reset(seed=0)
    for _ in range(24):
        _, _, _, truncated, _ = envs.step(envs.action_space.sample())
    assert truncated.all()
    first, _ = envs.reset(options={"reset_mask": np.array([True, True])})
    for _ in range(3):
        envs.step(envs.action_space.sample())
    observations, _ = envs.reset(options={"reset_mask": np.array([False, True])})
    np.testing.assert_array_equal(observations[1], first[1])
    assert (observations[0] != first[0]).any()


def test_buildings_of_different_types_are_padded(make_vec):
    envs = make_vec(None, 2, buildings=["SingleFamilyHouse", "OfficeSmall"], rescale_action=True)
    assert envs.single_observation_space.shape == (13,) and envs.single_action_space.shape == (10,)
    observations, info = envs.reset(seed=0)
    assert list(info["building"]) == ["SingleFamilyHouse", "OfficeSmall"]
    width = len(envs.layout_of(0).observation)
    assert width < 13 and not observations[0, width:].any()
    envs.step(envs.action_space.sample())
    with pytest.raises(errors.SettingError, match="rescale_action"):
        make_vec(None, 2, buildings=["SingleFamilyHouse", "OfficeSmall"])


def test_a_seed_draws_the_buildings_and_the_days(make_vec):
    envs = make_vec(
        None,
        3,
        buildings=["SingleFamilyHouse", "SingleFamilyHouse-0001"],
        resample=True,
        rescale_action=True,
        window_days=1,
        run_period="01-01..01-08",
        window_starts=2,
    )

    def sampled(seed):
        observations, info = envs.reset(seed=seed)
        return list(info["building"]), observations[:, -3].tolist()

    episodes = [sampled(seed) for seed in range(4)]
    assert episodes == [sampled(seed) for seed in range(4)]
    assert len({str(each) for each in episodes}) > 1


def test_a_custom_reward_is_computed_for_the_batch(make_vec):
    envs = make_vec("OfficeSmall", 2, reward=lambda info: -np.abs(info["zone_deviation"]).max(axis=1))
    envs.reset(seed=0)
    _, rewards, *_, info = envs.step(envs.action_space.sample())
    np.testing.assert_array_equal(rewards, -np.abs(info["zone_deviation"]).max(axis=1))


def test_invalid_actions_raise_before_any_environment_steps(make_vec):
    envs = make_vec("OfficeSmall", 2)
    envs.reset(seed=0)
    with pytest.raises(errors.ActionError, match=r"\[2, 10\]"):
        envs.step(np.zeros((2, 4), dtype=np.float32))
    bad = envs.action_space.sample()
    bad[1, 0] = np.inf
    with pytest.raises(errors.ActionError, match="finite"):
        envs.step(bad)
    envs.step(envs.action_space.sample())
