"""Every row of docs/coming_from.md holds."""

import inspect
import json
import re
import subprocess
import sys
from pathlib import Path

import building2building as b2b
import numpy as np
import pytest
from building2building import _core, errors, wrappers
from building2building.buildings import select_building

PAGE = Path(__file__).parents[3] / "docs/coming_from.md"
DAY = "01-01..01-01"
#: Functions that check a row, by the beginning of its first cell.
CHECKS = {}


def row(beginning):
    def register(check):
        CHECKS[beginning] = check
        return check

    return register


def table() -> dict[str, str]:
    """The rows of the page: what was, and what is."""
    lines = [line for line in PAGE.read_text().splitlines() if line.startswith("| ")][1:]
    return dict(line.strip("| ").split(" | ", 1) for line in lines)


ROWS = table()


@pytest.mark.parametrize("was", ROWS)
def test_a_row_of_the_page_holds(was, make):
    checks = [check for beginning, check in CHECKS.items() if was.startswith(beginning)]
    assert len(checks) == 1, f"{len(checks)} checks of the row {was}"
    checks[0](was, ROWS[was], make)


def test_every_check_is_of_a_row():
    assert all(any(was.startswith(beginning) for was in ROWS) for beginning in CHECKS)


def quoted(cell: str) -> list[str]:
    return re.findall(r'`"([^"`]+)"`', cell)


def setting(task) -> dict:
    building = b2b.find_building("OfficeSmall")._core
    return json.loads(_core.Setting(building, DAY, 12, task if isinstance(task, str) else json.dumps(task)).task_json())


def refused(words, function, *arguments, **options):
    with pytest.raises(TypeError, match=f"{words}.*docs/coming_from.md"):
        function(*arguments, **options)


def is_absent(*names):
    assert not [name for name in names if hasattr(b2b, name)]


@row('`make_env("OfficeSmall", split=')
def _(was, now, make):
    parameters = inspect.signature(b2b.make_env).parameters
    assert set(re.findall(r"(\w+)=\.\.\.", was)) <= parameters.keys()
    assert parameters["run_period"].default == "winter" and "`winter` instead of `full_year`" in now
    assert parameters["task"].default == "operate" and "without `task`, [`operate`]" in now
    assert select_building("OfficeSmall").name == "OfficeSmall"
    assert select_building("OfficeSmall", index=0).name == b2b.list_buildings("OfficeSmall", "train")[0]
    with pytest.raises(errors.SettingError, match="pass index=0"):
        b2b.make_env("OfficeSmall", split="train")


@row("`observation_names`, `action_names`")
def _(was, now, make):
    env = make()
    assert "Core_ZN air temperature" in env.metadata["observation_names"] and "Core_ZN air temperature" in now
    assert env.metadata["action_names"]
    env.reset()
    with pytest.warns(UserWarning, match="0 for every actuator"):
        env.step(np.zeros(env.action_space.shape))


@row("`day_of_week` from 1")
def _(was, now, make):
    # 1 January is a Sunday.
    env = make(run_period="01-01..01-08", task="occupancy", timesteps_per_hour=1)
    days = b2b.rollout(env, b2b.ConstantController(env)).observed("day of week")
    assert days[12] == 6 and days[36] == 0 and set(days) == set(range(7))
    slots = [slot for slot in env.layout.observation if slot.name.endswith(" occupancy")]
    assert slots and {(slot.low, slot.high) for slot in slots} == {(0.0, 1.0)}


@row('`task="task_const_e0"`')
@row('`task="task_const_e05"`')
def _(was, now, make):
    old = [name for name in re.findall(r'"(task_\w+)"', was)]
    new = quoted(now)
    assert len(old) == len(new) == 3
    for before, after in zip(old, new):
        with pytest.raises(errors.TaskError, match=re.escape(f"called {after} here")):
            b2b.make_env("OfficeSmall", task=before)
        setting(after)


@row("`..._emed`")
def _(was, now, make):
    for level, after in zip(("emed", "ehigh"), quoted(now)):
        for mode, setpoints in (("const", "constant"), ("occ", "occupancy"), ("rand", "random")):
            new = setpoints + after.removeprefix("...")
            with pytest.raises(errors.TaskError, match=re.escape(f"called {new} here")):
                b2b.make_env("OfficeSmall", task=f"task_{mode}_{level}")
            setting(new)


@row("`TaskConfig`")
def _(was, now, make):
    is_absent("TaskConfig", "RewardConfig", "NormalizedDeadbandRewardConfig")
    assert setting({"comfort_band": 0.5})["comfort_band"] == 0.5


@row("`make_env_from_config`")
def _(was, now, make):
    is_absent("make_env_from_config")


@row("`expose_heating_only_zones`")
def _(was, now, make):
    with pytest.raises(TypeError, match="`expose_heating_only_zones`"):
        b2b.make_env("Warehouse", expose_heating_only_zones=True)
    assert setting({"heating_only_zones": "both_sides"})["heating_only_zones"] == "both_sides"


