"""Wrappers."""

import copy
import json
import pickle
from types import MappingProxyType

import building2building as b2b
import gymnasium
import numpy as np
import pytest
from building2building import errors, wrappers


def stepped(env):
    env.reset(seed=0)
    observation, *_ = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation), (observation, env.observation_space)
    assert len(env.metadata["observation_names"]) == len(observation)
    return observation


def test_padding_is_zeros(make):
    observation = stepped(wrappers.PadObservation(make(), width=20))
    assert observation.shape == (20,) and not observation[13:].any()
    with pytest.raises(errors.SettingError, match="13"):
        wrappers.PadObservation(make(), width=5)


def test_houses_of_one_padded_width_have_one_space():
    day = {"run_period": "01-01..01-01", "timesteps_per_hour": 1, "rescale_action": True, "task": "occupancy"}

    def padded(house, **options):
        return lambda: wrappers.PadObservation(b2b.make_env(house, **day), **options)

    for options in ({"width": 20}, {"zones": 4}):
        envs = gymnasium.vector.SyncVectorEnv(
            [padded(house, **options) for house in ("SingleFamilyHouse-0064", "SingleFamilyHouse-0318")]
        )
        assert len({len(env.unwrapped.layout.zones) for env in envs.envs}) == 2, "the houses differ"
        observations, _ = envs.reset(seed=0)
        assert envs.observation_space.contains(observations)
        envs.close()


def test_normalized_observations_map_bounds_to_minus_one_and_one(make):
    env = wrappers.NormalizeObservation(make())
    observation = stepped(env)
    assert np.abs(observation).max() <= 1
    plain = env.unwrapped.observation
    names = env.metadata["observation_names"]
    zone = names.index("Core_ZN air temperature")
    assert observation[zone] == pytest.approx(2 * (plain[zone] - 5) / 35 - 1, abs=1e-6)
    outdoors = names.index("outdoor air temperature")
    assert observation[outdoors] == pytest.approx(2 * (plain[outdoors] + 40) / 90 - 1, abs=1e-6)


def test_bounds_by_last_words_leave_other_quantities_alone(make):
    previous = wrappers.PreviousStepObservation(make(timesteps_per_hour=1))
    env = wrappers.NormalizeObservation(previous, {"air temperature": (10, 35)})
    env.reset()
    observation, *_ = env.step(env.action_space.high)
    values = dict(zip(env.metadata["observation_names"], observation, strict=True))
    plain = dict(zip(previous.unwrapped.metadata["observation_names"], previous.unwrapped.observation, strict=True))
    zone, outdoors, electricity = "Core_ZN air temperature", "outdoor air temperature", "HVAC electricity"
    assert values[zone] == pytest.approx((plain[zone] - 10) / 12.5 - 1, abs=1e-6)
    assert values[outdoors] == pytest.approx((plain[outdoors] + 40) / 45 - 1, abs=1e-6)
    assert values[electricity] == pytest.approx(min(plain[electricity] / 60 - 1, 1), abs=1e-6), "120 W/m² for an hour"
    actions = [value for name, value in values.items() if name.startswith("previous") and name != "previous reward"]
    assert len(actions) == 10 and actions == [1] * 10
    with pytest.raises(errors.SettingError, match="bounds of air temprature apply to no slot"):
        wrappers.NormalizeObservation(previous, {"air temprature": (10, 35)})


def test_building_parameters_are_appended(make):
    observation = stepped(wrappers.AugmentObservationWithBuildingParams(make()))
    assert len(observation) > 15 and observation[13:].any() and np.abs(observation[13:]).max() <= 1
    env = make()
    morphology = env.unwrapped.morphology
    for name, (low, high) in morphology.common_attribute_bounds.items():
        value = morphology.common_attributes[name]
        scaled = np.clip(2 * (value - low) / (high - low) - 1, -1, 1)
        assert morphology.scaled_common_attributes[name] == pytest.approx(scaled), name
    assert morphology.common_attributes["actuators"] == 10 and morphology.common_attributes["systems"] == 5
    physical = stepped(wrappers.AugmentObservationWithBuildingParams(env, ["floor_area"], scaled=False))
    assert physical[-1] == pytest.approx(morphology.common_attributes["floor_area"])
    with pytest.raises(errors.SettingError, match="unknown building attribute"):
        wrappers.AugmentObservationWithBuildingParams(make(), ["color"])


