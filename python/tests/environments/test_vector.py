"""The contract of a Gymnasium vector environment."""

import inspect
import os
import pickle
import signal
import warnings

import building2building as b2b
import gymnasium
import numpy as np
import pytest
from building2building import errors
from building_types import every_type
from gymnasium.vector import AutoresetMode, SyncVectorEnv

DAY = {"run_period": "01-01..01-01", "timesteps_per_hour": 1, "task": "constant"}


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


@pytest.mark.parametrize("building_type", every_type())
def test_every_id_is_a_vector_environment_without_a_warning(building_type):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        envs = gymnasium.make_vec(f"b2b/{building_type}-v1", num_envs=2, **DAY)
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
            ours_final, theirs_final = ia["final_info"], ib["final_info"]
            assert ours_final["metrics"][0]["return"] == theirs_final["metrics"]["return"][0]
            assert ia["_final_info"].tolist() == ib["_final_info"].tolist()
            for name in ("step", "hour", "cost"):
                np.testing.assert_allclose(ours_final[name], theirs_final[name], rtol=1e-6)
                assert ours_final[f"_{name}"].tolist() == theirs_final[f"_{name}"].tolist()
            for term, values in theirs_final["reward_terms"].items():
                if not term.startswith("_"):
                    np.testing.assert_allclose(ours_final["reward_terms"][term], values, rtol=1e-6)
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
        days = info["first_day"].tolist()
        assert all(1 <= day <= 8 and path.endswith(".epw") for day, path in zip(days, info["weather"], strict=True))
        return list(info["building"]), observations[:, -3].tolist(), days

    episodes = [sampled(seed) for seed in range(4)]
    assert episodes == [sampled(seed) for seed in range(4)]
    assert len({str(each) for each in episodes}) > 1 and len({str(days) for *_, days in episodes}) > 1


def test_a_custom_reward_is_computed_for_the_batch(make_vec):
    envs = make_vec("OfficeSmall", 2, reward=lambda info: -np.abs(info["zone_deviation"]).max(axis=1))
    envs.reset(seed=0)
    _, rewards, *_, info = envs.step(envs.action_space.sample())
    np.testing.assert_array_equal(rewards, -np.abs(info["zone_deviation"]).max(axis=1))


def test_a_custom_reward_without_a_value_for_every_environment_is_an_error(make_vec):
    envs = make_vec("SingleFamilyHouse", 2, reward=lambda info: -np.abs(info["zone_deviation"]).mean())
    envs.reset(seed=0)
    with pytest.raises(errors.SettingError, match=r"shape \(\); expected \(2,\).*mean\(axis=-1\)"):
        envs.step(envs.action_space.sample())


def test_episodes_begin_with_a_reset_of_all_and_in_this_process(make_vec):
    envs = make_vec("SingleFamilyHouse", 2)
    with pytest.raises(errors.EpisodeError, match="call reset"):
        envs.step(envs.action_space.sample())
    with pytest.raises(errors.EpisodeError, match="call reset of all"):
        envs.reset(options={"reset_mask": np.array([True, False])})
    with pytest.raises(errors.ProcessError, match="make it again"):
        pickle.dumps(envs)


def test_a_custom_reward_counts_in_every_step_that_runs(make_vec):
    for mode, resets in [("SameStep", 0), ("NextStep", 1)]:
        envs = make_vec("SingleFamilyHouse", 1, reward=lambda info: np.array([7.0]), autoreset_mode=mode)
        envs.reset(seed=0)
        rewards = [float(envs.step(envs.action_space.sample())[1][0]) for _ in range(26)]
        assert rewards.count(0.0) == resets and rewards.count(7.0) == 26 - resets, mode


@pytest.mark.nightly
def test_a_reset_without_a_seed_continues_the_random_numbers_of_the_last_seed(make_vec):
    envs = make_vec("SingleFamilyHouse", 2, split="train", resample=True, rescale_action=True)

    def drawn():
        return [list(envs.reset(seed=seed)[1]["building"]) for seed in (5, None)]

    first = drawn()
    assert drawn() == first and first[0] != first[1]


@pytest.mark.nightly
def test_a_list_of_seeds_is_one_seed_and_a_list_without_numbers_is_none(make_vec):
    envs = make_vec("SingleFamilyHouse", 2, split="train", resample=True, rescale_action=True)

    def drawn(*seeds):
        return [list(envs.reset(seed=seed)[1]["building"]) for seed in seeds]

    first = drawn([5, 6], None, [None, None])
    assert drawn([5, 6], [None, None], None) == first and drawn([6, 5])[0] != first[0]
    assert first[1] != first[2]
    with pytest.raises(errors.SettingError, match="seed has 3 numbers; expected one, or 2"):
        envs.reset(seed=[1, 2, 3])
    some = {"reset_mask": np.array([True, False])}
    with pytest.raises(errors.SettingError, match="omit seed or reset_mask"):
        envs.reset(seed=1, options=some)
    envs.reset(seed=[None, None], options=some)


