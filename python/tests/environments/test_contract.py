"""The contract of a Gymnasium environment."""

import copy
import json
import pickle
import re
import subprocess
import sys
import types
import warnings

import building2building as b2b
import gymnasium
import numpy as np
import pytest
from building2building import errors
from building_types import every_type
from gymnasium.utils.env_checker import check_env

DAY = "01-01..01-01"


@pytest.mark.parametrize(
    "building_type, version, task",
    [
        pytest.param(*each.values, version, task, marks=each.marks)
        for each in every_type()
        for version, task in [("v0", "constant"), ("v1", "operate")]
    ],
)
def test_every_id_passes_the_checker_without_a_warning(building_type, version, task):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Gymnasium warns about every id that has a later version.
        warnings.filterwarnings("ignore", ".*-v0 is out of date", DeprecationWarning)
        env = gymnasium.make(f"b2b/{building_type}-{version}", run_period=DAY, render_mode="rgb_array")
        check_env(env.unwrapped)
    assert env.unwrapped.task == task
    env.close()


def test_an_environment_is_operated_unless_a_task_is_named(make):
    env = make(task="operate")
    with b2b.make_env("OfficeSmall", run_period=DAY) as plain:
        assert plain.metadata["task"] == env.metadata["task"] and plain.spec.id == "b2b/OfficeSmall-v1"
    names = ["occupancy", "band heating setpoint", "band cooling setpoint"]
    assert env.metadata["observation_names"][-3:] == [f"Perimeter_ZN_4 {name}" for name in names]


def test_a_spec_makes_the_same_environment(make):
    env = make(task="occupancy+energy0.5", rescale_action=True)
    spec = pickle.loads(pickle.dumps(env.spec))
    assert json.loads(env.spec.to_json())["kwargs"]["task"] == "occupancy+energy0.5"
    again = gymnasium.make(spec)
    action = env.action_space.sample()
    for each in (env, again):
        each.reset(seed=0)
    one, other = env.step(action), again.step(action)
    np.testing.assert_array_equal(one[0], other[0])
    assert one[1] == other[1] and again.metadata["action_names"] == env.metadata["action_names"]
    again.close()


def test_an_environment_pickles_as_its_arguments(make):
    env = make(task="occupancy", window_days=1)
    again = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(again.reset(seed=1)[0], env.reset(seed=1)[0])
    assert again.spec == env.spec and again._core.process != env._core.process
    again.close()


def test_metadata_has_names_and_units_of_all_slots(office):
    meta = office.metadata
    assert len(meta["observation_names"]) == len(meta["observation_units"]) == office.observation_space.shape[0]
    assert len(meta["action_names"]) == len(meta["action_units"]) == office.action_space.shape[0]
    assert meta["building"] == "OfficeSmall"
    assert set(meta["action_units"]) == {"kg/s", "°C"}


def test_the_morphology_is_metadata(make):
    env = make()
    assert env.metadata["morphology"] is env.unwrapped.morphology and "morphology" in env.metadata
    padded = b2b.wrappers.PadObservation(b2b.wrap_env_for_rl(env), width=20)
    assert padded.metadata["morphology"].name == "OfficeSmall"
    assert "morphology" not in json.loads(json.dumps(env.metadata)) and "x" not in env.metadata
    assert pickle.loads(pickle.dumps(env.metadata)) == dict(env.metadata)
    with pytest.raises(KeyError, match="nothing"):
        env.metadata["nothing"]


def test_a_first_action_of_zeros_that_are_out_of_bounds_is_a_warning(make):
    env = make()
    env.reset()
    with pytest.warns(UserWarning, match=r"0 for every actuator, but 5 of 10 .*physical units"):
        env.step(np.zeros(10))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.step(np.zeros(10))
        env.reset()
        env.step(env.action_space.low)
        rescaled = make(rescale_action=True)
        rescaled.reset()
        rescaled.step(np.zeros(10))


def learner(env, rescaled: bool):
    """Resets an environment as an algorithm of Stable-Baselines3 does."""
    name = "stable_baselines3.common.on_policy_algorithm"
    scope = {"__name__": name, "env": env}
    exec("class PPO:\n    def learn(self):\n        return env.reset()", scope)
    model = scope["PPO"]()
    model.action_space = gymnasium.spaces.Box(-1.0, 1.0, (10,)) if rescaled else env.action_space
    sys.modules.setdefault(name, types.ModuleType(name))
    model.learn()