@row("`eplus_output_dir`")
def _(was, now, make):
    refused("`eplus_output_dir`.*keep_engine_output", b2b.make_env, "OfficeSmall", eplus_output_dir="x")
    refused("`max_episode_steps`.*run_period", b2b.make_env, "OfficeSmall", max_episode_steps=7)


@row("`list_buildings`, `list_building_types`")
def _(was, now, make):
    assert len(b2b.list_building_types()) == 6
    counts = [len(b2b.list_buildings("Warehouse", split)) for split in ("train", "test", "test_small")]
    assert counts == [900, 100, 8] and len(b2b.list_buildings("Warehouse")) == 900


@row("`get_climate_zone(")
def _(was, now, make):
    zone = b2b.get_climate_zone("OfficeSmall-0001")
    assert re.fullmatch(r"\d[ABC]?", zone)
    refused("`building_type`.*the id is enough", b2b.get_climate_zone, "OfficeSmall", "OfficeSmall-0001")
    refused("`building_type`", b2b.get_climate_zone, building_type="OfficeSmall", building_id="OfficeSmall-0001")


@row("`list_buildings_by_climate_zone(")
def _(was, now, make):
    all_, some = (b2b.list_buildings_by_climate_zone("OfficeSmall", zone) for zone in (5, "5A"))
    assert set(some) < set(all_) and all(b2b.get_climate_zone(each)[0] == "5" for each in all_)


@row("`ClimateZoneUnavailableError`")
def _(was, now, make):
    is_absent("ClimateZoneUnavailableError")
    assert b2b.get_climate_zone("SingleFamilyHouse-0001") is None


@row("`rollout(env, controller, max_steps=")
def _(was, now, make):
    env = make(timesteps_per_hour=1)
    refused("`max_steps`.*pass steps", b2b.rollout, env, b2b.ConstantController(env), max_steps=3)
    assert len(b2b.rollout(env, b2b.ConstantController(env), steps=3)) == 3


@row("`trajectory.observations`, `.actions`")
def _(was, now, make):
    env = b2b.wrap_env_for_rl(make(timesteps_per_hour=1))
    trajectory = b2b.rollout(env, lambda observation: np.full(10, 1.0, np.float32), steps=2)
    assert trajectory.observations.dtype == np.float64 and np.abs(trajectory.observations).max() > 10
    np.testing.assert_allclose(trajectory.actions[0], env.unwrapped.layout.action_high, rtol=1e-6)


@row("`Trajectory.to_npz`")
def _(was, now, make):
    assert not hasattr(b2b.Trajectory, "to_npz") and not hasattr(b2b.Trajectory, "from_npz")
    assert hasattr(b2b.Trajectory, "save") and hasattr(b2b.Trajectory, "load")


@row("`trajectory.raw_observations`")
def _(was, now, make):
    env = make(timesteps_per_hour=1)
    trajectory = b2b.rollout(env, b2b.ConstantController(env))
    assert trajectory.truncated and len(trajectory.observed("outdoor air temperature")) == 25
    assert not any(hasattr(trajectory, name) for name in ("raw_observations", "terminateds", "truncateds"))


@row('`info["raw_observation"]`')
def _(was, now, make):
    env = make()
    env.reset()
    info = env.step(env.action_space.low)[-1]
    assert set(re.findall(r'info\["(\w+)"\]', now)) == {"zone_temperature", "energy"} <= set(info)
    assert "raw_observation" not in info and env.unwrapped.observation.dtype == np.float64


@row('`env.metadata["morphology"]`')
def _(was, now, make):
    env = make()
    assert env.metadata["morphology"] is env.unwrapped.morphology
    is_absent("build_morphology")


@row("`HEATING_ZONE`")
def _(was, now, make):
    is_absent("HEATING_ZONE", "UNITARY_ZONE", "VAV_SUPPLY")
    types = {node.node_type for node in make().unwrapped.morphology.nodes}
    assert types <= {each.value for each in b2b.NodeType} and b2b.NodeType.UNITARY_ZONE in types


@row("`UnitarySystem`")
def _(was, now, make):
    is_absent("UnitarySystem", "VAVSystem", "HeatPump")
    systems = make().unwrapped.description["systems"]
    assert {each["kind"] for each in systems} == {b2b.SystemKind.UNITARY.value}


@row("`PadObservation(")
def _(was, now, make):
    env = make()
    for arguments, options in (((20,), {}), ((), {"target_size": 20})):
        refused("`target_size`.*zones=target_size - 7", wrappers.PadObservation, env, *arguments, **options)
    padded = wrappers.PadObservation(env, zones=13)
    assert padded.observation_space.shape == (20,)
    assert padded.metadata["observation_names"].index("outdoor air temperature") == 13
    assert wrappers.PadObservation(env, width=20).metadata["observation_names"][13:] == ["padding"] * 7


