"""The info of a vector environment equals the infos of single environments, row by row."""

import building2building as b2b
import numpy as np
import pytest

DAY = {"run_period": "01-01..01-01", "timesteps_per_hour": 1, "rescale_action": True}


def assert_row(infos, row, info):
    """Asserts that a row of the infos of a batch is the info of a single environment, to the precision of f32."""
    for name in ("step", "hour", "cost", "emissions"):
        assert infos[name][row] == pytest.approx(info[name], rel=1e-6, abs=1e-9), name
    for group in ("energy", "reward_terms"):
        for name, value in info[group].items():
            assert infos[group][name][row] == pytest.approx(value, rel=1e-6, abs=1e-9), name
    for name in ("zone_temperature", "zone_target", "zone_deviation"):
        zones = len(info[name])
        np.testing.assert_allclose(infos[name][row][:zones], info[name], rtol=1e-5, atol=1e-5)
        assert np.isnan(infos[name][row][zones:]).all()
    if "zone_occupied" in info:
        assert infos["zone_occupied"][row][: len(info["zone_occupied"])].tolist() == info["zone_occupied"].tolist()


@pytest.mark.parametrize("mode, task", [("NextStep", "occupancy+cost2"), ("SameStep", "constant")])
def test_buildings_of_other_sizes_have_the_info_of_single_environments(mode, task):
    names = ["OfficeSmall", "SingleFamilyHouse-0007"]
    envs = b2b.make_vec(None, 2, buildings=names, task=task, autoreset_mode=mode, **DAY)
    singles = [b2b.make_env(building=b2b.find_building(name), task=task, **DAY) for name in names]
    envs.reset(seed=0)
    for env in singles:
        env.reset(seed=0)
    envs.action_space.seed(0)
    for _ in range(24):
        actions = envs.action_space.sample()
        *_, truncated, infos = envs.step(actions)
        for row, env in enumerate(singles):
            *_, info = env.step(actions[row][: env.action_space.shape[0]])
            assert_row(infos, row, info)
            assert infos["building"][row] == env.building.name
    assert truncated.all() and infos["hour"].tolist() == [23, 23]
    # The next episode.
    *_, infos = envs.step(envs.action_space.sample())
    assert infos["step"].tolist() == ([0, 0] if mode == "NextStep" else [1, 1])
    for env in (envs, *singles):
        env.close()


def test_houses_arranged_by_role_have_the_info_of_single_environments():
    houses = ["SingleFamilyHouse-0003", "SingleFamilyHouse-0007"]
    envs = b2b.make_vec(None, 2, buildings=houses, by_role=True, task="occupancy", **DAY)
    envs.reset(seed=0)
    singles = [b2b.make_env(building_id=name, task="occupancy", **DAY) for name in houses]
    for env in singles:
        env.reset(seed=0)
    for _ in range(3):
        action = np.zeros(envs.action_space.shape)
        *_, infos = envs.step(action)
        for row, env in enumerate(singles):
            assert_row(infos, row, env.step(action[row])[4])
    for env in (envs, *singles):
        env.close()


def test_drawn_buildings_have_infos_of_the_building_that_runs():
    envs = b2b.make_vec("SingleFamilyHouse", 2, resample=True, **DAY)
    envs.reset(seed=1)
    for step in range(1, 60):
        *_, infos = envs.step(envs.action_space.sample())
        assert infos["building"].tolist() == [name for name, *_ in envs._core.episodes()]
        assert (infos["zone_temperature"] > 0).all() and (infos["energy"]["electricity"] >= 0).all()
        assert infos["step"].tolist() == [step % 25] * 2
        begins = step % 25 == 0
        assert ("_first_day" in infos) == ("weather" in infos) == begins
        assert not begins or infos["first_day"].tolist() == [1, 1] and infos["_weather"].all()
    assert envs.statistics["building_changes"] > 0
    envs.close()