def test_a_slot_has_the_same_role_in_every_house(make):
    names = []
    for house in ("SingleFamilyHouse-0064", "SingleFamilyHouse-0318"):
        env = wrappers.RoleObservation(make(None, building_id=house))
        observation = stepped(env)
        own, slots = env.unwrapped.observation, env.metadata["observation_names"]
        assert observation.shape == (17,)
        outdoors = env.unwrapped.layout.outdoor_temperature
        assert observation[slots.index("outdoor air temperature")] == np.float32(own[outdoors])
        garage = [zone.temperature_slot for zone in env.unwrapped.layout.zones if zone.name == "Garage"]
        assert observation[slots.index("garage present")] == len(garage)
        expected = np.float32(own[garage[0]]) if garage else 0
        assert observation[slots.index("garage air temperature")] == expected
        names.append(slots)
    assert names[0] == names[1]
    assert b2b.wrap_env_for_rl(make(None, building_id="SingleFamilyHouse-0064")).observation_space.shape == (17,)
    with pytest.raises(errors.SettingError, match="houses"):
        wrappers.RoleObservation(make())


def test_buildings_are_resampled_on_reset(make):
    env = wrappers.ResampleBuildingOnResetWrapper(
        make("SingleFamilyHouse", rescale_action=True),
        ["SingleFamilyHouse", "SingleFamilyHouse-0001"],
        width=16,
    )

    def drawn():
        return [env.reset(seed=seed)[1]["building"] for seed in range(5)]

    names = drawn()
    assert set(names) == {"SingleFamilyHouse", "SingleFamilyHouse-0001"} and names == drawn()
    observation, *_ = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation)
    assert env.reset(options={"building": "SingleFamilyHouse-0001"})[1]["building"] == "SingleFamilyHouse-0001"


def resampled(make, **options):
    houses = ["SingleFamilyHouse", "SingleFamilyHouse-0001"]
    env = make("SingleFamilyHouse", rescale_action=True, timesteps_per_hour=1)
    return wrappers.ResampleBuildingOnResetWrapper(env, houses, **options)


def test_the_building_of_the_next_episode_does_not_repeat_the_draw_of_the_seed(make):
    env = resampled(make, width=16)
    for seed in range(3):
        random, _ = gymnasium.utils.seeding.np_random(seed)
        expected = [env._buildings[int(random.integers(2))] for _ in range(4)]
        drawn = [env.reset(seed=seed if episode == 0 else None)[1]["building"] for episode in range(4)]
        assert drawn == expected and env.unwrapped.np_random_seed == seed


def test_padded_slots_of_drawn_buildings_have_neutral_names(make):
    env = resampled(make, width=16)
    normalized = wrappers.NormalizeObservation(env)
    for building in env._buildings:
        observation, _ = normalized.reset(options={"building": building})
        assert normalized.observation_space.contains(observation)
        assert env.metadata["observation_names"] == [f"slot {number}" for number in range(16)]
        assert env.metadata["observation_units"] == ["1"] * 16 and env.metadata["building"] == building
    low, high = env.observation_space.low[0], env.observation_space.high[0]
    np.testing.assert_allclose(observation[-1], -2 * low / (high - low) - 1, rtol=1e-6)