@row("`NormalizeObservation(env)`")
def _(was, now, make):
    env = wrappers.NormalizeObservation(make(timesteps_per_hour=1))
    observation, _ = env.reset()
    assert env.observation_space.low.min() == -1 and env.observation_space.high.max() == 1
    in_bounds = np.abs(observation) < 1
    assert in_bounds.sum() > 5
    again, own = env.denormalize(observation), env.unwrapped.observation
    np.testing.assert_allclose(again[in_bounds], own[in_bounds], rtol=1e-4, atol=1e-3)
    assert env.observation(env.unwrapped.observation + 1e6).max() == 1


@row("`AugmentObservationWithBuildingParams(")
def _(was, now, make):
    env = make()
    refused(
        "`building_params`.*as parameters",
        wrappers.AugmentObservationWithBuildingParams,
        env,
        building_params={"area": 1.0},
    )
    with pytest.raises(errors.SettingError, match="got a dictionary"):
        wrappers.AugmentObservationWithBuildingParams(env, {"floor_area": 1.0})
    augmented = wrappers.AugmentObservationWithBuildingParams(wrappers.NormalizeObservation(env), ["floor_area"])
    observation, _ = augmented.reset()
    assert len(observation) == 14 and -1 <= observation[13] <= 1
    in_bounds = np.abs(observation[:13]) < 1
    again = augmented.denormalize(observation)
    np.testing.assert_allclose(again[in_bounds], env.observation[in_bounds], rtol=1e-4, atol=1e-3)
    assert augmented.denormalize(np.stack([observation] * 2)).shape == (2, 13)


@row("`ResampleBuildingOnResetWrapper(")
def _(was, now, make):
    wrapper = wrappers.ResampleBuildingOnResetWrapper
    refused("not a factory and indices", wrapper, lambda index: make(), [0, 1])
    refused("`env_factory`", wrapper, env_factory=lambda index: make(), available_indices=[0, 1])
    assert list(inspect.signature(wrapper).parameters)[:2] == ["env", "buildings"]
    with pytest.raises(errors.SettingError, match="wraps an environment"):
        wrappers.NormalizeObservation("OfficeSmall")


@row("`wrap_env_for_rl(")
def _(was, now, make):
    for option in ("normalize_obs", "rescale_action"):
        refused(f"`{option}`.*always", b2b.wrap_env_for_rl, make(), **{option: False})
    env = b2b.wrap_env_for_rl(make("SingleFamilyHouse"))
    assert env.observation_space.shape == (17,)
    for space in (env.observation_space, env.action_space):
        assert (space.low == -1).all() and (space.high == 1).all()


@row("`callable_controller`")
def _(was, now, make):
    controller = b2b.callable_controller(lambda observation: observation)
    controller.reset()
    assert controller(3) == 3


@row("`compute_normalized_score(")
def _(was, now, make):
    old = ("OfficeSmall", "constant", "winter", "OfficeSmall-0001")
    refused("`cumulative_return`", b2b.compute_normalized_score, -3.0, *old)
    names = ("building_type", "task", "run_period", "building_id")
    refused("`cumulative_return`", b2b.compute_normalized_score, cumulative_return=-3.0, **dict(zip(names, old)))
    refused("`building_id`", b2b.compute_normalized_score, -3.0, *old[:3], building_id=old[3])
    house = b2b.list_buildings("SingleFamilyHouse", "test_small")[0]
    assert b2b.compute_normalized_score(-30.0, house, "constant", "winter") > 0


@row("the controllers of `baselines/controllers`")
def _(was, now, make):
    env = make()
    tuned = b2b.ReactiveController.tuned(env)
    assert "unitary.deadband" in tuned
    b2b.ReactiveController(env, parameters={"unitary.deadband": 0.5})


@row("`benchmarks.DynamicsAdaptation(")
def _(was, now, make):
    for difficulty, problem in zip(("easy", "medium", "hard"), re.findall(r"`(dynamics-[\w-]+)`", now), strict=True):
        with pytest.raises(errors.SettingError, match=f"called {problem.removeprefix('dynamics-')} here"):
            b2b.benchmarks.DynamicsAdaptation(difficulty=difficulty)
        assert problem in b2b.benchmarks.list_problems()


@row("`benchmarks.GoalAdaptation`")
def _(was, now, make):
    assert all(
        hasattr(b2b.benchmarks, name) for name in re.findall(r"(\w+(?:Adaptation|Transfer|Generalization))", was)
    )


def command(*arguments) -> str:
    ran = subprocess.run([sys.executable, "-m", "building2building", *arguments], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@row("`python -m baselines.train_ppo`")
def _(was, now, make):
    assert "paper (PPO as in the paper)" in command("train", "--help")


@row("`python -m baselines.run_reactive_control`")
@row("`python -m baselines.tune_controller`")
def _(was, now, make):
    name = re.search(r"`b2b (\w+)`", now)[1]
    assert "Usage" in command(name, "--help")


@row("`setup_energyplus_path`")
def _(was, now, make):
    is_absent("setup_energyplus_path")
    assert b2b.find_building("OfficeSmall-0001").to_epjson()