def test_a_learner_with_actions_in_physical_units_is_warned(make):
    with pytest.warns(UserWarning, match=r"PPO needs actions in \[-1, 1\].*rescale_action=True"):
        learner(make(), rescaled=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # A learner on a rescaling wrapper, one on rescaled actions, and no learner.
        learner(make(), rescaled=True)
        learner(make(rescale_action=True), rescaled=True)
        make().reset()


def test_an_id_with_the_name_of_the_package_is_known_in_every_process():
    """As in workers of `SubprocVecEnv`: Gymnasium imports the package that is named before the colon."""
    code = "import gymnasium; print(gymnasium.make('building2building:b2b/OfficeSmall-v0', run_period='01-01..01-01'))"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert "<BuildingEnv OfficeSmall>" in ran.stdout, ran.stderr


def test_an_episode_is_truncated_at_the_end_of_its_run_period(make):
    env = make(timesteps_per_hour=1)
    env.reset()
    for step in range(1, 25):
        _, _, terminated, truncated, info = env.step(env.action_space.sample())
        assert not terminated and truncated == (step == 24)
    assert info["metrics"]["steps"] == 24
    with pytest.raises(errors.EpisodeError, match="no episode is in progress"):
        env.step(env.action_space.sample())


def test_rescaled_actions_are_equivalent(make):
    plain, rescaled = make(), make(rescale_action=True)
    plain.reset()
    rescaled.reset()
    share = np.linspace(-1, 1, 10)
    one = plain.step(rescaled.physical(share))
    other = rescaled.step(share)
    np.testing.assert_array_equal(one[0], other[0])
    np.testing.assert_allclose(plain.applied_action(), rescaled.physical(share))


def test_bounds_of_the_space_are_never_clamped(make):
    env = make(timesteps_per_hour=1)
    env.reset()
    for step in range(24):
        *_, info = env.step(env.action_space.high if step % 2 else env.action_space.low)
    assert info["metrics"]["clamped_actions"] == 0


def test_info_has_the_terms_of_the_reward(make):
    env = make(task="occupancy+energy0.5", run_period="01-02..01-02")
    env.reset()
    for _ in range(120):
        _, reward, _, _, info = env.step(env.action_space.high)
        assert sum(info["reward_terms"].values()) == reward
    assert info["reward_terms"]["temperature"] == pytest.approx(-np.mean(info["zone_deviation"] ** 2))
    energy = info["energy"]["electricity"] + info["energy"]["gas"]
    assert info["reward_terms"]["energy"] == pytest.approx(-0.5 / env.metadata["energy_scale"] * energy)
    assert energy > 0 and info["cost"] > 0 and info["emissions"] > 0
    assert info["zone_occupied"].any() and len(info["zone_temperature"]) == len(env.metadata["controlled_zones"])


def test_info_behaves_as_a_dictionary(make):
    env = make()
    env.reset()

    def info():
        return env.step(env.action_space.sample())[-1]

    assert "energy" in dict(info()) and "energy" in {**info()} and "energy" in info().copy()
    assert "energy" in pickle.loads(pickle.dumps(info())) and "energy" in copy.deepcopy(info())
    assert "energy" in list(info()) and len(info()) > 5 and (info() | {"x": 1})["x"] == 1
    written = info()
    written["mine"] = 1
    assert written["mine"] == 1 and "energy" in written and dict(written)["mine"] == 1
    assert "energy" in json.loads(json.dumps(info(), default=lambda array: array.tolist()))
    shown = info()
    shown["observation"] *= 0.0
    shown["zone_temperature"] *= 0.0
    assert env.observation.any() and env.observation[env.layout.temperatures].all()
    del (less := info())["observation"]
    assert "observation" not in less and "energy" in less


def test_a_run_period_of_two_weeks_is_the_weather_s(make):
    env = make("OfficeSmall", task="operate", run_period="peak-cooling")
    _, info = env.reset(seed=0)
    assert env.unwrapped.setting.episode_steps == 14 * 288
    envs = b2b.make_vec("OfficeSmall", 1, run_period="peak-cooling")
    try:
        envs.reset(seed=0)
        assert 150 < info["first_day"] < 240, "in summer"
        np.testing.assert_array_equal(envs._observations[0], env.unwrapped.observation.astype(np.float32))
    finally:
        envs.close()
    with pytest.raises(b2b.Error, match="did you mean peak-cooling"):
        make("OfficeSmall", run_period="peak-coolng")


def test_a_seed_draws_the_days_and_the_targets(make):
    env = make(
        "OfficeSmall",
        task="random",
        run_period="winter",
        window_days=2,
        window_starts=3,
        resample_targets=True,
        timesteps_per_hour=1,
    )

    def episode(seed):
        observation, info = env.reset(seed=seed)
        rows = [observation]
        while True:
            observation, _, _, truncated, _ = env.step(env.action_space.low)
            rows.append(observation)
            if truncated:
                return info["first_day"], np.array(rows)

    first, again, other = episode(3), episode(3), episode(5)
    assert first[0] == again[0] and len(first[1]) == 49
    np.testing.assert_array_equal(first[1], again[1])
    assert first[1].shape == other[1].shape and (first[1] != other[1]).any()


def test_penalties_are_from_the_last_step_of_the_episode(make):
    env = make(timesteps_per_hour=1)
    assert np.isnan(env.penalties).all()
    env.reset()
    assert np.isnan(env.penalties).all()
    _, reward, *_ = env.step(env.action_space.low)
    kept, penalties = env.snapshot(), env.penalties
    assert -sum(penalties) == reward
    for _ in range(3):
        env.step(env.action_space.high)
    assert env.penalties != penalties
    env.restore(kept)
    assert env.penalties == penalties
    env.reset()
    assert np.isnan(env.penalties).all()


def test_a_rollout_that_restores_snapshots_has_the_engine_s_report(make, tmp_path):
    env = make(timesteps_per_hour=1)
    controller = b2b.ReactiveController(env)

    def act(observation):
        if env.steps in (5, 9):
            env.restore(env.snapshot())
        return controller(observation)

    def summary(name, policy):
        controller.reset()
        b2b.rollout(env, policy).write(tmp_path / name)
        return json.loads((tmp_path / name / "summary.json").read_text())

    plain = summary("plain", lambda observation: controller(observation))
    restored = summary("restored", act)
    names = ("trajectory_hash", "meter_relative_error", "engine_warnings", "engine_severes")
    assert [restored[each] for each in names] == [plain[each] for each in names]
    assert plain["meter_relative_error"] is not None
    env.reset()
    (branch,) = env.branch(1)
    while not branch.step(env.action_space.low)[3]:
        pass
    with pytest.raises(errors.EpisodeError, match="of a branch does not finish"):
        branch.record().write(tmp_path / "branch", "low", 0, 1.0, *[np.zeros((1, 1))] * 3)
    branch.close()


def test_a_rollout_without_steps_has_the_observation_of_the_reset(make):
    env = make(timesteps_per_hour=1)
    trajectory = b2b.rollout(env, b2b.ReactiveController(env), steps=0)
    assert len(trajectory) == 0 and trajectory.observations.shape == (1, 13)
    assert trajectory.actions.shape == (0, 10) and trajectory.penalties.shape == (0, 2)
    assert trajectory.episode_return == 0 and not trajectory.truncated and trajectory.metrics is None


@pytest.fixture
def heated(make, tmp_path):
    """A warehouse whose only conditioned zone is heated, but not cooled."""
    model = json.loads(b2b.find_building("Warehouse").to_epjson())
    central = "AirLoop|AirTerm|Avail|Branch|Coil:Cool|Controller:|EnergyM|Fan:System|OutdoorAir:|Output"
    central += "|SetpointM|Sizing:System|UnitarySystemP|ZoneHVAC:AirD"
    model = {kind: objects for kind, objects in model.items() if not re.match(central, kind)}
    lists = ("EquipmentConnections", "EquipmentList")
    for kind in ("Coil:Heating:Fuel", "Sizing:Zone", "ZoneControl:Thermostat", *(f"ZoneHVAC:{each}" for each in lists)):
        model[kind] = {name: each for name, each in model[kind].items() if "Zone3" in name + str(each)}
    path = tmp_path / "heated.epJSON"
    path.write_text(json.dumps(model))
    building = b2b.import_building(path, place="Denver")
    return make(None, building=building, run_period="07-01..07-01", timesteps_per_hour=1, task="operate")


def test_a_warm_zone_without_cooling_is_in_its_band(heated):
    assert [zone.cooling for zone in heated.unwrapped.layout.zones if zone.controlled] == [False]
    heated.reset()
    for _ in range(14):
        *_, info = heated.step(heated.action_space.low)
    assert info["zone_temperature"] > info["zone_target"] + 5
    assert info["zone_deviation"].tolist() == [0.0] and info["reward_terms"]["temperature"] == 0
    with pytest.raises(errors.SettingError, match="no slots for comfort bands"):
        b2b.wrappers.PadObservation(heated, zones=5)


def test_a_custom_reward_replaces_the_task_s_reward(make):
    env = make(reward=lambda info: -float(np.abs(info["zone_deviation"]).max()))
    env.reset()
    _, reward, _, _, info = env.step(env.action_space.low)
    assert reward == -np.abs(info["zone_deviation"]).max() < 0


def test_a_rendered_frame_changes_with_the_state(make):
    pytest.importorskip("matplotlib")
    env = make(render_mode="rgb_array")
    env.reset()
    before = env.render()
    for _ in range(20):
        env.step(env.action_space.high)
        after = env.render()
    assert before.dtype == np.uint8 and before.shape == (540, 960, 3) and before.std() > 10
    assert (before != after).any()
    # A new renderer, which draws everything, gives the same frame.
    env.unwrapped._renderer = None
    np.testing.assert_array_equal(env.render(), after)


def test_a_frame_has_the_power_of_the_steps_between_two_calls(make):
    pytest.importorskip("matplotlib")

    def frames(every):
        env = make(render_mode="rgb_array", timesteps_per_hour=1)
        env.reset()
        for step in range(12):
            env.step(env.action_space.high if step % 2 else env.action_space.low)
            if every:
                env.render()
        return env, env.render()

    _, every_step = frames(True)
    env, once = frames(False)
    np.testing.assert_array_equal(once, every_step)
    here = env.snapshot()
    for _ in range(3):
        env.step(env.action_space.high)
    env.restore(here)
    np.testing.assert_array_equal(env.render(), once)


@pytest.mark.parametrize(
    "arguments, error, words",
    [
        ({"building_type": "OficeSmall"}, errors.BuildingError, "OfficeSmall"),
        ({"building_type": 3}, errors.SettingError, "the building is 3; pass a name"),
        ({"building_type": "OfficeSmall", "building_id": "OfficeSmall-2000"}, errors.BuildingError, "1000"),
        ({"building_type": "OfficeSmall", "place": "Dever"}, errors.BuildingError, "Denver"),
        ({"building_type": "OfficeSmall", "index": 900}, errors.SettingError, "0 to 899"),
        ({"building_type": "OfficeSmall", "split": "test"}, errors.SettingError, "pass index=0"),
        ({"building_type": "OfficeSmall", "task": "cosy"}, errors.TaskError, "occupancy"),
        ({"building_type": "OfficeSmall", "task": "task_occ_e05"}, errors.TaskError, "called occupancy.energy0.5 here"),
        ({"building_type": "OfficeSmall", "task": "constant+preview"}, errors.TaskError, "needs comfort bands"),
        ({"building_type": "OfficeSmall", "task": "none/missing.json"}, errors.TaskError, "none/missing.json"),
        ({"building_type": "OfficeSmall", "run_period": "spring"}, errors.BuildingError, "MM-DD"),
        ({"building_type": "OfficeSmall", "timesteps_per_hour": 7}, errors.Error, "steps per hour 7"),
        ({"building_type": "OfficeSmall", "window_days": 100}, errors.Error, "100 days"),
    ],
)
def test_invalid_arguments_raise_and_name_the_valid_ones(arguments, error, words):
    with pytest.raises(error, match=words) as raised:
        b2b.make_env(**arguments)
    assert isinstance(raised.value, b2b.Error)


def test_an_unknown_argument_is_answered_with_the_nearest():
    with pytest.raises(TypeError, match="`period`; did you mean `run_period`"):
        b2b.make_env("OfficeSmall", period="summer")
    with pytest.raises(TypeError, match="`tsk`; did you mean `task`"):
        b2b.make_vec("OfficeSmall", 2, tsk="constant")


def test_the_id_of_a_building_selects_it():
    with b2b.make_env("SingleFamilyHouse-0042", run_period="01-01..01-01") as env:
        assert env.metadata["building"] == "SingleFamilyHouse-0042"


def test_an_invalid_action_names_the_actuator_and_leaves_the_episode_intact(make):
    env = make()
    with pytest.raises(errors.EpisodeError, match="reset"):
        env.step(env.action_space.low)
    env.reset()
    action = env.action_space.low.astype(float)
    action[3] = np.nan
    with pytest.raises(errors.ActionError, match=env.metadata["action_names"][3]):
        env.step(action)
    with pytest.raises(errors.ActionError, match="expected 10"):
        env.step(action[:4])
    env.step(env.action_space.low)
    env.close()
    with pytest.raises(errors.EpisodeError, match="closed"):
        env.step(env.action_space.low)
    with pytest.raises(errors.EpisodeError, match="closed"):
        env.reset()