def test_roles_are_observed_inside_and_outside_of_drawn_buildings(make):
    inside = wrappers.ResampleBuildingOnResetWrapper(
        wrappers.RoleObservation(make("SingleFamilyHouse", rescale_action=True, timesteps_per_hour=1)),
        ["SingleFamilyHouse", "SingleFamilyHouse-0001"],
    )
    outside = wrappers.RoleObservation(resampled(make, width=16))
    for seed in range(3):
        one, other = inside.reset(seed=seed), outside.reset(seed=seed)
        assert one[1]["building"] == other[1]["building"]
        np.testing.assert_array_equal(one[0], other[0])
    assert inside.metadata["observation_names"] == outside.metadata["observation_names"]


HOUSES = ["SingleFamilyHouse-0064", "SingleFamilyHouse-0318"]


def test_slots_are_found_again_in_another_building(make):
    env = make(HOUSES[0], rescale_action=True, timesteps_per_hour=1)
    subset = wrappers.SubsetObservation(wrappers.NormalizeObservation(env), ["outdoor air temperature", "time of day"])
    drawn = wrappers.ResampleBuildingOnResetWrapper(subset, HOUSES)
    places = set()
    for house in HOUSES:
        observation, _ = drawn.reset(options={"building": house})
        outdoors = env.unwrapped.layout.outdoor_temperature
        places.add(outdoors)
        assert observation[0] == pytest.approx((env.unwrapped.observation[outdoors] + 40) / 45 - 1, abs=1e-6)
        assert subset.metadata["building"] == house
    assert len(places) == 2, "the houses differ"


def test_a_graph_is_that_of_the_building_that_was_drawn(make):
    env = make("OfficeSmall", rescale_action=True, timesteps_per_hour=1)
    drawn = wrappers.GraphObservation(wrappers.ResampleBuildingOnResetWrapper(env))
    before, _ = drawn.reset(options={"building": "OfficeSmall"})
    after, _ = drawn.reset(options={"building": "OfficeSmall-0042"})
    own, _ = wrappers.GraphObservation(make("OfficeSmall-0042", timesteps_per_hour=1)).reset()
    for part, other in zip(after, own, strict=True):
        np.testing.assert_array_equal(part, other)
    assert (before.nodes != after.nodes).any() and (before.edges != after.edges).any()


def test_the_other_actuators_follow_the_controller_of_the_building_that_was_drawn(make):
    options = {"rescale_action": True, "timesteps_per_hour": 1}
    names = ["Core_ZN supply air flow"]
    applied = []
    drawn = wrappers.ResampleBuildingOnResetWrapper(wrappers.SubsetAction(make("OfficeSmall", **options), names))
    drawn.reset(options={"building": "OfficeSmall-0042"})
    own = wrappers.SubsetAction(make("OfficeSmall-0042", **options), names)
    own.reset()
    for env in (drawn, own):
        env.step(np.zeros(1))
        applied.append(env.unwrapped.applied_action())
    np.testing.assert_array_equal(*applied)
    inner = make("OfficeSmall", **options)
    fixed = wrappers.SubsetAction(inner, names, b2b.ReactiveController(inner))
    drawn = wrappers.ResampleBuildingOnResetWrapper(fixed, ["OfficeSmall", "OfficeSmall-0042"])
    drawn.reset(options={"building": "OfficeSmall"})
    for _ in range(2):
        with pytest.raises(errors.SettingError, match="made for OfficeSmall, but the building is now OfficeSmall-0042"):
            drawn.reset(options={"building": "OfficeSmall-0042"})


def test_drawn_buildings_keep_the_control_of_the_environment(make):
    env = make("OfficeSmall", place="Miami", control="setpoints", timesteps_per_hour=1)
    drawn = wrappers.ResampleBuildingOnResetWrapper(env)
    assert drawn.reset(seed=0)[1]["building"].endswith("+setpoints")
    assert "Core_ZN cooling setpoint" in drawn.metadata["action_names"]
    again = pickle.loads(pickle.dumps(env.unwrapped))
    assert again.building.name == env.unwrapped.building.name
    again.close()