def test_the_episode_after_a_lost_one_begins_in_the_same_step(make_vec):
    envs = make_vec("SingleFamilyHouse-0042", 2, rescale_action=True, autoreset_mode="SameStep")
    first, _ = envs.reset(seed=0)
    actions = np.zeros(envs.action_space.shape)
    envs.step(actions)
    os.kill(envs._core.processes()[1], signal.SIGKILL)
    observations, _, _, truncated, infos = envs.step(actions)
    assert truncated.tolist() == infos["_lost"].tolist() == [False, True]
    np.testing.assert_array_equal(observations[1], first[1])
    infos = envs.step(actions)[4]
    assert infos["step"].tolist() == [3, 1]
    ends = [envs.step(actions)[3].tolist() for _ in range(23)]
    assert ends[20] == [True, False] and ends[22] == [False, True]


def test_more_buildings_than_environments_are_an_error(make_vec):
    houses = ["SingleFamilyHouse-0018", "SingleFamilyHouse-0042"]
    with pytest.raises(errors.SettingError, match="2 buildings for 1 environments.*pass num_envs=2, or resample=True"):
        make_vec(None, 1, buildings=houses)
    with pytest.raises(errors.SettingError, match="window_starts needs window_days"):
        make_vec("OfficeSmall", 1, window_starts=3)


def test_observations_and_infos_are_the_user_s(make_vec):
    def rewards(changes):
        envs = make_vec("OfficeSmall", 2, reward=lambda info: -np.abs(info["zone_deviation"]).mean(axis=-1))
        observations, _ = envs.reset(seed=0)
        found = []
        for _ in range(4):
            if changes:
                observations *= 0.0
            observations, reward, *_, infos = envs.step(envs.action_space.high)
            found.append(reward.tolist())
            if changes:
                infos["step"] += 7
        return found

    assert rewards(True) == rewards(False)


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


@pytest.mark.nightly
def test_infos_say_what_was_true_when_they_were_made(make_vec):
    houses = [f"SingleFamilyHouse-{number:04}" for number in range(1, 40)]
    envs = make_vec(None, 2, buildings=houses, resample=True, rescale_action=True, autoreset_mode="SameStep")
    _, began = envs.reset(seed=1)
    infos = [envs.step(envs.action_space.sample())[-1] for _ in range(25)]
    names = [list(info["building"]) for info in infos]
    assert names[:24] == [list(began["building"])] * 24 and names[24] != names[0]
    _, again = envs.reset(seed=2)
    kept = list(began["building"])
    unread = envs.step(envs.action_space.sample())[-1]
    expected = [envs.layout_of(index).spaces.name for index in range(2)]
    envs.close()
    assert list(began["building"]) == kept
    assert list(again["building"]) == expected == list(unread["building"])
    assert unread["reward_terms"]["temperature"].shape == (2,)


@pytest.mark.nightly
def test_buildings_of_a_split_are_drawn_by_the_seed_in_few_processes(make_vec):
    envs = make_vec("SingleFamilyHouse", 2, split="train", resample=2, rescale_action=True)
    assert len(envs.buildings) == 900 and envs.single_observation_space.shape == (11,)

    def drawn():
        names = []
        _, info = envs.reset(seed=3)
        for _ in range(4):
            names.append(tuple(info["building"]))
            for _ in range(25):
                *_, info = envs.step(envs.action_space.sample())
            assert len(envs._core.processes()) <= 8
        return names

    names = drawn()
    assert names[0] == names[1] != names[2] == names[3] and set(sum(names, ())) <= set(envs.buildings)
    assert names == drawn()
    statistics = envs.statistics
    assert statistics["building_changes"] >= 4 and statistics["episodes"] >= 8


@pytest.mark.nightly
def test_weights_tasks_and_the_generator_are_drawn_from(make_vec):
    sources = [b2b.Generator("SingleFamilyHouse", parameters={"floor_area": (100, 120)}), "Warehouse-0001"]
    options = {"resample": True, "rescale_action": True, "task": ["constant", "occupancy"]}
    envs = make_vec(None, 2, buildings=sources, weights={"SingleFamilyHouse": 1, "Warehouse": 0}, **options)
    observations, info = envs.reset(seed=0)
    assert all(name.startswith("SingleFamilyHouse-seed") for name in info["building"])
    assert envs.observation_space.contains(observations)
    mask, actions = envs.observation_mask(), envs.action_mask()
    assert mask.shape == observations.shape and not observations[~mask].any()
    assert actions.sum(axis=1).tolist() == [2, 2] and actions.shape == envs.action_space.shape
    with pytest.raises(errors.SettingError, match="Warehous"):
        make_vec(None, 1, buildings=sources, weights={"Warehous": 1}, **options)
    with pytest.raises(errors.SettingError, match="resample=True"):
        make_vec(None, 1, buildings=sources, rescale_action=True)