def test_the_forecast_is_the_future_weather(make):
    env = wrappers.WeatherForecast(make(), hours=3, quantities=("temperature", "wind_speed"))
    assert stepped(env).shape == (19,)
    observation, _ = env.reset()
    for _ in range(12):
        later, *_ = env.step(env.action_space.low)
    # The engine interpolates within the hour, so the forecast and its later value differ slightly.
    assert observation[13] == pytest.approx(later[6], abs=0.6)
    assert later[13] == pytest.approx(observation[14], abs=1e-4)


@pytest.fixture
def years(make, tmp_path):
    """Weather files of two years, the second 5 K warmer."""
    own = make().unwrapped.building.weather.read_text().splitlines()
    warmer = own[:8]
    for line in own[8:]:
        cells = line.split(",")
        cells[6] = str(float(cells[6]) + 5)
        warmer.append(",".join(cells))
    files = [tmp_path / "2019.epw", tmp_path / "2020.epw"]
    for file, lines in zip(files, (own, warmer), strict=True):
        file.write_text("\n".join(lines) + "\n")
    return files


@pytest.mark.nightly
def test_every_episode_draws_a_weather_year_by_the_seed(make, years):
    env = wrappers.WeatherForecast(make(weather_years=years), hours=1)
    outdoors = env.metadata["observation_names"].index("outdoor air temperature")

    def episodes(seed):
        drawn = []
        for episode in range(8):
            observation, info = env.reset(seed=seed if episode == 0 else None)
            drawn.append((info["weather"].rsplit("/", 1)[1], float(observation[outdoors]), float(observation[-1])))
        return drawn

    first = episodes(0)
    assert first == episodes(0) and first != episodes(1)
    temperature = {name: now for name, now, _ in first}
    # The engine and the forecast read the same file.
    for index in (1, 2):
        of_year = {each[0]: each[index] for each in first}
        assert of_year["2020.epw"] - of_year["2019.epw"] == pytest.approx(5, abs=0.1)
    # The building is sized once.
    np.testing.assert_array_equal(env.action_space.high, make().action_space.high)

    vector = b2b.make_vec("OfficeSmall", 8, run_period="01-01..01-02", weather_years=years)
    observations, _ = vector.reset(seed=0)
    assert {round(float(each)) for each in observations[:, outdoors]} == {round(each) for each in temperature.values()}
    vector.close()


def test_a_damaged_weather_year_is_an_error(make, tmp_path):
    file = tmp_path / "short.epw"
    file.write_text("LOCATION,x\n" * 20)
    with pytest.raises(errors.BuildingError, match="short.epw"):
        make(weather_years=[file])


def test_the_errors_of_a_forecast_grow_with_the_hours_ahead_and_follow_the_seed(make):
    hours, error = 6, 0.5
    quantities = ("temperature", "wind_speed")

    def errors_of(seed):
        perfect = wrappers.WeatherForecast(make(), hours, quantities)
        wrong = wrappers.WeatherForecast(make(), hours, quantities, errors={"temperature": error})
        (true, _), (drawn, _) = perfect.reset(seed=seed), wrong.reset(seed=seed)
        rows = [drawn - true]
        for _ in range(24):
            true, *_ = perfect.step(perfect.action_space.low)
            drawn, *_ = wrong.step(wrong.action_space.low)
            rows.append(drawn - true)
        return np.array(rows)[:, -2 * hours :]

    drawn = errors_of(0)
    np.testing.assert_array_equal(drawn, errors_of(0))
    assert (drawn[:, :hours] != errors_of(1)[:, :hours]).all() and (drawn[:, hours:] == 0).all()
    # One forecast an hour.
    np.testing.assert_allclose(drawn[0], drawn[11], atol=1e-4)
    assert (drawn[11, :hours] != drawn[12, :hours]).all()

    wrapper = wrappers.WeatherForecast(make(), hours, errors={"temperature": error})
    walks = np.array([wrapper._drawn_errors(hour)[:, 0] for hour in range(4000)])
    np.testing.assert_allclose(walks.std(axis=0), error * np.sqrt(np.arange(1, hours + 1)), rtol=0.05)
    with pytest.raises(errors.SettingError, match="errors has `humidity`; expected one of temperature"):
        wrappers.WeatherForecast(make(), errors={"humidity": 1.0})


def test_a_price_is_observed_and_charged(make):
    series = np.arange(24) / 100 + 0.1
    env = wrappers.PriceSignal(make(), series, ahead=2, weight=1000.0)
    observation, _ = env.reset()
    np.testing.assert_allclose(observation[-3:], series[:3], rtol=1e-6)
    _, reward, _, _, info = env.step(env.action_space.high)
    electricity = info["energy"]["electricity"] / 1000
    assert info["reward_terms"]["electricity price"] == pytest.approx(-1000 * 0.1 * electricity)
    assert reward == pytest.approx(sum(info["reward_terms"].values()))
    info = env.step(env.action_space.high)[4]
    assert "energy" in json.loads(json.dumps(info, default=np.ndarray.tolist))
    with pytest.raises(errors.SettingError, match="8760"):
        wrappers.PriceSignal(make(), [1.0])


def test_controllers_and_functions_have_the_rewards_and_steps_of_wrappers(make):
    for rescale in (False, True):
        inner = make(timesteps_per_hour=1, rescale_action=rescale)
        reactive = b2b.ReactiveController(inner)
        alone = b2b.rollout(inner, reactive)
        env = wrappers.PriceSignal(wrappers.NormalizeObservation(inner), weight=1000.0)
        priced = b2b.rollout(env, reactive)
        assert priced.hash() == alone.hash() and priced.episode_return < alone.episode_return - 1e-3
        reactive.reset()
        env.reset()
        rewards = [env.step(reactive(inner.unwrapped.observation))[1] for _ in range(24)]
        np.testing.assert_allclose(priced.rewards, rewards, rtol=1e-6)
        limited = b2b.rollout(gymnasium.wrappers.TimeLimit(env, 5), reactive)
        assert limited.rewards.tolist() == priced.rewards[:5].tolist() and limited.truncated


def test_a_controller_acts_through_wrappers_that_change_actions_only(make):
    env = make(timesteps_per_hour=1)
    reactive = b2b.ReactiveController(env)
    alone = b2b.rollout(env, reactive)
    rescaled = gymnasium.wrappers.RescaleAction(env, np.float32(-1), np.float32(1))
    subset = wrappers.PreviousStepObservation(wrappers.SubsetAction(env, ["Core_ZN supply air flow"]))
    for each in (rescaled, subset):
        through = b2b.rollout(each, reactive)
        assert through.hash() == alone.hash() and through.rewards.tolist() == alone.rewards.tolist()
    halved = gymnasium.wrappers.TransformAction(env, lambda action: 0.5 * action, None)
    assert b2b.rollout(halved, reactive).hash() != alone.hash()
    acting = b2b.make_env("OfficeSmall", run_period="01-01..01-01", acting="supervisory:60")
    priced = wrappers.PriceSignal(env, weight=1000.0)
    for each in (
        gymnasium.wrappers.RescaleAction(priced, np.float32(-1), np.float32(1)),
        gymnasium.wrappers.TimeLimit(rescaled, 5),
        acting,
    ):
        with pytest.raises(errors.SettingError, match="reactive cannot act.*env.unwrapped"):
            b2b.rollout(each, b2b.ReactiveController(each))
    acting.close()
    assert b2b.rollout(env, reactive).hash() == alone.hash()