@pytest.mark.nightly
def test_observations_are_normalized_by_the_same_bounds_for_all_buildings(make_vec):
    options = {"resample": True, "rescale_action": True, "autoreset_mode": "SameStep"}
    raw, normalized = (make_vec("SingleFamilyHouse", 2, normalize=each, **options) for each in (False, True))
    seen = [envs.reset(seed=5)[0] for envs in (raw, normalized)]
    for _ in range(26):
        np.testing.assert_array_equal(raw.scale(seen[0]), seen[1])
        assert normalized.observation_space.contains(seen[1])
        action = raw.action_space.sample()
        (*_, ends, info), (*_, other) = steps = raw.step(action), normalized.step(action)
        seen = [step[0] for step in steps]
        if ends.any():
            np.testing.assert_array_equal(raw.scale(info["final_obs"][0]), other["final_obs"][0])


@pytest.mark.nightly
def test_a_place_means_the_same_in_every_house_by_role(make_vec):
    houses = [f"SingleFamilyHouse-{number:04}" for number in range(1, 21)]
    options = {"buildings": houses, "resample": True, "rescale_action": True, "run_period": "01-01..01-01"}
    envs = make_vec(None, 4, by_role=True, **options)
    observations, _ = envs.reset(seed=2)
    assert observations.shape == (4, 17) and envs.observation_space.contains(observations)
    names = [name for name, _, _ in envs._core.slots()[0]]
    assert all([name for name, _, _ in row] == names for row in envs._core.slots())
    for environment, row in enumerate(observations):
        zones = [zone.name.lower() for zone in envs.layout_of(environment).zones]
        present = [name.split()[0] for name, value in zip(names, row) if name.endswith(" present") and value]
        assert present == zones
    assert (observations[:, names.index("time of day")] == observations[0, names.index("time of day")]).all()


def test_arguments_of_single_environments_are_said_to_be_theirs():
    single, vector = (set(inspect.signature(each).parameters) for each in (b2b.make_env, b2b.make_vec))
    assert single - vector == {"resample_targets", "in_process", "keep_engine_output"}
    for argument in single - vector:
        assert f"``{argument}``" in b2b.make_vec.__doc__
        with pytest.raises(TypeError, match=f"no argument `{argument}`, which make_env has; make single environments"):
            b2b.make_vec("OfficeSmall", 2, **{argument: True})
    for argument in ("resample", "normalize"):
        with pytest.raises(TypeError, match=f"no argument `{argument}`, which make_vec has"):
            b2b.make_env("OfficeSmall", **{argument: True})


def test_named_buildings_are_in_the_given_place(make_vec):
    envs = make_vec(None, 2, buildings=["OfficeSmall", "Warehouse"], place="Miami", rescale_action=True)
    assert [each.place for each in envs.buildings] == ["Miami", "Miami"]
    with pytest.raises(errors.SettingError, match="Miami.*already has a place"):
        make_vec(None, 2, buildings=envs.buildings, place="Denver", rescale_action=True)


def test_drawn_setpoints_are_in_physical_units(make_vec):
    envs = make_vec("OfficeSmall", 1, resample=True, control="setpoints")
    envs.reset(seed=0)
    np.testing.assert_array_equal(envs.single_action_space.high, envs.layout_of(0).action_high)


@pytest.mark.parametrize(
    "options, words",
    [
        ({"task": []}, "task is empty"),
        ({"task": [], "resample": True, "rescale_action": True, "split": "test"}, "task is empty"),
        ({"num_envs": 2**40}, "num_envs is 1099511627776; expected 1 to 2048"),
        ({"num_envs": 2049, "resample": True, "rescale_action": True}, "expected 1 to 2048"),
        ({"num_envs": 0}, "num_envs is 0"),
        ({"num_envs": "2"}, "num_envs is '2'"),
        ({"reward": "energy"}, "reward is 'energy'; expected a function"),
        ({"num_envs": 2, "task": ["constant", "occupancy", "random"]}, "3 tasks .* 2 environments.*pass num_envs=3"),
        ({"by_role": True}, "by_role gives slots"),
        ({"window_days": -1}, "window_days is -1; expected 1 or more"),
        ({"timesteps_per_hour": -1}, "timesteps_per_hour is -1"),
        ({"split": "train"}, "pass index=0"),
        ({"resample": True, "place": "Miami"}, "OfficeSmall-0001 is drawn at its own place"),
        ({"resample": True, "buildings": [b2b.Generator("OfficeSmall")], "weather": "x.epw"}, "pass buildings=.Gener"),
        ({"buildings": ["OfficeSmall-0001"], "split": "test", "index": 3}, "omit split and index"),
        ({"buildings": ["Warehouse-0001"]}, "Warehouse-0001 is of the type Warehouse, not OfficeSmall"),
        ({"resample": True}, "pass rescale_action=True"),
        ({"resample": True, "buildings": [b2b.Generator("OfficeSmall")]}, "pass rescale_action=True"),
    ],
)
def test_arguments_out_of_bounds_are_errors(options, words, make_vec):
    with pytest.raises(errors.SettingError, match=words):
        make_vec("OfficeSmall", **options)