@pytest.fixture
def leap_day(make, tmp_path):
    """A warehouse from 29 February to 1 March; the first day is like the one before, but at 7 °C."""
    lines = b2b.find_building("Warehouse").weather.read_text().splitlines()
    header = [line.replace("SAVINGS,No", "SAVINGS,Yes") for line in lines[:8]]
    rows = [["2020", *line.split(",")[1:]] for line in lines[8:]]
    march = [row[1:3] for row in rows].index(["3", "1"])
    rows[march:march] = [["2020", "2", "29", *row[3:6], "7.0", *row[7:]] for row in rows[march - 24 : march]]
    weather = tmp_path / "2020.epw"
    weather.write_text("\n".join([*header, *map(",".join, rows)]) + "\n")
    building = b2b.import_building(b2b.list_engine_models()["RefBldgWarehouseNew2004_Chicago"], weather)
    options = {"run_period": "02-29..03-01", "timesteps_per_hour": 1, "render_mode": "rgb_array"}
    return make(None, building=building, **options), [float(row[6]) for row in rows[march + 24 :]]


def test_29_february_has_its_own_weather_and_the_prices_of_the_day_before(leap_day):
    env, march = leap_day
    env = wrappers.PriceSignal(wrappers.WeatherForecast(env, hours=2), np.arange(8760), ahead=0)
    assert env.reset()[0][-3:].tolist() == [7, 7, 58 * 24]
    for _ in range(24):
        observation, *_ = env.step(env.action_space.low)
    np.testing.assert_allclose(observation[-3:], [*march[:2], 59 * 24], rtol=1e-6)


def test_a_frame_of_29_february_has_its_date(leap_day):
    pytest.importorskip("matplotlib")
    env, _ = leap_day
    env.reset()
    env.render()
    assert "02-29 00:00" in env.unwrapped._renderer._drawing._panels[0]._text.get_text()


def test_the_previous_reward_may_be_positive(make):
    env = wrappers.PreviousStepObservation(make(timesteps_per_hour=1, reward=lambda info: 7.0))
    assert stepped(env)[-2] == 7
    assert stepped(wrappers.NormalizeObservation(env))[-2] == 1, "clipped"


def test_slots_and_actuators_are_selected_by_name(make):
    env = wrappers.SubsetObservation(make(), ["outdoor air temperature", "Core_ZN air temperature"])
    assert stepped(env).shape == (2,)
    env = wrappers.SubsetAction(make(), ["Core_ZN supply air flow"])
    env.reset()
    env.step(np.array([0.1], dtype=np.float32))
    applied = env.unwrapped.applied_action()
    assert applied[env.unwrapped.metadata["action_names"].index("Core_ZN supply air flow")] == np.float32(0.1)
    assert applied[1] > 10
    with pytest.raises(errors.SettingError, match="Core_ZN"):
        wrappers.SubsetAction(make(), ["no such"])


def test_a_controller_sets_the_other_actuators_in_the_action_space_of_the_building(make):
    name = "Core_ZN supply air flow"
    env = make(timesteps_per_hour=1)
    rescaled = gymnasium.wrappers.RescaleAction(env, np.float32(-1), np.float32(1))
    for rest in (None, b2b.ReactiveController(env)):
        with pytest.raises(errors.SettingError, match="apply SubsetAction first"):
            wrappers.SubsetAction(rescaled, [name], rest)
    subset = wrappers.SubsetAction(env, [name], b2b.ReactiveController(env, parameters=MappingProxyType({})))
    applied = []
    for each in (subset, gymnasium.wrappers.RescaleAction(subset, np.float32(-1), np.float32(1))):
        each.reset(seed=0)
        each.step(each.action_space.low)
        applied.append(env.unwrapped.applied_action())
    np.testing.assert_allclose(applied[0], applied[1], rtol=1e-6, atol=1e-6)


def test_a_copied_controller_has_its_own_state(make):
    env = make(timesteps_per_hour=1)
    env.reset()
    controller = b2b.RandomController(env, seed=3)
    copied = copy.deepcopy(controller)
    first = controller.physical(env.unwrapped.observation)
    np.testing.assert_array_equal(copied.physical(env.unwrapped.observation), first)


def test_a_spec_makes_the_same_wrapped_environment(make):
    env = wrappers.PadObservation(wrappers.NormalizeObservation(make()), width=20)
    again = gymnasium.make(env.spec)
    np.testing.assert_array_equal(again.reset(seed=0)[0], env.reset(seed=0)[0])
    again.close()


def test_wrap_env_for_rl_bounds_both_spaces(make):
    env = b2b.wrap_env_for_rl(make(), width=20)
    assert env.observation_space.shape == (20,) and env.action_space.low.tolist() == [-1.0] * 10
    stepped(env)


@pytest.mark.parametrize(
    "wrap",
    [
        b2b.wrap_env_for_rl,
        wrappers.NormalizeObservation,
        gymnasium.wrappers.NormalizeObservation,
        lambda env: gymnasium.wrappers.RescaleAction(env, -1.0, 1.0),
    ],
)
def test_a_controller_does_not_act_through_wrappers_that_change_its_spaces(make, wrap):
    env = wrap(make(task="occupancy", timesteps_per_hour=1))
    controller = b2b.ReactiveController(env)
    observation, _ = env.reset(seed=0)
    with pytest.raises(errors.SettingError, match="ReactiveController was made for wrappers.*use rollout"):
        controller(observation)
    plain = b2b.rollout(env.unwrapped, b2b.ReactiveController(env.unwrapped)).episode_return
    assert b2b.rollout(env, controller).metrics["return"] == plain


def test_wrappers_notice_changed_observations(make):
    house = make("SingleFamilyHouse", timesteps_per_hour=1)
    for changed in [
        wrappers.NormalizeObservation(house),
        gymnasium.wrappers.NormalizeObservation(house),
        gymnasium.wrappers.FrameStackObservation(house, 3),
    ]:
        for wrap in (wrappers.RoleObservation, wrappers.GraphObservation):
            with pytest.raises(errors.SettingError):
                wrap(changed)
    with pytest.raises(errors.SettingError, match="before FrameStackObservation"):
        wrappers.NormalizeObservation(gymnasium.wrappers.FrameStackObservation(house, 3))


def test_a_price_with_a_weight_is_for_single_steps(make):
    env = make(acting="supervisory:60", task="operate")
    priced = wrappers.PriceSignal(env, weight=1.0)
    priced.reset(seed=0)
    with pytest.raises(errors.SettingError, match="made 12; take a tariff"):
        priced.step(np.zeros(priced.action_space.shape))


def test_zones_are_agents(make):
    from building2building.multiagent import ZonesParallelEnv
    from pettingzoo.test import parallel_api_test

    env = ZonesParallelEnv(make("OfficeMedium", timesteps_per_hour=1))
    assert len(env.possible_agents) == 18
    parallel_api_test(env, num_cycles=30)


@pytest.mark.parametrize("task", ["constant+deadband0.5", "operate"])
def test_zones_have_the_task_s_comfort_penalty(make, task):
    from building2building.multiagent import ZonesParallelEnv

    env = ZonesParallelEnv(make("OfficeSmall", task=task, timesteps_per_hour=1))
    env.reset(seed=0)
    penalties = []
    for _ in range(10):
        _, rewards, _, _, infos = env.step({agent: env.action_space(agent).high for agent in env.agents})
        zones = env.env.layout.controlled_zones
        terms = infos[zones[0]]["reward_terms"]
        own = [terms["energy"] / len(env.agents) - rewards[zone] for zone in zones]
        assert np.mean(own) == pytest.approx(-terms["temperature"])
        penalties.extend(own)
    assert max(penalties) > 0
    for options, words in [
        ({"task": "operate+pmv"}, "omit .pmv"),
        ({"task": "operate+noise0.2"}, "omit .noise and .bias"),
        ({"reward": lambda info: 0.0}, "omit reward"),
    ]:
        with pytest.raises(errors.SettingError, match=words):
            ZonesParallelEnv(make("OfficeSmall", **options))
    with pytest.raises(errors.SettingError, match="without wrappers"):
        ZonesParallelEnv(wrappers.NormalizeObservation(make("OfficeSmall")))
